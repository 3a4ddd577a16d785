//! `lwx_oapf` and `lwx_iter` [LWX]: the path's turning points as interim goals of the field, each
//! with a budget of steps.
//!
//! The interim goal is the turning point after the next one. The printed method restarts at
//! the turning point that was passed, so its path jumps ([`super::lwx_loop`] reproduces that); here
//! the robot goes on from where it is, the only way that a robot can. When an interim goal is not
//! reached within `L` steps per unit of distance, the nearer turning point is taken instead; when
//! that is not reached either, the law is stuck until there is another path. `lwx_iter` is stuck at
//! once.

use super::law::{Law, LawInput, Push};
use super::potential::{Gains, all_repulsions, attraction};
use super::route::turning_points;
use nalgebra::Point2;

/// The field towards one interim goal after the other.
#[derive(Debug, Clone)]
pub struct LwxOapf {
    gains: Gains,
    /// Steps per unit of distance (`L`).
    per_unit: f64,
    /// Out of steps, give up instead of taking the nearer turning point (`lwx_iter`).
    strict: bool,
    geometry: u64,
    points: Vec<Point2<f64>>,
    /// The turning point passed last.
    passed: usize,
    /// Turning points that the interim goal is ahead of it: 2, or 1 when that was not reached.
    ahead: usize,
    /// Steps left for the interim goal.
    left: f64,
}

impl LwxOapf {
    /// The field with these gains and `L` steps per unit of distance.
    #[must_use]
    pub const fn new(gains: Gains, per_unit: f64, strict: bool) -> Self {
        Self {
            gains,
            per_unit,
            strict,
            geometry: 0,
            points: Vec::new(),
            passed: 0,
            ahead: 2,
            left: 0.0,
        }
    }

    /// The interim goal; the path's end near the end.
    fn interim(&self, input: &LawInput<'_>) -> Point2<f64> {
        let index = (self.passed + self.ahead).min(self.points.len().saturating_sub(1));
        self.points.get(index).copied().unwrap_or(input.goal)
    }

    /// Steps for the interim goal.
    fn refill(&mut self, input: &LawInput<'_>) {
        self.left = budget(self.per_unit, input.at, self.interim(input));
    }
}

/// Eq. 11: `I = ceil(L |R - T|)`, at least a step.
pub(super) fn budget(per_unit: f64, from: Point2<f64>, to: Point2<f64>) -> f64 {
    (per_unit * (from - to).norm()).ceil().clamp(1.0, 1.0e6)
}

/// True for a robot that is farther from one turning point than the next one is, by the sum of
/// both axes.
pub(super) fn has_passed(at: Point2<f64>, here: Point2<f64>, next: Point2<f64>) -> bool {
    let manhattan = |a: Point2<f64>, b: Point2<f64>| (a.x - b.x).abs() + (a.y - b.y).abs();
    manhattan(at, here) > manhattan(here, next)
}

impl Law for LwxOapf {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        if self.geometry != input.geometry {
            self.geometry = input.geometry;
            self.points = turning_points(input.path);
            self.passed = 0;
            self.ahead = 2;
            self.refill(input);
        }
        while let [here, next, _, ..] = self.points[self.passed.min(self.points.len())..] {
            if !has_passed(input.at, here, next) {
                break;
            }
            self.passed += 1;
            self.ahead = 2;
            self.refill(input);
        }
        if self.left <= 0.0 {
            if self.strict || self.ahead == 1 {
                return Push::Stuck;
            }
            self.ahead = 1;
            self.refill(input);
        }
        self.left -= input.steps;
        let pull = attraction(self.gains.attract, input.at, self.interim(input));
        Push::Along(pull + all_repulsions(&self.gains, input))
    }

    fn escapes_minima(&self) -> bool {
        true
    }
}
