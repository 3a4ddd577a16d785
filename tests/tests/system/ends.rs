//! How a run ends when its parts do not keep their word.

use rustix::process::{Pid, Signal, kill_process};
use std::path::PathBuf;
use zeronav_msgs::topics::{RobotScan, Topic};
use zeronav_tests::rooms::box_in_an_aisle;
use zeronav_tests::{
    Zeronav, await_by_itself, binaries, is_alive, leftovers, real_time_turn, zeronav,
};

/// Starts a drive in real time and waits until all five services are there.
fn driving() -> (Zeronav, PathBuf) {
    underway(Zeronav::start(&[
        "run",
        "open_aisle",
        "--headless",
        "--json",
    ]))
}

/// The run and its domain, once everything is there.
fn underway(mut run: Zeronav) -> (Zeronav, PathBuf) {
    run.wait_until("every service runs", |run| run.children().len() == 5);
    run.wait_until("every service knows its domain", |run| {
        run.domains().len() == 1
    });
    let root = run.domains().pop().expect("a domain");
    run.wait_until("the scan flows", |_| leftovers(&root).len() > 40);
    (run, root)
}

fn kill(pid: u32) {
    let pid = i32::try_from(pid)
        .ok()
        .and_then(Pid::from_raw)
        .expect("a process id");
    kill_process(pid, Signal::KILL).expect("it is there");
}

#[test]
fn the_death_of_the_robot_ends_the_run_by_name() {
    let _turn = real_time_turn();
    let (run, root) = driving();
    let (pid, _) = run
        .children()
        .into_iter()
        .find(|(_, line)| line.contains("zeronav-robot-sim"))
        .expect("the robot");
    kill(pid);
    let ended = run.finish();
    assert_eq!(ended.code(), 3, "{}", ended.stderr);
    assert!(
        ended.stderr.contains("robot ended during the run"),
        "{}",
        ended.stderr
    );
    assert_eq!(ended.json()["outcome"], "service_died");
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

#[test]
fn killed_service_restarts_in_real_time() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), box_in_an_aisle()).expect("written");
    let arguments = ["run", "./it.toml", "--headless", "--json"];
    let (run, root) = underway(Zeronav::start_in(folder, &arguments));
    let (pid, _) = run
        .children()
        .into_iter()
        .find(|(_, line)| line.contains("zeronav-collision-guard"))
        .expect("the guard");
    kill(pid);
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true);
    assert_eq!(result["contacts"], 0);
    assert_eq!(result["restarts"][0]["service"], "collision_guard");
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

#[test]
fn killing_launch_ends_only_its_own_run() {
    let _turn = real_time_turn();
    let (run, root) = driving();
    let children: Vec<u32> = run.children().into_iter().map(|(pid, _)| pid).collect();
    let (live, live_root) = driving();
    kill(run.pid());
    await_by_itself("every child is gone", || {
        !children.iter().any(|pid| is_alive(*pid))
    });
    await_by_itself("nothing is left", || leftovers(&root).is_empty());
    assert!(
        !leftovers(&live_root).is_empty(),
        "a live domain was touched"
    );
    live.signal(Signal::INT);
    assert_eq!(live.finish().code(), 130);
}

#[test]
fn external_service_takes_its_seat() {
    let arguments = [
        "run",
        "unsealed",
        "--lockstep",
        "--headless",
        "--json",
        "--external",
        "collision_guard",
    ];
    let mut run = Zeronav::start(&arguments);
    run.wait_until("the others run", |run| run.children().len() == 4);
    run.wait_until("they know their domain", |run| run.domains().len() == 1);
    let root = run.domains().pop().expect("a domain");
    let mut guard = std::process::Command::new(binaries().join("zeronav-collision-guard"))
        .args(["--epoch", "1", "--domain"])
        .arg(&root)
        .spawn()
        .expect("the guard starts");
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    let services = result["services"].as_array().expect("services");
    let ours = services
        .iter()
        .find(|service| service["name"] == "collision_guard");
    let ours = ours.expect("the guard");
    assert_eq!(ours["binary"], "zeronav-collision-guard", "{ours:#}");
    assert_eq!(ours["pid"], guard.id(), "{ours:#}");
    guard
        .kill()
        .expect("it is there: launch does not end what it did not start");
    guard.wait().expect("its end");
    // The domain had a member until now; the next command removes it.
    assert_eq!(zeronav(&["list"]).code(), 0);
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
    let unknown = zeronav(&["run", "unsealed", "--external", "guard"]);
    assert_eq!(unknown.code(), 2);
    assert!(
        unknown.stderr.contains("collision_guard"),
        "{}",
        unknown.stderr
    );
}

#[test]
fn peer_with_swapped_fields_is_rejected_by_topic() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = "title = \"test\"\nbase = [\"warehouse\", \"porter\"]\n\
                    start = [3.0, 8.5, 0.0]\n\
                    [services.mapping]\nbinary = \"swapped_fields_mapping\"\n";
    std::fs::write(folder.path().join("it.toml"), scenario).expect("written");
    let ended = Zeronav::start_in(folder, &["run", "./it.toml", "--headless", "--json"]).finish();
    assert_eq!(ended.code(), 3, "{}", ended.stderr);
    for word in ["mapping", RobotScan::ROW.name, "schema"] {
        assert!(
            ended.stderr.contains(word),
            "`{word}` is not named:\n{}",
            ended.stderr
        );
    }
    assert_eq!(ended.json()["outcome"], "service_died");
}
