//! Services in Python on the real stack: they drive, repeat themselves in lockstep, come back from a
//! kill, and say what is wrong like every other service.

use rustix::process::Signal;
use serde_json::Value;
use std::process::Command;
use zeronav_tests::python::{example, program, python};
use zeronav_tests::rooms::box_in_an_aisle;
use zeronav_tests::{
    Stranger, Zeronav, await_by_itself, leftovers, real_time_turn, send_signal, workspace,
};

/// Drives past a box in an aisle with an example in each of these seats.
fn start(seats: &[(&str, &str)], more: &str, flags: &[&str]) -> Zeronav {
    let folder = tempfile::tempdir().expect("a folder");
    let mut text = box_in_an_aisle();
    for (role, name) in seats {
        let binary = example(name, folder.path());
        let lines = format!("\n[services.{role}]\nbinary = \"{}\"\n", binary.display());
        text += &lines;
    }
    text += more;
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let mut arguments = vec!["run", "./it.toml", "--headless", "--json"];
    arguments.extend(flags);
    Zeronav::start_in(folder, &arguments)
}

const PLANNER: (&str, &str) = ("global_planner", "astar");
const CONTROLLER: (&str, &str) = ("local_planner", "pure_pursuit");
const GUARD: (&str, &str) = ("collision_guard", "guard");

fn assert_arrived(result: &Value) {
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    assert_eq!(result["restarts"], serde_json::json!([]), "{result:#}");
}

#[test]
fn in_lockstep_python_seats_drive_the_same_way_twice() {
    // All at once: what differs in one of them differs in the run.
    let seats = [PLANNER, CONTROLLER, GUARD];
    let drive = || start(&seats, "", &["--lockstep"]).finish().expect(0);
    let (first, second) = (drive(), drive());
    assert_arrived(&first);
    assert!(first["run_hash"].is_string(), "{first:#}");
    assert_eq!(first["run_hash"], second["run_hash"]);
    let services = first["services"].as_array().expect("services");
    for (role, name) in seats {
        let seat = services.iter().find(|seat| seat["name"] == role);
        assert_eq!(seat.expect("a seat")["binary"], name, "{first:#}");
    }
    assert_eq!(first["plans"][0]["planner"], "astar_py", "{first:#}");
}

#[test]
fn in_real_time_two_python_seats_keep_up() {
    let _turn = real_time_turn();
    let result = start(&[PLANNER, CONTROLLER], "", &[]).finish().expect(0);
    assert_arrived(&result);
    for (role, name) in [PLANNER, CONTROLLER] {
        let services = result["services"].as_array().expect("services");
        let seat = services.iter().find(|seat| seat["name"] == role);
        assert_eq!(seat.expect("a seat")["binary"], name);
    }
    let hops: Vec<&Value> = ["direct", "through_map"]
        .iter()
        .filter_map(|ways| result["latency"]["every_scan"][*ways].as_array())
        .flatten()
        .collect();
    for (role, _) in [PLANNER, CONTROLLER] {
        let of_seat = hops.iter().filter(|hop| hop["name"] == role);
        let measured = of_seat.filter_map(|hop| hop["n"].as_u64()).max();
        assert!(measured.is_some_and(|n| n > 40), "{role}: {hops:#?}");
    }
}

/// Waits for the run time `time_s`, then kills the process in a seat.
fn kill_at(run: &mut Zeronav, role: &str, time_s: f64) {
    run.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"]
            .as_f64()
            .is_some_and(|now_s| now_s >= time_s)
    });
    let pid = run.service(role).expect("a process in the seat");
    assert!(send_signal(pid, Signal::KILL));
}

#[test]
fn a_killed_python_seat_comes_back_and_arrives() {
    for seat in [PLANNER, CONTROLLER] {
        let mut run = start(&[seat], "", &["--lockstep"]);
        kill_at(&mut run, seat.0, 3.0);
        let result = run.finish().expect(0);
        assert_eq!(result["reached"], true, "{result:#}");
        assert_eq!(result["contacts"], 0, "{result:#}");
        let restarts = result["restarts"].as_array().expect("restarts");
        assert_eq!(restarts.len(), 1, "{result:#}");
        assert_eq!(restarts[0]["service"], seat.0, "{result:#}");
    }
}

/// A drive whose global planner is left to the test, and its domain.
fn with_a_free_seat() -> (Zeronav, std::path::PathBuf) {
    let flags = ["--lockstep", "--external", "global_planner"];
    let mut run = start(&[], "", &flags);
    run.wait_until("the others run", |run| run.children().len() == 4);
    run.wait_until("they know their domain", |run| run.domains().len() == 1);
    let root = run.domains().pop().expect("a domain");
    (run, root)
}

#[test]
fn a_python_service_says_with_its_exit_code_what_is_wrong() {
    let (run, root) = with_a_free_seat();
    let folder = tempfile::tempdir().expect("a folder");
    let planner = example("astar", folder.path());
    let planner = planner.to_str().expect("a path");
    let ends = |binary: &str, flags: &[&str], code: i32, why: &str| {
        let (ended, log) = Stranger::start(binary, &root, flags).left();
        assert_eq!(ended, code, "{log}");
        assert!(log.contains(why), "{why} is not in: {log}");
    };
    ends(planner, &["--epoch", "7"], 2, "expects --epoch 1");
    ends(planner, &[], 2, "either --epoch N or --shadow is needed");
    ends(planner, &["--epoch", "0"], 2, "must be 1 to");
    // Built from another contract: the path has other fields.
    let text = "import sys\n\
        from zeronav import contract\n\
        object.__setattr__(contract.PLAN_PATH, 'schema', 1)\n\
        sys.path.insert(0, sys.argv.pop(1))\n\
        import astar\n\
        astar.run(astar.AStar)\n";
    let other = program("other", text, folder.path());
    let examples = workspace().join("services/python/examples");
    let flags = [examples.to_str().expect("a path"), "--epoch", "1"];
    let mut wrong = Command::new(other);
    wrong
        .arg(flags[0])
        .arg("--domain")
        .arg(&root)
        .args(&flags[1..]);
    let output = wrong.output().expect("it ran");
    let log = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{log}");
    assert!(log.contains("contract: topic plan/path"), "{log}");
    assert!(log.contains("schema hash differs"), "{log}");
    // The seat is free again for the right one, which leaves with the run.
    let mut right = Stranger::start(planner, &root, &["--epoch", "1"]);
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{}\n{result:#}", right.log());
    let (code, log) = right.left();
    assert_eq!(code, 0, "{log}");
    assert!(log.contains("launch is gone"), "{log}");
    await_by_itself("nothing is left", || leftovers(&root).is_empty());
}

#[test]
fn a_python_service_leaves_when_it_is_asked_to() {
    let (mut run, root) = with_a_free_seat();
    let folder = tempfile::tempdir().expect("a folder");
    let planner = example("astar", folder.path());
    let planner = planner.to_str().expect("a path");
    let service = Stranger::start(planner, &root, &["--epoch", "1"]);
    run.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|time_s| time_s > 0.5)
    });
    assert!(send_signal(service.pid(), Signal::TERM));
    let (code, log) = service.left();
    assert_eq!(code, 0, "{log}");
    assert!(!log.contains("Traceback"), "{log}");
}

#[test]
fn a_wrong_parameter_of_a_python_service_is_found_before_the_run() {
    for (line, why) in [
        (
            "config.lookahead_m = -1.0",
            "lookahead_m: must be 0.1 to 5.0",
        ),
        ("config.lokahead_m = 1.0", "did you mean `lookahead_m`?"),
        ("config.margin_m = \"wide\"", "margin_m: must be a number"),
    ] {
        let more = format!("{line}\n");
        let ended = start(&[CONTROLLER], &more, &["--lockstep"]).finish();
        assert_eq!(ended.code(), 2, "{}", ended.stderr);
        assert!(
            ended.stderr.contains(why),
            "{why} is not in: {}",
            ended.stderr
        );
        assert!(ended.stderr.contains("it.toml:"), "{}", ended.stderr);
    }
}

#[test]
fn a_seat_that_no_python_service_can_take_is_an_error_of_usage() {
    let text = "from zeronav import Service, contract as c, run\n\
        class Robot(Service):\n\
        \x20   role = c.Role.ROBOT\n\
        run(Robot)\n";
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(program("robot", text, folder.path()))
        .args(["--domain", "/nowhere", "--epoch", "1"])
        .output()
        .expect("it ran");
    let log = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{log}");
    assert_eq!(log, "no service in Python can take the seat robot\n");
}

#[test]
fn the_package_passes_its_own_tests() {
    let output = Command::new(python())
        .args(["-m", "unittest", "discover", "--start-directory"])
        .arg(workspace().join("services/python/tests"))
        .output()
        .expect("Python runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(!said.contains("Ran 0 tests"), "{said}");
}
