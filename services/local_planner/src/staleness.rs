//! How fast the robot may go by what it knows, given how old that is.

use zeronav_casts::Cast;
use zeronav_params::{ParameterError, parameters};

parameters! {
    /// How old inputs may be. Within the last part of an age the robot slows down, beyond it stops.
    #[derive(Copy)]
    pub struct StalenessConfig {
        /// Age of a scan since its capture.
        scan_age_s: f64 = 0.35, [0.01, 10.0] "s";
        /// Age of odometry since its capture.
        odometry_age_s: f64 = 0.1, [0.01, 10.0] "s";
        /// Age of the map and of the tracked obstacles, the older of both, since the scan that they are
        /// current as of.
        map_age_s: f64 = 1.0, [0.01, 60.0] "s";
        /// Age of the path since it was last confirmed.
        path_age_s: f64 = 1.5, [0.01, 60.0] "s";
    }
}

impl StalenessConfig {
    /// Accepts ages that what is made from scans does not reach between two of them: else the robot would
    /// stop before every scan.
    ///
    /// # Errors
    /// The first age that is too short.
    pub fn check(&self, scan_period_s: f64) -> Result<(), ParameterError> {
        let what = "the time from scan to scan";
        for (path, age_s) in [
            ("staleness.scan_age_s", self.scan_age_s),
            ("staleness.map_age_s", self.map_age_s),
            ("staleness.path_age_s", self.path_age_s),
        ] {
            if age_s <= scan_period_s {
                return Err(ParameterError::too_short(
                    (path, age_s),
                    (what, scan_period_s),
                ));
            }
        }
        Ok(())
    }
}

/// Share of an age from which on the robot slows down.
const SLOW_FROM: f64 = 0.7;

/// Share of the speed that is left just before the age ends.
const SLOW_TO: f64 = 0.3;

/// Ages of the inputs; `None` = never received. [ns]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Ages {
    /// Of the scan since its capture.
    pub scan_ns: Option<u64>,
    /// Of odometry since its capture.
    pub odometry_ns: Option<u64>,
    /// Of the map since the scan that it is current as of.
    pub map_ns: Option<u64>,
    /// Of the tracked obstacles, likewise. Who does not know what moves has an old map.
    pub obstacles_ns: Option<u64>,
    /// Of the path since it was last confirmed.
    pub path_ns: Option<u64>,
}

/// The input that is too old or missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StaleInput {
    /// Odometry.
    Odometry,
    /// The scan.
    Scan,
    /// The map, or what moves in it.
    Map,
    /// The path.
    Path,
    /// The pose: the robot does not know where it is.
    Pose,
}

/// Which inputs are so old that the robot slows down or stops; for its health.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Ageing([bool; 4]);

impl Ageing {
    /// True when it is this one, too.
    #[must_use]
    pub fn includes(self, input: StaleInput) -> bool {
        INPUTS
            .iter()
            .zip(self.0)
            .any(|(known, old)| old && *known == input)
    }

    /// The first of them, in the order in which they are reported.
    pub(crate) fn first(self) -> Option<StaleInput> {
        let mut old = INPUTS.iter().zip(self.0).filter(|(_, old)| *old);
        old.next().map(|(input, _)| *input)
    }

    /// True when it is any.
    #[must_use]
    pub fn any(self) -> bool {
        self.0.contains(&true)
    }
}

/// In the order in which they are reported.
const INPUTS: [StaleInput; 4] = [
    StaleInput::Odometry,
    StaleInput::Scan,
    StaleInput::Map,
    StaleInput::Path,
];

impl Ages {
    /// Age of the older one of the map and of what moves in it; `None` = one never came. [ns]
    pub(crate) fn oldest_of_map_ns(&self) -> Option<u64> {
        Some(self.map_ns?.max(self.obstacles_ns?))
    }
}

/// Ages as shares of their limits, in the order of [`INPUTS`]; `None` = never received.
fn shares(ages: &Ages, config: &StalenessConfig) -> [Option<f64>; 4] {
    [
        (ages.odometry_ns, config.odometry_age_s),
        (ages.scan_ns, config.scan_age_s),
        (ages.oldest_of_map_ns(), config.map_age_s),
        (ages.path_ns, config.path_age_s),
    ]
    .map(|(age_ns, limit_s)| Some(nanoseconds(age_ns?) / (limit_s * 1.0e9)))
}

/// The inputs that came once and are old enough for the robot to slow down.
#[must_use]
pub fn ageing(ages: &Ages, config: &StalenessConfig) -> Ageing {
    Ageing(shares(ages, config).map(|share| share.is_some_and(|share| share > SLOW_FROM)))
}

/// Share of the fastest speed that `ages` allow: 1 while every input is young, falling linearly
/// to 0.3 over the last part of an age.
///
/// # Errors
/// The first input whose age is beyond its limit: the robot must stop.
pub fn speed_factor(ages: &Ages, config: &StalenessConfig) -> Result<f64, StaleInput> {
    let mut factor = 1.0_f64;
    for (input, share) in INPUTS.into_iter().zip(shares(ages, config)) {
        let share = share.ok_or(input)?;
        if share > 1.0 {
            return Err(input);
        }
        if share > SLOW_FROM {
            let late = (share - SLOW_FROM) / (1.0 - SLOW_FROM);
            factor = factor.min(1.0 - late * (1.0 - SLOW_TO));
        }
    }
    Ok(factor)
}

fn nanoseconds(ns: u64) -> f64 {
    ns.to_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn young() -> Ages {
        Ages {
            scan_ns: Some(50 * MS),
            odometry_ns: Some(5 * MS),
            map_ns: Some(60 * MS),
            obstacles_ns: Some(60 * MS),
            path_ns: Some(80 * MS),
        }
    }

    #[track_caller]
    fn check(ages: Ages, expected: Result<f64, StaleInput>) {
        let found = speed_factor(&ages, &StalenessConfig::default());
        match (found, expected) {
            (Ok(found), Ok(expected)) => assert!((found - expected).abs() < 1e-9, "{found}"),
            (found, expected) => assert_eq!(found, expected),
        }
    }

    #[test]
    fn young_inputs_allow_everything() {
        check(young(), Ok(1.0));
    }

    #[test]
    fn ageing_inputs_slow_down_and_old_ones_stop() {
        let scan = |ms| Ages {
            scan_ns: Some(ms * MS),
            ..young()
        };
        check(scan(245), Ok(1.0));
        check(scan(350), Ok(0.3));
        check(scan(351), Err(StaleInput::Scan));
        let odometry_ns = Some(101 * MS);
        check(
            Ages {
                odometry_ns,
                ..young()
            },
            Err(StaleInput::Odometry),
        );
        let map_ns = Some(1001 * MS);
        check(Ages { map_ns, ..young() }, Err(StaleInput::Map));
        let path_ns = Some(1501 * MS);
        check(Ages { path_ns, ..young() }, Err(StaleInput::Path));
    }

    #[test]
    fn each_of_the_four_slows_then_stops_and_is_named_all_along() {
        let config = StalenessConfig::default();
        for (input, limit_s) in [
            (StaleInput::Odometry, config.odometry_age_s),
            (StaleInput::Scan, config.scan_age_s),
            (StaleInput::Map, config.map_age_s),
            (StaleInput::Path, config.path_age_s),
        ] {
            let at = |share: f64| {
                let age = Some((share * limit_s * 1.0e9).to_u64());
                let mut ages = young();
                match input {
                    StaleInput::Odometry => ages.odometry_ns = age,
                    StaleInput::Scan => ages.scan_ns = age,
                    StaleInput::Map => ages.map_ns = age,
                    StaleInput::Path => ages.path_ns = age,
                    StaleInput::Pose => unreachable!("a pose has no age"),
                }
                ages
            };
            assert_eq!(ageing(&at(0.69), &config), Ageing::default());
            check(at(0.69), Ok(1.0));
            let mut last = 1.0;
            for percent in [72, 80, 90, 99] {
                let ages = at(f64::from(percent) / 100.0);
                let factor = speed_factor(&ages, &config).expect("not stale yet");
                assert!(factor < last && factor > SLOW_TO - 1e-9, "{input:?}");
                last = factor;
                let old = ageing(&ages, &config);
                assert!(old.includes(input) && old.any());
                for other in INPUTS.into_iter().filter(|other| *other != input) {
                    assert!(!old.includes(other), "{other:?} beside {input:?}");
                }
            }
            check(at(1.01), Err(input));
            assert!(ageing(&at(1.01), &config).includes(input));
        }
    }

    #[test]
    fn who_does_not_know_what_moves_has_an_old_map() {
        let since = |ms| Ages {
            obstacles_ns: Some(ms * MS),
            ..young()
        };
        check(since(700), Ok(1.0));
        check(since(850), Ok(0.65));
        check(since(1001), Err(StaleInput::Map));
        assert!(ageing(&since(850), &StalenessConfig::default()).includes(StaleInput::Map));
        let never = Ages {
            obstacles_ns: None,
            ..young()
        };
        check(never, Err(StaleInput::Map));
    }

    #[test]
    fn missing_inputs_stop() {
        check(Ages::default(), Err(StaleInput::Odometry));
        check(
            Ages {
                map_ns: None,
                ..young()
            },
            Err(StaleInput::Map),
        );
    }
}
