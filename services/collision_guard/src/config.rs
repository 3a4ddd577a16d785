//! How old the guard's inputs may be, and how near the robot may come.

use crate::sweep::SPACING_M;
use zeronav_params::{ParameterError, parameters};

parameters! {
    /// What a user may set. Parameters of the robot are not here: they come with its description.
    ///
    /// Ages are those beyond which an input counts as missing: since a request or odometry arrived,
    /// and since a scan was captured, by the guard's own clock; in lockstep all of them in run time.
    #[derive(Copy)]
    pub struct GuardConfig {
        /// Age at which a request counts as lost. Must exceed two control periods, or one lost
        /// request stops the robot.
        request_age_s: f64 = 0.1, [f64::MIN_POSITIVE, 1.0e3] "s";
        /// Age at which a scan counts as lost. Must exceed the scan period.
        scan_age_s: f64 = 0.35, [f64::MIN_POSITIVE, 1.0e3] "s";
        /// Age at which odometry counts as lost. Must exceed two control periods.
        odometry_age_s: f64 = 0.1, [f64::MIN_POSITIVE, 1.0e3] "s";
        /// Longest time for which a command is obeyed before braking begins: one control period,
        /// transport and the drives.
        reaction_s: f64 = 0.08, [0.0, 2.0] "s";
        /// Distance that stays free around the footprint; at least half the distance of the checked
        /// poses, or something could be touched between two of them.
        margin_m: f64 = 0.01, [0.5 * SPACING_M, 1.0] "m";
        /// Distance beyond the margin within which the robot is slow; 0 = nowhere.
        slow_zone_m: f64 = 0.01, [0.0, 2.0] "m";
        /// Speed of the outline's fastest point in the slow zone.
        slow_mps: f64 = 0.5, [0.01, 100.0] "m/s";
        /// Distance driven while all ranges stay bitwise the same after which the lidar counts as
        /// frozen. A lidar without any noise in an endless straight corridor would be mistaken for
        /// one.
        frozen_m: f64 = 0.1, [0.01, 1.0e3] "m";
        /// Angle turned while all ranges stay bitwise the same after which the lidar counts as
        /// frozen.
        frozen_rad: f64 = 0.2, [0.01, 1.0e3] "rad";
    }
}

impl GuardConfig {
    /// Accepts ages that normal operation does not exceed: more than two control periods for
    /// requests and odometry, more than one scan period for scans.
    ///
    /// # Errors
    /// The first parameter that is wrong.
    pub fn check(&self, period_s: f64, scan_period_s: f64) -> Result<(), ParameterError> {
        zeronav_params::check(self)?;
        for (path, value_s, least_s, what) in [
            (
                "request_age_s",
                self.request_age_s,
                2.0 * period_s,
                "two control periods",
            ),
            (
                "scan_age_s",
                self.scan_age_s,
                scan_period_s,
                "the time from scan to scan",
            ),
            (
                "odometry_age_s",
                self.odometry_age_s,
                2.0 * period_s,
                "two control periods",
            ),
        ] {
            if value_s <= least_s {
                return Err(ParameterError::too_short((path, value_s), (what, least_s)));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The complaint about the defaults after `change`, with ticks of 20 ms and 10 scans a second.
    fn complaint(change: impl FnOnce(&mut GuardConfig)) -> String {
        let mut config = GuardConfig::default();
        change(&mut config);
        config
            .check(0.02, 0.1)
            .map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn the_defaults_suit_50_hz_and_a_5_hz_lidar() {
        assert_eq!(GuardConfig::default().check(0.02, 0.2), Ok(()));
    }

    #[test]
    fn ages_within_two_periods_are_rejected() {
        assert_eq!(
            complaint(|config| config.request_age_s = 0.04),
            "request_age_s must exceed two control periods, 0.04 s (0.07 would do), not 0.04"
        );
        assert_eq!(
            complaint(|config| config.scan_age_s = f64::NAN),
            "scan_age_s must be a number above 0, at most 1000, not NaN"
        );
    }

    #[test]
    fn margins_that_prove_nothing_are_rejected() {
        assert_eq!(
            complaint(|config| config.margin_m = 0.009),
            "margin_m must be a number from 0.01 to 1, not 0.009"
        );
    }
}
