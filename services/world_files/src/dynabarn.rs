//! Worlds of `DynaBARN`, cylinders that go round in an arena whatever the robot does (Nair et al.,
//! "`DynaBARN`: Benchmarking Metric Ground Navigation in Dynamic Environments", SSRR 2022), as CSV
//! files `obstacle,plugin,period_s,t_s,x_m,y_m` with one key frame a line.
//!
//! Between key frames obstacles go straight (the benchmark's simulator lays a spline through
//! them). At the end of its period an obstacle is back at its first key frame at once, as in the
//! benchmark; both lie on the edge of the arena.
//!
//! ```no_run
//! # fn main() -> Result<(), zeronav_world_files::DataError> {
//! use zeronav_world_files::{dynabarn, dynabarn::DynabarnWorld};
//! let world = DynabarnWorld::load("world_05.csv".as_ref())?;
//! let phase_s = 12.5;
//! let (spec, start, goal) = (world.spec(phase_s), dynabarn::START, dynabarn::GOAL);
//! # Ok(())
//! # }
//! ```

use crate::table::{DataError, Table};
use core::f64::consts::PI;
use std::path::Path;
use zeronav_msgs::Pose;
use zeronav_msgs::truth::TRUTH_OBSTACLES_MAX;
use zeronav_world::error::SpecError;
use zeronav_world::spec::{ObstacleSpec, ShapeSpec, WorldSpec};
use zeronav_world::track::Track;

/// Where the challenge puts the robot, `map_from_base`.
pub const START: Pose = Pose::new(11.0, 0.0, PI);

/// Where it sends it; any yaw will do.
pub const GOAL: Pose = Pose::new(-9.0, 0.0, PI);

/// How near counts as there. [m]
pub const GOAL_TOLERANCE_M: f64 = 1.0;

/// Run time that the challenge allows. [s]
pub const TIME_LIMIT_S: f64 = 100.0;

/// Radius of every obstacle. [m]
pub const RADIUS_M: f64 = 0.5;

/// The arena and the open side with the start. [m]
const AREA_M: [[f64; 2]; 2] = [[-11.0, -11.0], [13.0, 11.0]];

/// Centre and size of its three walls; the side x = 10 is open. [m]
const WALLS_M: [([f64; 2], [f64; 2]); 3] = [
    ([-10.0, 0.0], [0.5, 20.0]),
    ([0.0, 10.0], [20.0, 0.5]),
    ([0.0, -10.0], [20.0, 0.5]),
];

/// A world.
#[derive(Debug, Clone, PartialEq)]
pub struct DynabarnWorld {
    /// The round of every obstacle: rows `[t, x, y]` that begin at t = 0 and end with its period.
    /// [s, m, m]
    pub rounds: Vec<Vec<[f64; 3]>>,
}

impl DynabarnWorld {
    /// Reads a world.
    ///
    /// # Errors
    /// See [`DataError`].
    pub fn load(file: &Path) -> Result<Self, DataError> {
        let table = Table::read(file, "obstacle,plugin,period_s,t_s,x_m,y_m")?;
        let mut rounds: Vec<Vec<[f64; 3]>> = Vec::new();
        let mut last_obstacle = None;
        for row in table.rows() {
            let obstacle = row.number(0, 0.0, 1.0e6)?;
            if last_obstacle != Some(obstacle) {
                if rounds.len() == TRUTH_OBSTACLES_MAX {
                    let why = format!("more than {TRUTH_OBSTACLES_MAX} obstacles");
                    return Err(row.refused(why));
                }
                last_obstacle = Some(obstacle);
                rounds.push(Vec::new());
            }
            let period_s = row.number(2, 1.0e-3, 1.0e6)?;
            let key_frame = [
                row.number(3, 0.0, period_s)?,
                row.number(4, -1.0e3, 1.0e3)?,
                row.number(5, -1.0e3, 1.0e3)?,
            ];
            if let Some(round) = rounds.last_mut() {
                round.push(key_frame);
            }
        }
        for (index, round) in rounds.iter().enumerate() {
            Track::check(round)
                .map_err(|error: SpecError| table.refused(format!("obstacle {index}: {error}")))?;
        }
        Ok(Self { rounds })
    }

    /// The walls.
    #[must_use]
    pub fn shapes(&self) -> Vec<ShapeSpec> {
        let wall = |(centre_m, size_m)| ShapeSpec::Box {
            centre_m,
            size_m,
            yaw_rad: 0.0,
        };
        WALLS_M.into_iter().map(wall).collect()
    }

    /// The obstacles of a run that begins `phase_s` after the beginning of all rounds.
    #[must_use]
    pub fn obstacles(&self, phase_s: f64) -> Vec<ObstacleSpec> {
        let obstacle = |(index, round): (usize, &Vec<[f64; 3]>)| {
            let track = Track::new(round, true, phase_s);
            let at = track.at(0.0);
            let disc = ShapeSpec::Disc {
                centre_m: [at.x, at.y],
                radius_m: RADIUS_M,
            };
            ObstacleSpec {
                track: round.clone(),
                track_from_s: phase_s,
                repeat: true,
                ..ObstacleSpec::standing(format!("cylinder {index}"), disc)
            }
        };
        self.rounds.iter().enumerate().map(obstacle).collect()
    }

    /// The world for a scenario that begins `phase_s` after the beginning of all rounds.
    #[must_use]
    pub fn spec(&self, phase_s: f64) -> WorldSpec {
        WorldSpec {
            shapes: self.shapes(),
            obstacles: self.obstacles(phase_s),
            ..WorldSpec::area(AREA_M[0], AREA_M[1])
        }
    }
}
