//! The warden: a small process beside launch that ends what a dead launch left behind.
//!
//! When launch dies, its services bring the robot to rest and leave by themselves. One that hangs or
//! is stopped does not. The warden has a descriptor of every service and the names of the domains; it
//! waits until launch is gone, gives the services their time, kills those that are still there, with
//! what they have started, and removes the domains. Meanwhile it keeps the logs of all children short.
//! It is this program, started as `zeronav warden` with one end of a socket as standard input; the
//! kernel closes the other end when launch ends, in whatever way.

use super::crash_result::{self, Unread};
use super::descendants;
use super::log_limit::{Logs, PAUSE};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::net::{
    AddressFamily, RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, Shutdown, SocketFlags, SocketType, recvmsg, send, sendmsg,
    shutdown, socketpair,
};
use rustix::process::{Pid, Signal, kill_process_group, pidfd_send_signal};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};
use zeronav_shell::damage::{Damaged, damaged, read_last};
use zeronav_shell::half_made;

/// Name of the subcommand.
pub const COMMAND: &str = "warden";

/// How long services may take to leave after the death of launch.
const LEAVE_LIMIT: Duration = Duration::from_millis(1800);

/// Services that are remembered after their end.
const ROLES_MAX: usize = 10_000;

/// How long killed services may take to be gone.
const GONE_LIMIT: Duration = Duration::from_secs(2);

/// How long launch waits at most for its result to be written.
const SETTLE_LIMIT: Timespec = Timespec {
    tv_sec: 5,
    tv_nsec: 0,
};

/// Time between two tries to remove a domain.
const SWEEP_PAUSE: Duration = Duration::from_millis(20);

/// Longest message: a path with its word. [bytes]
const MESSAGE_BYTES_MAX: usize = 4096 + 16;

/// True in a program that is its own warden.
static ENABLED: AtomicBool = AtomicBool::new(false);

/// True while the warden has a result of this process's run.
static HAS_WILL: AtomicBool = AtomicBool::new(false);

/// Launch's end of the socket, once there was something to watch.
static SOCKET: OnceLock<Option<OwnedFd>> = OnceLock::new();

/// Says that this program has the subcommand [`COMMAND`]. Without this nothing is watched.
pub fn enable() {
    ENABLED.store(true, Ordering::Relaxed);
}

/// Starts the warden before there is anything to watch: launch may be killed while it makes a domain.
pub fn start() {
    tell("begin -", None);
}

/// Has a temporary folder, which this process is about to make, removed after its death.
pub(super) fn watch_folder(folder: &Path) {
    tell(&format!("folder {}", folder.display()), None);
}

/// Takes that back.
pub(super) fn forget_folder(folder: &Path) {
    tell(&format!("removed {}", folder.display()), None);
}

/// Has the domain at `root` removed after the death of this process.
pub fn watch_domain(root: &Path) {
    tell(&format!("domain {}", root.display()), None);
}

/// Has the process `pid`, a service or a companion of this name, ended after the death of this process, if it
/// does not leave by itself.
pub fn watch_process(name: &str, pid: u32, pidfd: BorrowedFd<'_>) {
    tell(&format!("service {pid} {name}"), Some(pidfd));
}

/// Has `result` put into the run's `folder` after the death of this process.
pub(super) fn keep_will(folder: &Path, result: BorrowedFd<'_>) {
    tell(&format!("will {}", folder.display()), Some(result));
    HAS_WILL.store(true, Ordering::Relaxed);
}

/// Takes that back.
pub(super) fn forget_will() {
    if HAS_WILL.swap(false, Ordering::Relaxed) {
        tell("forget -", None);
    }
}

/// Has done now what the warden does after the death of this process, which must follow at once; waits
/// until the result is written. False when none was left. For signal handlers, too: it makes system
/// calls alone.
pub(super) fn settle() -> bool {
    let Some(Some(socket)) = SOCKET.get() else {
        return false;
    };
    if !HAS_WILL.swap(false, Ordering::Relaxed) || shutdown(socket, Shutdown::Write).is_err() {
        return false;
    }
    let mut end = [PollFd::new(socket, PollFlags::IN)];
    let _ = poll(&mut end, Some(&SETTLE_LIMIT));
    true
}

/// [`settle`] when this process cannot read memory any more: the warden is told of which topic it read last,
/// and who writes that.
pub(super) fn settle_while_reading() -> bool {
    if let (Some(Some(socket)), Some(row)) = (SOCKET.get(), read_last()) {
        let mut bytes = [0; MESSAGE_BYTES_MAX];
        let writers = row.writers.iter().flat_map(|role| [" ", role.label()]);
        let words = ["read ", row.name].into_iter().chain(writers);
        let mut n = 0;
        // Without allocating: this may be a signal handler.
        for byte in words.flat_map(str::bytes).take(MESSAGE_BYTES_MAX) {
            bytes[n] = byte;
            n += 1;
        }
        let _ = send(
            socket,
            &bytes[..n],
            SendFlags::DONTWAIT | SendFlags::NOSIGNAL,
        );
    }
    settle()
}

/// Has the log of a child kept short, until this process is dead and all its services are gone.
pub fn watch_log(log: BorrowedFd<'_>) {
    tell("log -", Some(log));
}

fn tell(text: &str, descriptor: Option<BorrowedFd<'_>>) {
    if !ENABLED.load(Ordering::Relaxed) {
        return;
    }
    let socket = SOCKET.get_or_init(|| {
        spawn()
            .inspect_err(|error| tracing::warn!(%error, "the warden could not be started"))
            .ok()
    });
    let Some(socket) = socket else { return };
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut ancillary = SendAncillaryBuffer::new(&mut space);
    let descriptors: Vec<BorrowedFd<'_>> = descriptor.into_iter().collect();
    if !descriptors.is_empty() {
        ancillary.push(SendAncillaryMessage::ScmRights(&descriptors));
    }
    // A warden that does not listen must not keep launch waiting.
    let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
    if let Err(error) = sendmsg(
        socket,
        &[IoSlice::new(text.as_bytes())],
        &mut ancillary,
        flags,
    ) {
        tracing::warn!(%error, text, "the warden does not listen");
    }
}

/// Starts the process; launch's end of its socket.
fn spawn() -> std::io::Result<OwnedFd> {
    let (ours, theirs) = socketpair(
        AddressFamily::UNIX,
        SocketType::SEQPACKET,
        SocketFlags::CLOEXEC,
        None,
    )?;
    Command::new("/proc/self/exe")
        .arg(COMMAND)
        .stdin(theirs)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        // What the terminal sends to launch's group is not meant for the warden.
        .process_group(0)
        .spawn()?;
    Ok(ours)
}

/// A service that is watched.
struct Service {
    pid: Pid,
    pidfd: OwnedFd,
}

impl Service {
    /// True once it has ended.
    fn has_ended(&self, limit: Duration) -> bool {
        let timeout = Timespec {
            tv_sec: limit.as_secs().cast_signed(),
            tv_nsec: i64::from(limit.subsec_nanos()),
        };
        let mut descriptors = [PollFd::from_borrowed_fd(self.pidfd.as_fd(), PollFlags::IN)];
        matches!(poll(&mut descriptors, Some(&timeout)), Ok(1..))
    }

    fn kill(&self) {
        if !self.has_ended(Duration::ZERO) {
            let _ = pidfd_send_signal(&self.pidfd, Signal::KILL);
            let _ = kill_process_group(self.pid, Signal::KILL);
        }
    }
}

/// The warden itself: listens on standard input until launch is gone, then sees to what is left.
pub fn run() {
    // Asked to stop together with launch, it has its work still before it.
    for signal in zeronav_shell::signals::stopping() {
        let _ = signal_hook::flag::register(signal, Arc::new(AtomicBool::new(false)));
    }
    let mut watched = Watched::default();
    while watched.listen() {
        watched.logs.cut();
        watched.clear_up_after_the_dead();
        watched.domains.retain(|root| root.exists());
    }
    watched.execute_will();
    let Watched {
        services,
        mut domains,
        folders,
        mut logs,
        ..
    } = watched;
    let deadline = Instant::now() + LEAVE_LIMIT;
    while Instant::now() < deadline {
        let Some(last) = services.iter().find(|it| !it.has_ended(Duration::ZERO)) else {
            break;
        };
        last.has_ended(PAUSE.min(deadline.saturating_duration_since(Instant::now())));
        logs.cut();
    }
    services.iter().for_each(Service::kill);
    let deadline = Instant::now() + GONE_LIMIT;
    for service in &services {
        service.has_ended(deadline.saturating_duration_since(Instant::now()));
    }
    for root in &domains {
        descendants::end(root);
    }
    let deadline = Instant::now() + GONE_LIMIT;
    for folder in folders {
        let _ = std::fs::remove_dir_all(folder);
    }
    logs.cut();
    // Launch may have been killed before it could say that it has made a domain.
    let _ = zeronav_shell::domain::sweep_dead();
    // A service that was started by hand may still be a member; the last one out removes the domain.
    while Instant::now() < deadline {
        domains.retain(|root| !zeronav_shell::domain::sweep(root).unwrap_or(false));
        if domains.is_empty() {
            break;
        }
        std::thread::sleep(SWEEP_PAUSE);
    }
}

/// What the warden has been told of.
#[derive(Default)]
struct Watched {
    services: Vec<Service>,
    domains: Vec<PathBuf>,
    folders: Vec<PathBuf>,
    logs: Logs,
    /// Folder of a run and its result.
    will: Option<(PathBuf, File)>,
    /// The topic that launch could not read, and the seats that write it.
    unread: Option<(String, Vec<String>)>,
    /// The seats of all services so far.
    roles: BTreeMap<u32, String>,
    /// The newest service of each seat.
    newest: BTreeMap<String, u32>,
}

impl Watched {
    /// Forgets the services that have ended, and removes segments that they had begun: whoever waits for one waits
    /// long, launch before all, which cannot see to it then.
    fn clear_up_after_the_dead(&mut self) {
        let before = self.services.len();
        self.services
            .retain(|service| !service.has_ended(Duration::ZERO));
        if self.services.len() < before {
            for root in &self.domains {
                half_made::remove(root);
            }
        }
    }

    /// Puts the result in its place that launch has not taken back. Segments are looked at first: their
    /// makers remove them when they leave.
    fn execute_will(&mut self) {
        if let Some((folder, result)) = self.will.take() {
            let damaged: Vec<(Damaged, Vec<String>)> = (self.domains.iter())
                .flat_map(|root| damaged(root))
                .map(|segment| {
                    let authors = (segment.pids.iter())
                        .filter_map(|pid| Some(format!("{} (pid {pid})", self.roles.get(pid)?)))
                        .collect();
                    (segment, authors)
                })
                .collect();
            let unread = self.unread.take();
            let unread = unread.map(|(topic, roles)| Unread {
                topic,
                authors: self.possible_authors(&roles),
            });
            crash_result::write(&folder, result, &damaged, unread.as_ref());
        }
        let _ = shutdown(std::io::stdin(), Shutdown::Write);
    }

    /// The newest service of each of these seats, and every other that has not ended. The newest may just have
    /// crashed, too, since it read what it had overwritten.
    fn possible_authors(&self, roles: &[String]) -> Vec<String> {
        let newest = roles.iter().filter_map(|role| self.newest.get(role));
        let living = (self.services.iter()).filter(|service| !service.has_ended(Duration::ZERO));
        let living = living.map(|service| service.pid.as_raw_nonzero().get().unsigned_abs());
        let pids: BTreeSet<u32> = newest.copied().chain(living).collect();
        let author = |pid: u32| {
            let role = self.roles.get(&pid)?;
            let writes = roles.contains(role);
            writes.then(|| format!("{role} (pid {pid})"))
        };
        pids.into_iter().filter_map(author).collect()
    }

    /// Takes in one message, or waits a moment while there are logs; false when launch is gone.
    fn listen(&mut self) -> bool {
        let stdin = std::io::stdin();
        let mut descriptors = [PollFd::new(&stdin, PollFlags::IN)];
        let pause = Timespec {
            tv_sec: 0,
            tv_nsec: i64::from(PAUSE.subsec_nanos()),
        };
        if matches!(
            poll(&mut descriptors, self.logs.any().then_some(&pause)),
            Ok(0)
        ) {
            return true;
        }
        let mut bytes = [0; MESSAGE_BYTES_MAX];
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut ancillary = RecvAncillaryBuffer::new(&mut space);
        let received = recvmsg(
            std::io::stdin(),
            &mut [IoSliceMut::new(&mut bytes)],
            &mut ancillary,
            RecvFlags::CMSG_CLOEXEC,
        );
        let n = match received {
            Ok(message) if message.bytes > 0 => message.bytes,
            Err(Errno::INTR) => return true,
            Ok(_) | Err(_) => return false,
        };
        let descriptor = ancillary.drain().find_map(|message| match message {
            RecvAncillaryMessage::ScmRights(mut descriptors) => descriptors.next(),
            _ => None,
        });
        let text = core::str::from_utf8(&bytes[..n]).unwrap_or_default();
        match (text.split_once(' '), descriptor) {
            (Some(("service", said)), Some(pidfd)) => {
                let (number, role) = said.split_once(' ').unwrap_or((said, ""));
                let pid = number.parse().ok().and_then(Pid::from_raw);
                self.services.extend(pid.map(|pid| Service { pid, pidfd }));
                if let Ok(pid) = number.parse() {
                    self.newest.insert(role.to_owned(), pid);
                    self.roles.insert(pid, role.to_owned());
                    if self.roles.len() > ROLES_MAX {
                        self.roles.pop_first();
                    }
                }
            }
            (Some(("will", folder)), Some(result)) => {
                self.will = Some((PathBuf::from(folder), File::from(result)));
            }
            (Some(("forget", _)), _) => self.will = None,
            (Some(("read", said)), _) => {
                let mut words = said.split(' ').map(str::to_owned);
                self.unread = words.next().map(|topic| (topic, words.collect()));
            }
            (Some(("log", _)), Some(log)) => self.logs.add(File::from(log)),
            (Some(("domain", root)), _) => self.domains.push(PathBuf::from(root)),
            (Some(("folder", path)), _) => self.folders.push(PathBuf::from(path)),
            (Some(("removed", path)), _) => self.folders.retain(|folder| folder != Path::new(path)),
            _ => {}
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::process::{PidfdFlags, pidfd_open};

    #[test]
    fn who_crashed_with_launch_may_have_written_what_it_read() {
        let own = rustix::process::getpid();
        let mut watched = Watched::default();
        let mut came = |pid: u32, role: &str| {
            watched.roles.insert(pid, role.to_owned());
            watched.newest.insert(role.to_owned(), pid);
        };
        // A predecessor that has ended, one that has not and its newcomer that has, and another seat.
        let own_id = own.as_raw_nonzero().get().unsigned_abs();
        let (gone, crashed, other) = (own_id + 1, own_id + 2, own_id + 3);
        came(gone, "mapping");
        came(own_id, "mapping");
        came(crashed, "mapping");
        came(other, "robot");
        let pidfd = pidfd_open(own, PidfdFlags::empty()).expect("this process");
        watched.services.push(Service { pid: own, pidfd });
        let authors = watched.possible_authors(&["mapping".to_owned(), "local_planner".to_owned()]);
        let named = |pid| format!("mapping (pid {pid})");
        assert_eq!(authors, [named(own_id), named(crashed)]);
    }
}
