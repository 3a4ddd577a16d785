//! A path as the potential-field methods use it: turning points, a carrot, points around.

use crate::progress::{PathTracker, Place};
use nalgebra::Point2;
use zeronav_msgs::path::Waypoint;

use super::law::LawInput;

/// The robot's place on its path, never going back.
#[derive(Debug, Clone, Default)]
pub struct Route {
    tracker: PathTracker,
}

impl Route {
    /// The place of the robot; `None` without a path.
    pub fn place(&mut self, input: &LawInput<'_>) -> Option<Place> {
        self.tracker.advance(input.geometry, input.path, input.at)
    }

    /// The point of the path `ahead` of the place, at most its end.
    #[must_use]
    pub fn ahead(&self, input: &LawInput<'_>, place: &Place, ahead: f64) -> Point2<f64> {
        self.tracker.point_at(input.path, place.arc_m + ahead)
    }
}

/// [LWX] turning points: the first and last point and every one where the direction changes, by
/// `cross(d1, d2) != 0 or dot(d1, d2) < 0` instead of the printed slopes.
#[must_use]
pub fn turning_points(path: &[Waypoint]) -> Vec<Point2<f64>> {
    let mut points: Vec<Point2<f64>> = Vec::with_capacity(path.len());
    let all: Vec<Point2<f64>> = path
        .iter()
        .map(|waypoint| Point2::new(waypoint.x_m, waypoint.y_m))
        .collect();
    for (i, &here) in all.iter().enumerate() {
        let ends = i == 0 || i + 1 == all.len();
        let turns = !ends && {
            let (d1, d2) = (here - all[i - 1], all[i + 1] - here);
            d1.perp(&d2).abs() > 1.0e-9 * d1.norm() * d2.norm() || d1.dot(&d2) < 0.0
        };
        if ends || turns {
            points.push(here);
        }
    }
    points
}
