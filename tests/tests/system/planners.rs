//! Every planner of the table in the stack, by its key: it drives the porter through the other door when
//! the first one falls shut before it, or says that it cannot.

use serde_json::Value;
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};
use zeronav_global_planner::{PLANNERS, PlannerRow};
use zeronav_tests::Zeronav;

/// Runs side by side: in lockstep the five processes of a run mostly wait for each other.
const SIDE_BY_SIDE: usize = 3;

/// `door_closes` with this planner. Which way it takes first is its own affair, so the door need
/// not be what makes it look for another.
fn scenario(key: &str, smooth_m: f64) -> String {
    let text = zeronav_tests::shipped("door_closes");
    let text = text.replace("obstacle_replans_min = 1", "");
    format!(
        "{text}\n[services.global_planner]\nconfig.planner = \"{key}\"\nconfig.smooth_m = {smooth_m:?}\n"
    )
}

fn drive(row: &PlannerRow, smooth_m: f64) -> (i32, Value) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), scenario(row.key, smooth_m)).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let ended = Zeronav::start_in(folder, &arguments).finish();
    (ended.code(), ended.json())
}

/// What is wrong with a run of this planner, if anything.
fn fault(row: &PlannerRow, code: i32, result: &Value) -> Option<String> {
    let outcome = result["outcome"].as_str().unwrap_or("none");
    let reached = code == 0 && result["reached"] == true;
    let plans = result["plans"].as_array();
    let gave_up = plans
        .and_then(|plans| plans.last())
        .is_some_and(|plan| plan["status"] == "dead_end");
    let by_another = plans.is_none_or(|plans| {
        plans.is_empty() || plans.iter().any(|plan| plan["planner"] != row.key)
    });
    let collides = |plan: &Value| plan["status"] == "found" && plan["collides"] != false;
    let fault = if result["contacts"] != 0 {
        "a contact"
    } else if plans.is_some_and(|plans| plans.iter().any(collides)) {
        "a path through a wall"
    } else if by_another {
        "not the planner that was asked for"
    } else if reached {
        return None;
    } else if row.complete {
        "a complete planner does not arrive"
    } else if outcome == "no_path" && gave_up {
        return None;
    } else {
        "an incomplete planner does not say that it gave up"
    };
    Some(format!("{}: {fault} (code {code}, {outcome})", row.key))
}

#[test]
fn every_planner_gets_around_the_closed_door_or_reports_failure() {
    // Three of them once more with rounded paths.
    let rounded = ["mpgaa", "any_angle", "lazy_theta"];
    let runs = PLANNERS.iter().map(|row| (row, 0.0)).chain(
        PLANNERS
            .iter()
            .filter(|row| rounded.contains(&row.key))
            .map(|row| (row, 0.3)),
    );
    let waiting: Mutex<VecDeque<(&PlannerRow, f64)>> = Mutex::new(runs.collect());
    let next = || {
        let mut waiting = waiting.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.pop_front()
    };
    let faults = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..SIDE_BY_SIDE {
            scope.spawn(|| {
                while let Some((row, smooth_m)) = next() {
                    let (code, result) = drive(row, smooth_m);
                    eprintln!(
                        "{:12} {smooth_m:.1} {:12} {} m, {} paths, {} contacts, {} s",
                        row.key,
                        result["outcome"].as_str().unwrap_or("none"),
                        result["driven_m"],
                        result["plans"].as_array().map_or(0, Vec::len),
                        result["contacts"],
                        result["time_s"],
                    );
                    let mut faults = faults.lock().unwrap_or_else(PoisonError::into_inner);
                    faults.extend(fault(row, code, &result));
                }
            });
        }
    });
    let faults = faults.into_inner().unwrap_or_else(PoisonError::into_inner);
    assert!(faults.is_empty(), "{faults:#?}");
}

/// How far the path of 5 s into `oncoming_person` leaves the middle of the corridor, in which somebody
/// comes towards the robot at 1 m/s, when obstacles slower than this block the way. [m]
fn aside_m(blocks_below_mps: f64) -> f64 {
    let text = zeronav_tests::shipped("oncoming_person");
    let (text, _) = text.split_once("[expect]").expect("what it expects");
    let folder = tempfile::tempdir().expect("a folder");
    let text = format!(
        "{text}\n[services.global_planner]\nconfig.blocks_below_mps = {blocks_below_mps:?}\n"
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let result = Zeronav::start_in(folder, &arguments).finish().json();
    let plans = result["plans"].as_array().expect("paths");
    let until = plans
        .iter()
        .rfind(|plan| plan["time_s"].as_f64().is_some_and(|time_s| time_s <= 5.0));
    let points: Vec<[f64; 2]> =
        serde_json::from_value(until.expect("a path")["points_m"].clone()).expect("points");
    points
        .iter()
        .map(|[_, y]| (y - 4.0).abs())
        .fold(0.0, f64::max)
}

#[test]
fn who_walks_blocks_the_way_only_when_that_is_asked_for() {
    let (left_alone_m, blocked_m) = (aside_m(0.3), aside_m(1.5));
    assert!(left_alone_m < 0.1, "{left_alone_m} m");
    assert!(blocked_m > 0.5, "{blocked_m} m");
}
