//! Processes that a service has started and that have left its process group, as daemons do: they are
//! found by a mark in their environment, which every descendant inherits.

use rustix::process::{Pid, PidfdFlags, Signal, geteuid, pidfd_open, pidfd_send_signal};
use std::fs::File;
use std::io::Read;
use std::os::fd::OwnedFd;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::time::Duration;

/// Environment variable of every process of a stack: the root folder of its domain.
pub const MARK: &str = "ZERONAV_STACK";

/// Looks for processes that were started while the others were killed.
const ROUNDS_MAX: usize = 10;

/// Looks in a row that find nothing before there is nothing, and the time between them: the environment of
/// a process that is just being replaced by another program is empty for a moment.
const EMPTY_LOOKS: usize = 3;
const PAUSE: Duration = Duration::from_millis(5);

/// Longest environment that is read. [bytes]
const ENVIRONMENT_BYTES_MAX: u64 = 8 << 20;

/// Kills every process of this user that carries the mark of the domain at `root`; their ids. Its
/// services must have ended.
#[allow(
    clippy::must_use_candidate,
    reason = "the processes that were ended are of interest to few"
)]
pub fn end(root: &Path) -> Vec<u32> {
    let mut ended = Vec::new();
    let mut empty = 0;
    for _ in 0..ROUNDS_MAX {
        let found = find(root);
        if found.is_empty() {
            empty += 1;
            if empty == EMPTY_LOOKS {
                break;
            }
            std::thread::sleep(PAUSE);
            continue;
        }
        empty = 0;
        for (pid, process) in found {
            let _ = pidfd_send_signal(&process, Signal::KILL);
            ended.push(pid);
        }
    }
    ended.sort_unstable();
    ended.dedup();
    ended
}

fn find(root: &Path) -> Vec<(u32, OwnedFd)> {
    let mark = [MARK.as_bytes(), b"=", root.as_os_str().as_encoded_bytes()].concat();
    let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    processes
        .filter_map(|entry| {
            let pid: u32 = entry.file_name().to_str()?.parse().ok()?;
            // Before its environment is read: the id may be given to another one then.
            let process = pidfd_open(pid_of(pid)?, PidfdFlags::empty()).ok()?;
            (pid != std::process::id() && is_marked(pid, &mark)).then_some((pid, process))
        })
        .collect()
}

fn pid_of(pid: u32) -> Option<Pid> {
    i32::try_from(pid).ok().and_then(Pid::from_raw)
}

fn is_marked(pid: u32, mark: &[u8]) -> bool {
    let Ok(file) = File::open(format!("/proc/{pid}/environ")) else {
        return false;
    };
    let is_own = file
        .metadata()
        .is_ok_and(|file| file.uid() == geteuid().as_raw());
    let mut environment = Vec::new();
    is_own
        // A process that has ended has none any more.
        && file.take(ENVIRONMENT_BYTES_MAX).read_to_end(&mut environment).is_ok()
        && environment.split(|byte| *byte == 0).any(|entry| entry == mark)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Command, Stdio};

    #[test]
    fn a_descendant_that_has_left_the_session_is_ended_and_no_other() {
        let root = Path::new("/dev/shm/zn_no_such_domain");
        let mut other = Command::new("sleep");
        let mut other = (other.arg("600").env(MARK, "/dev/shm/zn_no_such_domain2"))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("started");
        // A service that leaves a daemon behind: it says its process id.
        let mut service = Command::new("sh")
            .args(["-c", "setsid sleep 600 > /dev/null & echo $!"])
            .env(MARK, root)
            .stderr(Stdio::null())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .expect("started");
        let mut said = String::new();
        let mut out = std::io::BufReader::new(service.stdout.take().expect("its output"));
        std::io::BufRead::read_line(&mut out, &mut said).expect("a line");
        let daemon: u32 = said.trim().parse().expect("a process id");
        let _ = service.wait();
        assert!(end(root).contains(&daemon), "{daemon} goes on");
        assert_eq!(find(root).len(), 0);
        assert!(other.try_wait().expect("looked at").is_none());
        let _ = other.kill();
        let _ = other.wait();
    }
}
