//! The dynamic window: which twists are looked at.

use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::description::Description;

/// Most steps of a rollout.
pub(crate) const STEPS_MAX: usize = 64;

/// Closed range of a sampled quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Range {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// What the rollouts of a period have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window<'a> {
    pub(crate) robot: &'a Description,
    /// Twist that the motions start from.
    pub(crate) from: Twist,
    /// [m/s] speeds to sample.
    pub(crate) speeds: Range,
    /// [rad/s] yaw rates to sample.
    pub(crate) yaw_rates: Range,
    /// [rad/s] yaw rate to steer for the local goal; sampled exactly when in range.
    pub(crate) preferred_radps: f64,
    /// [rad] heading of the robot in the map.
    pub(crate) yaw_rad: f64,
    /// [s]
    pub(crate) step_s: f64,
    /// [s]
    pub(crate) horizon_s: f64,
    /// [s] before braking begins.
    pub(crate) reaction_s: f64,
    /// [m] free at the end of a stop.
    pub(crate) stop_margin_m: f64,
    /// [m] around the outline in which nearness is told.
    pub(crate) soft_m: f64,
}

impl Window<'_> {
    /// Steps of a rollout.
    pub(crate) fn steps(&self) -> usize {
        let mut n = 1;
        while n < STEPS_MAX && (n.to_f64() + 0.5) * self.step_s < self.horizon_s {
            n += 1;
        }
        n
    }
}

/// Mean over `dt` of a value that ramps from `from` to `to` at `rate` and then holds.
pub(crate) fn ramp_mean(from: f64, to: f64, rate: f64, dt: f64) -> f64 {
    let share = ((to - from).abs() / (rate * dt)).min(1.0);
    to - 0.5 * (to - from) * share
}

/// `n >= 2` values evenly spread over a range, its ends included.
pub(crate) fn spread(values: &mut Vec<f64>, range: Range, n: usize) {
    values.clear();
    let last = (n.max(2) - 1).to_f64();
    values
        .extend((0..n.max(2)).map(|i| range.low + (range.high - range.low) * (i.to_f64() / last)));
}

/// Moves the nearest value onto `onto` when that lies in the range.
pub(crate) fn snap(values: &mut [f64], onto: f64) {
    let (Some(&low), Some(&high)) = (values.first(), values.last()) else {
        return;
    };
    if onto < low || onto > high {
        return;
    }
    let distance = |value: &f64| (value - onto).abs();
    if let Some(nearest) = values
        .iter_mut()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    {
        *nearest = onto;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_and_the_preferred_rate_are_sampled_exactly() {
        let mut values = Vec::new();
        let range = Range {
            low: -0.31,
            high: 0.87,
        };
        spread(&mut values, range, 41);
        snap(&mut values, 0.0);
        snap(&mut values, 0.5123);
        assert_eq!(values.len(), 41);
        assert!(values.iter().any(|v| v.abs() < 1e-15));
        assert!(values.iter().any(|v| (v - 0.5123).abs() < 1e-15));
        assert!((values[0] + 0.31).abs() < 1e-15 && (values[40] - 0.87).abs() < 1e-15);
    }
}
