//! Robots whose commands take effect late, in lockstep: what their description says reaches the guard and
//! the local planner.

use serde_json::Value;
use zeronav_tests::Zeronav;

/// The hall's walls and a robot that obeys so late [s]; `more` ends the file.
fn drive(delay_s: f64, controller: &str, start: &str, goal: &str, more: &str) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let text = format!(
        r#"
        title = "Commands take effect late"
        base = ["hall", "porter"]
        start = {start}

        [run]
        time_limit_s = 120.0

        [[goals]]
        {goal}

        [services.local_planner]
        config.controller = "{controller}"

        {more}

        [robot]
        actuation_delay_s = {delay_s}

        [expect]
        outcome = "reached"
        contacts_max = 0
        "#
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    Zeronav::start_in(folder, &arguments).finish().expect(0)
}

#[test]
fn a_robot_that_obeys_late_stops_before_a_box_that_it_could_not_avoid_by_its_brakes_alone() {
    // 0.9 m before the robot's front: at 0.9 m/s it needs 0.34 m to brake, and 0.27 m before that.
    let obstacle = "[[world.obstacles]]\nname = \"box\"\n\
         shape = { kind = \"box\", centre_m = [6.4, 4.0], size_m = [0.5, 1.0] }\n\
         appears = { robot_near = { point_m = [5.0, 4.0], distance_m = 0.1 } }\n";
    for controller in ["beam", "dwa"] {
        let goal = "pose = [8.5, 4.0, 0.0]";
        let result = drive(0.3, controller, "[1.5, 4.0, 0.0]", goal, obstacle);
        assert_eq!(result["verdict"], "pass", "{controller}: {result:#}");
    }
}

#[test]
fn a_robot_that_obeys_late_turns_to_its_goals_yaw_as_soon_as_others() {
    let goal = "pose = [4.0, 4.0, -1.6]\nyaw_tolerance_rad = 0.1";
    let time_s = |delay_s| {
        let result = drive(delay_s, "beam", "[1.5, 4.0, 2.5]", goal, "");
        assert_eq!(result["verdict"], "pass", "{delay_s} s: {result:#}");
        assert_eq!(result["command_lag"], Value::Null, "{result:#}");
        result["time_s"].as_f64().expect("a number")
    };
    let at_once_s = time_s(0.0);
    for delay_s in [0.15, 0.5] {
        let late_s = time_s(delay_s);
        assert!(
            late_s < 1.3 * at_once_s + 1.0,
            "{delay_s} s: {late_s} s, not {at_once_s} s"
        );
    }
}
