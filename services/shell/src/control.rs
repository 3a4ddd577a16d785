//! The client's end of a run's control socket: one line asked, one line answered. Launch answers.
//!
//! The socket lies in the domain's root folder, which only the same user can enter; both ends look
//! at the other's user id all the same.

use crate::folder::Folder;
use rustix::net::sockopt::{Timeout, set_socket_timeout, socket_peercred};
use rustix::net::{AddressFamily, SocketAddrUnix, SocketFlags, SocketType, connect, socket_with};
use std::io::{Error, ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

/// File name of the socket in the domain's root folder.
pub const SOCKET: &str = "control.sock";

/// Longest line that can be asked. [bytes]
pub const LINE_BYTES_MAX: usize = 64 * 1024;

/// Longest line that is answered. [bytes]
pub const ANSWER_BYTES_MAX: usize = 1024 * 1024;

/// How long a client waits for an answer, and how long the run keeps a connection.
pub const PATIENCE: Duration = Duration::from_secs(5);

/// Accepts a peer with the caller's own user id; its process id. Of a run's end of the socket, that is
/// the process that opened it: launch.
///
/// # Errors
/// `PermissionDenied` naming the other one.
pub fn check_same_user(stream: &UnixStream) -> std::io::Result<rustix::process::Pid> {
    let peer = socket_peercred(stream)?;
    if peer.uid == rustix::process::geteuid() {
        Ok(peer.pid)
    } else {
        Err(Error::new(
            ErrorKind::PermissionDenied,
            format!("the other end belongs to user id {}", peer.uid.as_raw()),
        ))
    }
}

/// The process that answers for the run in the domain's root folder, whether or not it does.
///
/// # Errors
/// As [`ask`]; `NotFound` or `ConnectionRefused` when there is no such process.
pub fn answering_process(folder: &Folder) -> std::io::Result<rustix::process::Pid> {
    check_same_user(&connection(folder)?)
}

/// A connection to the run; `WouldBlock` when too many others wait for one.
fn connection(folder: &Folder) -> std::io::Result<UnixStream> {
    let socket = socket_with(
        AddressFamily::UNIX,
        SocketType::STREAM,
        SocketFlags::CLOEXEC,
        None,
    )?;
    // The kernel's queue of a run that accepts nothing may be full.
    set_socket_timeout(&socket, Timeout::Send, Some(PATIENCE))?;
    connect(&socket, &SocketAddrUnix::new(folder.entry(SOCKET))?)?;
    Ok(UnixStream::from(socket))
}

/// Asks the run in the domain's root folder: `line` has no end of line, nor has the answer.
///
/// # Errors
/// What the system says: `NotFound` or `ConnectionRefused` when there is no run, `WouldBlock` when it
/// has not answered within [`PATIENCE`], `PermissionDenied` when the other end is not the same user,
/// `UnexpectedEof` or `FileTooLarge` when the answer has no end.
pub fn ask(folder: &Folder, line: &str) -> std::io::Result<Vec<u8>> {
    let mut stream = connection(folder)?;
    check_same_user(&stream)?;
    let deadline = Instant::now() + PATIENCE;
    stream.write_all(format!("{line}\n").as_bytes())?;
    let mut answer = Vec::new();
    let mut piece = [0; 4096];
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        // A timeout of 0 would be none.
        stream.set_read_timeout(Some(left.max(Duration::from_millis(1))))?;
        let read = stream.read(&mut piece)?;
        let (piece, ends) = match piece[..read].iter().position(|byte| *byte == b'\n') {
            Some(end) => (&piece[..end], true),
            None => (&piece[..read], false),
        };
        answer.extend_from_slice(piece);
        if answer.len() > ANSWER_BYTES_MAX {
            let why = format!("the answer is longer than {ANSWER_BYTES_MAX} bytes");
            return Err(Error::new(ErrorKind::FileTooLarge, why));
        }
        if ends {
            return Ok(answer);
        }
        if read == 0 {
            let why = "the connection ended before the answer did";
            return Err(Error::new(ErrorKind::UnexpectedEof, why));
        }
        if left.is_zero() {
            return Err(ErrorKind::WouldBlock.into());
        }
    }
}
