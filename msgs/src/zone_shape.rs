//! The polygon of a part of a zone: what lies in it, and which of its edges nothing else covers.

use crate::zones::{ZoneKind, ZonePart};
use nalgebra::{Point2, Vector2};

/// Gap between two parts that counts as none: neighbours of a mask share an edge. [m]
pub(crate) const SEAM_M: f64 = 1.0e-3;

/// From one point to another. [m]
pub type Segment = [Point2<f64>; 2];

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    pub(crate) message: ZonePart,
    pub(crate) kind: ZoneKind,
    /// Smallest upright rectangle around it. [m]
    pub(crate) min: Point2<f64>,
    pub(crate) max: Point2<f64>,
}

impl Part {
    pub(crate) fn of(message: &ZonePart) -> Option<Self> {
        let kind = message.kind()?;
        let mut min = Point2::new(f64::INFINITY, f64::INFINITY);
        let mut max = -min;
        for [x_m, y_m] in message.corners() {
            min = Point2::new(min.x.min(*x_m), min.y.min(*y_m));
            max = Point2::new(max.x.max(*x_m), max.y.max(*y_m));
        }
        Some(Self {
            message: *message,
            kind,
            min,
            max,
        })
    }

    /// No farther than this from the point lies the rectangle around it. [m]
    pub(crate) fn is_within(&self, at: Point2<f64>, reach_m: f64) -> bool {
        at.x >= self.min.x - reach_m
            && at.x <= self.max.x + reach_m
            && at.y >= self.min.y - reach_m
            && at.y <= self.max.y + reach_m
    }

    pub(crate) fn edges(&self) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
        let corners = self.message.corners();
        let next = corners.iter().cycle().skip(1);
        let pairs = corners.iter().zip(next);
        pairs.map(|(from, to)| (Point2::from(*from), Point2::from(*to)))
    }

    /// True for a point inside; crossing number, half-open in y.
    pub(crate) fn contains(&self, at: Point2<f64>) -> bool {
        self.is_within(at, 0.0)
            && self.edges().fold(false, |inside, (from, to)| {
                let crosses = (from.y > at.y) != (to.y > at.y)
                    && at.x < from.x + (at.y - from.y) / (to.y - from.y) * (to.x - from.x);
                inside ^ crosses
            })
    }

    /// From the point to the nearest edge. [m]
    pub(crate) fn edge_distance_m(&self, at: Point2<f64>) -> f64 {
        let distances = self.edges().map(|(from, to)| distance_m(&[from, to], at));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Twice the area, above 0 when the corners go round counter-clockwise. [m^2]
    fn turn(&self) -> f64 {
        let from = self.min;
        self.edges()
            .map(|(a, b)| (a - from).perp(&(b - from)))
            .sum()
    }

    /// Where a ray is inside: adds pairs of distances from its origin. [m]
    fn spans(&self, origin: Point2<f64>, towards: Vector2<f64>, spans: &mut Vec<[f64; 2]>) {
        let mut crossings: Vec<f64> = Vec::new();
        for (from, to) in self.edges() {
            let (a, b) = (towards.perp(&(from - origin)), towards.perp(&(to - origin)));
            if (a > 0.0) != (b > 0.0) {
                let at = from + (to - from) * (a / (a - b));
                crossings.push((at - origin).dot(&towards));
            }
        }
        crossings.sort_by(f64::total_cmp);
        spans.extend(crossings.chunks_exact(2).map(|pair| [pair[0], pair[1]]));
    }

    /// Adds what of the own edges no other one of all parts covers.
    pub(crate) fn open_edges(&self, all: &[&Self], open: &mut Vec<Segment>) {
        let outward = if self.turn() > 0.0 { 1.0 } else { -1.0 };
        let mut covered = Vec::new();
        for (from, to) in self.edges() {
            let Some(towards) = (to - from).try_normalize(0.0) else {
                continue;
            };
            // Beside a neighbour that shares the edge this lies in it.
            let beside = from + Vector2::new(towards.y, -towards.x) * (outward * SEAM_M);
            let (middle, reach_m) = (from + (to - from) * 0.5, (to - from).amax());
            covered.clear();
            let others = all.iter().filter(|it| !core::ptr::eq(**it, self));
            for other in others.filter(|it| it.is_within(middle, reach_m)) {
                other.spans(beside, towards, &mut covered);
            }
            covered.sort_by(|one, other| one[0].total_cmp(&other[0]));
            let length_m = (to - from).norm();
            let mut open_from_m = 0.0_f64;
            for [first_m, last_m] in covered.iter().copied().chain([[length_m, length_m]]) {
                let until_m = first_m.min(length_m);
                if until_m > open_from_m {
                    open.push([open_from_m, until_m].map(|along_m| from + towards * along_m));
                }
                open_from_m = open_from_m.max(last_m);
            }
        }
    }
}

/// From a point to the nearest one of a segment. [m]
#[must_use]
pub fn distance_m([from, to]: &Segment, at: Point2<f64>) -> f64 {
    let along = to - from;
    let length = along.norm_squared();
    let share = if length > 0.0 {
        ((at - from).dot(&along) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (from + along * share - at).norm()
}
