//! How old the guard's inputs may be.

use serde::{Deserialize, Serialize};

/// Ages beyond which an input counts as missing: since a request or odometry came in, and since a
/// scan was captured, by the guard's own clock; in lockstep all of them in run time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GuardConfig {
    /// [s] of a request. Must exceed two control periods, or one lost request stops the robot.
    pub request_age_s: f64,
    /// [s] of a scan. Must exceed the scan period.
    pub scan_age_s: f64,
    /// [s] of odometry. Must exceed two control periods.
    pub odometry_age_s: f64,
}

impl Default for GuardConfig {
    fn default() -> Self {
        Self {
            request_age_s: 0.1,
            scan_age_s: 0.35,
            odometry_age_s: 0.1,
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
}
