//! What could have been done about the contacts of a run whose obstacles all had a known future.

use super::future::{Future, Mover};
use super::oracle::robot::State;
use super::oracle::{Surroundings, is_unavoidable};
use crate::result::Touch;
use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Times before a contact from which the oracle tries, shortest first. [s] A contact that not even
/// the last avoids is unavoidable. Nothing is known of a pedestrian who has not appeared yet: with whom a
/// recording begins in front of the robot, the oracle tries from that moment on.
const LEADS_S: [f64; 4] = [0.5, 1.0, 2.0, 3.0];

/// A contact in the report of a suite.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ContactRow {
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

    /// The shortest of [`LEADS_S`] from which the contact could still have been avoided, at most
    /// the time since what was touched appeared. `motion` has rows of time, x, y, yaw, speed and
    /// yaw rate, as a run's result has them.
    pub(super) fn avoidable_s(&self, contact: &Touch, motion: &[[f64; 6]]) -> Option<f64> {
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
        // Who is there from the start was there before.
        let is_late = |mover: &&Mover| mover.name == contact.with && mover.appears_s > 0.0;
        let late = movers.iter().find(is_late);
        let age_s = late.map_or(f64::INFINITY, |mover| contact.time_s - mover.appears_s);
        let known_s = LEADS_S.map(|lead_s| lead_s.min(age_s.max(0.0)));
        known_s.into_iter().find(|lead_s| {
            let until_s = contact.time_s - lead_s;
            let before = motion.partition_point(|row| row[0] <= until_s);
            let Some(row) = motion.get(before.saturating_sub(1)) else {
                return true;
            };
            let [t_s, x, y, yaw_rad, v_mps, w_radps] = *row;
            let state = State {
                t_s,
                at_m: [x, y],
                yaw_rad,
                v_mps,
                w_radps,
            };
            !is_unavoidable(&state, contact.time_s, abilities, &around)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::future::walker;
    use super::*;

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
        assert_eq!(hindsight.avoidable_s(&touch("walker"), &motion), None);
        // Who had been there all the time could have been seen.
        let other = hindsight.avoidable_s(&touch("another"), &motion);
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
            hindsight.avoidable_s(&touch, &(0..=40).map(row).collect::<Vec<_>>())
        };
        // At a crawl it can stop in time; at 1 m/s half a second is not enough, a second is.
        assert_eq!(avoidable_s(0.54, 0.1), Some(0.5));
        assert_eq!(avoidable_s(0.1, 1.0), Some(1.0));
        // Without a motion nothing is proved.
        assert_eq!(hindsight.avoidable_s(&touch, &[]), Some(LEADS_S[0]));
    }
}
