//! What another user of the machine may try, and what a corrupt file of a run may do.
//!
//! The other user is a thread of this test that gives up root for the user `nobody`. Where the tests
//! do not run as root, those parts are skipped aloud.

use rustix::fs::{FlockOperation, flock};
use rustix::process::{Gid, Signal, Uid};
use std::fs::{File, OpenOptions, Permissions};
use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use zeronav_shell::Domain;
use zeronav_tests::{Ended, Zeronav, leftovers, real_time_turn, send_signal, zeronav};

/// User and group `nobody`.
const NOBODY: u32 = 65534;

/// What another user's file must not delay by more.
const DELAY_MAX: Duration = Duration::from_millis(50);

/// What a terminal would obey: clear the screen, in two spellings.
const ESCAPES: &str = "\u{1b}[2J\u{9b}2J";

/// What `act` gives as another user; `None`, said aloud, when this process cannot become one.
fn as_another_user<R: Send>(act: impl FnOnce() -> R + Send) -> Option<R> {
    if !rustix::process::geteuid().is_root() {
        eprintln!("SKIPPED: only root can become another user");
        return None;
    }
    // Credentials belong to a thread; the rest of the process stays root.
    std::thread::scope(|scope| {
        let other = scope.spawn(|| {
            let (uid, gid) = (Uid::from_raw(NOBODY), Gid::from_raw(NOBODY));
            rustix::thread::set_thread_groups(&[]).expect("groups");
            rustix::thread::set_thread_res_gid(gid, gid, gid).expect("a group");
            rustix::thread::set_thread_res_uid(uid, uid, uid).expect("a user");
            act()
        });
        Some(other.join().expect("the other user's thread ends"))
    })
}

/// A folder that looks like a domain and belongs to another user. Removed when dropped.
struct Planted(PathBuf);

impl Planted {
    /// Open to all users, or for its owner only.
    fn new(letters: &str, mode: u32) -> Option<Self> {
        let root = PathBuf::from(format!("/dev/shm/zn_{letters}"));
        assert_eq!(letters.len(), 10, "it must look like a domain");
        as_another_user(|| {
            std::fs::create_dir(&root).expect("a folder");
            std::fs::set_permissions(&root, Permissions::from_mode(mode)).expect("its mode");
            Self(root)
        })
    }
}

impl Drop for Planted {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Runs a command that must end by itself within ten seconds.
fn ends(arguments: &[&str]) -> Ended {
    let mut run = Zeronav::start(arguments);
    let started = Instant::now();
    while !run.has_ended() {
        assert!(
            started.elapsed() < Duration::from_secs(10),
            "`zeronav {}` hangs",
            arguments.join(" ")
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    run.finish()
}

/// Starts a drive in real time and waits until it moves.
fn driving() -> (Zeronav, PathBuf) {
    let mut run = Zeronav::start(&["run", "open_aisle", "--headless", "--json"]);
    run.wait_until("the drive has begun", |run| {
        run.report()
            .is_some_and(|report| report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.2))
    });
    let root = run.domains().pop().expect("a domain");
    (run, root)
}

/// Stops a run by Ctrl-C: nothing may be left of it.
fn stop(run: Zeronav, root: &Path) -> Ended {
    let started = Instant::now();
    run.signal(Signal::INT);
    let ended = run.finish();
    assert_eq!(ended.code(), 130, "{}", ended.stderr);
    assert!(
        started.elapsed() < Duration::from_secs(10),
        "Ctrl-C took {:?}",
        started.elapsed()
    );
    assert_eq!(leftovers(root), Vec::<PathBuf>::new());
    ended
}

/// Process id of the service in the seat `role`.
fn pid_of(run: &Zeronav, role: &str) -> Option<u32> {
    let report = run.report()?;
    let services = report["services"].as_array()?;
    let seat = services.iter().find(|service| service["role"] == role)?;
    u32::try_from(seat["pid"].as_u64()?).ok()
}

/// Times that the run needs to answer on its control socket, for as long as `goes_on`.
fn answer_times(run: &Zeronav, mut goes_on: impl FnMut() -> bool) -> Vec<Duration> {
    let mut times = Vec::new();
    while goes_on() {
        let asked = Instant::now();
        assert!(run.report().is_some(), "the control socket is deaf");
        times.push(asked.elapsed());
        std::thread::sleep(Duration::from_millis(5));
    }
    times.sort();
    times
}

/// The machine may be busy at one moment or another, but not in nine of ten.
fn assert_quick(times: &[Duration]) {
    let ninth = times[times.len() * 9 / 10];
    let last = times[times.len() - 1];
    eprintln!(
        "{} answers, 9 in 10 within {ninth:?}, all within {last:?}",
        times.len()
    );
    assert!(ninth < DELAY_MAX, "answers took {ninth:?}");
    assert!(last < Duration::from_millis(500), "an answer took {last:?}");
}

/// Everything below `folder` that is not a folder.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        match entry.file_type() {
            Ok(kind) if kind.is_dir() => files.extend(files_below(&entry.path())),
            _ => files.push(entry.path()),
        }
    }
    files
}

#[test]
fn no_file_of_a_run_is_open_to_other_users() {
    let _turn = real_time_turn();
    let (run, root) = driving();
    let folder = std::fs::symlink_metadata(&root).expect("the root folder");
    assert_eq!(folder.mode() & 0o7777, 0o700);
    let mut segments = leftovers(&root);
    segments.retain(|path| *path != root);
    assert!(segments.len() > 40, "{segments:?}");
    let below = files_below(&root);
    for path in segments.iter().chain(&below) {
        // What is gone by now was closed, not opened to others.
        if let Ok(metadata) = std::fs::symlink_metadata(path) {
            let mode = metadata.mode() & 0o7777;
            assert_eq!(mode & 0o077, 0, "{} has mode {mode:04o}", path.display());
        }
    }
    assert!(below.iter().any(|path| path.ends_with("control.sock")));
    as_another_user(|| {
        for path in segments.iter().chain([&root.join("lock")]) {
            let kind = OpenOptions::new()
                .write(true)
                .open(path)
                .map_err(|it| it.kind());
            let denied = matches!(kind, Err(ErrorKind::PermissionDenied | ErrorKind::NotFound));
            assert!(denied, "{} can be written", path.display());
            assert!(File::open(path).is_err(), "{} can be read", path.display());
        }
        assert!(std::fs::read_dir(&root).is_err(), "the root can be listed");
        assert!(UnixStream::connect(root.join("control.sock")).is_err());
    });
    stop(run, &root);
}

#[test]
fn planted_link_creates_no_file_and_planted_folder_is_untouched() {
    let Some(planted) = Planted::new("plantlink0", 0o777) else {
        return;
    };
    let home = tempfile::tempdir().expect("a folder of this user");
    let target = home.path().join("made_through_the_link");
    as_another_user(|| symlink(&target, planted.0.join("lock")).expect("a link"));
    assert_eq!(ends(&["list"]).code(), 0);
    assert!(
        !target.exists(),
        "a file was made through another user's link"
    );
    assert!(planted.0.is_dir(), "another user's folder was removed");
}

#[test]
fn lock_held_by_another_user_blocks_no_command() {
    for mode in [0o777, 0o700] {
        let Some(planted) = Planted::new("plantlock0", mode) else {
            return;
        };
        let held = as_another_user(|| {
            let lock = File::create(planted.0.join("lock")).expect("a lock");
            let turn = File::open(&planted.0).expect("the folder");
            for file in [&lock, &turn] {
                flock(file, FlockOperation::NonBlockingLockExclusive).expect("it is free");
            }
            (lock, turn)
        });
        assert_eq!(ends(&["list"]).code(), 0);
        assert_eq!(ends(&["ps"]).code(), 0);
        drop(held);
        assert_eq!(ends(&["ps"]).code(), 0);
        assert!(planted.0.is_dir(), "another user's folder was removed");
    }
}

/// Answers every line on `listener` as if it were the control socket of a run; ends with it.
fn answer_all(listener: &UnixListener, scenario: &str, goal: &str) -> usize {
    let mut answered = 0;
    while let Ok((mut stream, _)) = listener.accept() {
        let mut line = String::new();
        let _ = BufReader::new(&stream).read_line(&mut line);
        if line.contains("\"end\"") {
            break;
        }
        answered += 1;
        let run = serde_json::json!({ "run": {
            "scenario": scenario, "domain": scenario, "pid": 1, "mode": scenario, "time_s": 1.0,
            "task": scenario, "services": [],
        }});
        let answer = if line.contains("\"ps\"") {
            run.to_string()
        } else {
            goal.to_owned()
        };
        let _ = stream.write_all(format!("{answer}\n").as_bytes());
    }
    answered
}

/// Ends [`answer_all`].
fn end_answers(socket: &Path) {
    let mut stream = UnixStream::connect(socket).expect("it listens");
    stream.write_all(b"\"end\"\n").expect("written");
}

#[test]
fn planted_control_socket_is_ignored() {
    let Some(planted) = Planted::new("plantsock0", 0o777) else {
        return;
    };
    let socket = planted.0.join("control.sock");
    let listener = as_another_user(|| {
        let listener = UnixListener::bind(&socket).expect("a socket");
        std::fs::set_permissions(&socket, Permissions::from_mode(0o777)).expect("its mode");
        listener
    })
    .expect("root");
    let root = planted.0.to_str().expect("a name").to_owned();
    let answered = std::thread::scope(|scope| {
        let server = scope.spawn(|| answer_all(&listener, ESCAPES, "\"done\""));
        let ps = ends(&["ps"]);
        assert!(!ps.stdout.contains(&root), "{}", ps.stdout);
        // Another run of this user may go on beside this test: then it is the one that is meant.
        let goal = ends(&["goal", "1", "1", "0", "--domain", &root]);
        assert_eq!(goal.code(), 2, "{}{}", goal.stdout, goal.stderr);
        assert!(goal.stderr.contains("user id 65534"), "{}", goal.stderr);
        for ended in [ps, goal] {
            let shown = ended.stdout + &ended.stderr;
            assert!(!shown.contains(['\u{1b}', '\u{9b}']), "{shown:?}");
        }
        end_answers(&socket);
        server.join().expect("the server ends")
    });
    assert_eq!(answered, 0, "another user's socket was asked");
}

#[test]
fn foreign_answers_are_printed_and_not_executed() {
    let domain = Domain::create().expect("a domain");
    let socket = domain.root().join("control.sock");
    let listener = UnixListener::bind(&socket).expect("a socket");
    let root = domain.root().to_str().expect("a name").to_owned();
    let refusal = serde_json::json!({ "error": format!("{ESCAPES}\nzeronav: all is well") });
    std::thread::scope(|scope| {
        let server = scope
            .spawn(|| answer_all(&listener, &format!("{ESCAPES}\nshop"), &refusal.to_string()));
        let ps = ends(&["ps"]);
        assert!(
            ps.stdout.contains("\\u{1b}[2J\\u{9b}2J\\nshop"),
            "{}",
            ps.stdout
        );
        let json = ends(&["ps", "--json"]);
        let runs = json.json()["runs"].as_array().cloned().expect("runs");
        let scenario = format!("{ESCAPES}\nshop");
        assert!(runs.iter().any(|run| run["scenario"] == scenario.as_str()));
        let goal = ends(&["goal", "1", "1", "0", "--domain", &root]);
        assert_eq!(goal.code(), 2);
        assert_eq!(goal.stderr.lines().count(), 1, "{}", goal.stderr);
        assert!(goal.stderr.contains("\\u{1b}[2J"), "{}", goal.stderr);
        let odd = ends(&["goal", "1", "1", "0", "--domain", "/dev/shm/\u{1b}[2J"]);
        assert_eq!(odd.code(), 2);
        for ended in [ps, json, goal, odd] {
            let shown = ended.stdout + &ended.stderr;
            assert!(!shown.contains(['\u{1b}', '\u{9b}']), "{shown:?}");
        }
        end_answers(&socket);
        assert!(server.join().expect("the server ends") >= 3);
    });
    assert!(domain.close().expect("closed"));
}

#[test]
fn silent_connections_delay_nothing() {
    let _turn = real_time_turn();
    let (run, root) = driving();
    let socket = root.join("control.sock");
    let mut silent = Vec::new();
    let started = Instant::now();
    let times = answer_times(&run, || {
        // Fifty at once, and one more beside every question.
        let wanted = if silent.is_empty() { 50 } else { 1 };
        silent.extend((0..wanted).map(|_| UnixStream::connect(&socket).expect("a connection")));
        started.elapsed() < Duration::from_secs(2)
    });
    assert_quick(&times);
    stop(run, &root);
}

/// Puts a pipe in the place of every record of a member in the middleware's registry: who opens one
/// waits for ever, as with a disk that does not answer.
fn block_registry(root: &Path) -> usize {
    let nodes = files_below(&root.join("nodes"));
    let records = nodes
        .iter()
        .filter(|path| path.extension().is_some_and(|it| it == "details"));
    let mut blocked = 0;
    for record in records {
        std::fs::remove_file(record).expect("it is ours");
        let mode = rustix::fs::Mode::from_raw_mode(0o600);
        rustix::fs::mknodat(rustix::fs::CWD, record, rustix::fs::FileType::Fifo, mode, 0)
            .expect("a pipe");
        assert!(std::fs::metadata(record).expect("it").file_type().is_fifo());
        blocked += 1;
    }
    blocked
}

#[test]
fn blocked_registry_delays_neither_answers_nor_restarts_nor_signals() {
    let _turn = real_time_turn();
    let (run, root) = driving();
    let before = pid_of(&run, "global_planner").expect("a planner");
    assert!(block_registry(&root) >= 6, "five services and launch");
    let killed = Instant::now();
    assert!(send_signal(before, Signal::KILL));
    let mut restarted = None;
    let times = answer_times(&run, || {
        let now = pid_of(&run, "global_planner");
        if restarted.is_none() && now.is_some_and(|pid| pid != before) {
            restarted = Some(killed.elapsed());
        }
        assert!(killed.elapsed() < Duration::from_secs(10), "no successor");
        restarted.is_none() || killed.elapsed() < Duration::from_secs(2)
    });
    eprintln!("restarted after {:?}", restarted.expect("a successor"));
    assert_quick(&times);
    let ended = stop(run, &root);
    assert!(ended.stderr.contains("was not removed"), "{}", ended.stderr);
}

#[test]
fn run_ends_with_a_blocked_registry() {
    let _turn = real_time_turn();
    let (run, root) = driving();
    assert!(block_registry(&root) >= 6, "five services and launch");
    stop(run, &root);
}

#[test]
fn truncated_node_counter_ends_the_run_cleanly() {
    let _turn = real_time_turn();
    let (run, root) = driving();
    let counter = leftovers(&root)
        .into_iter()
        .find(|path| path.extension().is_some_and(|it| it == "global_mgmt"))
        .expect("a counter");
    let truncated = OpenOptions::new().write(true).open(counter);
    truncated.expect("it is ours").set_len(0).expect("cut");
    let pid = pid_of(&run, "global_planner").expect("a planner");
    assert!(send_signal(pid, Signal::KILL));
    let ended = run.finish();
    assert_eq!(ended.code(), 3, "{}", ended.stderr);
    assert!(
        ended.stderr.contains("counter of nodes"),
        "{}",
        ended.stderr
    );
    assert_eq!(ended.json()["outcome"], "service_died");
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

#[test]
fn foreign_domain_can_be_neither_joined_nor_removed() {
    let Some(planted) = Planted::new("plantjoin0", 0o700) else {
        return;
    };
    let refused = Domain::join(&planted.0)
        .expect_err("it is not ours")
        .to_string();
    assert!(refused.contains("not a run of this user"), "{refused}");
    assert!(refused.contains("65534"), "{refused}");
    assert!(zeronav_shell::domain::sweep(&planted.0).is_err());
    assert!(!zeronav_shell::domain::all().contains(&planted.0));
    assert!(planted.0.is_dir());
    assert_eq!(zeronav(&["list"]).code(), 0);
    assert!(planted.0.is_dir());
}
