//! A robot that does not know where it is, or is told wrongly, finds itself on the real processes and arrives.

use zeronav_tests::{workspace, zeronav};

/// Drives a scenario whose expectations say that it really arrives. How far off the pose was at most, and at the end. [m]
fn drives(name: &str) -> [f64; 2] {
    let file = workspace().join(format!("tests/scenarios/{name}.toml"));
    let file = file.to_str().expect("a path");
    let run = || zeronav(&["run", file, "--lockstep", "--headless", "--json"]).expect(0);
    let (result, again) = (run(), run());
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert!(result["run_hash"].is_string());
    assert_eq!(
        result["run_hash"], again["run_hash"],
        "the search is the same in every run"
    );
    let pose = &result["pose"];
    ["error_m_max", "error_m_last"].map(|key| pose[key].as_f64().expect("metres"))
}

#[test]
fn a_robot_that_wakes_without_a_pose_finds_itself_and_arrives() {
    let [most_m, last_m] = drives("wakes_anywhere");
    assert!(most_m > 5.0, "{most_m} m: the start gives it away");
    assert!(last_m < 0.1, "{last_m} m");
}

#[test]
fn a_robot_that_is_told_a_wrong_place_notices_and_arrives() {
    let [most_m, last_m] = drives("told_wrong_place");
    assert!(most_m > 1.9, "{most_m} m: it was told the truth");
    assert!(last_m < 0.1, "{last_m} m");
}
