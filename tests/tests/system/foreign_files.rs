//! Files that others have planted, pipes in the place of files, and children that write without end.

use rustix::fs::{AtFlags, CWD, FileType, Gid, Mode, Uid, chownat, mknodat};
use rustix::process::Signal;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};
use zeronav_tests::{Zeronav, binaries, executable, leftovers, real_time_turn, zeronav};

/// User and group `nobody`.
const NOBODY: u32 = 65534;

/// Gives a file, folder or link to another user; false, said aloud, when only root could.
fn give_away(path: &Path) -> bool {
    let (user, group) = (Uid::from_raw(NOBODY), Gid::from_raw(NOBODY));
    let given = chownat(
        CWD,
        path,
        Some(user),
        Some(group),
        AtFlags::SYMLINK_NOFOLLOW,
    );
    if given.is_err() {
        eprintln!("SKIPPED: only root can give a file away");
    }
    given.is_ok()
}

/// A folder that every user may make files in.
fn open_to_all() -> tempfile::TempDir {
    let place = tempfile::tempdir().expect("a folder");
    let mode = std::fs::Permissions::from_mode(0o1777);
    std::fs::set_permissions(place.path(), mode).expect("its mode");
    place
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path")
}

#[test]
fn folders_and_links_of_another_user_are_refused_for_every_output() {
    let place = open_to_all();
    let folder = place.path().join("runs");
    std::fs::create_dir(&folder).expect("a folder");
    let target = place.path().join("target");
    std::fs::create_dir(&target).expect("a folder");
    let link = place.path().join("link");
    symlink(&target, &link).expect("a link");
    if !give_away(&folder) || !give_away(&link) {
        return;
    }
    for planted in [&folder, &link] {
        let out = text(planted);
        let file = planted.join("it");
        for arguments in [
            &[
                "run",
                "open_aisle",
                "--lockstep",
                "--headless",
                "--out",
                out,
            ][..],
            &["suite", "generated", "--worlds", "0..1", "--out", out],
            &["man", out],
            &["map", "save", text(&file.with_extension("yaml"))],
        ] {
            let ended = zeronav(arguments);
            assert_ne!(ended.code(), 0, "{arguments:?}");
            let why = &ended.stderr;
            assert!(why.contains("user id 65534"), "{arguments:?}: {why}");
        }
    }
    for folder in [&folder, &target] {
        assert_eq!(std::fs::read_dir(folder).expect("it").count(), 0);
    }
    // A folder of one's own in the folder of another user is no other user's.
    let new = folder.join("mine");
    assert_eq!(zeronav(&["man", text(&new)]).code(), 0);
}

/// The only folder in `runs`.
fn run_folder(place: &Path) -> Option<PathBuf> {
    let entries = std::fs::read_dir(place.join("runs")).ok()?;
    entries.flatten().map(|entry| entry.path()).next()
}

#[test]
fn a_run_whose_folder_is_replaced_writes_to_none_of_the_planted_links() {
    let _turn = real_time_turn();
    let mut run = Zeronav::start(&["run", "open_aisle", "--headless", "--json"]);
    run.wait_until("the drive has begun", |run| {
        run.report()
            .is_some_and(|report| report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.2))
    });
    let root = run.domains().pop().expect("a domain");
    let place = run.folder.path().to_owned();
    let folder = run_folder(&place).expect("its folder");
    let moved = place.join("moved");
    std::fs::rename(&folder, &moved).expect("moved");
    let victim = place.join("victim");
    std::fs::write(&victim, "mine").expect("written");
    std::fs::create_dir_all(folder.join("logs")).expect("planted");
    let pid = run.pid();
    for name in [
        "result.json",
        "report.html",
        "logs/global_planner.log",
        "logs/launch.log",
    ] {
        symlink(&victim, folder.join(name)).expect("a link");
    }
    symlink(&victim, folder.join(format!(".result.json.{pid}.part"))).expect("a link");
    let planner = run.service("global_planner").expect("a planner");
    assert!(zeronav_tests::send_signal(planner, Signal::KILL));
    run.wait_until("the planner is started again", |run| {
        run.service("global_planner")
            .is_some_and(|pid| pid != planner)
    });
    run.signal(Signal::INT);
    let ended = run.finish();
    assert_eq!(ended.code(), 130, "{}", ended.stderr);
    assert_eq!(std::fs::read_to_string(&victim).expect("it"), "mine");
    for name in [
        "result.json",
        "report.html",
        "logs/global_planner.log",
        "logs/launch.log",
    ] {
        assert!(moved.join(name).is_file(), "{name}");
    }
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

#[test]
fn a_pipe_or_device_in_the_place_of_a_file_is_refused_at_once() {
    let place = tempfile::tempdir().expect("a folder");
    let made = |name: &str| {
        let path = place.path().join(name);
        mknodat(CWD, &path, FileType::Fifo, Mode::RWXU, 0).expect("a pipe");
        path
    };
    let (scenario, map) = (made("it.toml"), made("it.yaml"));
    let image = place.path().join("map.yaml");
    let yaml = |image: &str| {
        format!(
            "image: {image}\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n\
             occupied_thresh: 0.65\nfree_thresh: 0.196\n"
        )
    };
    std::fs::write(&image, yaml("it.pgm")).expect("written");
    made("it.pgm");
    let device = place.path().join("device.yaml");
    std::fs::write(&device, yaml("/dev/zero")).expect("written");
    made("result.json");
    let bag = place.path().join("bag");
    std::fs::create_dir(&bag).expect("a folder");
    let log = made("bag/it.mcap");
    let run = text(place.path());
    for arguments in [
        &["check", text(&scenario)][..],
        &["run", text(&scenario), "--lockstep", "--headless"],
        &["up", "--map", text(&map), "--robot", "porter"],
        &["up", "--map", text(&image), "--robot", "porter"],
        &["up", "--map", text(&device), "--robot", "porter"],
        &["report", run],
        &["latency", run],
        &["why", run],
        &["start-up", run],
        &["bag", "info", text(&log)],
        &["replay", text(&log)],
        &["import", text(&log)],
        &["import", text(&bag)],
    ] {
        let mut ended = Zeronav::start(arguments);
        // It may have waited for a place among other runs.
        let began = Instant::now();
        while !ended.has_ended() {
            assert!(
                began.elapsed() < Duration::from_secs(20),
                "{arguments:?} hangs"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
        let ended = ended.finish();
        assert_eq!(ended.code(), 2, "{arguments:?}: {}", ended.stderr);
        let why = &ended.stderr;
        assert!(
            why.contains("a pipe") || why.contains("a device"),
            "{arguments:?}: {why}"
        );
    }
}

/// How many bytes the line in a log says that were dropped.
fn dropped(log: &Path) -> Option<u64> {
    let text = std::fs::read(log).ok()?;
    let text = String::from_utf8_lossy(&text);
    let line = text
        .lines()
        .find(|line| line.contains("bytes were dropped here"))?;
    line.split(' ').find_map(|word| word.parse().ok())
}

#[test]
fn the_log_of_a_flooding_service_is_bounded_also_while_launch_is_stopped() {
    let _turn = real_time_turn();
    let place = tempfile::tempdir().expect("a folder");
    let planner = binaries().join("zeronav-global-planner");
    let script = format!(
        "#!/bin/sh\ncase \"$*\" in *--domain*) nice -n 19 yes flooding & ;; esac\nexec {} \"$@\"\n",
        planner.display()
    );
    executable(&place.path().join("floods"), &script);
    let scenario = "title = \"flood\"\nbase = [\"warehouse\", \"porter\"]\nstart = [4.0, 6.425, 0.0]\n\
                    [[goals]]\npose = [14.0, 6.425, 0.0]\n\
                    [services.global_planner]\nbinary = \"./floods\"\n";
    std::fs::write(place.path().join("it.toml"), scenario).expect("written");
    let file = place.path().join("it.toml");
    let mut run = Zeronav::start(&["up", text(&file), "--headless"]);
    let folder = run.folder.path().to_owned();
    let log = || run_folder(&folder).map(|run| run.join("logs/global_planner.log"));
    let now = || log().and_then(|log| dropped(&log));
    run.wait_until("the log is cut", |_| now().is_some());
    run.signal(Signal::STOP);
    let before = now();
    run.wait_until("it is cut while launch is stopped", |_| now() > before);
    run.signal(Signal::CONT);
    run.signal(Signal::INT);
    let ended = run.finish();
    assert_eq!(ended.code(), 130, "{}", ended.stderr);
    assert!(log().is_some_and(|log| log.metadata().is_ok_and(|it| it.len() < 1 << 30)));
}

#[test]
fn a_limit_of_file_sizes_is_told() {
    let place = tempfile::tempdir().expect("a folder");
    let script = "ulimit -f 1; exec \"$0\" man \"$1\"";
    let mut shell = Command::new("sh");
    let zeronav = binaries().join("zeronav");
    shell.args(["-c", script]).arg(zeronav).arg(place.path());
    let output = shell.output().expect("a shell");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(said.contains("File too large"), "{said}");
}
