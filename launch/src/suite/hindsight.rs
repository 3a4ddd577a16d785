//! What could have been done about the contacts of a run whose obstacles all had a known future.

use super::oracle::{Abilities, Disc, State, Surroundings, is_unavoidable};
use crate::scenario::Scenario;
use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use std::path::Path;
use zeronav_world::track::Track;
use zeronav_world::{Obstacle, World};

/// Times before a contact from which the oracle tries, shortest first. [s] A contact that not even
/// the last avoids is unavoidable.
const LEADS_S: [f64; 4] = [0.5, 1.0, 2.0, 3.0];

/// A contact as the result of a run has it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Touch {
    pub(super) time_s: f64,
    pub(super) moving: bool,
    pub(super) v_mps: f64,
    pub(super) with: String,
}

/// A contact in the report of a suite.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// 0.5, 1, 2 and 3 s; null when not even then. [s]
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
    /// The world of a scenario; `None` when something in it has a future that nobody knows.
    pub(super) fn of(file: &Path) -> Option<Self> {
        let scenario = Scenario::load(file.to_str()?).ok()?;
        let checked = scenario.validate().ok()?;
        let movers = checked.world.obstacles().iter().map(Mover::new);
        Some(Self {
            movers: movers.collect::<Option<_>>()?,
            abilities: Abilities::new(&scenario.robot, checked.footprint.inscribed_radius_m()),
            world: checked.world,
        })
    }

    /// The shortest of [`LEADS_S`] from which the contact could still have been avoided. `motion`
    /// has rows of time, x, y, yaw, speed and yaw rate, as a run's result has them.
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
        LEADS_S.into_iter().find(|lead_s| {
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
