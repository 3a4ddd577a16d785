//! A viewer and those who talk to it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStdout, Stdio};
use std::time::{Duration, Instant};
use zeronav_tests::command;

/// `zeronav view` on a stack, once it has printed its link.
pub(super) struct Viewer {
    pub(super) process: Child,
    _output: BufReader<ChildStdout>,
    pub(super) link: String,
}

impl Viewer {
    pub(super) fn start(root: &str, more: &[&str]) -> Self {
        Self::start_in(root, more, &std::env::var("PATH").unwrap_or_default())
    }

    /// The same with programs looked for in these folders.
    pub(super) fn start_in(root: &str, more: &[&str], path: &str) -> Self {
        let mut process = command()
            .args(["view", "--domain", root])
            .args(more)
            .env("PATH", path)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .expect("zeronav starts");
        let mut output = BufReader::new(process.stdout.take().expect("its output"));
        let mut link = String::new();
        output.read_line(&mut link).expect("its link");
        let link = link.trim().to_owned();
        assert!(link.starts_with("http://127.0.0.1:"), "{link:?}");
        Self {
            process,
            _output: output,
            link,
        }
    }

    /// `127.0.0.1:PORT` and the token.
    pub(super) fn address(&self) -> (String, String) {
        let rest = self.link.trim_start_matches("http://");
        let (host, token) = rest.split_once('/').expect("a path");
        (host.to_owned(), token.trim_start_matches('#').to_owned())
    }

    /// Its exit code, once the stack is gone.
    pub(super) fn code(mut self) -> Option<i32> {
        let began = Instant::now();
        while self.process.try_wait().expect("its state").is_none() {
            assert!(
                began.elapsed() < Duration::from_secs(60),
                "the viewer stays"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
        self.process.wait().expect("its state").code()
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

pub(super) fn connect(host: &str) -> TcpStream {
    let stream = TcpStream::connect(host).expect("a connection");
    let limit = Some(Duration::from_secs(20));
    stream.set_read_timeout(limit).expect("a limit");
    stream
}

/// Status and body of the answer to a request with these lines.
pub(super) fn ask(host: &str, lines: &[impl AsRef<str>], body: &str) -> (u16, String) {
    let mut stream = connect(host);
    let lines: Vec<&str> = lines.iter().map(AsRef::as_ref).collect();
    let head = lines.join("\r\n");
    let length = body.len();
    let close = if head.contains("Upgrade") {
        ""
    } else {
        "\r\nConnection: close"
    };
    let request = format!("{head}{close}\r\nContent-Length: {length}\r\n\r\n{body}");
    // A server that has read enough closes, which may cut the request short.
    let _ = stream.write_all(request.as_bytes());
    let mut answer = String::new();
    let _ = stream.read_to_string(&mut answer);
    let status = answer.split(' ').nth(1).and_then(|code| code.parse().ok());
    let body = answer.split_once("\r\n\r\n").map_or("", |(_, body)| body);
    (status.unwrap_or(0), body.to_owned())
}

pub(super) fn act(host: &str, token: &str, more: &str, body: &str) -> (u16, String) {
    let own = format!("Host: {host}");
    let token = format!("X-Zeronav-Token: {token}");
    let mut lines = vec!["POST /act HTTP/1.1", own.as_str(), token.as_str()];
    if !more.is_empty() {
        lines.push(more);
    }
    ask(host, &lines, body)
}

/// The lines of a request for the stream with this token.
pub(super) fn stream_lines(host: &str, token: &str) -> Vec<String> {
    let mut lines: Vec<String> = [
        "GET /stream HTTP/1.1",
        "Connection: Upgrade",
        "Upgrade: websocket",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
    ]
    .map(str::to_owned)
    .into();
    lines.push(format!("Host: {host}"));
    lines.push(match token {
        "" => "Sec-WebSocket-Protocol: zeronav".to_owned(),
        token => format!("Sec-WebSocket-Protocol: zeronav, {token}"),
    });
    lines
}

/// Bytes that look like chance, the same every time.
pub(super) fn noise(seed: u64, len: usize) -> Vec<u8> {
    let mut state = seed | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state.to_le_bytes()[0]
    };
    (0..len).map(|_| next()).collect()
}
