//! The client's end of a run's control socket: one line asked, one line answered. Launch answers.
//!
//! The socket lies in the domain's root folder, which only the same user can enter; both ends look
//! at the other's user id all the same.

use crate::folder::Folder;
use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

/// File name of the socket in the domain's root folder.
pub const SOCKET: &str = "control.sock";

/// Longest line, asked or answered. [bytes]
pub const LINE_BYTES_MAX: usize = 64 * 1024;

/// How long a client waits for an answer, and how long the run keeps a connection.
pub const PATIENCE: Duration = Duration::from_secs(5);

/// Accepts a peer with the caller's own user id.
///
/// # Errors
/// `PermissionDenied` naming the other one.
pub fn check_same_user(stream: &UnixStream) -> std::io::Result<()> {
    let peer = rustix::net::sockopt::socket_peercred(stream)?;
    if peer.uid == rustix::process::geteuid() {
        Ok(())
    } else {
        Err(Error::new(
            ErrorKind::PermissionDenied,
            format!("the other end belongs to user id {}", peer.uid.as_raw()),
        ))
    }
}

/// Asks the run in the domain's root folder: `line` has no end of line, nor has the answer.
///
/// # Errors
/// What the system says, and `PermissionDenied` when the other end is not the same user.
pub fn ask(folder: &Folder, line: &str) -> std::io::Result<Vec<u8>> {
    let mut stream = UnixStream::connect(folder.entry(SOCKET))?;
    check_same_user(&stream)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    stream.write_all(format!("{line}\n").as_bytes())?;
    let mut answer = Vec::new();
    let limit = u64::try_from(LINE_BYTES_MAX).unwrap_or(u64::MAX);
    BufReader::new(&stream)
        .take(limit)
        .read_until(b'\n', &mut answer)?;
    answer.pop_if(|last| *last == b'\n');
    Ok(answer)
}
