//! What came of one drive of a soak.

mod excuse;
pub(super) mod verdict;

use super::case::Case;
use super::hindsight::{ContactRow, Hindsight};
use excuse::excuse;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use zeronav_measure::result::RunResult;

/// What the nearest thing is called at a contact with what stands.
const STANDING: &str = "world";

/// For how long after a fault the end of its process is a consequence of it: a hang is noticed late on
/// a busy machine. [s]
const CONSEQUENCE_S: f64 = 10.0;

/// A restart is noted at the tick of launch's look, which may be just before that of the fault. [s]
const EARLY_S: f64 = 0.1;

/// What came of one drive of a soak.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Soaked {
    /// Its world, by which it is found among the runs.
    pub world: String,
    /// Seed of its place, its faults and its run.
    pub seed: u64,
    /// `lockstep` or `real_time`.
    pub mode: String,
    /// True when it reached all of its goals.
    pub arrived: bool,
    /// How it ended, see `outcome` in a run's result; null without a result.
    pub outcome: Option<String>,
    /// Contacts of its own fault.
    pub contacts_own_fault: u64,
    /// Contacts that an oracle could have avoided and that nothing the stack did brought about, one line
    /// each that says why.
    #[serde(default)]
    pub excused: Vec<String>,
    /// Faults that were made, by kind.
    pub kinds: BTreeMap<String, u64>,
    /// The same by what broke: a seat or a topic.
    pub targets: BTreeMap<String, u64>,
    /// Faults that could not be made, such as those of a seat that was empty.
    pub not_made: u64,
    /// Restarts by seat.
    pub restarts: BTreeMap<String, u64>,
    /// Restarts that no fault explains, one line each.
    pub unasked: Vec<String>,
    /// Swaps by how they ended.
    pub swaps: BTreeMap<String, u64>,
    /// What it has left over, one line each.
    pub left: Vec<String>,
    /// The same drive without faults, where this one did not reach its goals: true when it does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arrives_without_faults: Option<bool>,
}

impl Soaked {
    /// What a case came to: its row, its run if it has a result, and what was left over.
    pub(crate) fn of(
        case: &Case,
        (arrived, contacts): (bool, &[ContactRow]),
        run: Option<&RunResult>,
        left: Vec<String>,
    ) -> Self {
        let mut own: Vec<usize> = (0..contacts.len())
            .filter(|at| is_own_fault(&contacts[*at]))
            .collect();
        let mut excused = Vec::new();
        if let Some(run) = run.filter(|_| case.rule.future_is_known && !own.is_empty())
            && let Some(hindsight) = Hindsight::of(&case.scenario)
        {
            own.retain(|at| {
                let touch = run.touches.get(*at);
                let why = touch.and_then(|touch| excuse(&hindsight, run, touch));
                excused.extend(why.clone());
                why.is_none()
            });
        }
        let mut soaked = Self {
            world: case.world.clone(),
            seed: case.seed,
            mode: case.class.clone().unwrap_or_default(),
            arrived,
            outcome: run.map(|run| run.outcome.clone()),
            contacts_own_fault: own.len() as u64,
            excused,
            left,
            ..Self::default()
        };
        let Some(run) = run else {
            return soaked;
        };
        let count = |counts: &mut BTreeMap<String, u64>, what: &String| {
            *counts.entry(what.clone()).or_default() += 1;
        };
        for fault in &run.faults {
            if fault.why.is_some() {
                soaked.not_made += 1;
                continue;
            }
            count(&mut soaked.kinds, &fault.kind);
            count(&mut soaked.targets, &fault.target);
        }
        for restart in &run.restarts {
            count(&mut soaked.restarts, &restart.service);
        }
        for swap in &run.swaps {
            count(&mut soaked.swaps, &swap.state);
        }
        soaked.unasked = unasked(run);
        soaked
    }

    /// True when the same drive without faults has something to say.
    pub(crate) fn is_in_doubt(&self) -> bool {
        !self.arrived || self.contacts_own_fault > 0
    }

    /// True when it did not reach its goals and it is not known that it would not have without faults
    /// either.
    pub(crate) fn is_lost(&self) -> bool {
        !self.arrived && self.arrives_without_faults != Some(false)
    }

    /// Why it is no success beside what is said of any run.
    pub(crate) fn cause(&self) -> Option<&'static str> {
        if self.contacts_own_fault > 0 {
            Some("contact by own fault")
        } else if self.left.is_empty() {
            None
        } else {
            Some("left over")
        }
    }
}

/// True when the robot drove into something: what stands does not come, and what moves had been avoided
/// by an oracle. Who stands is run into.
fn is_own_fault(contact: &ContactRow) -> bool {
    contact.with == STANDING || (contact.moving && !contact.unavoidable)
}

/// The restarts of seats in which nothing was killed or stopped just before. Each kill or stop explains
/// one.
fn unasked(run: &RunResult) -> Vec<String> {
    let deadly = |kind: &str| ["kill", "stop"].contains(&kind);
    let mut struck: Vec<(&str, f64)> = (run.faults.iter())
        .filter(|fault| fault.why.is_none() && deadly(&fault.kind))
        .map(|fault| (fault.target.as_str(), fault.time_s))
        .collect();
    let mut unasked = Vec::new();
    for restart in &run.restarts {
        let explains = |(seat, time_s): &(&str, f64)| {
            let span_s = time_s - EARLY_S..time_s + CONSEQUENCE_S;
            *seat == restart.service && span_s.contains(&restart.time_s)
        };
        if let Some(at) = struck.iter().position(explains) {
            struck.remove(at);
        } else {
            let (seat, time_s, how) = (&restart.service, restart.time_s, &restart.how);
            unasked.push(format!("{seat} at {time_s:.2} s: {how}"));
        }
    }
    unasked
}

#[cfg(test)]
mod tests {
    use super::super::case::{Manner, Rule, Success};
    use super::*;
    use serde_json::{Value, json};
    use std::path::PathBuf;
    use zeronav_msgs::topics::{RobotScan, Topic};

    fn case() -> Case {
        Case {
            world: "soak_0004".to_owned(),
            class: Some("lockstep".to_owned()),
            seed: 5,
            scenario: PathBuf::from("soak_0004.toml"),
            time_limit_s: 100.0,
            rule: Rule {
                success: Success::Expectations,
                optimal_time_s: None,
                reference_m: None,
                future_is_known: true,
                way: crate::turns::OutlineWay::NotSearched,
            },
            manner: Manner::default(),
        }
    }

    /// A real result with these faults and restarts.
    fn run(faults: &Value, restarts: &Value) -> RunResult {
        let text = include_str!("../../measure/tests/data/result_lockstep.json");
        let mut result: Value = serde_json::from_str(text).unwrap();
        result["faults"] = faults.clone();
        result["restarts"] = restarts.clone();
        serde_json::from_value(result).unwrap()
    }

    fn contact(with: &str, moving: bool, unavoidable: bool) -> ContactRow {
        ContactRow {
            world: "soak_0004".to_owned(),
            seed: 5,
            time_s: 3.0,
            with: with.to_owned(),
            moving,
            v_mps: 0.0,
            avoidable_s: None,
            unavoidable,
        }
    }

    #[test]
    fn a_contact_is_own_fault_unless_something_came() {
        let own = |contact| Soaked::of(&case(), (true, &[contact]), None, Vec::new());
        for (with, moving, unavoidable, counts) in [
            ("cylinder 1", true, false, 1),
            ("cylinder 1", true, true, 0),
            ("cylinder 1", false, false, 0),
            ("world", true, false, 1),
            // Turning into a wall at no forward speed is nobody else's fault.
            ("world", false, false, 1),
        ] {
            let soaked = own(contact(with, moving, unavoidable));
            assert_eq!(soaked.contacts_own_fault, counts, "{with} {moving}");
            assert_eq!(soaked.cause().is_some(), counts > 0);
            assert_eq!(soaked.is_in_doubt(), counts > 0);
        }
    }

    #[test]
    fn what_is_left_over_counts() {
        let left = vec!["/dev/shm/zn_0123456789_a.data".to_owned()];
        let soaked = Soaked::of(&case(), (true, &[]), None, left.clone());
        assert_eq!((soaked.cause(), &soaked.left), (Some("left over"), &left));
    }

    #[test]
    fn faults_and_restarts_are_counted_by_kind_and_seat() {
        let fault = |kind: &str, target: &str, time_s: f64, why: Value| {
            json!({"id": 1, "kind": kind, "target": target, "tick": 0, "time_s": time_s,
                   "until_s": null, "recovery_ms": null, "why": why})
        };
        let restart = |service: &str, time_s: f64| json!({"service": service, "time_s": time_s, "how": "killed", "wait_ms": 0});
        let faults = json!([
            fault("kill", "mapping", 3.0, Value::Null),
            fault("stop", "mapping", 5.0, Value::Null),
            fault("drop", RobotScan::ROW.name, 5.0, Value::Null),
            fault("kill", "collision_guard", 6.0, json!("no process")),
        ]);
        let restarts = json!([
            restart("mapping", 3.0),
            restart("mapping", 5.5),
            restart("mapping", 5.6),
            restart("local_planner", 8.0),
        ]);
        let run = run(&faults, &restarts);
        let soaked = Soaked::of(&case(), (false, &[]), Some(&run), Vec::new());
        let counts = |pairs: &[(&str, u64)]| -> BTreeMap<String, u64> {
            let pairs = pairs.iter();
            pairs.map(|(name, n)| ((*name).to_owned(), *n)).collect()
        };
        assert_eq!(
            soaked.kinds,
            counts(&[("kill", 1), ("stop", 1), ("drop", 1)])
        );
        let targets = counts(&[("mapping", 2), (RobotScan::ROW.name, 1)]);
        assert_eq!((&soaked.targets, soaked.not_made), (&targets, 1));
        let by_seat = counts(&[("mapping", 3), ("local_planner", 1)]);
        assert_eq!(soaked.restarts, by_seat);
        let unasked = [
            "mapping at 5.60 s: killed",
            "local_planner at 8.00 s: killed",
        ];
        assert_eq!(soaked.unasked, unasked);
        // It is lost unless it is lost without faults, too.
        let lost = |arrives_without_faults| {
            let soaked = soaked.clone();
            Soaked {
                arrives_without_faults,
                ..soaked
            }
            .is_lost()
        };
        assert_eq!(
            [None, Some(true), Some(false)].map(lost),
            [true, true, false]
        );
    }
}
