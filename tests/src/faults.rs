//! A drive with one fault, and what it did to the robot.

use core::fmt::Write;
use serde_json::Value;
use zeronav_msgs::topics::{
    ControlRequest, MapObstacles, MapUpdate, PlanPath, RobotCommand, RobotOdometry, RobotScan,
    Topic, TopicRow,
};

/// The seats whose services may break.
pub const SERVICES: [&str; 4] = [
    "mapping",
    "global_planner",
    "local_planner",
    "collision_guard",
];

/// What breaks them in lockstep.
pub const KINDS: [&str; 3] = ["kill", "stop", "slow"];

/// Topics between services, each from another one, the robot included.
const TOPICS: [&TopicRow; 7] = [
    RobotScan::ROW,
    RobotOdometry::ROW,
    MapUpdate::ROW,
    MapObstacles::ROW,
    PlanPath::ROW,
    ControlRequest::ROW,
    RobotCommand::ROW,
];

/// What is done to their messages, and the rest of its lines.
const TOPIC_KINDS: [(&str, &str); 3] = [
    ("drop", "share = 0.5\n"),
    ("delay", "by_ms = 100.0\n"),
    ("corrupt", "share = 0.5\n"),
];

/// Faults of a drive that disturb each topic in each way, and each clock either way; all begin so much
/// after another, and last so long. [s]
pub const DISTURBED_EVERY_S: f64 = 3.0;
const DISTURBED_LASTS_S: f64 = 1.0;

/// The lines of such a drive, and what each of its faults is.
#[must_use]
pub fn disturbed() -> (String, Vec<String>) {
    one_after_another(&disturbances())
}

/// What each of its faults is, and its lines without when it begins.
#[must_use]
pub fn disturbances() -> Vec<(String, String)> {
    let mut faults = Vec::new();
    for topic in TOPICS.map(|row| row.name) {
        for (kind, more) in TOPIC_KINDS {
            let what = format!("`{kind}` `{topic}`");
            faults.push((
                what,
                format!("kind = \"{kind}\"\ntopic = \"{topic}\"\n{more}"),
            ));
        }
    }
    for service in SERVICES {
        for by_ms in [200.0, -200.0] {
            let what = format!("`clock` `{service}` {by_ms:+} ms");
            let lines = format!("kind = \"clock\"\nservice = \"{service}\"\nby_ms = {by_ms:?}\n");
            faults.push((what, lines));
        }
    }
    faults
}

/// The lines of a drive with some of them, and what each is.
#[must_use]
pub fn one_after_another(faults: &[(String, String)]) -> (String, Vec<String>) {
    let (mut lines, mut names, mut at_s) = (String::new(), Vec::new(), 2.0);
    for (name, fault) in faults {
        let _ = writeln!(
            lines,
            "[[faults]]\n{fault}begins = {{ at_s = {at_s:?} }}\nlasts_s = {DISTURBED_LASTS_S:?}"
        );
        names.push(name.clone());
        at_s += DISTURBED_EVERY_S;
    }
    (lines, names)
}

/// Slower than this the robot stands. [m/s]
const STANDING_MPS: f64 = 0.01;

/// The scenario of a drive up and down an aisle with `n_goals` goals and these lines more.
#[must_use]
pub fn scenario(n_goals: usize, lines: &str) -> String {
    let mut text = "title = \"faults\"\nbase = [\"warehouse\", \"porter\"]\n\
                    start = [4.0, 6.425, 0.0]\nrun.time_limit_s = 3600.0\n"
        .to_owned();
    for goal in 0..n_goals {
        let x_m = if goal % 2 == 0 { 12.5 } else { 5.0 };
        let _ = writeln!(text, "[[goals]]\npose = [{x_m}, 6.425, 0.0]");
    }
    text + "[restart]\nper_service = 10000\nper_run = 10000\n" + lines
}

/// The lines of one fault at `at_s`.
#[must_use]
pub fn fault(kind: &str, service: &str, at_s: f64) -> String {
    let more = if kind == "slow" {
        "by_ms = 20.0\nlasts_s = 2.0\n"
    } else {
        ""
    };
    format!(
        "[[faults]]\nkind = \"{kind}\"\nservice = \"{service}\"\nbegins = {{ at_s = {at_s:?} }}\n{more}"
    )
}

/// What one fault did, by the ground truth of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effect {
    /// Way from the fault to the next standstill before the goal; `None` without one. [m]
    pub stop_m: Option<f64>,
    /// How long the robot stood then. [s]
    pub stood_s: f64,
    /// Lowest speed in the window. [m/s]
    pub v_mps_min: f64,
}

/// The effect of a fault of a run, by its place in the result, in the `window_s` after its begin.
#[must_use]
pub fn effect(result: &Value, index: usize, window_s: f64) -> Effect {
    let begun_s = result["faults"][index]["time_s"].as_f64().unwrap_or(0.0);
    let rows: Vec<Vec<f64>> = (result["motion"].as_array().into_iter().flatten())
        .filter_map(|row| Some(row.as_array()?.iter().filter_map(Value::as_f64).collect()))
        .filter(|row: &Vec<f64>| row.len() == 6 && row[0] >= begun_s)
        .collect();
    let window = rows.iter().filter(|row| row[0] < begun_s + window_s);
    let stands = |row: &&Vec<f64>| row[4].abs() < STANDING_MPS;
    let v_mps_min = window.clone().map(|row| row[4]).fold(f64::MAX, f64::min);
    let stop = window.clone().position(|row| stands(&row));
    let stop_m = stop.map(|at| {
        let ways = rows[..=at].windows(2);
        ways.map(|pair| (pair[1][1] - pair[0][1]).hypot(pair[1][2] - pair[0][2]))
            .sum()
    });
    let stood = stop.map_or(0, |at| rows[at..].iter().take_while(stands).count());
    Effect {
        stop_m,
        stood_s: 0.1 * f64::from(u32::try_from(stood).unwrap_or(u32::MAX)),
        v_mps_min,
    }
}
