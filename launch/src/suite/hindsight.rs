//! What could have been done about the contacts of a run whose obstacles all had a known future.

use super::oracle::robot::{Abilities, Disc, State};
use super::oracle::{Surroundings, is_unavoidable};
use crate::result::Touch;
use crate::scenario::Scenario;
use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use std::path::Path;
use zeronav_world::track::Track;
use zeronav_world::{Obstacle, World};

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

/// A world whose future is known, and the robot in it.
pub(super) struct Hindsight {
    world: World,
    movers: Vec<Mover>,
    abilities: Abilities,
}

/// A disc on a track.
struct Mover {
    name: String,
    track: Track,
    radius_m: f64,
    appears_s: f64,
    lasts_s: f64,
}

impl Mover {
    /// `None` when its future depends on the robot, or it is no disc on a track.
    fn new(obstacle: &Obstacle) -> Option<Self> {
        let spec = &obstacle.spec;
        let radius_m = obstacle.shape.form().form().as_ball()?.radius;
        let appears_s = match &spec.appears {
            Some(trigger) => trigger.at_s.filter(|_| trigger.robot_near.is_none())?,
            None => 0.0,
        };
        let is_played = !spec.track.is_empty() && spec.starts.is_none();
        is_played.then(|| Self {
            name: spec.name.clone(),
            track: Track::new(&spec.track, spec.repeat, spec.track_from_s),
            radius_m,
            appears_s,
            lasts_s: spec.lasts_s.unwrap_or(f64::INFINITY),
        })
    }

    fn at(&self, t_s: f64) -> Option<Disc> {
        let since_s = t_s - self.appears_s;
        let at = (0.0..self.lasts_s)
            .contains(&since_s)
            .then(|| self.track.at(since_s))?;
        Some(([at.x, at.y], self.radius_m))
    }
}

impl Hindsight {
    /// The world of a scenario; `None` when something in it has an unknown future.
    pub(super) fn of(file: &Path) -> Option<Self> {
        let scenario = Scenario::load(file.to_str()?).ok()?;
        let checked = scenario.validate().ok()?;
        let movers = checked.world.obstacles().iter().map(Mover::new);
        Some(Self {
            movers: movers.collect::<Option<_>>()?,
            abilities: Abilities::new(&scenario.robot, &checked.footprint),
            world: checked.world,
        })
    }

    /// The shortest of [`LEADS_S`] from which the contact could still have been avoided, at most
    /// the time since what was touched appeared. `motion` has rows of time, x, y, yaw, speed and
    /// yaw rate, as a run's result has them.
    pub(super) fn avoidable_s(&self, contact: &Touch, motion: &[[f64; 6]]) -> Option<f64> {
        let discs_at = |t_s: f64| {
            self.movers
                .iter()
                .filter_map(|mover| mover.at(t_s))
                .collect()
        };
        let fixed_m = |[x, y]: [f64; 2]| self.world.point_distance_m(Point2::new(x, y));
        let around = Surroundings {
            discs_at: &discs_at,
            fixed_m: &fixed_m,
        };
        // Who is there from the start was there before.
        let is_late = |mover: &&Mover| mover.name == contact.with && mover.appears_s > 0.0;
        let late = self.movers.iter().find(is_late);
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
            !is_unavoidable(&state, contact.time_s, &self.abilities, &around)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hall, a robot of 0.25 m that brakes with 1 m/s^2, and a pedestrian who walks past x = 5 from
    /// `y = 0` at 1 m/s, from the second second on.
    fn scenario(more: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let text = format!(
            r#"
            title = "Test"
            start = [1.0, 2.0, 0.0]
            [world]
            area_m = [[0.0, 0.0], [10.0, 5.0]]
            [[world.obstacles]]
            name = "walker"
            shape = {{ kind = "disc", centre_m = [5.0, 0.0], radius_m = 0.3 }}
            appears = {{ at_s = 2.0 }}
            track = [[7.0, 5.0, 0.0], [11.0, 5.0, 4.0]]
            track_from_s = 7.0
            {more}
            [robot]
            radius_m = 0.25
            v_mps_max = 1.0
            w_radps_max = 2.0
            a_mps2_max = 1.0
            alpha_radps2_max = 4.0
            lidar = {{ n_beams = 360, rate_hz = 10.0, range_m_min = 0.1, range_m_max = 12.0 }}
            "#
        );
        std::fs::write(folder.path().join("it.toml"), text).unwrap();
        folder
    }

    fn of(more: &str) -> Option<Hindsight> {
        Hindsight::of(&scenario(more).path().join("it.toml"))
    }

    #[test]
    fn people_are_where_they_were_recorded() {
        let walker = &of("").unwrap().movers[0];
        assert_eq!(walker.at(1.9), None);
        assert_eq!(walker.at(3.5), Some(([5.0, 1.5], 0.3)));
        assert!(of("lasts_s = 1.0").unwrap().movers[0].at(3.1).is_none());
        // Who waits for the robot has no future of its own.
        let near = "starts = { robot_near = { point_m = [1.0, 1.0], distance_m = 1.0 } }";
        assert!(of(near).is_none());
    }

    #[test]
    fn nobody_knows_of_somebody_who_is_not_there_yet() {
        // He appears at 2 s at (5, 0), walking towards a robot that drives at 1 m/s.
        let hindsight = of("").unwrap();
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
        let hindsight = of("").unwrap();
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
