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

/// The same where it was told the truth and did not believe that.
const LOST: &str = "took itself to be lost";

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
    /// True when the robot said that it had arrived and had not; in `kidnapped`, when it took another place for its own.
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
    /// How often the robot no longer knew where it was.
    #[serde(default)]
    pub lost: Option<usize>,
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
            pose_error_rad: run.pose.as_ref().and_then(|pose| pose.error_rad_last),
            lost: run.pose.as_ref().map(|pose| pose.lost),
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
            lost: None,
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
        Success::Found {
            off_m,
            off_rad,
            may_be_lost,
        } => {
            let pose = run.pose.as_ref();
            let is_there = pose.is_some_and(|pose| {
                pose.error_m_last <= *off_m
                    && pose.error_rad_last.is_some_and(|rad| rad <= *off_rad)
            });
            // However it ended: who is wrong and certain has not found himself.
            if !is_there && pose.is_some_and(|pose| pose.known_last == Some(true)) {
                return Some(WRONG_PLACE.to_owned());
            }
            if !may_be_lost && pose.is_some_and(|pose| pose.lost > 0) {
                return Some(LOST.to_owned());
            }
            (is_there, WRONG_PLACE)
        }
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
mod tests;
