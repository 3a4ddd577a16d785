//! What becomes of a result that cannot be written, and of output that has no reader.

use rustix::process::Signal;
use std::fs::File;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use zeronav_tests::rooms::short_drive;
use zeronav_tests::{Zeronav, command};

fn short() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("short.toml"), short_drive("")).expect("written");
    folder
}

/// Runs `zeronav` with these ends of its output.
fn with_output(folder: &Path, arguments: &[&str], out: Stdio, err: Stdio) -> Output {
    command()
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(out)
        .stderr(err)
        .spawn()
        .and_then(std::process::Child::wait_with_output)
        .expect("zeronav runs")
}

/// A device on which there is never room.
fn full() -> Stdio {
    let file = File::options().write(true).open("/dev/full");
    file.expect("/dev/full").into()
}

/// A pipe whose reader has gone.
fn unread() -> Stdio {
    let (_, writer): (OwnedFd, OwnedFd) = rustix::pipe::pipe().expect("a pipe");
    writer.into()
}

fn only_line(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes).into_owned();
    assert_eq!(text.lines().count(), 1, "not one line:\n{text}");
    text
}

/// The folder of the only run.
fn run_folder(folder: &Path) -> Option<PathBuf> {
    let mut runs = std::fs::read_dir(folder.join("runs")).ok()?.flatten();
    runs.next().map(|entry| entry.path())
}

#[test]
fn full_standard_output_ends_with_one_line_and_exit_code_4() {
    let folder = short();
    for arguments in [
        &["list"][..],
        &["list", "--json"],
        &["run", "./short.toml", "--lockstep", "--headless", "--json"],
        &["run", "./short.toml", "--lockstep", "--headless"],
    ] {
        let ended = with_output(folder.path(), arguments, full(), Stdio::piped());
        assert_eq!(ended.status.code(), Some(4), "{arguments:?}: {ended:?}");
        let line = only_line(&ended.stderr);
        assert!(line.contains("standard output"), "{line}");
    }
}

#[test]
fn closed_pipe_is_not_an_error() {
    let folder = short();
    let ended = with_output(folder.path(), &["list"], unread(), Stdio::piped());
    assert_eq!(ended.status.code(), Some(0), "{ended:?}");
    assert!(ended.stderr.is_empty(), "{ended:?}");
}

#[test]
fn unwritable_standard_error_keeps_the_exit_code() {
    let folder = short();
    for err in [full as fn() -> Stdio, unread] {
        let arguments = ["run", "no_such_scenario"];
        let ended = with_output(folder.path(), &arguments, Stdio::piped(), err());
        assert_eq!(ended.status.code(), Some(2), "{ended:?}");
        let arguments = ["run", "./short.toml", "--lockstep", "--json"];
        let ended = with_output(folder.path(), &arguments, Stdio::piped(), err());
        assert_eq!(ended.status.code(), Some(0), "{ended:?}");
    }
}

#[test]
fn unwritable_result_ends_with_one_line_and_exit_code_4() {
    let arguments = ["run", "./short.toml", "--lockstep", "--headless", "--json"];
    let mut run = Zeronav::start_in(short(), &arguments);
    run.wait_until("its folder is there", |run| {
        run_folder(run.folder.path()).is_some_and(|folder| folder.join("logs").is_dir())
    });
    let folder = run_folder(run.folder.path()).expect("its folder");
    // A folder of that name keeps any user from writing the file.
    std::fs::create_dir_all(folder.join("result.json/taken")).expect("a folder");
    let ended = run.finish();
    assert_eq!(ended.json()["verdict"], "pass");
    assert_eq!(ended.code(), 4, "{}", ended.stderr);
    let line = only_line(ended.stderr.as_bytes());
    assert!(line.contains("result.json"), "{line}");
    let left: Vec<PathBuf> = std::fs::read_dir(&folder)
        .expect("the folder")
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "part"))
        .collect();
    assert!(left.is_empty(), "half files are left: {left:?}");
}

#[test]
fn without_a_terminal_progress_is_a_line_every_five_seconds() {
    let endless = short_drive("")
        .replace("time_limit_s = 30.0", "time_limit_s = 100000.0")
        .replace("[[goals]]\npose = [4.5, 1.0, 0.0]\n", "");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("endless.toml"), endless).expect("written");
    let err = folder.path().join("err.txt");
    let mut run = command()
        .args(["run", "./endless.toml", "--lockstep"])
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(File::create(&err).expect("a file"))
        .spawn()
        .expect("zeronav runs");
    let started = std::time::Instant::now();
    let said = || std::fs::read_to_string(&err).unwrap_or_default();
    while !said().contains(" s  waiting") {
        assert!(started.elapsed().as_secs() < 60, "nothing said: {}", said());
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(started.elapsed().as_secs_f64() > 4.9, "said too soon");
    assert!(zeronav_tests::send_signal(run.id(), Signal::INT));
    assert_eq!(run.wait().expect("its end").code(), Some(130));
}
