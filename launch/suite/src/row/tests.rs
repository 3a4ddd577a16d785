use super::super::case::{Manner, Rule};
use super::super::turns::OutlineWay;
use super::*;
use serde_json::{Value, json};
use std::path::PathBuf;

fn case(standing_counts: bool) -> Case {
    Case {
        world: "world_001".to_owned(),
        class: None,
        seed: 3,
        scenario: PathBuf::from("barn_world_001.toml"),
        time_limit_s: 100.0,
        rule: Rule {
            success: Success::Arrival {
                goal_m: [0.0, 10.0],
                tolerance_m: 1.0,
                standing_counts,
            },
            optimal_time_s: Some(5.0),
            reference_m: Some(9.0),
            future_is_known: false,
            way: OutlineWay::NotSearched,
        },
        manner: Manner::default(),
    }
}

/// Waits for half a second and more, drives at 1 m/s for ten, stops.
fn motion() -> Vec<[f64; 6]> {
    (0..=120)
        .map(|tenth| 0.1 * f64::from(tenth))
        .map(|t| [t, 0.0, (t - 0.55).clamp(0.0, 10.0), 1.57, 1.0, 0.0])
        .collect()
}

/// A real result with the values that a row is made of replaced.
fn run(changes: &[(&str, Value)]) -> RunResult {
    let text = include_str!("../../../measure/tests/data/result_lockstep.json");
    let mut result: Value = serde_json::from_str(text).unwrap();
    let Value::Object(usual) = json!({
        "verdict": "pass", "outcome": "reached", "reached": true,
        "contacts_moving": 0, "contacts_standing": 0, "clearance_m_min": 0.12,
        "time_s": 12.5, "driven_m": 9.9, "wall_s": 0.7,
        "track_m": [[0.0, 0.0], [0.0, 9.2]], "motion": motion(), "touches": [],
        "jerk_mps3": 0.75, "interventions": 2, "recoveries": 3, "run_hash": "00ff", "directory": "runs/x",
    }) else {
        unreachable!("an object");
    };
    let changes = changes.iter().cloned();
    let changes = changes.map(|(name, value)| (name.to_owned(), value));
    for (name, value) in usual.into_iter().chain(changes) {
        result[name] = value;
    }
    serde_json::from_value(result).unwrap()
}

fn row(standing_counts: bool, changes: &[(&str, Value)]) -> Row {
    Row::new(&case(standing_counts), &finish(run(changes)))
}

fn finish(run: RunResult) -> Finish {
    Finish {
        result: Some(run),
        code: Some(0),
        hung: false,
        complaint: String::new(),
        domain: None,
    }
}

#[test]
fn who_is_found_knows_where_he_is_and_who_is_wrong_and_certain_is_counted() {
    let mut case = case(true);
    let found = |may_be_lost| Success::Found {
        off_m: 0.5,
        off_rad: 0.3,
        may_be_lost,
    };
    case.rule.success = found(true);
    let row = |(off_m, off_rad): (f64, f64), known: bool, reached: bool, touched: bool| {
        let mut run = run(&[
            ("reached", json!(reached)),
            (
                "outcome",
                json!(if reached { "reached" } else { "timeout" }),
            ),
            ("contacts_standing", json!(u32::from(touched))),
        ]);
        let pose = run.pose.get_or_insert_default();
        (pose.error_m_last, pose.error_rad_last) = (off_m, Some(off_rad));
        pose.known_last = Some(known);
        let row = Row::new(&case, &finish(run));
        (row.success, row.wrong_arrival, row.cause)
    };
    let cause = |text: &str| Some(text.to_owned());
    let near = (0.4, 0.2);
    assert_eq!(row(near, true, true, false), (true, false, None));
    for far in [(0.6, 0.0), (0.0, 0.4)] {
        for reached in [true, false] {
            let wrong = (false, true, cause(WRONG_PLACE));
            assert_eq!(row(far, true, reached, false), wrong);
        }
        let lost = (false, false, cause("timeout"));
        assert_eq!(row(far, false, false, false), lost);
    }
    let late = (false, false, cause("timeout"));
    assert_eq!(row(near, true, false, false), late);
    let touches = (false, false, cause("contact while standing"));
    assert_eq!(row(near, true, true, true), touches);
    // Who was told the truth has no reason to be lost, even if he is found again.
    for (may_be_lost, expected) in [(true, None), (false, cause(LOST))] {
        case.rule.success = found(may_be_lost);
        let mut run = run(&[("reached", json!(true)), ("outcome", json!("reached"))]);
        let pose = run.pose.get_or_insert_default();
        (pose.error_rad_last, pose.known_last, pose.lost) = (Some(0.0), Some(true), 1);
        let row = Row::new(&case, &finish(run));
        assert_eq!((row.lost, row.cause), (Some(1), expected));
    }
}

#[test]
fn a_success_has_its_score_and_its_ratio() {
    let row = row(true, &[]);
    assert!(row.success, "{row:?}");
    // From 0.7 s, when it has driven 0.15 m, to 9.6 s, when 0.95 m are left: T = 8.9 s, which
    // counts as 2 OT = 10; by the older rule as 4 OT = 20.
    assert!((row.clock_s.unwrap() - 8.9).abs() < 1e-9, "{row:?}");
    assert!((row.score.unwrap() - 0.5).abs() < 1e-12);
    assert!((row.score_4ot.unwrap() - 0.25).abs() < 1e-12);
    assert!((row.path_ratio.unwrap() - 1.1).abs() < 1e-12);
    assert!((row.goal_distance_m.unwrap() - 0.8).abs() < 1e-12);
    assert_eq!((row.interventions, row.jerk_mps3), (Some(2), Some(0.75)));
    assert_eq!(
        (row.recoveries, row.stuck_cause.as_deref()),
        (Some(3), None)
    );
    assert!(row.arrived && !row.is_at_fault());
    assert_eq!(row.not_reproducible, None);
}

#[test]
fn a_run_that_something_else_decided_about_is_named() {
    let why = ["mapping killed by signal 9", "the run was ended by hand"];
    let changes = [
        ("reproducible", json!(false)),
        ("not_reproducible", json!(why)),
    ];
    let row = row(true, &changes);
    assert!(row.success, "it counts all the same");
    assert_eq!(row.not_reproducible, Some(why.join("; ")));
    assert_eq!(
        super::super::summary::Summary::of(&[&row]).not_reproducible,
        1
    );
}

#[test]
fn every_failure_has_its_cause() {
    let cause = |standing_counts, changes: &[(&str, Value)]| {
        let row = row(standing_counts, changes);
        assert_eq!(row.score, Some(if row.success { 0.5 } else { 0.0 }));
        row.cause
    };
    let touched = [
        ("contacts_moving", json!(1)),
        ("contacts_standing", json!(1)),
    ];
    assert_eq!(cause(false, &touched).unwrap(), "contact while moving");
    assert_eq!(
        cause(true, &touched[1..]).unwrap(),
        "contact while standing"
    );
    assert_eq!(cause(false, &touched[1..]), None);
    let late = [("reached", json!(false)), ("outcome", json!("timeout"))];
    assert_eq!(cause(true, &late).unwrap(), "timeout");
    // The robot believes to be there and is not.
    let beside = [("track_m", json!([[0.0, 0.0], [0.0, 8.9]]))];
    assert_eq!(cause(true, &beside).unwrap(), "stopped beside the goal");
}

#[test]
fn a_run_without_result_is_a_failure_with_its_reason() {
    let mut finish = Finish {
        result: None,
        code: Some(3),
        hung: false,
        complaint: "mapping stopped answering".to_owned(),
        domain: None,
    };
    let row = Row::new(&case(true), &finish);
    assert_eq!((row.success, row.score), (false, Some(0.0)));
    assert!(row.cause.unwrap().contains("mapping stopped answering"));
    finish.hung = true;
    let row = Row::new(&case(true), &finish);
    // 10 minutes and a minute for each of its 100 s.
    let cause = "hung: no end within 6600 s";
    assert_eq!(row.cause.as_deref(), Some(cause));
    let why = row.not_reproducible.unwrap_or_default();
    assert_eq!(why, format!("ended by the suite ({cause})"));
    finish.result = Some(run(&[]));
    let row = Row::new(&case(true), &finish);
    assert_eq!((row.success, row.cause.as_deref()), (false, Some(cause)));
    let mut in_real_time = case(true);
    in_real_time.manner.real_time = true;
    finish.result = None;
    let row = Row::new(&in_real_time, &finish);
    assert_eq!(row.cause.as_deref(), Some("hung: no end within 660 s"));
    assert_eq!(row.not_reproducible, None);
}
