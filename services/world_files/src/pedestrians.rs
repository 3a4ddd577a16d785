//! Recorded people, as CSV files `t_s,id,x_m,y_m` that are sorted by time and person (the scenes
//! of Pellegrini et al., "You'll Never Walk Alone", ICCV 2009, and of Lerner et al., "Crowds by
//! Example", 2007).
//!
//! People are discs that walk straight from sample to sample, exist only between their first and
//! their last, and do not see the robot.
//!
//! ```no_run
//! # fn main() -> Result<(), zeronav_world_files::DataError> {
//! use zeronav_world_files::pedestrians::{Playback, Scene};
//! let scene = Scene::load("zara01.csv".as_ref())?;
//! let playback = Playback { from_s: 60.0, duration_s: Some(90.0), radius_m: 0.3 };
//! let (spec, (lower, upper)) = (scene.spec(&playback), scene.bounds());
//! # Ok(())
//! # }
//! ```

use crate::table::{DataError, Table};
use nalgebra::Point2;
use std::collections::BTreeMap;
use std::path::Path;
use zeronav_casts::Cast;
use zeronav_world::spec::{ObstacleSpec, ShapeSpec, Trigger, WorldSpec};
use zeronav_world::track::Track;

/// Most people of a recording.
const WALKERS_MAX: usize = 65_536;

/// Room around the people's tracks that the area of a scene has. [m]
const MARGIN_M: f64 = 2.0;

/// Shortest stay that is played. [s]
const STAY_S_MIN: f64 = 0.01;

/// A recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Every person's samples `[t, x, y]`, by id. [s, m, m]
    pub walkers: BTreeMap<u64, Vec<[f64; 3]>>,
}

/// Which part of a recording is played, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Playback {
    /// Moment of the recording at which the run begins. [s]
    pub from_s: f64,
    /// How much of it is played; `None` = all that is left. [s]
    pub duration_s: Option<f64>,
    /// Radius of a person. [m]
    pub radius_m: f64,
}

impl Scene {
    /// Reads a recording.
    ///
    /// # Errors
    /// See [`DataError`].
    pub fn load(file: &Path) -> Result<Self, DataError> {
        let table = Table::read(file, "t_s,id,x_m,y_m")?;
        let mut walkers: BTreeMap<u64, Vec<[f64; 3]>> = BTreeMap::new();
        for row in table.rows() {
            let id = row.number(1, 0.0, 1.0e15)?;
            let id = if id.fract() == 0.0 {
                id.to_u64()
            } else {
                return Err(row.refused("the id must be a whole number"));
            };
            if walkers.len() == WALKERS_MAX && !walkers.contains_key(&id) {
                return Err(row.refused(format!("more than {WALKERS_MAX} people")));
            }
            walkers.entry(id).or_default().push([
                row.number(0, 0.0, 1.0e6)?,
                row.number(2, -1.0e5, 1.0e5)?,
                row.number(3, -1.0e5, 1.0e5)?,
            ]);
        }
        // A glimpse is no walk.
        walkers.retain(|_, samples| samples.len() > 1);
        for (id, samples) in &walkers {
            Track::check(samples)
                .map_err(|error| table.refused(format!("person {id}: {error}")))?;
        }
        if walkers.is_empty() {
            return Err(table.refused("nobody walks in it"));
        }
        Ok(Self { walkers })
    }

    /// Lower left and upper right corner of everywhere that anybody was. [m]
    #[must_use]
    pub fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        let (mut lower, mut upper) = (Point2::from([f64::MAX; 2]), Point2::from([f64::MIN; 2]));
        for [_, x, y] in self.walkers.values().flatten() {
            lower = Point2::new(lower.x.min(*x), lower.y.min(*y));
            upper = Point2::new(upper.x.max(*x), upper.y.max(*y));
        }
        (lower, upper)
    }

    /// First and last moment of the recording. [s]
    #[must_use]
    pub fn span_s(&self) -> (f64, f64) {
        let times = || self.walkers.values().flatten().map(|sample| sample[0]);
        (
            times().fold(f64::INFINITY, f64::min),
            times().fold(f64::NEG_INFINITY, f64::max),
        )
    }

    /// The people of `playback` as obstacles, by id.
    #[must_use]
    pub fn obstacles(&self, playback: &Playback) -> Vec<ObstacleSpec> {
        let from_s = playback.from_s;
        let until_s = playback
            .duration_s
            .map_or(f64::INFINITY, |duration_s| from_s + duration_s);
        let walker = |(id, samples): (&u64, &Vec<[f64; 3]>)| {
            let (first, last) = (samples.first()?, samples.last()?);
            let (came_s, left_s) = (first[0].max(from_s), last[0].min(until_s));
            if left_s - came_s < STAY_S_MIN {
                return None;
            }
            let at = Track::new(samples, false, came_s).at(0.0);
            let disc = ShapeSpec::Disc {
                centre_m: [at.x, at.y],
                radius_m: playback.radius_m,
            };
            Some(ObstacleSpec {
                appears: (came_s > from_s).then_some(Trigger {
                    at_s: Some(came_s - from_s),
                    robot_near: None,
                }),
                lasts_s: Some(left_s - came_s),
                track: samples.clone(),
                track_from_s: came_s,
                ..ObstacleSpec::standing(format!("person {id}"), disc)
            })
        };
        self.walkers.iter().filter_map(walker).collect()
    }

    /// Corners of the area for a scenario: the tracks and 2 m around them. [m]
    #[must_use]
    pub fn area_m(&self) -> [[f64; 2]; 2] {
        let (lower, upper) = self.bounds();
        [
            [lower.x - MARGIN_M, lower.y - MARGIN_M],
            [upper.x + MARGIN_M, upper.y + MARGIN_M],
        ]
    }

    /// The people of `playback` in an open area, for a scenario.
    #[must_use]
    pub fn spec(&self, playback: &Playback) -> WorldSpec {
        let [lower_m, upper_m] = self.area_m();
        WorldSpec {
            obstacles: self.obstacles(playback),
            ..WorldSpec::area(lower_m, upper_m)
        }
    }
}
