//! The limit of open files, which every process of a stack inherits from the supervisor.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Open files that a process of a stack may need: each port is a handful of mapped files, the
/// supervisor has most of them (some 210), and guests and restarts add theirs.
pub(crate) const NEEDED: u64 = 512;

/// Raises the soft limit of open files to [`NEEDED`] where it is lower.
///
/// # Errors
/// One line with both numbers when the hard limit is lower.
pub(crate) fn raise() -> Result<(), String> {
    let limit = getrlimit(Resource::Nofile);
    // `None` is no limit.
    if limit.current.is_none_or(|current| current >= NEEDED) {
        return Ok(());
    }
    if let Some(most) = limit.maximum.filter(|most| *most < NEEDED) {
        return Err(format!(
            "{most} open files are allowed and every process of a stack needs {NEEDED}; \
             raise the limit (ulimit -n {NEEDED})"
        ));
    }
    let raised = Rlimit {
        current: Some(NEEDED),
        ..limit
    };
    setrlimit(Resource::Nofile, raised)
        .map_err(|error| format!("raising the limit of open files to {NEEDED}: {error}"))
}
