//! Locked memory: what a service has touched is not paged out.

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Resource, getrlimit};
use rustix::thread::{CapabilitySet, capabilities};

/// Environment variable that asks a service to lock its memory.
pub const LOCK_MEMORY: &str = "ZERONAV_LOCK_MEMORY";

/// Locks the memory of this process when [`LOCK_MEMORY`] is set and the system grants it. Pages are
/// locked when they are touched: a map whose memory is only reserved takes none.
pub(crate) fn lock_if_asked() {
    if std::env::var_os(LOCK_MEMORY).is_none() {
        return;
    }
    // With less than no limit the lock may be granted now and an allocation fail later.
    let unlimited = getrlimit(Resource::Memlock).current.is_none();
    let capable =
        capabilities(None).is_ok_and(|own| own.effective.contains(CapabilitySet::IPC_LOCK));
    if !unlimited && !capable {
        tracing::warn!("memory is not locked: it needs CAP_IPC_LOCK or `ulimit -l unlimited`");
        return;
    }
    let flags = MlockAllFlags::CURRENT | MlockAllFlags::FUTURE | MlockAllFlags::ONFAULT;
    if let Err(error) = mlockall(flags) {
        tracing::warn!(%error, "memory is not locked");
    }
}
