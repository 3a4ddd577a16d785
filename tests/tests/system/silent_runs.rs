//! A run whose launch does not answer: it is listed as such, and `zeronav down` ends it.

use rustix::process::Signal;
use serde_json::Value;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::os::fd::AsRawFd;
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};
use zeronav_tests::up::Up;
use zeronav_tests::{await_by_itself, command, domains_of, leftovers, zeronav};

/// How long a stack may take to begin.
const START_LIMIT: Duration = Duration::from_secs(120);

#[test]
fn a_run_whose_launch_is_stopped_is_listed_and_ended() {
    let up = Up::start(&["open_aisle", "--lockstep"]);
    let pid = up.stack.pid().to_string();
    up.stack.signal(Signal::STOP);

    // Each waits for an answer.
    let (for_machines, for_people, refused) = std::thread::scope(|scope| {
        let for_machines = scope.spawn(|| zeronav(&["ps", "--json"]));
        let for_people = scope.spawn(|| zeronav(&["ps"]));
        let refused = up.ask(&["status"], 2);
        (for_machines.join(), for_people.join(), refused)
    });
    let listed = for_machines.expect("it ends").expect(0);
    let runs = listed["runs"].as_array().expect("a list");
    let of_domain = |run: &&Value| run["domain"] == up.root.as_str();
    let run = runs.iter().find(of_domain).expect("it is listed");
    assert_eq!(run["pid"].to_string(), pid, "{run}");
    assert_eq!(run["silent"], "no answer within 5 s", "{run}");
    let listed = for_people.expect("it ends").stdout;
    let line = listed.lines().find(|line| line.contains(&up.root));
    let line = line.expect(&listed);
    let way_out = format!("`zeronav down --domain {}` ends it", up.root);
    for said in ["does not answer", &format!("pid {pid}"), &way_out] {
        assert!(line.contains(said), "{line}");
    }
    // A request says the same, and changes nothing.
    for said in ["no answer within 5 s", &pid, "`zeronav down` ends it"] {
        assert!(refused.contains(said), "{refused}");
    }

    let said = up.ask(&["down"], 0);
    assert!(said.contains("is down, ended by SIGTERM"), "{said}");
    let result = up.stack.finish().expect(130);
    assert_eq!(result["outcome"], "interrupted", "{result:#}");
    assert_eq!(leftovers(Path::new(&up.root)), Vec::<PathBuf>::new());
}

/// A launch whose standard error nobody reads, as that of a pager that waits: it stands in a write
/// for ever, and no signal but SIGKILL gets it out. Dropping it ends it.
struct Deaf {
    launch: Child,
    folder: tempfile::TempDir,
    /// Nothing is read from it.
    _unread: std::io::PipeReader,
}

impl Deaf {
    fn start() -> Self {
        let (unread, stderr) = std::io::pipe().expect("a pipe");
        // Filled through an opening of its own: the flag must not be launch's, too.
        let mut filling = OpenOptions::new()
            .write(true)
            .custom_flags(rustix::fs::OFlags::NONBLOCK.bits().cast_signed())
            .open(format!("/proc/self/fd/{}", stderr.as_raw_fd()))
            .expect("the pipe");
        let full = loop {
            if let Err(error) = filling.write(&[b'.'; 4096]) {
                break error.kind();
            }
        };
        assert_eq!(full, ErrorKind::WouldBlock);
        let folder = tempfile::tempdir().expect("a folder");
        let launch = command()
            .args(["up", "open_aisle", "--headless", "--lockstep"])
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(stderr)
            .spawn()
            .expect("it starts");
        Self {
            launch,
            folder,
            _unread: unread,
        }
    }

    /// The root folder of its domain, once it has one.
    fn root(&mut self) -> PathBuf {
        let launch = self.launch.id();
        self.until("it has a domain", || domains_of(launch).pop())
    }

    /// Waits until it says that it is up, which nobody reads.
    fn await_silence(&mut self, root: &Path) {
        let root = root.display().to_string();
        self.until("it is silent", || {
            let said = zeronav(&["status", "--domain", &root]).stderr;
            said.contains("no answer within").then_some(())
        });
    }

    fn until<T>(&mut self, what: &str, mut look: impl FnMut() -> Option<T>) -> T {
        let began = Instant::now();
        loop {
            if let Some(found) = look() {
                return found;
            }
            let status = self.launch.try_wait().expect("its state");
            assert!(status.is_none(), "it ended before {what}: {status:?}");
            assert!(
                began.elapsed() < START_LIMIT,
                "waited too long until {what}"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for Deaf {
    fn drop(&mut self) {
        let _ = self.launch.kill();
        let _ = self.launch.wait();
    }
}

#[test]
fn a_launch_that_obeys_no_signal_is_killed() {
    let mut deaf = Deaf::start();
    let root = deaf.root();
    deaf.await_silence(&root);
    let said = zeronav(&["down", "--json", "--domain", &root.display().to_string()]);
    assert_eq!(said.expect(0)["how"], "by SIGKILL", "{}", said.stderr);
    assert!(
        said.stderr.contains("no answer within 5 s"),
        "{}",
        said.stderr
    );
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
    let status = deaf.launch.wait().expect("its end");
    assert_eq!(status.signal(), Some(Signal::KILL.as_raw()), "{status}");
    // The warden has seen to the rest.
    let runs = std::fs::read_dir(deaf.folder.path().join("runs")).expect("runs");
    let run = runs.flatten().next().expect("its folder").path();
    // Another command may have removed the domain before the warden came to write.
    let mut result = Value::Null;
    await_by_itself("a result is left", || {
        let text = std::fs::read_to_string(run.join("result.json")).unwrap_or_default();
        result = serde_json::from_str(&text).unwrap_or_default();
        !result.is_null()
    });
    assert_eq!(result["outcome"], "launch_died", "{result:#}");
}
