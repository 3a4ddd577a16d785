//! Wheels that slip: how much of their motion reaches the ground.

use crate::noise::{Draws, Stream};
use zeronav_robot_description::SlipSpec;

/// How long one draw of the slip lasts. [ns] It counts in run time, so the tick does not matter.
const HOLD_NS: u64 = 100_000_000;

/// Most of the motion that may be lost.
const RATIO_MAX: f64 = 0.95;

/// The slip of one run.
#[derive(Debug, Clone, Copy)]
pub struct Slip {
    spec: SlipSpec,
    seed: u64,
}

/// What is left of the wheels' motion on the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grip {
    /// Of the forward speed, 0 to 1.
    pub forward: f64,
    /// Of the yaw rate, 0 to 1.
    pub turn: f64,
}

impl Grip {
    /// Wheels that do not slip.
    pub const FULL: Self = Self {
        forward: 1.0,
        turn: 1.0,
    };

    /// What is left when both take their share.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            forward: self.forward * other.forward,
            turn: self.turn * other.turn,
        }
    }
}

impl Slip {
    /// The slip of `spec` under `seed`.
    #[must_use]
    pub const fn new(spec: SlipSpec, seed: u64) -> Self {
        Self { spec, seed }
    }

    /// The grip of a tick that begins at `run_ns`.
    #[must_use]
    pub fn at(&self, run_ns: u64) -> Grip {
        let mut draws = Draws::new(self.seed, Stream::Slip, run_ns / HOLD_NS);
        let mut left = |mean: f64| {
            let lost = mean + self.spec.sigma_ratio * draws.normal();
            1.0 - lost.clamp(0.0, RATIO_MAX)
        };
        Grip {
            forward: left(self.spec.forward_ratio),
            turn: left(self.spec.turn_ratio),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_lost_and_a_draw_lasts_a_tenth_of_a_second() {
        let spec = SlipSpec {
            forward_ratio: 0.1,
            turn_ratio: 0.2,
            sigma_ratio: 0.02,
        };
        let slip = Slip::new(spec, 3);
        assert_eq!(slip.at(0), slip.at(HOLD_NS - 1));
        assert_ne!(slip.at(0), slip.at(HOLD_NS));
        let n = 10_000_u32;
        let (mut forward, mut turn) = (0.0, 0.0);
        for place in 0..u64::from(n) {
            let grip = slip.at(place * HOLD_NS);
            forward += grip.forward / f64::from(n);
            turn += grip.turn / f64::from(n);
        }
        // Five standard errors.
        assert!((forward - 0.9).abs() < 0.001, "{forward}");
        assert!((turn - 0.8).abs() < 0.001, "{turn}");
    }

    #[test]
    fn wheels_never_push_more_than_they_turn() {
        let spec = SlipSpec {
            forward_ratio: 0.0,
            turn_ratio: 0.9,
            sigma_ratio: 0.9,
        };
        let slip = Slip::new(spec, 3);
        for place in 0..1000 {
            let grip = slip.at(place * HOLD_NS);
            assert!((0.0..=1.0).contains(&grip.forward) && (0.0..=1.0).contains(&grip.turn));
        }
    }
}
