//! A stack whose user has reached the limit of processes: a swap is rejected, a restart is tried again
//! within its budget, and the run ends with its result.

use serde_json::Value;
use std::fs::Permissions;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use zeronav_tests::{copy_binary, real_time_turn};

/// Users and groups who have no processes, as of `nobody` down: one for each test, as the limit is that of a
/// user.
const NOBODY: u32 = 65534;

/// What nobody does: starts a stack that may have 40 processes and threads, starts 60 others, asks for
/// a swap, and kills the planner.
const SCRIPT: &str = r#"
(ulimit -u 40; exec ./zeronav $1 --headless --json > up.json 2> up.err < /dev/null) &
up=$!
./zeronav wait ready --timeout 60 || exit 10
for i in $(seq 60); do sleep 300 & others="$others $!"; done
./zeronav swap local_planner zeronav-local-planner --shadow 0s --keep 1s > swap.txt 2>&1
echo $? >> swap.txt
planner=$(pgrep -P $up -f zeronav-global-planner)
kill -9 $planner || exit 11
wait $up
echo $? > code.txt
kill $others
"#;

/// A folder of nobody's with the programs of zeronav: the checkout may lie where nobody can look. `None`
/// when this test cannot become nobody.
fn folder_of_nobody(nobody: u32) -> Option<tempfile::TempDir> {
    if !rustix::process::geteuid().is_root() {
        eprintln!("SKIPPED: only root can become another user, and root has no such limit");
        return None;
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::set_permissions(folder.path(), Permissions::from_mode(0o755)).expect("its mode");
    for name in [
        "zeronav",
        "zeronav-collision-guard",
        "zeronav-global-planner",
        "zeronav-local-planner",
        "zeronav-mapping",
        "zeronav-robot-sim",
    ] {
        copy_binary(name, folder.path());
    }
    chown(folder.path(), Some(nobody), Some(nobody)).expect("its owner");
    Some(folder)
}

/// What came of a script that nobody runs in this folder, with this argument.
fn by_nobody(folder: &Path, script: &str, argument: &str) -> Output {
    let nobody = std::fs::metadata(folder).expect("its owner").uid();
    Command::new("bash")
        .args(["-c", script, "bash", argument])
        .current_dir(folder)
        .env_remove("CARGO")
        .env("HOME", folder)
        .stdin(Stdio::null())
        .uid(nobody)
        .gid(nobody)
        .output()
        .expect("it runs")
}

/// Starts a stack with this command and takes the room for processes away; its result.
fn at_the_limit(folder: &Path, command: &str) -> Value {
    let ended = by_nobody(folder, SCRIPT, command);
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap_or_default();
    let said = read("up.err");
    assert!(ended.status.success(), "{ended:?}\n{said}");
    let swap = read("swap.txt");
    for part in [
        "rejected: no thread to ask it: ",
        "see `ulimit -u`",
        "\n1\n",
    ] {
        assert!(swap.contains(part), "{swap}");
    }
    assert_eq!(read("code.txt"), "3\n", "{said}");
    assert!(!said.contains("panicked"), "{said}");
    serde_json::from_str(&read("up.json")).expect("a result")
}

#[test]
fn a_stack_at_the_limit_of_processes_rejects_swaps_and_ends_with_a_result() {
    let Some(folder) = folder_of_nobody(NOBODY) else {
        return;
    };
    let _turn = real_time_turn();
    let result = at_the_limit(folder.path(), "up open_aisle");
    assert_eq!(result["outcome"], "service_died", "{result:#}");
    let restarts = result["restarts"].as_array().expect("restarts");
    let limited = restarts.iter().filter(|restart| {
        let how = restart["how"].as_str().unwrap_or_default();
        how.contains("starting") && how.contains("see `ulimit -u`")
    });
    assert!(limited.count() > 3, "{result:#}");
}

/// With room for a process the run would have gone on in another way.
#[test]
fn a_lockstep_run_without_room_for_a_process_says_that_it_is_not_reproducible() {
    let Some(folder) = folder_of_nobody(NOBODY - 1) else {
        return;
    };
    let _turn = real_time_turn();
    // Without a goal it goes on until its time limit: some minutes.
    let text = "title = \"waits\"\nbase = [\"warehouse\", \"porter\"]\nstart = [4.0, 6.425, 0.0]\n\
                run.time_limit_s = 100000.0\n";
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let result = at_the_limit(folder.path(), "run ./it.toml --lockstep");
    assert_eq!(result["outcome"], "service_died", "{result:#}");
    assert_eq!(result["reproducible"], false, "{result:#}");
    let why = result["not_reproducible"].as_array().expect("reasons");
    for begin in [
        "a newcomer of local_planner was rejected: no thread to ask it: ",
        "a successor of global_planner found no room: starting ",
    ] {
        let says = |line: &&Value| line.as_str().is_some_and(|line| line.starts_with(begin));
        assert!(why.iter().any(|line| says(&line)), "{begin}: {why:#?}");
    }
}

/// Nobody may have one process and no thread beside it.
const SUITES: &str = r#"
mkdir one
printf 'title = "one"\nbase = ["warehouse", "porter"]\nstart = [4.0, 6.425, 0.0]\n' > one/it.toml
printf 'run.time_limit_s = 1.0\n[[goals]]\npose = [5.0, 6.425, 0.0]\n' >> one/it.toml
(ulimit -u 1; exec ./zeronav suite generated --worlds 0..1 --bound --json > bound.json 2> bound.err)
echo $? >> bound.err
(ulimit -u 1; exec ./zeronav suite ./one --json > drive.json 2> drive.err)
echo $? >> drive.err
"#;

#[test]
fn suites_at_the_limit_of_processes_name_it_and_do_not_panic() {
    let Some(folder) = folder_of_nobody(NOBODY - 2) else {
        return;
    };
    let ended = by_nobody(folder.path(), SUITES, "");
    assert!(ended.status.success(), "{ended:?}");
    for (name, what) in [
        ("bound.err", "no thread to plan ways: "),
        ("drive.err", "starting a run of "),
    ] {
        let said = std::fs::read_to_string(folder.path().join(name)).expect("what it said");
        assert!(said.contains(what), "{name}: {said}");
        assert!(said.ends_with("\n2\n"), "{name}: {said}");
        assert!(!said.contains("panicked"), "{name}: {said}");
    }
}
