//! `lwx_lsq` [LWX]: the global path, fitted by least squares, followed by a carrot.

use super::fit::free_fit;
use super::law::{Law, LawInput, Push};
use super::potential::{Gains, all_repulsions, attraction};
use super::walk::is_free;
use nalgebra::Point2;

/// [m or cells] from the nearest point of the curve to the carrot.
const LOOKAHEAD: f64 = 1.0;

/// [m or cells] between the path's points that are fitted.
const SPACING: f64 = 0.25;

/// A curve that is followed from its start to its end.
#[derive(Debug, Clone, Default)]
pub(super) struct Curve {
    pub(super) points: Vec<Point2<f64>>,
    next: usize,
}

impl Curve {
    pub(super) fn new(points: Vec<Point2<f64>>) -> Self {
        Self { points, next: 0 }
    }

    /// The point ahead of the nearest one; never back.
    pub(super) fn carrot(&mut self, at: Point2<f64>) -> Option<Point2<f64>> {
        let window = self.points.get(self.next..)?.iter().take(40);
        let nearest = window
            .enumerate()
            .min_by(|a, b| (a.1 - at).norm().total_cmp(&(b.1 - at).norm()))
            .map_or(0, |(i, _)| i);
        self.next += nearest;
        let ahead = self.points.get(self.next..)?;
        ahead
            .iter()
            .find(|point| (*point - at).norm() >= LOOKAHEAD)
            .or(ahead.last())
            .copied()
    }
}

/// The field towards a carrot on the fitted path; on the path as it is where no fit is free.
#[derive(Debug, Clone)]
pub struct LwxLsq {
    gains: Gains,
    geometry: u64,
    curve: Curve,
    /// The curve is a fit.
    fitted: bool,
}

impl LwxLsq {
    /// The field with these gains.
    #[must_use]
    pub fn new(gains: Gains) -> Self {
        Self {
            gains,
            geometry: 0,
            curve: Curve::default(),
            fitted: false,
        }
    }

    /// True when the current curve is a fit.
    #[must_use]
    pub const fn is_fitted(&self) -> bool {
        self.fitted
    }

    fn take(&mut self, input: &LawInput<'_>) {
        self.geometry = input.geometry;
        let mut points: Vec<Point2<f64>> = Vec::new();
        for pair in input.path.windows(2) {
            let from = Point2::new(pair[0].x_m, pair[0].y_m);
            let to = Point2::new(pair[1].x_m, pair[1].y_m);
            let mut along = 0.0;
            while along < (to - from).norm() {
                points.push(from + (to - from).normalize() * along);
                along += SPACING;
            }
        }
        points.extend(input.path.last().map(|end| Point2::new(end.x_m, end.y_m)));
        let fit = free_fit(&points, |from, to| is_free(input.bodies, from, to));
        self.fitted = fit.is_some();
        self.curve = Curve::new(fit.unwrap_or(points));
    }
}

impl Law for LwxLsq {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        if self.geometry != input.geometry {
            self.take(input);
        }
        let carrot = self.curve.carrot(input.at).unwrap_or(input.goal);
        let pull = attraction(self.gains.attract, input.at, carrot);
        Push::Along(pull + all_repulsions(&self.gains, input))
    }
}
