//! One run of a suite as it is reported.

use super::case::{Case, Success};
use super::hindsight::{ContactRow, Hindsight};
use super::runner::Finish;
use super::score::{RULES, score};
use super::soaked::Soaked;
use super::track::{closest_m, turning_rad};
use serde::{Deserialize, Serialize};
use zeronav_console::exit::EXIT_USAGE;
use zeronav_measure::result::{RunResult, Touch};

/// The folder of the runs in that of the suite.
pub(super) const RUNS: &str = "runs";

/// Why a run is no success whose robot said that it had arrived and had not.
const BESIDE_THE_GOAL: &str = "stopped beside the goal";

/// The same where its pose was wrong.
const WRONG_PLACE: &str = "took another place for its own";

/// One run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// World.
    pub world: String,
    /// What the world is sorted by.
    pub class: Option<String>,
    /// Seed.
    pub seed: u64,
    /// True when everything was as the suite asks.
    pub success: bool,
    /// Why it was not.
    pub cause: Option<String>,
    /// How the run ended, see `outcome` in a run's result.
    pub outcome: Option<String>,
    /// Contacts that began while the robot moved.
    pub contacts_moving: u32,
    /// Contacts that began while it stood.
    pub contacts_standing: u32,
    /// Contacts that began while it moved and that an oracle who knows every future could not have
    /// avoided either; null where the future depends on the robot.
    pub unavoidable: Option<u32>,
    /// True when the robot came to its goal in time, whatever it touched.
    pub arrived: bool,
    /// From the goal to its end. [s]
    pub time_s: Option<f64>,
    /// The same by the benchmark's clock, which runs from the first 0.1 m really driven to the
    /// tolerance around the goal; only where the benchmark has one. [s]
    pub clock_s: Option<f64>,
    /// Score by the rule of 2 OT and the benchmark's clock.
    pub score: Option<f64>,
    /// Score by the rule of 4 OT.
    pub score_4ot: Option<f64>,
    /// True when a way of the robot's outline was found among what stands; null where none was looked for.
    #[serde(default)]
    pub way_exists: Option<bool>,
    /// True when the robot said that it had arrived and had not.
    #[serde(default)]
    pub wrong_arrival: bool,
    /// Run time per time of that way at top speeds, of successes.
    #[serde(default)]
    pub time_ratio: Option<f64>,
    /// Distance driven per length of reference, of successes.
    pub path_ratio: Option<f64>,
    /// Smallest distance of the footprint to anything. [m]
    pub clearance_m_min: Option<f64>,
    /// Sum of the changes of direction of the track. [rad]
    pub turning_rad: Option<f64>,
    /// Mean absolute jerk of the true forward speed. [m/s^3]
    pub jerk_mps3: Option<f64>,
    /// Interventions of the collision guard.
    pub interventions: Option<u64>,
    /// Manoeuvres and waits of the local planner's recovery.
    pub recoveries: Option<u64>,
    /// Why it got stuck: `blocked`, `no_progress`, `too_many_attempts`; null when it has not.
    pub stuck_cause: Option<String>,
    /// Distance driven. [m]
    pub driven_m: Option<f64>,
    /// How near the robot's centre really came to the goal. [m]
    pub goal_distance_m: Option<f64>,
    /// Wall time of the drive, which depends on the machine and is no result. [s]
    #[serde(skip)]
    pub wall_s: Option<f64>,
    /// How far off the robot's pose was at the end. [m]
    #[serde(default)]
    pub pose_error_m: Option<f64>,
    /// The same of its yaw. [rad]
    #[serde(default)]
    pub pose_error_rad: Option<f64>,
    /// Hash of the run.
    pub run_hash: Option<String>,
    /// Why the run may go otherwise the next time; null when it does not.
    #[serde(default)]
    pub not_reproducible: Option<String>,
    /// The run's folder, in that of the suite.
    pub directory: Option<String>,
    /// Why it could not begin, exit code 2; the report has it once.
    #[serde(skip)]
    pub refusal: Option<String>,
    /// What it touched; the report has it in a list of its own.
    #[serde(skip)]
    pub contacts: Vec<ContactRow>,
    /// What came of a drive of a soak; the report has it in a list of its own.
    #[serde(skip)]
    pub soaked: Option<Box<Soaked>>,
}

impl Row {
    /// The row of a run.
    #[must_use]
    pub(super) fn new(case: &Case, finish: &Finish) -> Self {
        let Some(run) = &finish.result else {
            return Self::without_result(case, finish);
        };
        let goal_distance_m = match case.rule.success {
            Success::Arrival { goal_m, .. } => closest_m(&run.track_m, goal_m),
            Success::Found { .. } | Success::Expectations => None,
        };
        let contacts = contacts(case, run);
        let n_unavoidable = contacts
            .iter()
            .filter(|contact| contact.moving && contact.unavoidable)
            .count();
        let unavoidable = u32::try_from(n_unavoidable).unwrap_or(u32::MAX);
        let arrival = missed(&case.rule.success, run, goal_distance_m);
        let cause = if finish.hung {
            Some(case.hung())
        } else {
            touched(&case.rule.success, run, unavoidable).or_else(|| arrival.clone())
        };
        let success = cause.is_none();
        let way_s = case.rule.way.found().map(|way| way.time_s);
        let clock_s = case.clock().and_then(|clock| clock.time_s(&run.motion));
        let by_rule = |fastest| {
            let optimal_time_s = case.rule.optimal_time_s?;
            let time_s = clock_s.unwrap_or(f64::INFINITY);
            Some(score(success, optimal_time_s, time_s, fastest))
        };
        Self {
            success,
            cause,
            outcome: Some(run.outcome.clone()),
            contacts_moving: run.contacts_moving,
            contacts_standing: run.contacts_standing,
            unavoidable: case.rule.future_is_known.then_some(unavoidable),
            arrived: arrival.is_none() && !finish.hung,
            wrong_arrival: matches!(arrival.as_deref(), Some(BESIDE_THE_GOAL | WRONG_PLACE)),
            time_ratio: way_s
                .filter(|way_s| success && *way_s > 0.0)
                .map(|way_s| run.time_s / way_s),
            time_s: Some(run.time_s),
            clock_s,
            score: by_rule(RULES[0]),
            score_4ot: by_rule(RULES[1]),
            path_ratio: case
                .rule
                .reference_m
                .filter(|_| success)
                .map(|reference_m| run.driven_m / reference_m),
            clearance_m_min: run.clearance_m_min,
            turning_rad: Some(turning_rad(&run.track_m)),
            jerk_mps3: run.jerk_mps3,
            interventions: Some(run.interventions as u64),
            recoveries: Some(run.recoveries.into()),
            stuck_cause: run.stuck_cause.clone(),
            driven_m: Some(run.driven_m),
            goal_distance_m,
            wall_s: Some(run.wall_s),
            pose_error_m: run.pose.as_ref().map(|pose| pose.error_m_last),
            pose_error_rad: run.pose.as_ref().map(|pose| pose.error_rad_last),
            run_hash: run.run_hash.clone(),
            not_reproducible: match run.reproducible {
                Some(_) if finish.hung => Some(by_the_suite(case)),
                Some(false) => Some(run.not_reproducible.join("; ")),
                _ => None,
            },
            directory: Some(format!("{RUNS}/{}", case.name())),
            contacts,
            ..Self::of(case)
        }
    }

    /// A run that left no result has failed like any other.
    fn without_result(case: &Case, finish: &Finish) -> Self {
        let nothing = case.rule.optimal_time_s.map(|_| 0.0);
        let cause = if finish.hung {
            case.hung()
        } else {
            match finish.code {
                Some(code) => format!("no result, exit code {code}: {}", finish.headline()),
                None => "no result, ended by a signal".to_owned(),
            }
        };
        let refused = finish.code == Some(i32::from(EXIT_USAGE));
        Self {
            refusal: refused.then(|| format!("{}: {}", case.world, finish.complaint)),
            cause: Some(cause),
            not_reproducible: (finish.hung && !case.manner.real_time).then(|| by_the_suite(case)),
            score: nothing,
            score_4ot: nothing,
            ..Self::of(case)
        }
    }

    /// The row of a case of which nothing is known yet.
    pub(super) fn of(case: &Case) -> Self {
        Self {
            world: case.world.clone(),
            class: case.class.clone(),
            seed: case.seed,
            success: false,
            cause: None,
            outcome: None,
            contacts_moving: 0,
            contacts_standing: 0,
            unavoidable: None,
            arrived: false,
            time_s: None,
            clock_s: None,
            way_exists: case.rule.way.exists(),
            wrong_arrival: false,
            time_ratio: None,
            score: None,
            score_4ot: None,
            path_ratio: None,
            clearance_m_min: None,
            turning_rad: None,
            jerk_mps3: None,
            interventions: None,
            recoveries: None,
            stuck_cause: None,
            driven_m: None,
            goal_distance_m: None,
            wall_s: None,
            pose_error_m: None,
            pose_error_rad: None,
            run_hash: None,
            not_reproducible: None,
            directory: None,
            refusal: None,
            contacts: Vec::new(),
            soaked: None,
        }
    }

    /// True when it touched something while it moved, and an oracle would not have.
    #[must_use]
    pub fn is_at_fault(&self) -> bool {
        self.contacts_moving > self.unavoidable.unwrap_or(0)
    }

    /// True when the time was over.
    #[must_use]
    pub fn is_timeout(&self) -> bool {
        self.outcome.as_deref() == Some("timeout")
    }
}

/// What a run touched and what could have been done about it.
fn contacts(case: &Case, run: &RunResult) -> Vec<ContactRow> {
    if run.touches.is_empty() {
        return Vec::new();
    }
    let known = case.rule.future_is_known;
    let hindsight = known.then(|| Hindsight::of(&case.scenario)).flatten();
    let row = |touch: &Touch| {
        let avoidable = hindsight.as_ref();
        let avoidable = avoidable.map(|hindsight| hindsight.avoidable_s(touch, run));
        ContactRow {
            world: case.world.clone(),
            seed: case.seed,
            time_s: touch.time_s,
            with: touch.with.clone(),
            moving: touch.moving,
            v_mps: touch.v_mps,
            avoidable_s: avoidable.flatten(),
            unavoidable: avoidable == Some(None),
        }
    };
    run.touches.iter().map(row).collect()
}

/// Why a run is no success for what it touched.
fn touched(success: &Success, run: &RunResult, unavoidable: u32) -> Option<String> {
    let standing_counts = match success {
        Success::Arrival {
            standing_counts, ..
        } => *standing_counts,
        Success::Found { .. } => true,
        Success::Expectations => {
            let n_contacts = run.contacts_moving + run.contacts_standing;
            return (run.verdict != "pass" && n_contacts > 0).then(|| "contact".to_owned());
        }
    };
    // Where contacts with a stopped robot are forgiven, so are those that were unavoidable.
    let forgiven = if standing_counts { 0 } else { unavoidable };
    let cause = if run.contacts_moving > forgiven {
        "contact while moving"
    } else if standing_counts && run.contacts_standing > 0 {
        "contact while standing"
    } else {
        return None;
    };
    Some(cause.to_owned())
}

/// Why a run did not end as it should, whatever it touched.
fn missed(success: &Success, run: &RunResult, goal_distance_m: Option<f64>) -> Option<String> {
    let (is_there, otherwise) = match success {
        Success::Expectations => return (run.verdict != "pass").then(|| run.outcome.clone()),
        Success::Arrival { tolerance_m, .. } => (
            goal_distance_m.is_some_and(|distance_m| distance_m <= *tolerance_m),
            BESIDE_THE_GOAL,
        ),
        Success::Found { off_m, off_rad } => (
            (run.pose.as_ref())
                .is_some_and(|pose| pose.error_m_last <= *off_m && pose.error_rad_last <= *off_rad),
            WRONG_PLACE,
        ),
    };
    match (run.reached, is_there) {
        (false, _) => Some(run.outcome.clone()),
        (true, false) => Some(otherwise.to_owned()),
        (true, true) => None,
    }
}

/// Why a run that the suite has ended goes otherwise the next time.
fn by_the_suite(case: &Case) -> String {
    format!("ended by the suite ({})", case.hung())
}

#[cfg(test)]
mod tests {
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
        let text = include_str!("../../measure/tests/data/result_lockstep.json");
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
        let finish = Finish {
            result: Some(run(changes)),
            code: Some(0),
            hung: false,
            complaint: String::new(),
            domain: None,
        };
        Row::new(&case(standing_counts), &finish)
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
}
