//! The warden: a small process beside launch that ends what a dead launch left behind.
//!
//! When launch dies, its services bring the robot to rest and leave by themselves. One that hangs or
//! is stopped does not. The warden has a descriptor of every service and the names of the domains; it
//! waits until launch is gone, gives the services their time, kills those that are still there and
//! removes the domains. Meanwhile it keeps the logs of all children short. It is this program, started as `zeronav warden` with one end of a socket as
//! standard input; the kernel closes the other end when launch ends, in whatever way.

use super::log_limit::{Logs, PAUSE};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::net::{
    AddressFamily, RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, SocketFlags, SocketType, recvmsg, sendmsg, socketpair,
};
use rustix::process::{Pid, Signal, kill_process_group, pidfd_send_signal};
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

/// Name of the subcommand.
pub const COMMAND: &str = "warden";

/// How long services may take to leave after the death of launch.
const LEAVE_LIMIT: Duration = Duration::from_millis(1800);

/// How long killed services may take to be gone.
const GONE_LIMIT: Duration = Duration::from_secs(2);

/// Time between two tries to remove a domain.
const SWEEP_PAUSE: Duration = Duration::from_millis(20);

/// Longest message.
const MESSAGE_BYTES_MAX: usize = 256;

/// True in a program that is its own warden.
static ENABLED: AtomicBool = AtomicBool::new(false);

/// Launch's end of the socket, once there was something to watch.
static SOCKET: OnceLock<Option<OwnedFd>> = OnceLock::new();

/// Says that this program has the subcommand [`COMMAND`]. Without this nothing is watched.
pub fn enable() {
    ENABLED.store(true, Ordering::Relaxed);
}

/// Has the domain at `root` removed after the death of this process.
pub fn watch_domain(root: &Path) {
    tell(&format!("domain {}", root.display()), None);
}

/// Has the service `pid` ended after the death of this process, if it does not leave by itself.
pub fn watch_service(pid: u32, pidfd: BorrowedFd<'_>) {
    tell(&format!("service {pid}"), Some(pidfd));
}

/// Has the log of a child kept short, until this process is dead and all its services are gone.
pub(crate) fn watch_log(log: BorrowedFd<'_>) {
    tell("log -", Some(log));
}

fn tell(text: &str, descriptor: Option<BorrowedFd<'_>>) {
    if !ENABLED.load(Ordering::Relaxed) {
        return;
    }
    let socket = SOCKET.get_or_init(|| {
        start()
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

/// Starts the warden; launch's end of its socket.
fn start() -> std::io::Result<OwnedFd> {
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
    let mut services: Vec<Service> = Vec::new();
    let mut domains: Vec<PathBuf> = Vec::new();
    let mut logs = Logs::default();
    while listen(&mut services, &mut domains, &mut logs) {
        logs.cut();
        services.retain(|service| !service.has_ended(Duration::ZERO));
        domains.retain(|root| root.exists());
    }
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
    logs.cut();
    // A service that was started by hand may still be a member; the last one out removes the domain.
    while Instant::now() < deadline {
        domains.retain(|root| !zeronav_shell::domain::sweep(root).unwrap_or(false));
        if domains.is_empty() {
            break;
        }
        std::thread::sleep(SWEEP_PAUSE);
    }
}

/// Takes in one message, or waits a moment while there are logs; false when launch is gone.
fn listen(services: &mut Vec<Service>, domains: &mut Vec<PathBuf>, logs: &mut Logs) -> bool {
    let stdin = std::io::stdin();
    let mut descriptors = [PollFd::new(&stdin, PollFlags::IN)];
    let pause = Timespec {
        tv_sec: 0,
        tv_nsec: i64::from(PAUSE.subsec_nanos()),
    };
    if matches!(poll(&mut descriptors, logs.any().then_some(&pause)), Ok(0)) {
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
        (Some(("service", pid)), Some(pidfd)) => {
            let pid = pid.parse().ok().and_then(Pid::from_raw);
            services.extend(pid.map(|pid| Service { pid, pidfd }));
        }
        (Some(("log", _)), Some(log)) => logs.add(File::from(log)),
        (Some(("domain", root)), _) => domains.push(PathBuf::from(root)),
        _ => {}
    }
    true
}
