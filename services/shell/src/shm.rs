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

/// Why the system may have refused something, as the end of a line; empty when nothing is seen.
pub(crate) fn shortage() -> &'static str {
    let has_inodes = statvfs(SHM).map_or(true, |stat| stat.f_favail > 0);
    if !has_inodes {
        "; /dev/shm has no inode left: see `df -i /dev/shm`"
    } else if getrlimit(Resource::As).current.is_some() {
        "; the address space is limited: see `ulimit -v`"
    } else {
        ""
    }
}
