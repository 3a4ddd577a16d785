//! A stack whose user has reached the limit of processes: a swap is rejected, a restart is tried again
//! within its budget, and the run ends with its result.

use serde_json::Value;
use std::fs::Permissions;
use std::os::unix::fs::{PermissionsExt, chown};
use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};
use zeronav_tests::{binaries, real_time_turn};

/// User and group `nobody`.
const NOBODY: u32 = 65534;

/// What nobody does: brings a stack up that may have 40 processes and threads, starts 60 others, asks for
/// a swap, and kills the planner.
const SCRIPT: &str = r#"
(ulimit -u 40; exec ./zeronav up open_aisle --headless --json > up.json 2> up.err < /dev/null) &
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

#[test]
fn a_stack_at_the_limit_of_processes_rejects_swaps_and_ends_with_a_result() {
    if !rustix::process::geteuid().is_root() {
        eprintln!("SKIPPED: only root can become another user, and root has no such limit");
        return;
    }
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::set_permissions(folder.path(), Permissions::from_mode(0o755)).expect("its mode");
    // The checkout may lie where nobody can look.
    for name in [
        "zeronav",
        "zeronav-collision-guard",
        "zeronav-global-planner",
        "zeronav-local-planner",
        "zeronav-mapping",
        "zeronav-robot-sim",
    ] {
        std::fs::copy(binaries().join(name), folder.path().join(name)).expect("a binary");
    }
    chown(folder.path(), Some(NOBODY), Some(NOBODY)).expect("its owner");
    let ended = Command::new("bash")
        .args(["-c", SCRIPT])
        .current_dir(folder.path())
        .env_remove("CARGO")
        .env("HOME", folder.path())
        .stdin(Stdio::null())
        .uid(NOBODY)
        .gid(NOBODY)
        .output()
        .expect("it runs");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap_or_default();
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
    let result: Value = serde_json::from_str(&read("up.json")).expect("a result");
    assert_eq!(result["outcome"], "service_died", "{result:#}");
    let restarts = result["restarts"].as_array().expect("restarts");
    let limited = restarts.iter().filter(|restart| {
        let how = restart["how"].as_str().unwrap_or_default();
        how.contains("starting") && how.contains("see `ulimit -u`")
    });
    assert!(limited.count() > 3, "{result:#}");
}
