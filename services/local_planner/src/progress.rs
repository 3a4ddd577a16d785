//! Where along the path the robot is: a place that only moves forward.

use nalgebra::{Point2, Vector2};
use zeronav_msgs::path::{WAYPOINTS_MAX, Waypoint};

/// [m] how far ahead of the last place the next one is looked for.
const SEARCH_M: f64 = 2.0;

/// [m] a later stretch of a new path must be nearer by this much to be preferred.
const PREFER_EARLIER_M: f64 = 0.05;

/// The robot's place on a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// [m] along the path from its start.
    pub arc_m: f64,
    /// [m] distance of the robot from the path there.
    pub cross_track_m: f64,
    /// [m] along the path to its end.
    pub remaining_m: f64,
}

/// Follows one path; a path with another geometry starts from the beginning.
///
/// The place never goes back (Appendix D of the paper notes, "monotone progress index"), so a
/// path that comes near itself is not cut short. On a new geometry the earliest stretch is taken
/// that is as near as the nearest one, give or take 5 cm: a path starts at the robot, but a
/// restarted process finds itself in the middle of one.
#[derive(Debug, Clone)]
pub struct PathTracker {
    geometry: u64,
    /// Path length at every waypoint. [m]
    arcs_m: Vec<f64>,
    place: Place,
}

impl Default for PathTracker {
    fn default() -> Self {
        Self::new()
    }
}

impl PathTracker {
    /// A tracker without a path.
    #[must_use]
    pub fn new() -> Self {
        Self {
            geometry: 0,
            arcs_m: Vec::with_capacity(WAYPOINTS_MAX),
            place: Place {
                arc_m: 0.0,
                cross_track_m: 0.0,
                remaining_m: 0.0,
            },
        }
    }

    /// The place of a robot at `position` (map frame) on `path`, whose geometry has the id
    /// `geometry`; `None` for a path without waypoints. Linear in the waypoints for a new
    /// geometry, else in those within two metres.
    pub fn advance(
        &mut self,
        geometry: u64,
        path: &[Waypoint],
        position: Point2<f64>,
    ) -> Option<Place> {
        if path.is_empty() {
            self.geometry = 0;
            self.arcs_m.clear();
            return None;
        }
        let fresh = geometry != self.geometry || path.len() != self.arcs_m.len();
        if fresh {
            self.geometry = geometry;
            self.measure(path);
        }
        let (from_m, to_m) = if fresh {
            (0.0, f64::INFINITY)
        } else {
            (self.place.arc_m, self.place.arc_m + SEARCH_M)
        };
        let nearest = self.nearest(path, position, from_m, to_m, 0.0);
        let (arc_m, cross_track_m) = if fresh {
            self.nearest(path, position, from_m, to_m, nearest.1 + PREFER_EARLIER_M)
        } else {
            nearest
        };
        self.place = Place {
            arc_m,
            cross_track_m,
            remaining_m: (self.length_m() - arc_m).max(0.0),
        };
        Some(self.place)
    }

    /// [m] length of the path.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.arcs_m.last().copied().unwrap_or(0.0)
    }

    /// The place of the last [`Self::advance`]; `None` without a path.
    #[must_use]
    pub fn place(&self) -> Option<Place> {
        (!self.arcs_m.is_empty()).then_some(self.place)
    }

    /// The point at `arc_m` along `path`, clipped to its ends. `path` is the one given to
    /// [`Self::advance`] last and not empty.
    #[must_use]
    pub fn point_at(&self, path: &[Waypoint], arc_m: f64) -> Point2<f64> {
        let next = self.arcs_m.partition_point(|arc| *arc < arc_m);
        if next == 0 {
            return point(&path[0]);
        }
        if next >= path.len() {
            return point(&path[path.len() - 1]);
        }
        let (a, b) = (point(&path[next - 1]), point(&path[next]));
        let length_m = self.arcs_m[next] - self.arcs_m[next - 1];
        let share = if length_m > 0.0 {
            (arc_m - self.arcs_m[next - 1]) / length_m
        } else {
            0.0
        };
        a + (b - a) * share
    }

    fn measure(&mut self, path: &[Waypoint]) {
        self.arcs_m.clear();
        let mut arc_m = 0.0;
        let mut last = point(&path[0]);
        for waypoint in path {
            let here = point(waypoint);
            arc_m += (here - last).norm();
            self.arcs_m.push(arc_m);
            last = here;
        }
    }

    /// Arc length and distance of the nearest point of the path between two arc lengths; the
    /// first segment nearer than `enough_m` ends the search. [m]
    fn nearest(
        &self,
        path: &[Waypoint],
        position: Point2<f64>,
        from_m: f64,
        to_m: f64,
        enough_m: f64,
    ) -> (f64, f64) {
        let first = self
            .arcs_m
            .partition_point(|arc| *arc <= from_m)
            .clamp(1, path.len());
        let start = self.point_at(path, from_m);
        let mut best = (from_m.min(self.length_m()), (position - start).norm());
        for i in first..path.len() {
            let begin_m = self.arcs_m[i - 1].max(from_m);
            let end_m = self.arcs_m[i].min(to_m);
            if begin_m > to_m || best.1 <= enough_m {
                break;
            }
            let (a, b) = (point(&path[i - 1]), point(&path[i]));
            let length_m = self.arcs_m[i] - self.arcs_m[i - 1];
            if length_m <= 0.0 {
                continue;
            }
            let along: Vector2<f64> = (b - a) / length_m;
            let arc_m = (self.arcs_m[i - 1] + (position - a).dot(&along))
                .clamp(begin_m, end_m.max(begin_m));
            let distance_m = (a + along * (arc_m - self.arcs_m[i - 1]) - position).norm();
            if distance_m < best.1 {
                best = (arc_m, distance_m);
            }
        }
        best
    }
}

fn point(waypoint: &Waypoint) -> Point2<f64> {
    Point2::new(waypoint.x_m, waypoint.y_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(points: &[(f64, f64)]) -> Vec<Waypoint> {
        let waypoint = |&(x_m, y_m): &(f64, f64)| Waypoint {
            x_m,
            y_m,
            ..Waypoint::default()
        };
        points.iter().map(waypoint).collect()
    }

    fn check(tracker: &mut PathTracker, path: &[Waypoint], at: (f64, f64), expected: [f64; 3]) {
        let place = tracker
            .advance(7, path, Point2::new(at.0, at.1))
            .expect("the path has waypoints");
        let found = [place.arc_m, place.cross_track_m, place.remaining_m];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{place:?} at {at:?}");
        }
    }

    #[test]
    fn an_l_is_followed_round_its_corner() {
        let path = path(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)]);
        let mut tracker = PathTracker::new();
        check(&mut tracker, &path, (0.0, 0.1), [0.0, 0.1, 7.0]);
        check(&mut tracker, &path, (1.5, -0.2), [1.5, 0.2, 5.5]);
        check(&mut tracker, &path, (3.2, 0.0), [3.2, 0.0, 3.8]);
        check(&mut tracker, &path, (4.5, 0.5), [4.5, 0.5, 2.5]);
        check(&mut tracker, &path, (4.0, 9.0), [6.5, 6.5, 0.5]);
        check(&mut tracker, &path, (4.0, 9.0), [7.0, 6.0, 0.0]);
    }

    #[test]
    fn the_place_never_goes_back() {
        let path = path(&[(0.0, 0.0), (4.0, 0.0)]);
        let mut tracker = PathTracker::new();
        check(&mut tracker, &path, (2.0, 0.0), [2.0, 0.0, 2.0]);
        check(&mut tracker, &path, (1.0, 0.0), [2.0, 1.0, 2.0]);
    }

    #[test]
    fn a_path_that_returns_beside_itself_starts_on_its_first_leg() {
        let path = path(&[(0.0, 0.0), (5.0, 0.0), (5.0, 0.04), (0.0, 0.04)]);
        let mut tracker = PathTracker::new();
        check(&mut tracker, &path, (1.0, 0.03), [1.0, 0.03, 9.04]);
    }

    #[test]
    fn single_points_and_empty_paths_are_no_surprise() {
        let mut tracker = PathTracker::new();
        check(
            &mut tracker,
            &path(&[(1.0, 1.0)]),
            (1.0, 2.0),
            [0.0, 1.0, 0.0],
        );
        assert_eq!(tracker.advance(8, &[], Point2::origin()), None);
    }
}
