//! Processes that a service has started and that have left its process group, as daemons do: they are
//! found by a mark in their environment, which every descendant inherits.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, geteuid, pidfd_open, pidfd_send_signal};
use std::fs::File;
use std::io::Read;
use std::os::fd::OwnedFd;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::time::{Duration, Instant};

/// Environment variable of every process of a stack: the root folder of its domain.
pub const MARK: &str = "ZERONAV_STACK";

/// How long this looks and waits at most.
const LIMIT: Duration = Duration::from_secs(5);

/// Looks in a row that find nothing before there is nothing, and the time between them.
const EMPTY_LOOKS: usize = 3;
const PAUSE: Duration = Duration::from_millis(5);

/// Longest environment that is read. [bytes]
const ENVIRONMENT_BYTES_MAX: u64 = 8 << 20;

/// Kills every process of this user that carries the mark of the domain at `root`, and waits until they
/// are gone: until then they may hold locks in the domain. Their ids. Its services must have ended.
#[allow(
    clippy::must_use_candidate,
    reason = "the processes that were ended are of interest to few"
)]
pub fn end(root: &Path) -> Vec<u32> {
    let deadline = Instant::now() + LIMIT;
    let mut ended = Vec::new();
    let mut empty = 0;
    while empty < EMPTY_LOOKS && Instant::now() < deadline {
        let found = find(root);
        for (pid, process) in &found.marked {
            let _ = pidfd_send_signal(process, Signal::KILL);
            ended.push(*pid);
        }
        for (_, process) in &found.marked {
            await_end(process, deadline);
        }
        // What was started while the others were killed is found by the next look.
        let is_empty = found.marked.is_empty() && !found.is_unclear;
        empty = if is_empty { empty + 1 } else { 0 };
        if found.marked.is_empty() {
            std::thread::sleep(PAUSE);
        }
    }
    ended.sort_unstable();
    ended.dedup();
    ended
}

fn await_end(process: &OwnedFd, deadline: Instant) {
    let left = deadline.saturating_duration_since(Instant::now());
    let timeout = Timespec {
        tv_sec: left.as_secs().cast_signed(),
        tv_nsec: i64::from(left.subsec_nanos()),
    };
    let mut descriptors = [PollFd::new(process, PollFlags::IN)];
    let _ = poll(&mut descriptors, Some(&timeout));
}

/// What a look has found.
#[derive(Default)]
struct Found {
    marked: Vec<(u32, OwnedFd)>,
    /// True when it cannot be said of a process yet whether it is marked.
    is_unclear: bool,
}

fn find(root: &Path) -> Found {
    let mark = [MARK.as_bytes(), b"=", root.as_os_str().as_encoded_bytes()].concat();
    let mut found = Found::default();
    for entry in std::fs::read_dir("/proc").into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(pid) = name.to_str().and_then(|name| name.parse().ok()) else {
            continue;
        };
        // Before its environment is read: the id may be given to another one then.
        let process = pid_of(pid).and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok());
        if let Some(process) = process.filter(|_| pid != std::process::id()) {
            match Marked::read(pid, &mark) {
                Marked::Yes => found.marked.push((pid, process)),
                Marked::Unclear => found.is_unclear = true,
                Marked::No => {}
            }
        }
    }
    found
}

fn pid_of(pid: u32) -> Option<Pid> {
    i32::try_from(pid).ok().and_then(Pid::from_raw)
}

/// Whether a process carries a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Marked {
    Yes,
    No,
    /// It is just being replaced by another program, or its memory is gone and it is not: for a moment,
    /// however long that is on a busy machine, it has neither environment nor arguments.
    Unclear,
}

impl Marked {
    fn read(pid: u32, mark: &[u8]) -> Self {
        let read = |name: &str| {
            let mut bytes = Vec::new();
            let file = File::open(format!("/proc/{pid}/{name}")).ok()?;
            let is_own = (file.metadata()).is_ok_and(|file| file.uid() == geteuid().as_raw());
            // A process that has ended has nothing any more.
            let read = file.take(ENVIRONMENT_BYTES_MAX).read_to_end(&mut bytes);
            (is_own && read.is_ok()).then_some(bytes)
        };
        let Some(environment) = read("environ") else {
            return Self::No;
        };
        if !environment.is_empty() {
            return Self::of(&environment, &[], &[], mark);
        }
        let [arguments, stat] = ["cmdline", "stat"].map(|name| read(name).unwrap_or_default());
        Self::of(&environment, &arguments, &stat, mark)
    }

    /// By what the kernel says of a process: the last two count without an environment only.
    fn of(environment: &[u8], arguments: &[u8], stat: &[u8], mark: &[u8]) -> Self {
        /// Bit of the flags of a thread of the kernel, which never has a program.
        const KERNEL: u64 = 0x0020_0000;
        if !environment.is_empty() {
            let is_marked = environment
                .split(|byte| *byte == 0)
                .any(|entry| entry == mark);
            return if is_marked { Self::Yes } else { Self::No };
        }
        let stat = String::from_utf8_lossy(stat);
        // After its name, which may be anything: state, parent, group, session, terminal, its group, flags.
        let rest = stat.rsplit(") ").next().unwrap_or_default();
        let mut fields = rest.split(' ');
        let state = fields.next().unwrap_or_default();
        let flags = fields.nth(5).and_then(|flags| flags.parse::<u64>().ok());
        let has_ended = ["", "Z", "X", "x"].contains(&state);
        let is_kernel = flags.is_none_or(|flags| flags & KERNEL != 0);
        if arguments.is_empty() && !has_ended && !is_kernel {
            Self::Unclear
        } else {
            Self::No
        }
    }
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
        assert_eq!(find(root).marked.len(), 0);
        assert!(other.try_wait().expect("looked at").is_none());
        let _ = other.kill();
        let _ = other.wait();
    }
    #[test]
    fn a_process_without_a_program_is_looked_at_again_and_others_are_not() {
        let mark = b"ZERONAV_STACK=/dev/shm/zn_a";
        let of = |environment: &[u8], arguments: &[u8], stat: &str| {
            Marked::of(environment, arguments, stat.as_bytes(), mark)
        };
        let own = [&b"A=1\0"[..], mark, b"\0"].concat();
        assert_eq!(of(&own, b"", ""), Marked::Yes);
        assert_eq!(
            of(b"A=1\0ZERONAV_STACK=/dev/shm/zn_ab\0", b"", ""),
            Marked::No
        );
        let running = "7 (a) b) R 1 7 7 0 -1 4194304 1";
        assert_eq!(of(b"", b"", running), Marked::Unclear);
        assert_eq!(of(b"", b"env\0-i\0", running), Marked::No, "it has none");
        for ended in [
            "7 (it) Z 1 7 7 0 -1 4194304 1",
            "7 (it) X 1 7 7 0 -1 4194304 1",
            "",
        ] {
            assert_eq!(of(b"", b"", ended), Marked::No, "{ended}");
        }
        let of_the_kernel = "2 (kthreadd) S 0 0 0 0 -1 2129984 0";
        assert_eq!(of(b"", b"", of_the_kernel), Marked::No);
    }

    /// A process that is killed gives its memory back before its locks, and long after its environment.
    #[test]
    fn who_was_killed_holds_no_lock_any_more() {
        let place = tempfile::tempdir().expect("a folder");
        let root = Path::new("/dev/shm/zn_no_such_domain3");
        let file = place.path().join("lock");
        let script = "import fcntl, sys, time\nlock = open(sys.argv[1], 'w')\n\
                      fcntl.flock(lock, fcntl.LOCK_SH)\nmemory = b'1' * (1 << 29)\n\
                      print(1, flush=True)\ntime.sleep(600)\n";
        let mut holder = Command::new("python3")
            .args(["-c", script])
            .arg(&file)
            .env(MARK, root)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .expect("started");
        let mut said = String::new();
        let mut out = std::io::BufReader::new(holder.stdout.take().expect("its output"));
        std::io::BufRead::read_line(&mut out, &mut said).expect("a line");
        assert_eq!(said, "1\n");
        assert_eq!(end(root), [holder.id()]);
        let lock = File::open(&file).expect("it");
        let how = rustix::fs::FlockOperation::NonBlockingLockExclusive;
        rustix::fs::flock(&lock, how).expect("nobody holds it");
        let _ = holder.wait();
    }
}
