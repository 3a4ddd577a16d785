//! The file system of shared memory, and what it may be short of.

use rustix::fs::statvfs;
use rustix::process::{Resource, getrlimit};

/// Where the segments lie.
pub const SHM: &str = "/dev/shm";

/// Bytes free there.
///
/// # Errors
/// What the system says.
pub(crate) fn free_bytes() -> std::io::Result<u64> {
    let stat = statvfs(SHM)?;
    Ok(stat.f_bavail.saturating_mul(stat.f_frsize))
}

/// Inodes free there; `None` where their number has no limit.
pub(crate) fn free_inodes() -> Option<u64> {
    let stat = statvfs(SHM).ok()?;
    (stat.f_files > 0).then_some(stat.f_favail)
}

/// Why the system may have refused something, as the end of a line; empty when nothing is seen.
pub(crate) fn shortage() -> &'static str {
    if free_inodes() == Some(0) {
        "; /dev/shm has no inode left: see `df -i /dev/shm`"
    } else if getrlimit(Resource::As).current.is_some() {
        "; the address space is limited: see `ulimit -v`"
    } else {
        ""
    }
}
