//! The control socket of a run: one JSON object per line, asked and answered.
//!
//! It lies in the domain's root folder, which only the same user can enter; both ends look at the
//! other's user id all the same. The run's end never waits: one poll over the listener and every
//! connection, a bounded number of connections, bounded lines, a time limit for each.

use super::request::{Reply, Request};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::collections::VecDeque;
use std::io::{Error, ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::net::{UnixListener, UnixStream};
use std::time::Instant;
use zeronav_shell::control::{
    self, ANSWER_BYTES_MAX, LINE_BYTES_MAX, PATIENCE, SOCKET, check_same_user,
};
use zeronav_shell::folder::{FILE_MODE, Folder};

/// Connections that the run keeps at a time; one more takes the place of the oldest.
const CLIENTS_MAX: usize = 16;

/// Connections that one look accepts.
const ACCEPTS_MAX: usize = 64;

/// The run's end of the socket.
#[derive(Debug)]
pub(crate) struct Server {
    listener: UnixListener,
    /// The oldest first.
    clients: VecDeque<Client>,
}

/// A connection that has asked or been answered in part.
#[derive(Debug)]
struct Client {
    stream: UnixStream,
    since: Instant,
    asked: Vec<u8>,
    /// What is left of the answer; empty until the line was complete.
    answer: Vec<u8>,
}

impl Server {
    /// Opens the socket in the domain's root folder.
    ///
    /// # Errors
    /// What the system says.
    pub(crate) fn open(folder: &Folder) -> std::io::Result<Self> {
        let path = folder.entry(SOCKET);
        let listener = UnixListener::bind(&path)?;
        let mode = rustix::fs::Mode::from_raw_mode(FILE_MODE);
        rustix::fs::chmod(&path, mode)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            clients: VecDeque::new(),
        })
    }

    /// Answers what has been asked completely since the last call. It waits for nothing.
    pub(crate) fn serve(&mut self, mut answer: impl FnMut(Request) -> Reply) {
        let (news, ready) = self.poll();
        let mut ready = ready.into_iter();
        self.clients.retain_mut(|client| {
            let ready = ready.next().unwrap_or(false);
            client.since.elapsed() < PATIENCE && (!ready || client.go_on(&mut answer))
        });
        if !news {
            return;
        }
        for _ in 0..ACCEPTS_MAX {
            let Ok((stream, _)) = self.listener.accept() else {
                return;
            };
            if check_same_user(&stream).is_err() || stream.set_nonblocking(true).is_err() {
                continue;
            }
            let mut client = Client {
                stream,
                since: Instant::now(),
                asked: Vec::new(),
                answer: Vec::new(),
            };
            // Most have asked by now and are answered at once, however many others are silent.
            if client.go_on(&mut answer) {
                if self.clients.len() == CLIENTS_MAX {
                    self.clients.pop_front();
                }
                self.clients.push_back(client);
            }
        }
    }

    /// One look: whether connections wait to be accepted, and which of the clients can go on.
    fn poll(&self) -> (bool, Vec<bool>) {
        let wanted = |client: &Client| {
            if client.answer.is_empty() {
                PollFlags::IN
            } else {
                PollFlags::OUT
            }
        };
        let mut looks: Vec<PollFd<'_>> = self
            .clients
            .iter()
            .map(|client| PollFd::from_borrowed_fd(client.stream.as_fd(), wanted(client)))
            .collect();
        looks.push(PollFd::new(&self.listener, PollFlags::IN));
        if poll(&mut looks, Some(&Timespec::default())).is_err() {
            return (false, vec![false; self.clients.len()]);
        }
        let mut ready: Vec<bool> = looks
            .iter()
            .map(|look| !look.revents().is_empty())
            .collect();
        let news = ready.pop().unwrap_or(false);
        (news, ready)
    }
}

impl Client {
    /// Reads what is there and writes what can be taken; false when the connection is done.
    fn go_on(&mut self, answer: &mut impl FnMut(Request) -> Reply) -> bool {
        self.exchange(answer)
            .unwrap_or_else(|error| error.kind() == ErrorKind::WouldBlock)
    }

    fn exchange(&mut self, answer: &mut impl FnMut(Request) -> Reply) -> std::io::Result<bool> {
        if self.answer.is_empty() {
            let Some(line) = self.line()? else {
                return Ok(false);
            };
            let reply = match serde_json::from_slice(&line) {
                Ok(request) => answer(request),
                Err(error) => Reply::Error(format!("not a request: {error}")),
            };
            self.answer = in_a_line(&reply)?;
        }
        while !self.answer.is_empty() {
            let written = self.stream.write(&self.answer)?;
            if written == 0 {
                return Ok(false);
            }
            self.answer.drain(..written);
        }
        Ok(false)
    }

    /// The complete line; `WouldBlock` before it is, `None` when it never will be.
    fn line(&mut self) -> std::io::Result<Option<Vec<u8>>> {
        let mut piece = [0; 4096];
        loop {
            if let Some(end) = self.asked.iter().position(|byte| *byte == b'\n') {
                self.asked.truncate(end);
                return Ok(Some(core::mem::take(&mut self.asked)));
            }
            if self.asked.len() >= LINE_BYTES_MAX {
                return Ok(None);
            }
            match self.stream.read(&mut piece)? {
                0 => return Ok(None),
                read => self.asked.extend_from_slice(&piece[..read]),
            }
        }
    }
}

/// An answer and its end of line; no longer than a client reads.
fn in_a_line(reply: &Reply) -> std::io::Result<Vec<u8>> {
    let mut line = serde_json::to_vec(reply).map_err(Error::other)?;
    if line.len() > ANSWER_BYTES_MAX {
        let why = format!("the answer is longer than {ANSWER_BYTES_MAX} bytes");
        line = serde_json::to_vec(&Reply::Error(why)).map_err(Error::other)?;
    }
    line.push(b'\n');
    Ok(line)
}

/// Asks the run in the domain's root folder.
///
/// # Errors
/// What the system says, `PermissionDenied` when the other end is not the same user, or an answer
/// that cannot be read.
pub(crate) fn ask(folder: &Folder, request: &Request) -> std::io::Result<Reply> {
    let text = serde_json::to_string(request).map_err(Error::other)?;
    let answer = control::ask(folder, &text)?;
    serde_json::from_slice(&answer).map_err(Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::time::Duration;

    /// A folder with a server in it, removed with the first field.
    fn opened() -> (tempfile::TempDir, Folder, Server) {
        let place = tempfile::tempdir().expect("a temporary folder");
        let folder = Folder::create(&place.path().join("root")).expect("a folder");
        let server = Server::open(&folder).expect("a socket");
        (place, folder, server)
    }

    fn connect(folder: &Folder) -> UnixStream {
        UnixStream::connect(folder.entry(SOCKET)).expect("a connection")
    }

    fn answered(stream: &UnixStream) -> String {
        let mut line = String::new();
        let limit = Some(Duration::from_secs(5));
        stream.set_read_timeout(limit).expect("a limit");
        let _ = BufReader::new(stream).read_line(&mut line);
        line
    }

    #[test]
    fn requests_and_bad_lines_get_one_answer_each() {
        let (_place, folder, mut server) = opened();
        let request = Request::Step { ticks: 7 };
        let wanted = request.clone();
        let client = std::thread::spawn(move || {
            let good = ask(&folder, &request);
            let mut stream = connect(&folder);
            stream
                .write_all(b"{\"command\":\"fly\"}\n")
                .expect("written");
            (good, answered(&stream))
        });
        let mut seen = Vec::new();
        while !client.is_finished() {
            server.serve(|request| {
                seen.push(request);
                Reply::Done
            });
            std::thread::yield_now();
        }
        let (good, bad) = client.join().expect("the client ends");
        assert_eq!(good.expect("an answer"), Reply::Done);
        assert!(bad.contains("not a request"), "{bad}");
        assert_eq!(seen, [wanted]);
    }

    #[test]
    fn silent_and_slow_connections_cost_nothing_and_keep_no_other_from_its_answer() {
        let (_place, folder, mut server) = opened();
        let silent: Vec<UnixStream> = (0..50).map(|_| connect(&folder)).collect();
        let mut slow = connect(&folder);
        slow.write_all(b"{\"command\":").expect("written");
        let mut quick = connect(&folder);
        quick.write_all(b"{\"command\":\"ps\"}\n").expect("written");
        let started = Instant::now();
        server.serve(|_| Reply::Done);
        let took = started.elapsed();
        assert!(took < Duration::from_millis(50), "one look took {took:?}");
        assert_eq!(server.clients.len(), CLIENTS_MAX);
        assert_eq!(answered(&quick), "\"done\"\n");
        slow.write_all(b"\"ps\"}\n").expect("written");
        server.serve(|_| Reply::Done);
        assert_eq!(answered(&slow), "\"done\"\n");
        assert_eq!(server.clients.len(), CLIENTS_MAX - 1);
        // The oldest had to go; the others are still connected.
        let mut first = &silent[0];
        assert_eq!(first.read(&mut [0]).expect("its end"), 0);
    }

    #[test]
    fn a_line_without_end_is_cut_off() {
        let (_place, folder, mut server) = opened();
        let mut stream = connect(&folder);
        stream.set_nonblocking(true).expect("a mode");
        let mut sent = 0;
        loop {
            match stream.write(&[b'x'; 4096]) {
                Ok(written) => sent += written,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(_) => break,
            }
            server.serve(|_| Reply::Done);
            let kept = server
                .clients
                .front()
                .map_or(0, |client| client.asked.len());
            assert!(kept <= LINE_BYTES_MAX, "{kept} bytes are kept");
            assert!(sent < 100 * LINE_BYTES_MAX, "never cut off");
        }
        assert!(server.clients.is_empty());
    }

    #[test]
    fn an_answer_that_is_not_taken_waits_in_the_background() {
        let (_place, folder, mut server) = opened();
        let mut stream = connect(&folder);
        stream
            .write_all(b"{\"command\":\"ps\"}\n")
            .expect("written");
        // More than the kernel buffers for a connection.
        let long = Reply::Error("x".repeat(ANSWER_BYTES_MAX - 100));
        server.serve(|_| long.clone());
        assert_eq!(server.clients.len(), 1);
        let reader = std::thread::spawn(move || answered(&stream).len());
        while !reader.is_finished() {
            server.serve(|_| Reply::Done);
            std::thread::yield_now();
        }
        assert!(reader.join().expect("the reader ends") > ANSWER_BYTES_MAX - 100);
        assert!(server.clients.is_empty());
    }

    #[test]
    fn an_answer_longer_than_clients_read_is_an_error_that_says_so() {
        let whole = Reply::Error("x".repeat(ANSWER_BYTES_MAX / 2));
        assert!(in_a_line(&whole).expect("a line").len() > ANSWER_BYTES_MAX / 2);
        let long = in_a_line(&Reply::Error("x".repeat(ANSWER_BYTES_MAX))).expect("a line");
        let long = String::from_utf8(long).expect("text");
        assert!(
            long.contains("is longer than") && long.len() < 100,
            "{long}"
        );
    }
}
