//! A process that launch starts beside itself: a service, or a companion.

use super::child_log::{LogPlace, last_lines};
use super::descendants::MARK;
use super::warden;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open};
use std::ffi::OsString;
use std::fs::File;
use std::io::Error;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::time::Duration;

/// How a process is started.
#[derive(Debug)]
pub struct Beginning<'a> {
    /// What the warden and the log call it.
    pub name: &'a str,
    /// The program.
    pub binary: &'a Path,
    /// Its arguments.
    pub arguments: &'a [OsString],
    /// Root folder of the domain.
    pub root: &'a Path,
    /// Where its output goes.
    pub log: &'a LogPlace,
    /// Its standard input.
    pub stdin: Stdio,
    /// Its standard output, if that is not its log.
    pub stdout: Option<Stdio>,
}

/// A started process in a process group of its own. When launch dies, whatever kills it, the process is
/// asked to leave, and the warden ends it if it does not. Dropping it kills it.
#[derive(Debug)]
pub struct Process {
    /// The binary.
    pub binary: PathBuf,
    /// What it writes to both its outputs.
    log: File,
    child: std::process::Child,
    pidfd: OwnedFd,
    ended: Option<ExitStatus>,
}

impl Process {
    /// Starts it, after `prepare` has changed the command. Call it from a thread that lives as long as the
    /// process shall: the kernel asks it to leave when the thread ends.
    ///
    /// # Errors
    /// What the system says, naming the binary.
    pub fn start(
        beginning: Beginning<'_>,
        prepare: impl FnOnce(&mut Command),
    ) -> std::io::Result<Self> {
        let binary = beginning.binary;
        let named = |error: Error| {
            let why = format!("starting {}: {error}{}", binary.display(), hint(&error));
            Error::new(error.kind(), why)
        };
        let log = beginning.log.open().map_err(named)?;
        let mut command = Command::new(binary);
        let stdout = match beginning.stdout {
            Some(stdout) => stdout,
            None => log.try_clone().map_err(named)?.into(),
        };
        command
            .args(beginning.arguments)
            .env(MARK, beginning.root)
            .stdin(beginning.stdin)
            .stdout(stdout)
            .stderr(log.try_clone().map_err(named)?)
            .process_group(0);
        end_with_this_thread(&mut command, Signal::TERM);
        prepare(&mut command);
        let mut process = command.spawn().map_err(named)?;
        let pidfd = i32::try_from(process.id())
            .ok()
            .and_then(Pid::from_raw)
            .ok_or_else(|| Error::other("no process id"))
            .and_then(|pid| Ok(pidfd_open(pid, PidfdFlags::empty())?));
        let pidfd = match pidfd {
            Ok(pidfd) => pidfd,
            Err(error) => {
                let _ = process.kill();
                let _ = process.wait();
                return Err(named(error));
            }
        };
        warden::watch_process(beginning.name, process.id(), pidfd.as_fd());
        Ok(Self {
            binary: binary.to_owned(),
            log,
            child: process,
            pidfd,
            ended: None,
        })
    }

    /// Process id.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// The writing end of its standard input, where that is a pipe; once.
    pub fn stdin(&mut self) -> Option<ChildStdin> {
        self.child.stdin.take()
    }

    /// The reading end of its standard output, where that is a pipe; once.
    pub fn stdout(&mut self) -> Option<ChildStdout> {
        self.child.stdout.take()
    }

    /// How it ended, once it has.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        if self.ended.is_none() {
            self.ended = self.child.try_wait().ok().flatten();
        }
        self.ended
    }

    /// Sends `signal` to its process group.
    pub fn signal(&mut self, signal: Signal) {
        if self.ended().is_none()
            && let Some(pid) = i32::try_from(self.pid()).ok().and_then(Pid::from_raw)
        {
            let _ = kill_process_group(pid, signal);
        }
    }

    /// Waits for the end; true when it came within `limit`.
    pub fn wait(&mut self, limit: Duration) -> bool {
        if self.ended().is_some() {
            return true;
        }
        let timeout = Timespec {
            tv_sec: limit.as_secs().cast_signed(),
            tv_nsec: i64::from(limit.subsec_nanos()),
        };
        let mut descriptors = [PollFd::from_borrowed_fd(self.pidfd.as_fd(), PollFlags::IN)];
        let _ = poll(&mut descriptors, Some(&timeout));
        self.ended().is_some()
    }

    /// The last lines of its log.
    #[must_use]
    pub fn log_tail(&self, lines: usize) -> Vec<String> {
        last_lines(&self.log, lines)
    }

    /// Another handle of its log.
    ///
    /// # Errors
    /// When there are too many.
    pub fn log(&self) -> std::io::Result<File> {
        self.log.try_clone()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.signal(Signal::KILL);
        let _ = self.child.wait();
    }
}

/// What to do about an error of starting a process or a thread, as the end of a line.
#[must_use]
pub fn hint(error: &Error) -> &'static str {
    match error.kind() {
        std::io::ErrorKind::WouldBlock => {
            "; the limit of processes and threads of this user is reached: see `ulimit -u`"
        }
        std::io::ErrorKind::OutOfMemory => "; there is too little memory: see `ulimit -v`",
        _ => "",
    }
}

/// Has the process that `command` starts sent `signal` when this thread ends.
#[allow(
    unsafe_code,
    reason = "the parent-death signal can only be set between fork and exec"
)]
pub fn end_with_this_thread(command: &mut Command, signal: Signal) {
    let parent = rustix::process::getpid();
    // SAFETY: the closure runs in the forked child before exec and makes only system calls that
    // are async-signal-safe; it allocates nothing and takes no lock.
    unsafe {
        command.pre_exec(move || {
            rustix::process::set_parent_process_death_signal(Some(signal))?;
            // A log or segment beyond `ulimit -f` is an error of the write and kills no robot.
            libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
            // Launch may have died between fork and the call: then the signal would never be sent.
            if rustix::process::getppid() != Some(parent) {
                return Err(Error::from_raw_os_error(3));
            }
            Ok(())
        });
    }
}
