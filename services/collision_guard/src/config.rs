//! How old the guard's inputs may be, and how near the robot may come.

use crate::sweep::SPACING_M;
use serde::{Deserialize, Serialize};

/// What a user may set. Numbers of the robot are not here: they come with its description.
///
/// Ages are those beyond which an input counts as missing: since a request or odometry came in,
/// and since a scan was captured, by the guard's own clock; in lockstep all of them in run time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GuardConfig {
    /// [s] of a request. Must exceed two control periods, or one lost request stops the robot.
    pub request_age_s: f64,
    /// [s] of a scan. Must exceed the scan period.
    pub scan_age_s: f64,
    /// [s] of odometry. Must exceed two control periods.
    pub odometry_age_s: f64,
    /// [s] for which a command is obeyed before braking begins, at worst: one control period,
    /// transport and the drives. 0 to 2.
    pub reaction_s: f64,
    /// [m] that stay free around the footprint. At least half the spacing of the looked-at poses
    /// (0.01), or something could be touched between two of them.
    pub margin_m: f64,
    /// [m] beyond the margin within which the robot is slow, 0 = nowhere.
    pub slow_zone_m: f64,
    /// [m/s] of the outline's fastest point in the slow zone, > 0.
    pub slow_mps: f64,
    /// [m] driven while all ranges stay bitwise the same after which the lidar counts as frozen.
    /// A lidar without any noise in an endless straight corridor would be mistaken for one.
    pub frozen_m: f64,
    /// [rad] turned, likewise.
    pub frozen_rad: f64,
}

impl Default for GuardConfig {
    fn default() -> Self {
        Self {
            request_age_s: 0.1,
            scan_age_s: 0.35,
            odometry_age_s: 0.1,
            reaction_s: 0.08,
            margin_m: 0.01,
            slow_zone_m: 0.01,
            slow_mps: 0.5,
            frozen_m: 0.1,
            frozen_rad: 0.2,
        }
    }
}

/// Why a [`GuardConfig`] cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// An age is not a positive, finite number.
    #[error("{field} is {value_s} s, it must be a positive number")]
    NotPositive {
        /// Name of the field.
        field: &'static str,
        /// [s] its value.
        value_s: f64,
    },
    /// An age would run out in normal operation.
    #[error("{field} is {value_s} s, it must exceed {least_s} s")]
    TooShort {
        /// Name of the field.
        field: &'static str,
        /// [s] its value.
        value_s: f64,
        /// [s] what it must exceed.
        least_s: f64,
    },
    /// A number is outside its range.
    #[error("{field} is {value}, it must be {least} to {most}")]
    OutOfRange {
        /// Name of the field.
        field: &'static str,
        /// Its value.
        value: f64,
        /// Smallest value accepted.
        least: f64,
        /// Largest value accepted.
        most: f64,
    },
}

impl GuardConfig {
    /// Accepts ages that normal operation does not run into: more than two control periods for
    /// requests and odometry, more than one scan period for scans.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, period_s: f64, scan_period_s: f64) -> Result<(), ConfigError> {
        for (field, value_s, least_s) in [
            ("request_age_s", self.request_age_s, 2.0 * period_s),
            ("scan_age_s", self.scan_age_s, scan_period_s),
            ("odometry_age_s", self.odometry_age_s, 2.0 * period_s),
        ] {
            if !(value_s.is_finite() && value_s > 0.0) {
                return Err(ConfigError::NotPositive { field, value_s });
            }
            if value_s <= least_s {
                return Err(ConfigError::TooShort {
                    field,
                    value_s,
                    least_s,
                });
            }
        }
        for (field, value, least, most) in [
            ("reaction_s", self.reaction_s, 0.0, 2.0),
            ("margin_m", self.margin_m, 0.5 * SPACING_M, 1.0),
            ("slow_zone_m", self.slow_zone_m, 0.0, 2.0),
            ("slow_mps", self.slow_mps, 0.01, 100.0),
            ("frozen_m", self.frozen_m, 0.01, 1.0e3),
            ("frozen_rad", self.frozen_rad, 0.01, 1.0e3),
        ] {
            // Written so that NaN is refused.
            if !(value >= least && value <= most) {
                return Err(ConfigError::OutOfRange {
                    field,
                    value,
                    least,
                    most,
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_suit_50_hz_and_a_5_hz_lidar() {
        assert_eq!(GuardConfig::default().check(0.02, 0.2), Ok(()));
    }

    #[test]
    fn ages_within_two_periods_are_refused() {
        let config = GuardConfig {
            request_age_s: 0.04,
            ..GuardConfig::default()
        };
        assert!(matches!(
            config.check(0.02, 0.1),
            Err(ConfigError::TooShort {
                field: "request_age_s",
                ..
            })
        ));
        let config = GuardConfig {
            scan_age_s: f64::NAN,
            ..GuardConfig::default()
        };
        assert!(matches!(
            config.check(0.02, 0.1),
            Err(ConfigError::NotPositive {
                field: "scan_age_s",
                ..
            })
        ));
    }

    #[test]
    fn margins_that_prove_nothing_are_refused() {
        let config = GuardConfig {
            margin_m: 0.009,
            ..GuardConfig::default()
        };
        assert!(matches!(
            config.check(0.02, 0.1),
            Err(ConfigError::OutOfRange {
                field: "margin_m",
                ..
            })
        ));
    }
}
