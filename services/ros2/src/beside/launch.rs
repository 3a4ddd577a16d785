//! The companion as a client of launch.

use serde::Deserialize;
use serde_json::{Value, json};
use zeronav_shell::Domain;
use zeronav_shell::control::ask;

/// What becomes of goals, as launch says it. What it says besides is not read.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(super) struct GoalReport {
    /// The stack's number for them.
    pub(super) id: u64,
    /// `queued`, `active`, `reached`, `cancelled`, `replaced`, `time_limit`, or why they failed.
    pub(super) outcome: String,
    /// Goals that are not reached yet.
    pub(super) goals_left: usize,
    /// Since it became active. [s]
    pub(super) elapsed_s: f64,
    /// Way left to the current goal. [m]
    pub(super) distance_remaining_m: Option<f64>,
    /// The same at the present speed. [s]
    pub(super) time_remaining_s: Option<f64>,
    /// Manoeuvres and waits of the recovery.
    pub(super) recoveries: u32,
    /// Why they failed, in words.
    pub(super) why: String,
}

impl GoalReport {
    /// True until the robot is there or has given up.
    #[must_use]
    pub(super) fn goes_on(&self) -> bool {
        matches!(self.outcome.as_str(), "queued" | "active")
    }
}

/// How goals count as reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tolerance {
    /// [m]
    pub(super) distance_m: f64,
    /// [rad]
    pub(super) yaw_rad: f64,
}

/// Drives to these poses, `map_from_base`, in place of all goals before. [m, m, rad]
///
/// # Errors
/// Why launch does not.
pub(super) fn go(
    domain: &Domain,
    poses: &[[f64; 3]],
    within: Tolerance,
) -> Result<GoalReport, String> {
    let goal = |pose: &[f64; 3]| {
        json!({
            "pose": pose,
            "tolerance_m": within.distance_m,
            "yaw_tolerance_rad": within.yaw_rad,
        })
    };
    let goals: Vec<Value> = poses.iter().map(goal).collect();
    goal_of(request(
        domain,
        &json!({ "command": "goal", "goals": goals, "now": true }),
    )?)
}

/// What becomes of goals.
///
/// # Errors
/// As [`go`].
pub(super) fn status(domain: &Domain, id: u64) -> Result<GoalReport, String> {
    goal_of(request(
        domain,
        &json!({ "command": "goal_status", "id": id }),
    )?)
}

/// Stops driving to goals.
///
/// # Errors
/// As [`go`].
pub(super) fn cancel(domain: &Domain, id: u64) -> Result<(), String> {
    request(domain, &json!({ "command": "cancel", "id": id })).map(|_| ())
}

/// Puts the robot there, `map_from_base`. [m, m, rad]
///
/// # Errors
/// As [`go`].
pub(super) fn put(domain: &Domain, pose: [f64; 3]) -> Result<(), String> {
    request(domain, &json!({ "command": "pose", "pose": pose })).map(|_| ())
}

/// True once every service can answer.
///
/// # Errors
/// As [`go`].
pub(super) fn is_ready(domain: &Domain) -> Result<bool, String> {
    let reply = request(domain, &json!({ "command": "ps" }))?;
    Ok(reply["run"]["ready"] == true)
}

fn request(domain: &Domain, request: &Value) -> Result<Value, String> {
    let answer = ask(domain.folder(), &request.to_string())
        .map_err(|error| format!("launch does not answer: {error}"))?;
    let reply: Value = serde_json::from_slice(&answer)
        .map_err(|error| format!("launch answered what is no JSON: {error}"))?;
    match reply.get("error").and_then(Value::as_str) {
        Some(why) => Err(why.to_owned()),
        None => Ok(reply),
    }
}

fn goal_of(mut reply: Value) -> Result<GoalReport, String> {
    serde_json::from_value(reply["goal"].take())
        .map_err(|error| format!("launch answered something else than asked: {error}"))
}
