//! What a run leaves when launch cannot end it: a result that was written before its start.
//!
//! The warden keeps it (see [`warden`]) and puts it in its place when launch is gone without having
//! taken it back: killed, crashed, or unable to read shared memory that a process of the stack has cut
//! off or overwritten. Then launch ends as it is, as it can trust none of its memory any more.

use super::crash_result::FILE;
use super::warden;
use libc::{SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGSEGV};
use rustix::fs::{MemfdFlags, memfd_create};
use std::fs::File;
use std::io::Write;
use std::os::fd::AsFd;
use zeronav_console::exit::EXIT_SERVICE;
use zeronav_files::Folder;
use zeronav_shell::damage::is_reading;

/// Signals of a process that cannot go on.
const FATAL: [i32; 5] = [SIGBUS, SIGSEGV, SIGABRT, SIGILL, SIGFPE];

/// What the end by one of [`FATAL`] says.
const SAID: &str = "zeronav: launch cannot go on: its memory is damaged (see result.json)\n";

/// The result of a run that launch could not end, until it is dropped.
#[derive(Debug)]
pub struct Will(());

impl Will {
    /// Leaves `result`, a JSON object, for the run in `folder`. Without room for it there is none.
    pub fn leave(folder: &Folder, result: &[u8]) -> Self {
        let left = std::path::absolute(folder.path()).and_then(|path| {
            let mut file = File::from(memfd_create(FILE, MemfdFlags::CLOEXEC)?);
            file.write_all(result)?;
            warden::keep_will(&path, file.as_fd());
            Ok(())
        });
        if let Err(error) = left {
            tracing::warn!(%error, "a run that is killed will leave no result");
        }
        Self(())
    }
}

impl Drop for Will {
    fn drop(&mut self) {
        if std::thread::panicking() {
            warden::settle();
        } else {
            warden::forget_will();
        }
    }
}

/// Ends this process with one line and an exit code of its own when a fatal signal comes, after the
/// warden has written the result of its run.
#[allow(
    unsafe_code,
    reason = "after a memory fault only a signal handler can still act"
)]
pub fn settle_when_fatal() {
    for signal in FATAL {
        // SAFETY: the struct is plain data, and all zeros is a value of it; the handler makes system
        // calls alone. It is on while no second signal comes, on a stack of its own.
        let failed = unsafe {
            let mut action: libc::sigaction = core::mem::zeroed();
            action.sa_sigaction = end as *const () as libc::sighandler_t;
            action.sa_flags = libc::SA_ONSTACK | libc::SA_RESETHAND;
            libc::sigaction(signal, &raw const action, core::ptr::null_mut()) != 0
        };
        if failed {
            tracing::warn!(signal, "a crash of launch leaves no result");
        }
    }
}

/// What a fatal signal does. It returns when no result was left, and the signal comes again: then it
/// has its usual effect.
extern "C" fn end(signal: libc::c_int) {
    let is_settled = match signal {
        SIGBUS | SIGSEGV => warden::settle_while_reading(),
        SIGABRT if is_reading() => warden::settle_while_reading(),
        _ => warden::settle(),
    };
    if is_settled {
        let _ = rustix::io::write(rustix::stdio::stderr(), SAID.as_bytes());
        signal_hook::low_level::exit(i32::from(EXIT_SERVICE));
    }
}
