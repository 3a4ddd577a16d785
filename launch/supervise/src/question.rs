//! What a binary answers to a flag that makes it print something and leave. It may be any program:
//! it may print without end, hang, or be none.

use super::child::Child;
use super::own_time::Patience;
use super::process::{end_with_this_thread, hint};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open};
use std::ffi::OsStr;
use std::io::Read;
use std::os::fd::AsFd;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Longest time that an answer may take, of the program's own: time without a processor does not count.
const LIMIT: Duration = Duration::from_secs(5);

/// Longest time in any case.
const WALL_LIMIT: Duration = Duration::from_secs(300);

/// Longest answer. [bytes]
const BYTES_MAX: usize = 4 << 20;

/// Longest wait between two looks at the time.
const PAUSE: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 100_000_000,
};

const NO_TIME: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 0,
};

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum Silence {
    /// It cannot be started.
    #[error("cannot be started: {0}{hint}", hint = hint(.0))]
    Start(#[from] std::io::Error),
    /// It neither answered nor ended.
    #[error("no answer within {} s", LIMIT.as_secs())]
    Late,
    /// It printed without end.
    #[error("more than {} MB of answer", BYTES_MAX >> 20)]
    Flood,
    /// It ended with another exit code than 0.
    #[error("{how}{}{}", if said.is_empty() { "" } else { ": " }, headline(said))]
    Refused {
        /// How it ended.
        how: String,
        /// What it wrote to standard error.
        said: String,
    },
}

/// The first line of a text that says something, cut when it is very long.
pub fn headline(text: &str) -> String {
    const CHARS_MAX: usize = 400;
    let line = text.lines().map(str::trim).find(|line| !line.is_empty());
    line.unwrap_or_default().chars().take(CHARS_MAX).collect()
}

/// Starts `binary` with `arguments` and reads what it prints until it leaves with exit code 0.
///
/// # Errors
/// See [`Silence`]; whatever it was, the process is gone.
pub fn ask(binary: &Path, arguments: &[&OsStr]) -> Result<String, Silence> {
    let mut command = Command::new(binary);
    command
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .process_group(0);
    end_with_this_thread(&mut command, Signal::KILL);
    let mut process = command.spawn()?;
    let heard = listen(&mut process);
    if heard.is_err() {
        let group = i32::try_from(process.id()).ok().and_then(Pid::from_raw);
        if let Some(group) = group {
            let _ = kill_process_group(group, Signal::KILL);
        }
        let _ = process.wait();
    }
    let Heard { status, texts } = heard?;
    let [answer, said] = texts.map(|text| String::from_utf8_lossy(&text).into_owned());
    if status.success() {
        return Ok(answer);
    }
    Err(Silence::Refused {
        how: Child::end_in_words(status),
        said,
    })
}

/// A process that has ended.
struct Heard {
    status: ExitStatus,
    texts: [Vec<u8>; 2],
}

/// Reads both outputs until the process has ended.
fn listen(process: &mut std::process::Child) -> Result<Heard, Silence> {
    let deadline = Instant::now() + WALL_LIMIT;
    let mut patience = Patience::with(process.id());
    let pid = i32::try_from(process.id()).ok().and_then(Pid::from_raw);
    let pid = pid.ok_or_else(|| std::io::Error::other("no process id"))?;
    let end = pidfd_open(pid, PidfdFlags::empty()).map_err(std::io::Error::from)?;
    let mut texts = [Vec::new(), Vec::new()];
    let (mut stdout, mut stderr) = (process.stdout.take(), process.stderr.take());
    loop {
        // Before the outputs are read: what it wrote last is read after it ended.
        let ended = process.try_wait()?;
        let mut open = Vec::with_capacity(3);
        open.extend(stdout.as_ref().map(|pipe| PollFd::new(pipe, PollFlags::IN)));
        open.extend(stderr.as_ref().map(|pipe| PollFd::new(pipe, PollFlags::IN)));
        let wait = if ended.is_some() {
            NO_TIME
        } else {
            open.push(PollFd::new(&end, PollFlags::IN));
            PAUSE
        };
        let ready = poll(&mut open, Some(&wait)).unwrap_or(0);
        let [answer, said] = &mut texts;
        take(&mut stdout, answer)?;
        take(&mut stderr, said)?;
        if texts.iter().any(|text| text.len() > BYTES_MAX) {
            return Err(Silence::Flood);
        }
        // Others may hold its outputs open for ever.
        if let Some(status) = ended.filter(|_| ready == 0 || (stdout.is_none() && stderr.is_none()))
        {
            return Ok(Heard { status, texts });
        }
        if patience.is_over(LIMIT) || Instant::now() > deadline {
            return Err(Silence::Late);
        }
    }
}

/// Reads once from a pipe that has something; `None` from its end on.
fn take(pipe: &mut Option<impl Read + AsFd>, text: &mut Vec<u8>) -> Result<(), Silence> {
    let Some(open) = pipe else {
        return Ok(());
    };
    let mut descriptors = [PollFd::new(open, PollFlags::IN)];
    if poll(&mut descriptors, Some(&NO_TIME)).unwrap_or(0) == 0 {
        return Ok(());
    }
    let mut bytes = [0; 1 << 14];
    match open.read(&mut bytes) {
        Ok(0) => *pipe = None,
        Ok(length) => text.extend_from_slice(&bytes[..length]),
        Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
        Err(error) => return Err(error.into()),
    }
    Ok(())
}
