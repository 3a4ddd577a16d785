//! A path as the potential-field methods use it: turning points, a carrot, points around.

use crate::progress::{PathTracker, Place};
use nalgebra::Point2;
use zeronav_casts::Cast;
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

/// The nodes of the papers' A* along a path: the path comes as its corners, between which there is one
/// node a cell.
#[derive(Debug, Clone, Default)]
pub struct Nodes {
    geometry: u64,
    /// Place along the path and position of every node but the first, in order. [m]
    nodes: Vec<(f64, Point2<f64>)>,
}

impl Nodes {
    /// Takes the nodes of the path of `input` when it is another one; `cell` is the side of a cell. [m]
    pub fn take(&mut self, input: &LawInput<'_>, cell: f64) {
        if self.geometry == input.geometry {
            return;
        }
        self.geometry = input.geometry;
        self.nodes.clear();
        let mut arc = 0.0;
        for pair in input.path.windows(2) {
            let from = Point2::new(pair[0].x_m, pair[0].y_m);
            let along = Point2::new(pair[1].x_m, pair[1].y_m) - from;
            let n = (along.amax() / cell).round().clamp(1.0, 1.0e4).to_u32();
            for i in 1..=n {
                let share = f64::from(i) / f64::from(n);
                let place = arc + share * along.norm();
                self.nodes.push((place, from + along * share));
            }
            arc += along.norm();
        }
    }

    /// The nodes that lie farther along the path than `arc`, nearest first. [m]
    pub fn after(&self, arc: f64) -> impl Iterator<Item = Point2<f64>> {
        let first = self.nodes.partition_point(|(place, _)| *place <= arc);
        self.nodes[first..].iter().map(|(_, node)| *node)
    }

    /// The last node: the end of the path.
    #[must_use]
    pub fn last(&self) -> Option<Point2<f64>> {
        self.nodes.last().map(|(_, node)| *node)
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
