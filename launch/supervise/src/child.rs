//! One service process.

use super::child_log::LogPlace;
use super::process::{Beginning, Process};
use super::scheduling;
use rustix::process::Signal;
use std::ffi::OsString;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{ExitStatus, Stdio};
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

/// A started service in a process group of its own, see [`Process`].
#[derive(Debug)]
pub struct Child {
    /// The seat it sits in.
    pub role: Role,
    /// Which start of the seat it is.
    pub epoch: u32,
    /// The binary.
    pub binary: PathBuf,
    process: Process,
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
        let beginning = Beginning {
            name: role.label(),
            binary: start.binary,
            arguments: start.arguments,
            root: start.root,
            log: start.log,
            stdin,
            stdout: None,
        };
        let process = Process::start(beginning, |command| {
            if let Some(spec) = start.scheduling {
                scheduling::ask(command, spec);
            }
        })?;
        Ok(Self {
            role,
            epoch,
            binary: start.binary.to_owned(),
            process,
            memory_peak_bytes: 0,
            scheduling: start.scheduling.cloned(),
            scheduled: None,
        })
    }

    /// Process id.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.process.pid()
    }

    /// How it ended, once it has.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        self.process.ended()
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
        self.process.signal(signal);
    }

    /// Waits for the end; true when it came within `limit`.
    pub fn wait(&mut self, limit: Duration) -> bool {
        self.process.wait(limit)
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
        self.process.log_tail(lines)
    }
}

/// True when the system has no room for another process now, which may change.
#[must_use]
pub fn is_short(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{OutOfMemory, WouldBlock};
    matches!(error.kind(), WouldBlock | OutOfMemory)
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
    use super::{Child, is_short, own_memory_peak_bytes};
    use crate::process::hint;
    use std::os::unix::process::ExitStatusExt;
    use std::process::ExitStatus;

    #[test]
    fn every_end_is_said_by_its_code_or_its_signal() {
        let code = |code: i32| Child::end_in_words(ExitStatus::from_raw(code << 8));
        let signal = |signal| Child::end_in_words(ExitStatus::from_raw(signal));
        for n in [0, 1, 3, 5, 101] {
            assert_eq!(code(n), format!("exit code {n}"));
        }
        assert_eq!(code(4), "exit code 4: too little shared memory in /dev/shm");
        for n in [6, 9, 11, 15, 24, 26] {
            assert_eq!(signal(n), format!("killed by signal {n}"));
        }
        // A shell says 128 and the signal.
        for said in [code(135), signal(7)] {
            assert!(said.starts_with("killed by SIGBUS: "), "{said}");
        }
        for said in [code(153), signal(25)] {
            assert!(said.starts_with("killed by SIGXFSZ: "), "{said}");
        }
    }

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
