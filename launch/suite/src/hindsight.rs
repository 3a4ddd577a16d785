//! What could have been done about the contacts of a run whose obstacles all had a known future.

use super::future::{Future, Mover};
use super::oracle::robot::State;
use super::oracle::{Surroundings, is_unavoidable};
use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use std::path::Path;
use zeronav_measure::result::{RunResult, Touch};

/// Times before a contact from which the oracle tries, shortest first. [s] A contact that not even
/// the last avoids is unavoidable. Nothing is known of a pedestrian who has not appeared yet: with whom a
/// recording begins in front of the robot, the oracle tries from that moment on.
const LEADS_S: [f64; 4] = [0.5, 1.0, 2.0, 3.0];

/// A contact in the report of a suite.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ContactRow {
    /// World of the run.
    pub world: String,
    /// Its seed.
    pub seed: u64,
    /// Time since the goal was given. [s]
    pub time_s: f64,
    /// What was touched.
    pub with: String,
    /// True when the robot moved.
    pub moving: bool,
    /// Its forward speed just before. [m/s]
    pub v_mps: f64,
    /// How long before an oracle that knows every future could still avoid it, the shortest of
    /// 0.5, 1, 2 and 3 s, or the time since what was touched appeared; null when not even then. [s]
    pub avoidable_s: Option<f64>,
    /// True when not even then.
    pub unavoidable: bool,
}

/// A world whose future is known, looked at after a run.
pub(super) struct Hindsight {
    future: Future,
}

impl Hindsight {
    /// The world of a scenario; `None` when something in it has an unknown future.
    pub(super) fn of(file: &Path) -> Option<Self> {
        let future = Future::of(file).ok()?;
        Some(Self { future })
    }

    /// The world and the robot.
    pub(super) const fn future(&self) -> &Future {
        &self.future
    }

    /// The shortest of [`LEADS_S`] from which the contact could still have been avoided, at most
    /// the time since what was touched appeared.
    pub(super) fn avoidable_s(&self, contact: &Touch, run: &RunResult) -> Option<f64> {
        // Who is there from the start was there before.
        let is_late = |mover: &&Mover| mover.name == contact.with && mover.appears_s > 0.0;
        let late = self.future.movers.iter().find(is_late);
        let contact_s = contact.time_s + run.first_goal_s;
        let age_s = late.map_or(f64::INFINITY, |mover| contact_s - mover.appears_s);
        let known_s = LEADS_S.map(|lead_s| lead_s.min(age_s.max(0.0)));
        known_s.into_iter().find(|lead_s| {
            state_at(run, contact_s - lead_s)
                .is_none_or(|state| self.is_avoidable(&state, contact_s))
        })
    }

    /// Whether the robot could have avoided the contact at a run time [s] from a state on.
    pub(super) fn is_avoidable(&self, state: &State, contact_s: f64) -> bool {
        let Future {
            world,
            movers,
            abilities,
            ..
        } = &self.future;
        let discs_at = |t_s: f64| movers.iter().filter_map(|mover| mover.at(t_s)).collect();
        let fixed_m = |[x, y]: [f64; 2]| world.point_distance_m(Point2::new(x, y));
        let around = Surroundings {
            discs_at: &discs_at,
            fixed_m: &fixed_m,
        };
        !is_unavoidable(state, contact_s, abilities, &around)
    }
}

/// The newest state of a run up to a run time, `None` before its first goal. [s] The rows of a result's
/// motion count from that goal, the tracks of obstacles from the beginning of the run.
pub(super) fn state_at(run: &RunResult, run_s: f64) -> Option<State> {
    let until_s = run_s - run.first_goal_s;
    let before = run.motion.partition_point(|row| row[0] <= until_s);
    let [t_s, x, y, yaw_rad, v_mps, w_radps] = *run.motion.get(before.checked_sub(1)?)?;
    Some(State {
        t_s: t_s + run.first_goal_s,
        at_m: [x, y],
        yaw_rad,
        v_mps,
        w_radps,
    })
}

#[cfg(test)]
mod tests {
    use super::super::future::walker;
    use super::*;

    /// A real result with this motion, whose first goal came at a run time. [s]
    fn run(motion: Vec<[f64; 6]>, first_goal_s: f64) -> RunResult {
        let text = include_str!("../../measure/tests/data/result_lockstep.json");
        let result: RunResult = serde_json::from_str(text).unwrap();
        RunResult {
            first_goal_s,
            motion,
            ..result
        }
    }

    fn hindsight() -> Hindsight {
        let folder = walker("");
        Hindsight::of(&folder.path().join("it.toml")).unwrap()
    }

    #[test]
    fn nobody_knows_of_somebody_who_is_not_there_yet() {
        // He appears at 2 s at (5, 0), walking towards a robot that drives at 1 m/s.
        let hindsight = hindsight();
        let motion: Vec<[f64; 6]> = (0..=30)
            .map(|tenth| 0.1 * f64::from(tenth))
            .map(|t| {
                [
                    t,
                    5.0,
                    0.6 - (t - 2.0),
                    -core::f64::consts::FRAC_PI_2,
                    1.0,
                    0.0,
                ]
            })
            .collect();
        let touch = |with: &str| Touch {
            time_s: 2.06,
            moving: true,
            v_mps: 1.0,
            with: with.to_owned(),
            pose: [0.0; 3],
        };
        let run = run(motion, 0.0);
        assert_eq!(hindsight.avoidable_s(&touch("walker"), &run), None);
        // Who had been there all the time could have been seen.
        let other = hindsight.avoidable_s(&touch("another"), &run);
        assert!(other.is_some(), "{other:?}");
    }

    #[test]
    fn how_long_before_a_contact_could_be_avoided_depends_on_the_speed() {
        let hindsight = hindsight();
        // The walker is at (5, 2) at 4 s; the robot would be `x` west of him then, at `v`.
        let touch = Touch {
            time_s: 4.0,
            moving: true,
            v_mps: 1.0,
            with: "walker".to_owned(),
            pose: [0.0; 3],
        };
        let avoidable_s = |x: f64, v: f64| {
            let row = |tenth: u32| {
                let t = 0.1 * f64::from(tenth);
                [t, 5.0 - x - v * (4.0 - t), 2.0, 0.0, v, 0.0]
            };
            hindsight.avoidable_s(&touch, &run((0..=40).map(row).collect(), 0.0))
        };
        // At a crawl it can stop in time; at 1 m/s half a second is not enough, a second is.
        assert_eq!(avoidable_s(0.54, 0.1), Some(0.5));
        assert_eq!(avoidable_s(0.1, 1.0), Some(1.0));
        // Without a motion nothing is proved.
        assert_eq!(
            hindsight.avoidable_s(&touch, &run(Vec::new(), 0.0)),
            Some(LEADS_S[0])
        );
    }

    #[test]
    fn who_moves_is_where_it_is_by_the_run_and_not_by_the_goal() {
        let hindsight = hindsight();
        // The goal came at 1.5 s; 2.5 s later the walker is at (5, 2), and the robot just west of him.
        let touch = Touch {
            time_s: 2.5,
            moving: true,
            v_mps: 1.0,
            with: "walker".to_owned(),
            pose: [0.0; 3],
        };
        let row = |tenth: u32| {
            let t = 0.1 * f64::from(tenth);
            [t, 4.9 - (2.5 - t), 2.0, 0.0, 1.0, 0.0]
        };
        let motion: Vec<[f64; 6]> = (0..=25).map(row).collect();
        let late = hindsight.avoidable_s(&touch, &run(motion.clone(), 1.5));
        assert_eq!(late, Some(1.0), "half a second before he cannot be missed");
        // 1.5 s before he is elsewhere.
        let wrong = hindsight.avoidable_s(&touch, &run(motion, 0.0));
        assert_eq!(wrong, Some(0.5));
    }
}
