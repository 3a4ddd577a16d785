//! How fast the robot may go by what it knows, given how old that is.

use crate::config::StalenessConfig;

/// Ages of the inputs; `None` = never received. [ns]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Ages {
    /// Of the scan since its capture.
    pub scan_ns: Option<u64>,
    /// Of odometry since its capture.
    pub odometry_ns: Option<u64>,
    /// Of the map since the scan that it is current as of.
    pub map_ns: Option<u64>,
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
    /// The map.
    Map,
    /// The path.
    Path,
}

/// Share of the fastest speed that `ages` allow: 1 while every input is young, falling linearly
/// to `slow_to` over the last part of an age.
///
/// # Errors
/// The first input whose age is beyond its limit: the robot must stop.
pub fn speed_factor(ages: &Ages, config: &StalenessConfig) -> Result<f64, StaleInput> {
    let mut factor = 1.0_f64;
    for (input, age_ns, limit_s) in [
        (
            StaleInput::Odometry,
            ages.odometry_ns,
            config.odometry_age_s,
        ),
        (StaleInput::Scan, ages.scan_ns, config.scan_age_s),
        (StaleInput::Map, ages.map_ns, config.map_age_s),
        (StaleInput::Path, ages.path_ns, config.path_age_s),
    ] {
        let share = nanoseconds(age_ns.ok_or(input)?) / (limit_s * 1.0e9);
        if share > 1.0 {
            return Err(input);
        }
        if share > config.slow_from {
            let late = (share - config.slow_from) / (1.0 - config.slow_from);
            factor = factor.min(1.0 - late * (1.0 - config.slow_to));
        }
    }
    Ok(factor)
}

#[allow(
    clippy::cast_precision_loss,
    reason = "ages are compared with tenths of seconds"
)]
fn nanoseconds(ns: u64) -> f64 {
    ns as f64
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
