//! Conversions between the nanoseconds of messages and the seconds of equations.

use zeronav_casts::Cast;

/// `ns` nanoseconds in seconds; exact in nanoseconds up to 2^53 ns, 104 days.
#[must_use]
#[allow(clippy::cast_precision_loss, reason = "exact up to 104 days")]
pub const fn seconds(ns: u64) -> f64 {
    ns as f64 * 1.0e-9
}

/// `duration_s` seconds in nanoseconds, rounded; 0 for negative durations and NaN, `u64::MAX` for
/// durations that do not fit.
#[must_use]
pub fn nanoseconds(duration_s: f64) -> u64 {
    (duration_s * 1.0e9).round().to_u64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_survive_both_ways() {
        for ns in [0, 1, 16_666_667, 1_000_000_001, 86_400_000_000_000] {
            assert_eq!(nanoseconds(seconds(ns)), ns);
        }
    }

    #[test]
    fn what_is_no_duration_saturates() {
        assert_eq!(nanoseconds(-1.0), 0);
        assert_eq!(nanoseconds(f64::NAN), 0);
        assert_eq!(nanoseconds(f64::INFINITY), u64::MAX);
    }
}
