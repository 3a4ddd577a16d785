//! What is known of the form of something that is followed.

use crate::fit::Fit;

/// Most hits that the radius is a mean of; more and it follows what is seen.
const RADIUS_HITS_MAX: f64 = 20.0;

/// Standard deviation of a radius that was seen once. [m]
const RADIUS_SIGMA_M: f64 = 0.05;

/// Radius of what is half hidden and its standard deviation. [m]
const EXPECTED_RADIUS_M: f64 = 0.3;
const EXPECTED_RADIUS_SIGMA_M: f64 = 0.1;

/// Round or not, and how large.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Form {
    /// How far it reaches from its centre. [m]
    pub radius_m: f64,
    radius_hits: f64,
    /// Above 0 for round things.
    roundness: i32,
}

impl Form {
    /// What the first look at it tells, when something hid part of it or not.
    #[must_use]
    pub(crate) fn of(fit: &Fit, hidden: bool) -> Self {
        let sliver = is_sliver(fit, hidden);
        let round = sliver || matches!(fit, Fit::Circle { .. });
        let unknown = hidden && round;
        Self {
            radius_m: if unknown {
                EXPECTED_RADIUS_M
            } else {
                fit.radius_m()
            },
            radius_hits: if unknown { 0.0 } else { 1.0 },
            roundness: i32::from(round),
        }
    }

    /// A disc whose radius is known.
    #[must_use]
    pub(crate) fn disc(radius_m: f64) -> Self {
        Self {
            radius_m,
            radius_hits: RADIUS_HITS_MAX,
            roundness: 1,
        }
    }

    /// True when it is taken for a disc.
    #[must_use]
    pub(crate) fn is_round(&self) -> bool {
        self.roundness > 0
    }

    /// How well its radius is known. [m]
    #[must_use]
    pub(crate) fn radius_sigma_m(&self) -> f64 {
        if self.radius_hits < 1.0 {
            EXPECTED_RADIUS_SIGMA_M
        } else {
            RADIUS_SIGMA_M / self.radius_hits.sqrt()
        }
    }

    /// Learns from another look.
    pub(crate) fn see(&mut self, fit: &Fit, hidden: bool) {
        let circle = matches!(fit, Fit::Circle { .. });
        if !is_sliver(fit, hidden) {
            let vote = if circle { 1 } else { -1 };
            self.roundness = (self.roundness + vote).clamp(-5, 5);
        }
        if self.is_round() == circle && !hidden {
            self.radius_hits = (self.radius_hits + 1.0).min(RADIUS_HITS_MAX);
            self.radius_m += (fit.radius_m() - self.radius_m) / self.radius_hits;
        }
    }
}

/// True for what may be all that is seen of something round that is half hidden: it is straight, too.
fn is_sliver(fit: &Fit, hidden: bool) -> bool {
    hidden && matches!(fit, Fit::Segment { half_m, .. } if *half_m <= EXPECTED_RADIUS_M)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point2, Vector2};

    const fn segment(half_m: f64) -> Fit {
        Fit::Segment {
            middle: Point2::new(2.0, 0.0),
            along: Vector2::new(0.0, 1.0),
            half_m,
        }
    }

    const fn circle(radius_m: f64) -> Fit {
        Fit::Circle {
            centre: Point2::new(2.0, 0.0),
            radius_m,
        }
    }

    #[test]
    fn a_sliver_may_be_somebody_until_all_of_him_is_seen() {
        let mut form = Form::of(&segment(0.05), true);
        assert!(form.is_round());
        assert!((form.radius_m - EXPECTED_RADIUS_M).abs() < 1e-12);
        for _ in 0..10 {
            form.see(&segment(0.1), true);
        }
        assert!(form.is_round() && (form.radius_sigma_m() - EXPECTED_RADIUS_SIGMA_M).abs() < 1e-12);
        form.see(&circle(0.25), false);
        assert!((form.radius_m - 0.25).abs() < 1e-12);
        assert!((form.radius_sigma_m() - RADIUS_SIGMA_M).abs() < 1e-12);
    }

    #[test]
    fn walls_are_not_round_and_discs_are() {
        // Too long to be anybody, or seen whole.
        assert!(!Form::of(&segment(0.4), true).is_round());
        assert!(!Form::of(&segment(0.1), false).is_round());
        let mut form = Form::of(&circle(0.2), false);
        for _ in 0..3 {
            form.see(&circle(0.3), false);
        }
        assert!((form.radius_m - 0.275).abs() < 1e-12, "{form:?}");
        for _ in 0..5 {
            form.see(&segment(0.5), false);
        }
        assert!(!form.is_round());
    }
}
