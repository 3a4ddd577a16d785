//! The free space around the robot when a manoeuvre is searched for, and the outline's clearance at any
//! pose in it: exact, as far as it matters.
//!
//! All positions are relative to where the robot stood, along the axes of the map.

use crate::field::ClearanceField;
use crate::footprint::Footprint;
use crate::lanes::data::narrow;
use crate::past_hits::{Hit, is_remembered};
use crate::squares::Squares;
use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;

/// [m] from where the robot stands to the sides of the window.
pub(crate) const HALF_M: f64 = 3.2;

/// [m] side of a cell of the coarse clearances.
pub(crate) const CELL_M: f64 = 0.1;

/// Cells on a side of the window.
pub(crate) const CELLS: usize = 64;

/// Obstacles are found by buckets of so many cells on a side.
const BUCKET_CELLS: usize = 2;
const BUCKETS: usize = CELLS / BUCKET_CELLS;

/// An obstacle: a point of the scan, or a cell of the map.
#[derive(Debug, Clone, Copy)]
struct Obstacle {
    at: Point2<f64>,
    is_square: bool,
}

/// What is around the robot.
#[derive(Debug, Clone, Default)]
pub(crate) struct Space {
    squares: Squares,
    /// Sorted by bucket.
    obstacles: Vec<Obstacle>,
    unsorted: Vec<Obstacle>,
    /// Index of the first obstacle of each bucket, and one past the last.
    starts: Vec<u32>,
    /// Clearance at the centres of the coarse cells; a bound from below, less than a cell's diagonal. [m]
    coarse: Vec<f32>,
    /// Coarse cells of which nothing is known, beyond what the robot may stand in.
    unseen: Vec<bool>,
    /// Box around the outline in `base`.
    low: Point2<f64>,
    high: Point2<f64>,
}

impl Space {
    /// Takes in obstacle cells and points, the latter in the `base` of a robot with this yaw. A robot that
    /// does not see all around (`sees_on`) keeps the cells that it measures from afar: it will not when it
    /// has passed them.
    pub(crate) fn fill(
        &mut self,
        (field, footprint): (&ClearanceField, &Footprint),
        yaw_rad: f64,
        (points_in_base, past_in_base, sees_on): (&[Point2<f64>], &[Hit], bool),
        lidar_in_base: Point2<f64>,
    ) {
        let here = Pose::new(0.0, 0.0, yaw_rad);
        let points = points_in_base.iter();
        let hits = points.map(|at| Hit::of(lidar_in_base, *at));
        let hits = || hits.clone().chain(past_in_base.iter().copied());
        let measured = hits().filter(|hit| sees_on || is_remembered(&hit.at));
        let measured = measured.map(|hit| hit.in_parent(&here));
        self.squares.fill(&field.sheet(), HALF_M, measured);
        (self.low, self.high) = footprint.bounds();
        self.unsorted.clear();
        let inside = |at: &Point2<f64>| at.x.abs() < HALF_M && at.y.abs() < HALF_M;
        let of = |is_square| move |at| Obstacle { at, is_square };
        let squares = self.squares.centres.iter().copied();
        self.unsorted.extend(squares.filter(inside).map(of(true)));
        let points = hits().map(|hit| here.transform(hit.at));
        self.unsorted.extend(points.filter(inside).map(of(false)));
        self.sort();
        self.coarse.clear();
        let at = |index: usize| narrow((index.to_f64() + 0.5) * CELL_M - HALF_M);
        for y in 0..CELLS {
            for x in 0..CELLS {
                self.coarse.push(field.nearest_m(at(x), at(y)));
            }
        }
    }

    /// Takes in, for a robot that does not see where it backs, of which places nothing is known; those within
    /// `own_m` of it count as known: it stands there.
    pub(crate) fn fill_unseen(&mut self, own_m: f64, is_unknown: impl Fn(Vector2<f64>) -> bool) {
        let at = |index: usize| (index.to_f64() + 0.5) * CELL_M - HALF_M;
        self.unseen.clear();
        for y in 0..CELLS {
            for x in 0..CELLS {
                let at = Vector2::new(at(x), at(y));
                self.unseen.push(at.norm() > own_m && is_unknown(at));
            }
        }
    }

    /// All that is known counts as seen: the robot sees where it backs.
    pub(crate) fn see_all(&mut self) {
        self.unseen.clear();
    }

    /// True when the rear of the outline is where nothing is known of, at a pose.
    pub(crate) fn backs_unseen(&self, pose: &Pose) -> bool {
        let middle_m = 0.5 * (self.low.y + self.high.y);
        !self.unseen.is_empty()
            && [self.low.y, middle_m, self.high.y].iter().any(|side_m| {
                let at = pose.transform(Point2::new(self.low.x, *side_m));
                self.unseen[cell(at.y) * CELLS + cell(at.x)]
            })
    }

    /// Counting sort by bucket.
    fn sort(&mut self) {
        self.starts.clear();
        self.starts.resize(BUCKETS * BUCKETS + 1, 0);
        let index = |obstacle: &Obstacle| {
            let (x, y) = (bucket(obstacle.at.x), bucket(obstacle.at.y));
            y * BUCKETS + x
        };
        for obstacle in &self.unsorted {
            self.starts[index(obstacle) + 1] += 1;
        }
        for i in 1..self.starts.len() {
            self.starts[i] += self.starts[i - 1];
        }
        self.obstacles.clone_from(&self.unsorted);
        // From the back, so that each bucket's end comes down to its start.
        let mut ends: [u32; BUCKETS * BUCKETS] = [0; BUCKETS * BUCKETS];
        ends.copy_from_slice(&self.starts[1..]);
        for obstacle in &self.unsorted {
            let end = &mut ends[index(obstacle)];
            *end -= 1;
            self.obstacles[*end as usize] = *obstacle;
        }
    }

    /// Clearance at the centre of a coarse cell, give or take [`CELL_M`]. [m]
    pub(crate) fn coarse_m(&self, x: usize, y: usize) -> f64 {
        f64::from(self.coarse[y * CELLS + x])
    }

    /// Clearance of the outline at a pose, exact up to `enough_m`; something below `need_m` as soon as it
    /// is less than that. Beyond the window nothing is free. [m]
    pub(crate) fn clearance_m(
        &self,
        footprint: &Footprint,
        pose: &Pose,
        need_m: f64,
        enough_m: f64,
    ) -> f64 {
        let inner_m = HALF_M - footprint.circumscribed_m - enough_m;
        if pose.x_m.abs() > inner_m || pose.y_m.abs() > inner_m {
            return f64::NEG_INFINITY;
        }
        let (x, y) = (cell(pose.x_m), cell(pose.y_m));
        // From the pose to the cell's centre, and from there to that of a cell of the map.
        let slack_m = 1.5 * CELL_M;
        if self.coarse_m(x, y) > footprint.circumscribed_m + enough_m + slack_m {
            return enough_m;
        }
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let rotated =
            |at: Vector2<f64>| Vector2::new(cos * at.x - sin * at.y, sin * at.x + cos * at.y);
        let middle = rotated((self.low.coords + self.high.coords) * 0.5);
        let half = (self.high - self.low) * 0.5;
        let around_m = core::f64::consts::SQRT_2 * self.squares.half_m;
        let reach_m = enough_m + around_m;
        let half_x = cos.abs() * half.x + sin.abs() * half.y + reach_m;
        let half_y = sin.abs() * half.x + cos.abs() * half.y + reach_m;
        let (middle_x, middle_y) = (pose.x_m + middle.x, pose.y_m + middle.y);
        let (from_x, to_x) = (bucket(middle_x - half_x), bucket(middle_x + half_x));
        let (from_y, to_y) = (bucket(middle_y - half_y), bucket(middle_y + half_y));
        let mut least_m = enough_m;
        for y in from_y..=to_y {
            let row = y * BUCKETS;
            let (first, last) = (self.starts[row + from_x], self.starts[row + to_x + 1]);
            for obstacle in &self.obstacles[first as usize..last as usize] {
                let (dx, dy) = (obstacle.at.x - pose.x_m, obstacle.at.y - pose.y_m);
                let at = Point2::new(cos * dx + sin * dy, cos * dy - sin * dx);
                let grown_m = least_m + around_m;
                let beside = at.x < self.low.x - grown_m || at.x > self.high.x + grown_m;
                if beside || at.y < self.low.y - grown_m || at.y > self.high.y + grown_m {
                    continue;
                }
                let space_m = if obstacle.is_square {
                    footprint.square_distance_m(at, Vector2::new(cos, -sin), self.squares.half_m)
                } else {
                    footprint.distance_m(at)
                };
                least_m = least_m.min(space_m);
                if least_m < need_m {
                    return least_m;
                }
            }
        }
        least_m
    }
}

/// The coarse cell along an axis.
pub(crate) fn cell(at_m: f64) -> usize {
    ((at_m + HALF_M) / CELL_M)
        .clamp(0.0, CELLS.to_f64() - 1.0)
        .to_usize()
}

fn bucket(at_m: f64) -> usize {
    cell(at_m) / BUCKET_CELLS
}

#[cfg(test)]
mod tests {
    #![allow(clippy::print_stdout, reason = "the seed of a failed run")]

    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;
    use zeronav_msgs::description::{Corner, Description};

    /// 0.6 m wide, from 0.4 m behind `base` to so far ahead of it.
    fn rectangle(front_m: f64) -> Footprint {
        let corner = |(x_m, y_m)| Corner { x_m, y_m };
        let corners = [(front_m, 0.3), (-0.4, 0.3), (-0.4, -0.3), (front_m, -0.3)].map(corner);
        let robot = Description {
            inscribed_radius_m: 0.3,
            circumscribed_radius_m: front_m.hypot(0.3),
            ..Description::default()
        };
        Footprint::new(&robot, &corners)
    }

    #[test]
    fn the_clearance_is_that_of_the_nearest_point() {
        let footprint = rectangle(0.8);
        for seed in 0..5 {
            println!("seed {seed}");
            let mut random = Pcg32::seed_from_u64(seed);
            let mut within = |half: f64| random.random_range(-half..half);
            let points: Vec<Point2<f64>> = (0..40)
                .map(|_| Point2::new(within(3.0), within(3.0)))
                .collect();
            let (yaw_rad, mut field) = (within(3.0), ClearanceField::default());
            let here = Pose::new(0.0, 0.0, yaw_rad);
            field.fill(None, &here, &points, HALF_M, 1.5);
            let mut space = Space::default();
            let lidar = Point2::origin();
            space.fill((&field, &footprint), yaw_rad, (&points, &[], true), lidar);
            for _ in 0..2000 {
                let pose = Pose::new(within(2.0), within(2.0), within(3.0));
                let in_base = |point: &Point2<f64>| {
                    footprint.distance_m(pose.isometry().inverse() * here.transform(*point))
                };
                let true_m = points.iter().map(in_base).fold(0.2, f64::min);
                let found_m = space.clearance_m(&footprint, &pose, f64::NEG_INFINITY, 0.2);
                assert!(
                    (found_m - true_m).abs() < 1e-9,
                    "{found_m} {true_m} at {pose:?}"
                );
                let enough = space.clearance_m(&footprint, &pose, 0.05, 0.2) >= 0.05;
                assert_eq!(enough, true_m >= 0.05, "at {pose:?}");
            }
            let outside = Pose::new(3.0, 0.0, 0.0);
            assert!(space.clearance_m(&footprint, &outside, 0.0, 0.2) < 0.0);
        }
    }

    #[test]
    fn the_rear_does_not_go_where_nothing_is_known_of() {
        let footprint = rectangle(0.4);
        let mut field = ClearanceField::default();
        field.fill(None, &Pose::default(), &[], HALF_M, 1.5);
        let mut space = Space::default();
        space.fill(
            (&field, &footprint),
            0.0,
            (&[], &[], false),
            Point2::origin(),
        );
        space.fill_unseen(0.65, |at| at.x < -0.2);
        let backs = |space: &Space, x_m: f64, yaw_rad: f64| {
            space.backs_unseen(&Pose::new(x_m, 0.0, yaw_rad))
        };
        assert!(!backs(&space, 0.0, 0.0), "where it stands");
        assert!(backs(&space, -0.5, 0.0));
        assert!(!backs(&space, -0.5, 3.1), "its nose sees");
        space.see_all();
        assert!(!backs(&space, -0.5, 0.0));
    }
}
