//! The signals that ask a process to stop.

use crate::error::StartError;
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// SIGTERM, SIGINT and SIGQUIT, and SIGHUP unless this process was started to ignore it (nohup).
#[must_use]
pub fn stopping() -> Vec<i32> {
    let mut signals = vec![SIGTERM, SIGINT, SIGQUIT];
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    if !ignores(&status, SIGHUP) {
        signals.push(SIGHUP);
    }
    signals
}

/// A flag that the signals of [`stopping`] set, and a socket that they make readable.
pub(crate) fn catch() -> Result<(Arc<AtomicBool>, UnixStream), StartError> {
    let failed = |error| StartError::system("catching signals", error);
    let stop = Arc::new(AtomicBool::new(false));
    let (reader, writer) = UnixStream::pair().map_err(failed)?;
    for end in [&reader, &writer] {
        end.set_nonblocking(true).map_err(failed)?;
    }
    for signal in stopping() {
        signal_hook::flag::register(signal, Arc::clone(&stop)).map_err(failed)?;
        let writer = writer.try_clone().map_err(failed)?;
        signal_hook::low_level::pipe::register(signal, writer).map_err(failed)?;
    }
    Ok((stop, reader))
}

/// True when a `/proc/PID/status` says that `signal` is ignored.
fn ignores(status: &str, signal: i32) -> bool {
    let mask = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & (1 << (signal - 1)) != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hangup_that_is_ignored_from_the_start_stays_ignored() {
        let status = |mask: &str| format!("SigBlk:\t0000000000000000\nSigIgn:\t{mask}\n");
        assert!(ignores(&status("0000000000000001"), SIGHUP));
        assert!(ignores(&status("0000000000001003"), SIGHUP));
        assert!(!ignores(&status("0000000000001002"), SIGHUP));
        assert!(ignores(&status("0000000000004000"), SIGTERM));
        assert!(!ignores("", SIGHUP));
    }
}
