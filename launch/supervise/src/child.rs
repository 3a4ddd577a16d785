//! One service process.

use super::child_log::{LogPlace, last_lines};
use super::descendants::MARK;
use super::scheduling;
use super::warden;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open};
use std::ffi::OsString;
use std::fs::File;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;
use zeronav_measure::result::scheduling::Scheduling;
use zeronav_msgs::role::Role;
use zeronav_scenario::scheduling::SchedulingSpec;
use zeronav_shell::memory;

/// How a child is started.
#[derive(Debug, Clone, Copy)]
pub struct Start<'a> {
    /// The program.
    pub binary: &'a Path,
    /// Its arguments.
    pub arguments: &'a [OsString],
    /// Root folder of the domain.
    pub root: &'a Path,
    /// Where its output goes.
    pub log: &'a LogPlace,
    /// How it is scheduled, if not as launch is.
    pub scheduling: Option<&'a SchedulingSpec>,
}

/// A started service in a process group of its own. When launch dies, whatever kills it, the service
/// is asked to leave, and the warden ends it if it does not.
#[derive(Debug)]
pub struct Child {
    /// The seat it sits in.
    pub role: Role,
    /// Which start of the seat it is.
    pub epoch: u32,
    /// The binary.
    pub binary: PathBuf,
    /// What it writes to both its outputs.
    log: File,
    process: std::process::Child,
    pidfd: OwnedFd,
    ended: Option<ExitStatus>,
    memory_peak_bytes: u64,
    scheduling: Option<SchedulingSpec>,
    scheduled: Option<Scheduling>,
}

impl Child {
    /// Starts a process in the seat of `role`, which is its `stdin`. Call it from a thread that lives as
    /// long as the child shall: the kernel asks the child to leave when the thread ends.
    ///
    /// # Errors
    /// What the system says, naming the binary.
    pub fn start(role: Role, epoch: u32, stdin: Stdio, start: &Start<'_>) -> std::io::Result<Self> {
        let Start {
            binary,
            arguments,
            root,
            log,
            scheduling,
        } = *start;
        let name = |error: std::io::Error| {
            std::io::Error::new(
                error.kind(),
                format!("starting {}: {error}{}", binary.display(), hint(&error)),
            )
        };
        let log = log.open().map_err(name)?;
        let mut command = Command::new(binary);
        command
            .args(arguments)
            .env(MARK, root)
            .stdin(stdin)
            .stdout(log.try_clone().map_err(name)?)
            .stderr(log.try_clone().map_err(name)?)
            .process_group(0);
        end_with_this_thread(&mut command, Signal::TERM);
        if let Some(spec) = scheduling {
            scheduling::ask(&mut command, spec);
        }
        let process = command.spawn().map_err(name)?;
        let pidfd = i32::try_from(process.id())
            .ok()
            .and_then(Pid::from_raw)
            .ok_or_else(|| std::io::Error::other("no process id"))
            .and_then(|pid| Ok(pidfd_open(pid, PidfdFlags::empty())?));
        let mut process = process;
        let pidfd = match pidfd {
            Ok(pidfd) => pidfd,
            Err(error) => {
                let _ = process.kill();
                let _ = process.wait();
                return Err(name(error));
            }
        };
        warden::watch_service(role, process.id(), pidfd.as_fd());
        Ok(Self {
            role,
            epoch,
            binary: binary.to_owned(),
            log,
            process,
            pidfd,
            ended: None,
            memory_peak_bytes: 0,
            scheduling: scheduling.cloned(),
            scheduled: None,
        })
    }

    /// Process id.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.process.id()
    }

    /// How it ended, once it has.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        if self.ended.is_none() {
            self.ended = self.process.try_wait().ok().flatten();
        }
        self.ended
    }

    /// True while it is stopped by a signal.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.state() == "T"
    }

    /// The kernel's letter for its state.
    fn state(&self) -> String {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.pid()));
        let stat = stat.unwrap_or_default();
        let rest = stat.rsplit(") ").next();
        let state = rest.and_then(|rest| rest.split(' ').next());
        state.unwrap_or("?").to_owned()
    }

    /// What the kernel says that it is doing, to tell why it does nothing: its
    /// state, where it sleeps, and how long it has run and waited for a processor in all.
    #[must_use]
    pub fn condition(&self) -> String {
        let read = |name: &str| {
            std::fs::read_to_string(format!("/proc/{}/{name}", self.pid())).unwrap_or_default()
        };
        let state = self.state();
        let times = read("schedstat");
        let mut times_s = times
            .split_ascii_whitespace()
            .map(|ns| ns.parse::<u64>().map_or(0.0, zeronav_msgs::time::seconds));
        let (ran_s, waited_s) = (times_s.next().unwrap_or(0.0), times_s.next().unwrap_or(0.0));
        let place = read("wchan");
        format!(
            "state {state} in {place}, ran {ran_s:.3} s, waited for a processor {waited_s:.3} s"
        )
    }

    /// Largest resident memory so far, without shared memory. [bytes]
    pub fn memory_peak_bytes(&mut self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.pid()));
        if let Some(bytes) = status.ok().as_deref().and_then(own_memory_peak_bytes) {
            self.memory_peak_bytes = self.memory_peak_bytes.max(bytes);
        }
        self.memory_peak_bytes
    }

    /// How the kernel schedules it, or did while it ran.
    pub fn scheduling(&mut self) -> Option<&Scheduling> {
        if let Some(now) = scheduling::read(self.pid(), self.scheduling.as_ref()) {
            self.scheduled = Some(now);
        }
        self.scheduled.as_ref()
    }

    /// What the scenario asks of the scheduler and the kernel has not granted. Memory is not yet
    /// locked then, and left out.
    pub fn refused_at_start(&self) -> Vec<String> {
        let spec = self.scheduling.clone().map(|spec| SchedulingSpec {
            lock_memory: false,
            ..spec
        });
        let now = spec.and_then(|spec| scheduling::read(self.pid(), Some(&spec)));
        now.map_or_else(Vec::new, |now| now.refused)
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

    /// How it ended, in words.
    #[must_use]
    pub fn end_in_words(status: ExitStatus) -> String {
        match (status.code(), status.signal()) {
            (Some(135), _) | (_, Some(7)) if memory::is_full() => {
                "killed by SIGBUS: /dev/shm is full".to_owned()
            }
            (Some(135), _) | (_, Some(7)) => {
                "killed by SIGBUS: shared memory that it used was cut off".to_owned()
            }
            (Some(153), _) | (_, Some(25)) => {
                "killed by SIGXFSZ: a file became larger than `ulimit -f` allows".to_owned()
            }
            (Some(4), _) => "exit code 4: too little shared memory in /dev/shm".to_owned(),
            (Some(code), _) => format!("exit code {code}"),
            (None, Some(signal)) => format!("killed by signal {signal}"),
            (None, None) => "ended".to_owned(),
        }
    }

    /// The last lines of its log.
    #[must_use]
    pub fn log_tail(&self, lines: usize) -> Vec<String> {
        last_lines(&self.log, lines)
    }
}

/// True when the system has no room for another process now, which may change.
#[must_use]
pub fn is_short(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{OutOfMemory, WouldBlock};
    matches!(error.kind(), WouldBlock | OutOfMemory)
}

/// What to do about an error of starting a process or a thread, as the end of a line.
#[must_use]
pub fn hint(error: &std::io::Error) -> &'static str {
    match error.kind() {
        std::io::ErrorKind::WouldBlock => {
            "; the limit of processes and threads of this user is reached: see `ulimit -u`"
        }
        std::io::ErrorKind::OutOfMemory => "; there is too little memory: see `ulimit -v`",
        _ => "",
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.signal(Signal::KILL);
        let _ = self.process.wait();
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
                return Err(std::io::Error::from_raw_os_error(3));
            }
            Ok(())
        });
    }
}

/// From a process's `status`: the largest resident memory, less the part that is shared memory now.
/// The kernel keeps no peak of the difference; shared memory is mapped early and stays.
fn own_memory_peak_bytes(status: &str) -> Option<u64> {
    let bytes = |name: &str| -> Option<u64> {
        let line = status.lines().find_map(|line| line.strip_prefix(name))?;
        let kibibytes = line.trim().trim_end_matches("kB").trim();
        Some(kibibytes.parse::<u64>().ok()?.saturating_mul(1024))
    };
    Some(bytes("VmHWM:")?.saturating_sub(bytes("RssShmem:").unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::{hint, is_short, own_memory_peak_bytes};

    #[test]
    fn a_system_without_room_is_told_from_a_binary_that_is_missing() {
        // EAGAIN of fork(2), ENOMEM, ENOENT.
        let of = |errno| {
            let error = std::io::Error::from_raw_os_error(errno);
            (is_short(&error), hint(&error).contains("ulimit -"))
        };
        assert_eq!(
            [11, 12, 2].map(of),
            [(true, true), (true, true), (false, false)]
        );
    }

    #[test]
    fn shared_memory_is_no_memory_of_the_process() {
        let status = "Name:\ta\nVmHWM:\t    90 kB\nVmRSS:\t   80 kB\nRssShmem:\t  30 kB\n";
        assert_eq!(own_memory_peak_bytes(status), Some(60 * 1024));
        assert_eq!(own_memory_peak_bytes("VmHWM:\t 7 kB\n"), Some(7 * 1024));
        assert_eq!(own_memory_peak_bytes("VmRSS:\t 7 kB\n"), None);
    }
}
