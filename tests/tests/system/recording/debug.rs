//! Runs that stand before a tick, with a debugger on one of their processes.

use super::recorded;
use rustix::process::Signal;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Output, Stdio};
use zeronav_tests::rooms::short_drive;
use zeronav_tests::{await_by_itself, command, domains_of, send_signal, zeronav};

/// A process may stand still for less than a debugger holds it here.
const HANGS_SOON: &str = "[restart]\nhang_after_s = 0.2\n";

/// `zeronav debug` in `folder`, with its prompt open.
fn start(folder: &Path, arguments: &[&str]) -> Child {
    let process = command()
        .arg("debug")
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    process.expect("zeronav runs")
}

/// Says these lines at the prompt of `zeronav debug`: its exit code, and what it says.
fn debugged(folder: &Path, arguments: &[&str], lines: &str) -> (i32, String, String) {
    let mut process = start(folder, arguments);
    let mut input: ChildStdin = process.stdin.take().expect("a pipe");
    // It may end before it reads them.
    let _ = input.write_all(lines.as_bytes());
    drop(input);
    let ended: Output = process.wait_with_output().expect("it ends");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    let code = ended.status.code().unwrap_or(-1);
    (code, text(ended.stdout), text(ended.stderr))
}

/// The ticks before which the run stood.
fn stood(said: &str) -> Vec<u64> {
    let parts = said.split(" is paused before tick ").skip(1);
    let number = |text: &str| text.split(' ').next().and_then(|tick| tick.parse().ok());
    parts.filter_map(number).collect()
}

#[test]
fn a_run_stands_goes_back_waits_for_a_debugger_and_ends_as_without() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = short_drive("") + HANGS_SOON;
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let plain = zeronav(&[
        "run",
        &folder.path().join("it.toml").display().to_string(),
        "--lockstep",
        "--json",
    ]);
    let hash = plain.expect(0)["run_hash"]
        .as_str()
        .expect("a hash")
        .to_owned();
    // It holds the process for five times as long as makes it hung, and the run does two ticks with it.
    let gdb = "gdb -nx -batch -ex bt -ex";
    let mut arguments = vec!["it.toml", "--at", "40", "--attach", "local_planner", "--"];
    arguments.extend(gdb.split(' '));
    arguments.extend(["shell sleep 1; zeronav step 2 && echo granted"]);
    let lines = "step 5\nback 3\ngoto 1.0s\nwhy\nattach\ncontinue\n";
    let (code, said, complained) = debugged(folder.path(), &arguments, lines);
    assert_eq!(code, 0, "{said}\n{complained}");
    // Attached at 40, from where it was granted two; the tick of 1.0 s is number 50.
    assert_eq!(
        stood(&said),
        [40, 42, 47, 44, 50, 52],
        "{said}\n{complained}"
    );
    assert_eq!(said.matches("granted").count(), 2, "{said}\n{complained}");
    assert!(said.contains("#0 "), "a stack of calls: {said}");
    let end = said.lines().last().expect("a line");
    assert!(end.contains("the run has ended: reached"), "{end}");
    assert!(end.ends_with(&hash), "{end}: {hash}");
    assert!(!said.contains("not reproducible"), "{said}");
}

#[test]
fn a_recording_is_debugged_with_its_seed_and_a_run_may_be_over_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = recorded(folder.path(), "it", "");
    let file = file.display().to_string();
    let (code, said, complained) = debugged(
        folder.path(),
        &[&file, "--at", "0.2s", "--", "gdb"],
        "s\nq\n",
    );
    assert_eq!(
        (code, stood(&said)),
        (0, vec![10, 11]),
        "{said}\n{complained}"
    );
    let (code, said, complained) =
        debugged(folder.path(), &[&file, "--at", "100000", "--", "gdb"], "");
    assert_eq!((code, stood(&said)), (1, vec![]), "{said}\n{complained}");
    assert!(complained.contains("before tick 100000"), "{complained}");
    assert!(said.contains("the run has ended: reached"), "{said}");
}

#[test]
fn what_cannot_be_debugged_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), short_drive("")).expect("written");
    for (arguments, why) in [
        (
            &["it.toml", "--at", "0", "--", "gdb"][..],
            "`0` is neither a tick",
        ),
        (&["absent.toml", "--", "gdb"], "absent.toml"),
        (&["absent.mcap", "--", "gdb"], "absent.mcap"),
        (&["it.toml", "--attach", "wheels", "--", "gdb"], "wheels"),
    ] {
        let (code, said, complained) = debugged(folder.path(), arguments, "");
        assert_eq!(code, 2, "{said}{complained}");
        assert!(complained.contains(why), "{why}: {complained}");
    }
    // At the prompt nothing is lost by a mistake.
    let lines = "jump\nattach\nattach mapping\nstep 0\nquit\n";
    let (code, said, complained) =
        debugged(folder.path(), &["it.toml", "--", "/absent/gdb"], lines);
    assert_eq!(code, 0, "{said}\n{complained}");
    for why in [
        "`jump` is none of",
        "attach to which seat",
        "starting /absent/gdb",
        "`0` is no number",
    ] {
        assert!(complained.contains(why), "{why}: {complained}");
    }
}

#[test]
fn a_signal_ends_a_run_that_stands_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), short_drive("")).expect("written");
    for signal in [Signal::INT, Signal::TERM] {
        let mut process = start(folder.path(), &["it.toml", "--at", "5", "--", "gdb"]);
        let mut said = BufReader::new(process.stdout.take().expect("a pipe")).lines();
        let stands = said.find(|line| {
            line.as_ref()
                .is_ok_and(|line| line.contains("is paused before tick 5"))
        });
        assert!(stands.is_some(), "{signal:?}");
        let domains = domains_of(process.id());
        assert_eq!(domains.len(), 1, "{domains:?}");
        assert!(send_signal(process.id(), signal));
        await_by_itself("it ends", || matches!(process.try_wait(), Ok(Some(_))));
        let status = process.wait().expect("it has ended");
        assert_eq!(status.code(), Some(130), "{signal:?}");
        assert!(!domains[0].exists(), "{signal:?}: {domains:?}");
    }
}
