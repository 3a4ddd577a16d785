//! A stop that the guard commands by itself.

use crate::limits::Limits;
use crate::verdict::LEAD_S;
use zeronav_motion::Twist;

/// [m/s] up to which a robot turns on the spot.
const CREEP_MPS: f64 = 0.01;

/// A ramp to rest under way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ramp {
    /// What a robot that obeys does by now: it brakes on the arc that it was on.
    expected: Twist,
    /// [m/s] >= 0 by which commands are slower than that, so that a robot that was slowing down
    /// already does not pause.
    lead_mps: f64,
}

impl Ramp {
    /// A ramp whose commands begin at this twist.
    pub(crate) const fn from(expected: Twist) -> Self {
        Self {
            expected,
            lead_mps: 0.0,
        }
    }

    /// Where a ramp begins for a robot that has the twist `soon` when its first command takes effect: on
    /// the arc that the robot is on then, because the stops that were checked begin there, with
    /// commands as far below its speed as the `last` one can be ahead of it.
    pub(crate) fn begin(soon: Option<Twist>, last: Twist, limits: &Limits) -> Self {
        let Some(Twist { v_mps, w_radps }) = soon else {
            return Self::from(last);
        };
        let lead_mps = limits.a_mps2_max.max(limits.brake_mps2) * LEAD_S;
        let ahead_mps = (v_mps - last.v_mps) * v_mps.signum();
        let w_radps = if v_mps.abs() > CREEP_MPS {
            w_radps
        } else {
            let lead_radps = limits.alpha_radps2_max * LEAD_S;
            let (low, high) = (w_radps - lead_radps, w_radps + lead_radps);
            last.w_radps.clamp(low, high)
        };
        Self {
            expected: Twist { v_mps, w_radps },
            // A request far beyond its speed must not make it faster yet.
            lead_mps: ahead_mps.clamp(0.0, lead_mps),
        }
    }

    /// The command one step later. The yaw rate is the one for the speed that the robot has, not
    /// for the one commanded.
    pub(crate) fn step(&mut self, limits: &Limits, elapsed_s: f64) -> Twist {
        self.expected = limits.towards_rest(self.expected, elapsed_s);
        let speed_mps = (self.expected.v_mps.abs() - self.lead_mps).max(0.0);
        limits.clamp(Twist {
            v_mps: speed_mps.copysign(self.expected.v_mps),
            w_radps: self.expected.w_radps,
        })
    }
}
