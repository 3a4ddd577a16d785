//! A question over the control socket of a run, against launches that answer it in every way.

use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use zeronav_shell::control::{ANSWER_BYTES_MAX, SOCKET, answering_process, ask};
use zeronav_shell::folder::Folder;

/// What a client gets from a run that does this with its connection after it has read the question.
fn asked(answer: impl FnOnce(&mut UnixStream, &str) + Send) -> std::io::Result<Vec<u8>> {
    let place = tempfile::tempdir().expect("a place");
    let folder = Folder::create(&place.path().join("run")).expect("a folder");
    let listener = UnixListener::bind(folder.entry(SOCKET)).expect("a socket");
    std::thread::scope(|scope| {
        scope.spawn(move || {
            let (mut stream, _) = listener.accept().expect("a client");
            let mut line = String::new();
            let reader = stream.try_clone().expect("the same stream");
            BufReader::new(reader).read_line(&mut line).expect("a line");
            answer(&mut stream, &line);
        });
        ask(&folder, "how far?")
    })
}

#[test]
fn the_answer_is_what_comes_before_the_end_of_the_line() {
    let answer = asked(|stream, line| {
        assert_eq!(line, "how far?\n");
        stream.write_all(b"3 m\nand more").expect("written");
    });
    assert_eq!(answer.expect("an answer"), b"3 m");
    // In pieces, and longer than one read takes.
    let long = vec![b'x'; 10_000];
    let answer = asked(|stream, _| {
        for piece in long.chunks(3000) {
            stream.write_all(piece).expect("written");
        }
        stream.write_all(b"\n").expect("written");
    });
    assert_eq!(answer.expect("an answer"), long);
    let longest = vec![b'x'; ANSWER_BYTES_MAX];
    let answer = asked(|stream, _| {
        stream.write_all(&longest).expect("written");
        stream.write_all(b"\n").expect("written");
    });
    assert_eq!(answer.expect("an answer").len(), ANSWER_BYTES_MAX);
}

#[test]
fn an_answer_without_an_end_is_an_error_and_bounded() {
    let cut = asked(|stream, _| stream.write_all(b"3").expect("written"));
    assert_eq!(cut.expect_err("no end").kind(), ErrorKind::UnexpectedEof);
    let endless = asked(|stream, _| {
        // Until the client goes.
        while stream.write_all(&[b'x'; 4096]).is_ok() {}
    });
    assert_eq!(endless.expect_err("no end").kind(), ErrorKind::FileTooLarge);
}

#[test]
fn a_run_that_is_not_there_is_told_from_one_that_answers() {
    let place = tempfile::tempdir().expect("a place");
    let folder = Folder::create(&place.path().join("run")).expect("a folder");
    let error = ask(&folder, "how far?").expect_err("no socket");
    assert_eq!(error.kind(), ErrorKind::NotFound);
    let listener = UnixListener::bind(folder.entry(SOCKET)).expect("a socket");
    let pid = answering_process(&folder).expect("this process");
    assert_eq!(pid, rustix::process::getpid());
    drop(listener);
    let error = ask(&folder, "how far?").expect_err("nobody listens");
    assert_eq!(error.kind(), ErrorKind::ConnectionRefused);
}
