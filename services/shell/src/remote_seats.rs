//! Seats that are filled on another host, and how those speak that take part: one JSON object per line, over a
//! socket in the domain's root folder that the link of the host opens.
//!
//! On the host of launch a process sits in each such seat and tells the link so ([`ToLink::Sit`]); it hears when
//! the process on the other host has ended. There, the supervisor hears which seats it has to fill
//! ([`FromLink::Wanted`]) and tells what became of them.

use crate::control::check_same_user;
use crate::folder::Folder;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::{Error, ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use zeronav_msgs::role::Role;

/// File name of the socket in the domain's root folder.
pub const LINK_SOCKET: &str = "link.sock";

/// File name of what the link counts, in the same folder: one JSON object, written once a second.
pub const LINK_REPORT: &str = "link.json";

/// Longest line. [bytes]
const LINE_BYTES_MAX: usize = 32 * 1024;

/// Longest [`Program::keys`]. [bytes]
pub const KEYS_BYTES_MAX: usize = 1024;

/// Longest [`Program::binary`]. [bytes]
pub const BINARY_BYTES_MAX: usize = 255;

/// Longest [`Held::why`]. [characters]
pub const WHY_CHARS_MAX: usize = 160;

/// A start of a seat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeatStart {
    /// Code of the role.
    pub role: u16,
    /// Which start of it.
    pub epoch: u32,
}

impl SeatStart {
    /// The role; `None` for one without a seat.
    #[must_use]
    pub fn role(self) -> Option<Role> {
        Role::from_code(self.role).filter(|role| Role::SERVICES.contains(role))
    }
}

/// What sits in a seat, where a swap has made it another than the scenario's. The configuration of the program that stands
/// for it on the host of launch.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// Name of the program, one of those that the scenario names for the seat; empty = the one in the seat.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub binary: String,
    /// Keys of its configuration, TOML.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub keys: String,
}

/// A start of a seat that is to be made on the other host.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wanted {
    /// The start.
    pub seat: SeatStart,
    /// What is to be started.
    #[serde(default)]
    pub program: Program,
}

/// What became of a start of a seat.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Held {
    /// The start.
    pub seat: SeatStart,
    /// Exit code of its process once that has ended; 128 and the signal's number when it was killed.
    pub ended: Option<u8>,
    /// What it said last before it failed, or why it could not be started; empty otherwise.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub why: String,
}

/// What the link is told.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ToLink {
    /// The sender sits in this seat for a process on the other host.
    Sit {
        /// The seat, and what is to be started in it.
        wanted: Wanted,
        /// Process id of the sender.
        pid: u32,
    },
    /// The sender fills the seats of this host: what became of each.
    Filled {
        /// The starts.
        held: Vec<Held>,
    },
}

/// What the link tells.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FromLink {
    /// The process on the other host has ended with this exit code.
    Ended {
        /// As in [`Held`].
        code: u8,
        /// As in [`Held`].
        why: String,
    },
    /// The seats that this host has to fill.
    Wanted {
        /// Name of the run, empty while there is none.
        run: String,
        /// The starts.
        seats: Vec<Wanted>,
        /// The run is over, or another one has begun.
        over: bool,
    },
}

/// One end of a connection. Nothing waits.
#[derive(Debug)]
pub struct Line {
    stream: UnixStream,
    came: Vec<u8>,
    unsent: Vec<u8>,
}

impl Line {
    /// Connects to the link in the domain's root folder.
    ///
    /// # Errors
    /// What the system says: `NotFound` or `ConnectionRefused` when there is no link.
    pub fn connect(folder: &Folder) -> std::io::Result<Self> {
        Self::new(UnixStream::connect(folder.entry(LINK_SOCKET))?)
    }

    /// The end of an accepted connection.
    ///
    /// # Errors
    /// `PermissionDenied` when the other end belongs to another user.
    pub fn new(stream: UnixStream) -> std::io::Result<Self> {
        check_same_user(&stream)?;
        stream.set_nonblocking(true)?;
        Ok(Self {
            stream,
            came: Vec::new(),
            unsent: Vec::new(),
        })
    }

    /// Sends a line, or what the socket takes of it; the rest goes with the next call of anything.
    ///
    /// # Errors
    /// What the system says; `WouldBlock` when the other end reads nothing.
    pub fn send(&mut self, what: &impl Serialize) -> std::io::Result<()> {
        serde_json::to_writer(&mut self.unsent, what)?;
        self.unsent.push(b'\n');
        self.flush()?;
        if self.unsent.len() > LINE_BYTES_MAX {
            return Err(ErrorKind::WouldBlock.into());
        }
        Ok(())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        while !self.unsent.is_empty() {
            match self.stream.write(&self.unsent) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(n) => drop(self.unsent.drain(..n)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// The lines that have come whole since the last call.
    ///
    /// # Errors
    /// `UnexpectedEof` when the other end is gone, `InvalidData` for lines that mean nothing.
    pub fn receive<T: DeserializeOwned>(&mut self) -> std::io::Result<Vec<T>> {
        self.flush()?;
        let mut piece = [0; 4096];
        let gone = loop {
            match self.stream.read(&mut piece) {
                Ok(0) => break true,
                Ok(n) => self.came.extend_from_slice(&piece[..n]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break false,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
            if self.came.len() > LINE_BYTES_MAX {
                break false;
            }
        };
        let mut lines = Vec::new();
        while let Some(end) = self.came.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = self.came.drain(..=end).collect();
            let line = serde_json::from_slice(&line);
            lines.push(line.map_err(|error| Error::new(ErrorKind::InvalidData, error))?);
        }
        if self.came.len() > LINE_BYTES_MAX {
            return Err(Error::new(ErrorKind::InvalidData, "a line without an end"));
        }
        if gone && lines.is_empty() {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        Ok(lines)
    }
}

impl AsFd for Line {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.stream.as_fd()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seat() -> SeatStart {
        SeatStart {
            role: Role::Mapping.code(),
            epoch: 2,
        }
    }

    fn pair() -> (Line, UnixStream) {
        let (one, other) = UnixStream::pair().expect("a pair");
        (Line::new(one).expect("the same user"), other)
    }

    #[test]
    fn lines_come_whole_and_in_order() {
        let (mut one, other) = pair();
        let mut other = Line::new(other).expect("the same user");
        let sit = ToLink::Sit {
            wanted: Wanted {
                seat: seat(),
                program: Program::default(),
            },
            pid: 7,
        };
        one.send(&sit).expect("sent");
        one.send(&ToLink::Filled {
            held: vec![Held {
                seat: seat(),
                ended: Some(3),
                why: "no map".to_owned(),
            }],
        })
        .expect("sent");
        let lines: Vec<ToLink> = other.receive().expect("lines");
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[0], sit);
        assert_eq!(seat().role(), Some(Role::Mapping));
        assert!(other.receive::<ToLink>().expect("nothing").is_empty());
        drop(one);
        let gone = other.receive::<ToLink>().expect_err("gone");
        assert_eq!(gone.kind(), ErrorKind::UnexpectedEof);
    }

    #[test]
    fn half_lines_wait_and_what_means_nothing_is_an_error() {
        let (mut one, mut other) = pair();
        other
            .write_all(br#"{"ended":{"why":"","code""#)
            .expect("written");
        assert!(one.receive::<FromLink>().expect("nothing yet").is_empty());
        other.write_all(b":1}}\n{}\n").expect("written");
        let error = one.receive::<FromLink>().expect_err("no such line");
        assert_eq!(error.kind(), ErrorKind::InvalidData);
        let (mut one, mut other) = pair();
        other
            .write_all(&vec![b'x'; LINE_BYTES_MAX + 1])
            .expect("written");
        let error = one.receive::<FromLink>().expect_err("no end");
        assert_eq!(error.kind(), ErrorKind::InvalidData);
    }
}
