//! The live page that a stack on a terminal has by itself.

use super::client::{Viewer, ask};
use rustix::process::Signal;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use zeronav_tests::{
    await_by_itself, binaries, children_of, is_alive, leftovers, real_time_turn, send_signal,
    zeronav,
};

/// `zeronav` on a terminal, which `script` makes.
struct OnTerminal {
    process: Child,
    said: PathBuf,
    _folder: tempfile::TempDir,
}

impl OnTerminal {
    fn start(arguments: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let said = folder.path().join("said");
        let output = File::create(&said).expect("a file");
        let program = binaries().join("zeronav");
        let process = Command::new("script")
            .args([
                "-qefc",
                // Some shells stay as the parent of what they are told to run.
                &format!("exec {} {arguments}", program.display()),
                "/dev/null",
            ])
            .current_dir(folder.path())
            .env_remove("CARGO")
            .stdin(Stdio::null())
            .stdout(output)
            .stderr(Stdio::null())
            .spawn()
            .expect("script (bsdutils) is there");
        Self {
            process,
            said,
            _folder: folder,
        }
    }

    fn said(&self) -> String {
        let bytes = std::fs::read(&self.said).unwrap_or_default();
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// The word that begins so, once it has been printed.
    fn word(&self, start: &str) -> String {
        let mut found = String::new();
        await_by_itself(start, || {
            let said = self.said();
            let mut words = said.split(|c: char| c.is_whitespace() || c == ';');
            words
                .find(|word| word.starts_with(start))
                .unwrap_or("")
                .clone_into(&mut found);
            found.len() > start.len()
        });
        found
    }

    /// Process id of zeronav, and that of its viewer where it has one.
    fn pids(&self) -> (u32, Option<u32>) {
        let (zeronav, _) = children_of(self.process.id()).pop().expect("zeronav");
        let viewer = children_of(zeronav).into_iter();
        let mut viewer = viewer.filter(|(_, line)| line.contains("zeronav-viewer"));
        (zeronav, viewer.next().map(|(pid, _)| pid))
    }
}

impl Drop for OnTerminal {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        if std::thread::panicking() {
            eprintln!("on the terminal: {}", self.said());
        }
    }
}

#[test]
fn on_a_terminal_a_stack_has_a_page_that_ends_with_it() {
    let _turn = real_time_turn();
    // Without: neither by wish nor where nobody looks.
    let without = OnTerminal::start("up open_aisle --no-view");
    let root = without.word("/dev/shm/zn_");
    assert_eq!(without.pids().1, None);
    assert_eq!(zeronav(&["down", "--domain", &root]).code(), 0);
    assert!(!without.said().contains("live page"), "{}", without.said());

    // A viewer that hangs holds nothing up and is ended.
    let stack = OnTerminal::start("up open_aisle");
    let root = stack.word("/dev/shm/zn_");
    let link = stack.word("http://127.0.0.1:");
    let host = link
        .trim_start_matches("http://")
        .split('/')
        .next()
        .expect("a host");
    assert_eq!(
        ask(host, &["GET / HTTP/1.1", &format!("Host: {host}")], "").0,
        200
    );
    let viewer = stack.pids().1.expect("a viewer");
    assert!(send_signal(viewer, Signal::STOP));
    assert_eq!(zeronav(&["down", "--domain", &root]).code(), 0);
    await_by_itself("the viewer is gone", || !is_alive(viewer));
    assert_eq!(leftovers(Path::new(&root)), Vec::<PathBuf>::new());

    // One that dies comes back under the same link as often as its budget allows, and is then missed by
    // nobody; another can be had. The usual port could be taken by the page of another test meanwhile, any
    // that is free by a connection.
    let port = 20_000 + std::process::id() % 10_000;
    let stack = OnTerminal::start(&format!("up open_aisle --port {port}"));
    let root = stack.word("/dev/shm/zn_");
    let link = stack.word("http://127.0.0.1:");
    let launch = stack.pids().0;
    for times in 1..=3 {
        assert!(send_signal(stack.pids().1.expect("a viewer"), Signal::KILL));
        await_by_itself("it is back", || {
            let said = stack.said();
            let back = said.matches("the live page is back under the same link");
            back.count() == times
        });
        let (host, token) = link
            .trim_start_matches("http://")
            .split_once("/#")
            .expect("a link with a token");
        let request = [
            "GET / HTTP/1.1".to_owned(),
            format!("Host: {host}"),
            format!("X-Zeronav-Token: {token}"),
        ];
        assert_eq!(ask(host, &request, "").0, 200);
    }
    assert!(send_signal(stack.pids().1.expect("a viewer"), Signal::KILL));
    await_by_itself("it is said", || {
        stack.said().contains("companion viewer is lost")
    });
    let mut again = Viewer::start(&root, &[]);
    // The death of zeronav ends it, too.
    assert!(send_signal(launch, Signal::KILL));
    await_by_itself("the viewer has ended", || {
        again
            .process
            .try_wait()
            .is_ok_and(|status| status.is_some())
    });
    await_by_itself("nothing is left", || leftovers(Path::new(&root)).is_empty());
}
