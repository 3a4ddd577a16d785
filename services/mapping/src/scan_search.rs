//! Where the robot is when it has lost its pose, as far as the scan can be laid on the map near by.
//!
//! A match that begins in the wrong place converges to the wrong place. So all poses within reach are
//! tried on a coarse raster by how many points they explain (correlative scan matching: Olson,
//! "Real-Time Correlative Scan Matching", 2009), the best ones are made exact, and the result counts only
//! when it explains nearly all of the scan that lies where the map is known, and no other place
//! explains about as much.

use crate::scan_match::{Match, Surfaces};
use nalgebra::{Matrix3, Point2, Vector3};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;

/// Farthest that is looked. [m, rad]
const REACH_MAX: (f64, f64) = (1.2, 0.6);

/// Raster of the poses that are tried. [m, rad]
const RASTER: (f64, f64) = (0.1, 0.06);

/// Most points that are tried; of more, every n-th.
const POINTS_MAX: usize = 60;

/// How far from a surface a point may lie on the raster, and in the end, to be explained, in cells.
const ON_CELLS: (f64, f64) = (3.0, 2.0);

/// Share of the points where the map is known, and of all, that must be explained, and their number.
const EXPLAINED: (f64, f64, usize) = (0.7, 0.4, 30);

/// Poses on the raster that are made exact.
const BEST: usize = 8;

/// How far poses lie apart that are not the same. [m, rad]
const OTHER: (f64, f64) = (0.3, 0.3);

/// Share of the points by which the best place must explain more than any other.
const AHEAD: f64 = 0.1;

impl Surfaces {
    /// The pose within `reach` [m, rad] of `predicted` at which the ends of the beams, in `base` [m],
    /// lie on the surfaces; `None` when too few of them do, or when there is more than one such place.
    pub(crate) fn find(
        &self,
        ends: &[Point2<f64>],
        predicted: &Pose,
        reach: (f64, f64),
        is_mapped: impl Fn(Point2<f64>) -> bool,
    ) -> Option<Match> {
        let reach = (reach.0.min(REACH_MAX.0), reach.1.min(REACH_MAX.1));
        let best = self.best_on_raster(ends, predicted, reach);
        let deviations = Vector3::new(RASTER.0, RASTER.0, RASTER.1);
        let covariance = Matrix3::from_diagonal(&deviations.component_mul(&deviations));
        let mut winner: Option<(f64, Match)> = None;
        let mut others = [(0.0, Pose::default()); BEST];
        for ((share, pose), other) in best.iter().zip(&mut others) {
            if *share <= 0.0 {
                continue;
            }
            // A lost robot is laid on cells: hits tell nothing from far.
            let Some(laid) = self.lay(ends, pose, &covariance, |_| true) else {
                continue;
            };
            let share = self.explained(ends, &laid.pose, ON_CELLS.1);
            *other = (share, laid.pose);
            if winner.as_ref().is_none_or(|(most, _)| share > *most) {
                winner = Some((share, laid));
            }
        }
        let (share, found) = winner?;
        let is_other = |pose: &Pose| {
            let turned_rad = wrap_angle(pose.yaw_rad - found.pose.yaw_rad).abs();
            pose.distance_m(&found.pose) > OTHER.0 || turned_rad > OTHER.1
        };
        let rival = others
            .iter()
            .any(|(other, pose)| *other + AHEAD > share && is_other(pose));
        let (mapped, on) = self.explained_where(ends, &found.pose, is_mapped);
        let is_explained = on.to_f64() >= EXPLAINED.0 * mapped.to_f64()
            && on.to_f64() >= EXPLAINED.1 * ends.len().to_f64()
            && on >= EXPLAINED.2;
        (is_explained && !rival).then_some(found)
    }

    /// The poses on the raster that explain most, best first, none beside a better one.
    fn best_on_raster(
        &self,
        ends: &[Point2<f64>],
        around: &Pose,
        (reach_m, reach_rad): (f64, f64),
    ) -> [(f64, Pose); BEST] {
        let mut best = [(0.0, Pose::default()); BEST];
        let steps = |reach: f64, raster: f64| {
            let n = (reach / raster).ceil().to_i32();
            (-n..=n).map(move |step| f64::from(step) * raster)
        };
        for yaw_rad in steps(reach_rad, RASTER.1) {
            for x_m in steps(reach_m, RASTER.0) {
                for y_m in steps(reach_m, RASTER.0) {
                    let pose = Pose::new(
                        around.x_m + x_m,
                        around.y_m + y_m,
                        wrap_angle(around.yaw_rad + yaw_rad),
                    );
                    let share = self.explained(ends, &pose, ON_CELLS.0);
                    insert(&mut best, share, pose);
                }
            }
        }
        best
    }

    /// Share of some points that lie within `on_cells` of a surface.
    fn explained(&self, ends: &[Point2<f64>], pose: &Pose, on_cells: f64) -> f64 {
        let every = ends.len().div_ceil(POINTS_MAX).max(1);
        let on_m = on_cells * self.geometry().resolution_m;
        let into_map = pose.isometry();
        let (mut on, mut n) = (0.0, 0.0_f64);
        for end in ends.iter().step_by(every) {
            n += 1.0;
            if self.distance_m(into_map * end) <= on_m {
                on += 1.0;
            }
        }
        on / n.max(1.0)
    }

    /// How many points lie where the map is known or on a surface, and how many on a surface.
    fn explained_where(
        &self,
        ends: &[Point2<f64>],
        pose: &Pose,
        is_mapped: impl Fn(Point2<f64>) -> bool,
    ) -> (usize, usize) {
        let on_m = ON_CELLS.1 * self.geometry().resolution_m;
        let into_map = pose.isometry();
        let (mut mapped, mut on) = (0, 0);
        for end in ends {
            let at = into_map * end;
            let is_on = self.distance_m(at) <= on_m;
            on += usize::from(is_on);
            mapped += usize::from(is_on || is_mapped(at));
        }
        (mapped, on)
    }
}

/// Keeps the best poses, of those beside each other only the best.
fn insert(best: &mut [(f64, Pose); BEST], share: f64, pose: Pose) {
    if share <= best[BEST - 1].0 {
        return;
    }
    let beside = |other: &Pose| {
        other.distance_m(&pose) < 1.5 * RASTER.0
            && wrap_angle(other.yaw_rad - pose.yaw_rad).abs() < 1.5 * RASTER.1
    };
    let same = best
        .iter()
        .position(|(most, other)| *most > 0.0 && beside(other));
    let place = match same {
        Some(at) if best[at].0 >= share => return,
        Some(at) => at,
        None => BEST - 1,
    };
    best[place] = (share, pose);
    best.sort_by(|a, b| b.0.total_cmp(&a.0));
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::{Cell, GridGeometry};

    /// A room of 8 m x 6 m with a pillar, or a bare corridor of 8 m x 2 m.
    fn surfaces(height: u32, pillar: bool, ends: bool) -> Surfaces {
        let geometry = GridGeometry {
            resolution_m: 0.05,
            width: 160,
            height,
            ..GridGeometry::default()
        };
        let (w, h) = geometry.size();
        Surfaces::new(&geometry, |index| {
            let width = geometry.width as usize;
            let cell = |n: usize| i32::try_from(n).expect("small");
            let Cell { x, y } = Cell::new(cell(index % width), cell(index / width));
            y < 2
                || y >= h - 2
                || ends && (x < 2 || x >= w - 2)
                || pillar && (100..110).contains(&x) && (70..80).contains(&y)
        })
    }

    /// What is seen of the surfaces from a pose, as far as 5 m.
    fn seen(surfaces: &Surfaces, from: &Pose) -> Vec<Point2<f64>> {
        let into_base = from.isometry().inverse();
        (0..240)
            .filter_map(|beam| {
                let (sin, cos) =
                    (from.yaw_rad + f64::from(beam) * core::f64::consts::TAU / 240.0).sin_cos();
                let at = |k: i32| {
                    let range_m = 0.02 * f64::from(k);
                    Point2::new(from.x_m + range_m * cos, from.y_m + range_m * sin)
                };
                let hit = (1..250)
                    .map(at)
                    .find(|at| surfaces.distance_m(*at) < 0.03)?;
                Some(into_base * hit)
            })
            .collect()
    }

    #[test]
    fn a_robot_that_is_within_reach_is_found() {
        let room = surfaces(120, true, true);
        let truth = Pose::new(3.0, 2.0, 0.4);
        let ends = seen(&room, &truth);
        let lost = Pose::new(3.7, 1.5, 0.7);
        let found = room
            .find(&ends, &lost, (1.0, 0.5), |_| true)
            .expect("a place");
        assert!(found.pose.distance_m(&truth) < 0.05, "{found:?}");
        assert!(wrap_angle(found.pose.yaw_rad - truth.yaw_rad).abs() < 0.03);
        assert_eq!(
            room.find(&ends, &lost, (0.2, 0.1), |_| true),
            None,
            "beyond reach"
        );
    }

    #[test]
    fn what_lies_on_the_map_here_and_there_is_nowhere() {
        let corridor = surfaces(40, false, false);
        let ends = seen(&corridor, &Pose::new(4.0, 1.0, 0.0));
        let about = Pose::new(4.3, 1.0, 0.0);
        assert_eq!(corridor.find(&ends, &about, (1.0, 0.3), |_| true), None);
    }

    #[test]
    fn another_room_is_not_taken_for_this_one() {
        let (room, other) = (surfaces(120, true, true), surfaces(64, false, true));
        let at = Pose::new(3.0, 1.6, 0.0);
        let ends = seen(&other, &at);
        assert_eq!(room.find(&ends, &at, (1.0, 0.5), |_| true), None);
    }
}
