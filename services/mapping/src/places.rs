//! Places at which a robot that does not know where it is may be, and the map on which they are looked for.

use crate::beams::{Beam, every_nth, is_near};
use crate::explained::Explained;
use crate::global_search::GlobalSearch;
use crate::mapper::Mapper;
use crate::scan_match::{Match, Surfaces};
use crate::search_map::SearchMap;
use nalgebra::{Matrix3, Point2, Vector3};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::map::{FLAG_STATIC, FLAG_UNKNOWN};
use zeronav_msgs::pose::wrap_angle;

/// Deviations of a place that was searched. [m, rad]
const ROUGH: (f64, f64) = (0.1, 0.05);

/// Places nearer than this are one. [m, rad]
const SAME: (f64, f64) = (0.2, 0.15);

/// A place, and what it has explained so far.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Held {
    /// `map_from_base` when the search began.
    pub(crate) pose: Pose,
    pub(crate) explained: Explained,
}

/// How many of about `n_max` beams ended where beams count.
pub(crate) fn n_hits(beams: &[Beam], n_max: usize, range_m_max: f64) -> f64 {
    let beams = beams.iter().step_by(every_nth(beams, n_max));
    beams
        .filter(|beam| is_near(beam, range_m_max))
        .count()
        .to_f64()
}

/// What a robot has moved between two poses.
pub(crate) fn motion(from: &Pose, to: &Pose) -> Pose {
    Pose::from(from.isometry().inverse() * to.isometry())
}

pub(crate) fn is_same(one: &Pose, other: &Pose) -> bool {
    one.distance_m(other) <= SAME.0 && wrap_angle(one.yaw_rad - other.yaw_rad).abs() <= SAME.1
}

/// Lays ends on the map from a pose that is known roughly.
pub(crate) fn lay(surfaces: &Surfaces, ends: &[Point2<f64>], pose: &Pose) -> Option<Match> {
    let deviations = Vector3::new(ROUGH.0, ROUGH.0, ROUGH.1);
    let covariance = Matrix3::from_diagonal(&deviations.component_mul(&deviations));
    surfaces.lay(ends, pose, &covariance, |_| true)
}

/// The places that a search has found, made exact, each once.
pub(crate) fn exact(search: &GlobalSearch, mapper: &Mapper, ends: &[Point2<f64>]) -> Vec<Held> {
    let mut places: Vec<Held> = Vec::new();
    for place in search.places() {
        let laid = (mapper.surfaces()).and_then(|surfaces| lay(surfaces, ends, &place.pose));
        let pose = laid.map_or(place.pose, |laid| laid.pose);
        if !places.iter().any(|other| is_same(&other.pose, &pose)) {
            places.push(Held {
                pose,
                explained: Explained::default(),
            });
        }
    }
    places
}

/// What is searched: the static map, and where it leaves room.
#[derive(Debug)]
pub(crate) struct Ground {
    map: SearchMap,
    /// Clearance to the world alone, where zones are painted. [mm]
    world_mm: Option<Vec<u16>>,
    /// Least clearance. [m]
    least_m: f64,
}

impl Ground {
    /// Begins it for a robot that can stand where the clearance is `room_m`.
    pub(crate) fn new(mapper: &Mapper, room_m: f64) -> Self {
        let room_m = room_m.min(0.001 * f64::from(mapper.clearance_limit_mm()));
        Self {
            map: SearchMap::new(mapper.geometry()),
            // A robot may be in a keepout zone.
            world_mm: mapper.clearance_without_zones(),
            least_m: room_m - 1.5 * mapper.geometry().resolution_m,
        }
    }

    /// Goes on making it, as [`SearchMap::make`]; the map once it is whole.
    pub(crate) fn make(&mut self, mapper: &Mapper, n_cells: usize) -> Option<&SearchMap> {
        let (cells, least_m) = (mapper.cells(), self.least_m);
        let world_mm = self.world_mm.as_ref();
        let is_whole = self.map.make(
            |index| cells[index].flags & FLAG_STATIC != 0,
            |index| {
                let cell = &cells[index];
                let clearance_mm = world_mm.map_or(cell.clearance_mm, |world| world[index]);
                cell.flags & FLAG_UNKNOWN == 0 && 0.001 * f64::from(clearance_mm) >= least_m
            },
            n_cells,
        );
        is_whole.then_some(&self.map)
    }
}
