//! Ages by the clock: in real time the lidar goes blind for a while, and each of the two that can
//! stop the robot has to notice by itself.

use serde_json::Value;
use zeronav_tests::{Zeronav, real_time_turn};

/// Drives across the hall in real time, with a lidar that says nothing for 2.5 s on the way.
fn blind(more: &str) -> Value {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    let text = format!(
        r#"
        title = "The lidar goes blind for a while"
        base = ["hall", "porter"]
        start = [1.5, 4.0, 0.0]

        [run]
        time_limit_s = 20.0

        [[goals]]
        pose = [8.0, 4.0, 0.0]

        [[robot.faults]]
        kind = "lidar_blackout"
        begins = {{ driven_m = 2.5 }}
        lasts_s = 2.5

        {more}
        "#
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--headless", "--json"];
    Zeronav::start_in(folder, &arguments).finish().expect(0)
}

/// The speeds from the first place on at which the lidar says nothing any more. [m/s]
fn speeds_once_blind(result: &Value) -> Vec<f64> {
    let motion: Vec<[f64; 6]> =
        serde_json::from_value(result["motion"].clone()).expect("rows of six numbers");
    let blind = motion.into_iter().skip_while(|row| row[1] < 1.5 + 2.5);
    blind.map(|row| row[4]).collect()
}

fn stale_scans(result: &Value) -> u64 {
    result["interventions_by_reason"]["scan_stale"]
        .as_u64()
        .unwrap_or(0)
}

#[test]
fn local_planner_stops_for_a_stale_scan_in_real_time() {
    // The guard would go on for ten seconds.
    let result = blind(
        "[services.collision_guard]\nconfig.scan_age_s = 10.0\n\
         [services.local_planner]\nconfig.staleness.scan_age_s = 0.3\n\
         config.staleness.map_age_s = 10.0\n",
    );
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(stale_scans(&result), 0, "{result:#}");
    let speeds = speeds_once_blind(&result);
    assert!(speeds[0] > 0.5, "it was slow before: {}", speeds[0]);
    let rest = speeds.iter().position(|v_mps| v_mps.abs() < 0.01);
    let rest = rest.expect("it came to rest");
    assert!(
        speeds[rest..].iter().any(|v_mps| *v_mps > 0.3),
        "it came to rest at the goal only"
    );
}

#[test]
fn guard_stops_for_a_stale_scan_in_real_time() {
    // The local planner asks for full speed, whatever it sees or does not.
    let result = blind(
        "[services.local_planner]\nbinary = \"requests_full_speed\"\n\
         [expect]\noutcome = \"timeout\"\n",
    );
    assert!(stale_scans(&result) >= 1, "{result:#}");
    let speeds = speeds_once_blind(&result);
    assert!(speeds[0] > 0.5, "it was slow before: {}", speeds[0]);
    let rest = speeds.iter().position(|v_mps| v_mps.abs() < 0.01);
    let rest = rest.expect("it came to rest");
    assert!(
        speeds[rest..].iter().any(|v_mps| *v_mps > 0.3),
        "it came to rest at the wall only"
    );
}
