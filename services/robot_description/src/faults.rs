//! Faults of a simulated robot by script: what breaks, when, and for how long.
//!
//! ```
//! use zeronav_robot_description::FaultSpec;
//! #[derive(serde::Deserialize)]
//! struct Robot {
//!     faults: Vec<FaultSpec>,
//! }
//! let robot: Robot = toml::from_str(
//!     r#"
//!     [[faults]]
//!     kind = "lidar_blackout"
//!     begins = { driven_m = 4.0 }
//!     lasts_s = 2.0
//!
//!     [[faults]]
//!     kind = "odometry_jump"
//!     begins = { at_s = 6.0 }
//!     shift = [0.3, 0.0, 0.1]
//!     "#,
//! )
//! .unwrap();
//! assert!(robot.faults.iter().all(|fault| fault.check().is_ok()));
//! ```

use core::f64::consts::PI;
use serde::{Deserialize, Serialize};
use zeronav_world::error::{SpecError, number};

/// Most faults of one robot.
pub(crate) const FAULTS_MAX: usize = 64;

/// Longest time that a fault may wait or last. [s]
const TIME_S_MAX: f64 = 1.0e6;

/// One fault. Those that last may overlap; no service knows of them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum FaultSpec {
    /// The lidar sees nothing.
    LidarBlackout {
        /// When it begins.
        begins: Begin,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
        /// What its readers get.
        #[serde(default)]
        looks: Blackout,
    },
    /// The lidar sends the ranges of its last scan again and again, with the time of now.
    LidarFrozen {
        /// When it begins.
        begins: Begin,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
    },
    /// The lidar is turned in its mount, which its readers do not know.
    LidarTurned {
        /// When it begins.
        begins: Begin,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
        /// By how much, counter-clockwise, -pi to pi. [rad]
        angle_rad: f64,
    },
    /// Odometry says at once that the robot has moved. Its variances do not know.
    OdometryJump {
        /// When.
        begins: Begin,
        /// `[x, y, yaw]` in `base`. [m, m, rad]
        shift: [f64; 3],
    },
    /// The floor is slippery: this share of the motion that the robot's own slip leaves is lost.
    Slip {
        /// When it begins.
        begins: Begin,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
        /// Share of the forward motion that is lost, 0 to 1 (the wheels spin on the spot).
        #[serde(default)]
        forward_ratio: f64,
        /// Share of the turning that is lost, 0 to 1.
        #[serde(default)]
        turn_ratio: f64,
    },
}

/// When a fault begins. Exactly one of the two.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Begin {
    /// Run time. [s]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_s: Option<f64>,
    /// Distance that the robot has really driven. [m]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub driven_m: Option<f64>,
}

/// How a lidar that sees nothing looks to its readers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Blackout {
    /// There are no scans.
    #[default]
    Silent,
    /// Scans in which nothing came back: +inf.
    NoReturn,
    /// Scans in which every beam is wrong: NaN.
    Invalid,
}

impl FaultSpec {
    /// When it begins.
    #[must_use]
    pub const fn begins(&self) -> Begin {
        match self {
            Self::LidarBlackout { begins, .. }
            | Self::LidarFrozen { begins, .. }
            | Self::LidarTurned { begins, .. }
            | Self::OdometryJump { begins, .. }
            | Self::Slip { begins, .. } => *begins,
        }
    }

    /// How long it lasts; `None`: to the end, or no time at all for a jump. [s]
    #[must_use]
    pub const fn lasts_s(&self) -> Option<f64> {
        match self {
            Self::LidarBlackout { lasts_s, .. }
            | Self::LidarFrozen { lasts_s, .. }
            | Self::LidarTurned { lasts_s, .. }
            | Self::Slip { lasts_s, .. } => *lasts_s,
            Self::OdometryJump { .. } => None,
        }
    }

    /// Wheels and ground do not agree while it lasts, or odometry does not say what the wheels do.
    #[must_use]
    pub const fn misleads_odometry(&self) -> bool {
        matches!(self, Self::OdometryJump { .. } | Self::Slip { .. })
    }

    /// Accepts faults that can happen.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), SpecError> {
        self.begins()
            .check()
            .map_err(|error| error.within("begins"))?;
        if let Some(lasts_s) = self.lasts_s() {
            number(lasts_s, 1.0e-3, TIME_S_MAX, "lasts_s")?;
        }
        match self {
            Self::LidarBlackout { .. } | Self::LidarFrozen { .. } => Ok(()),
            Self::LidarTurned { angle_rad, .. } => number(*angle_rad, -PI, PI, "angle_rad"),
            Self::OdometryJump { shift, .. } => {
                number(shift[0], -100.0, 100.0, "shift[0]")?;
                number(shift[1], -100.0, 100.0, "shift[1]")?;
                number(shift[2], -PI, PI, "shift[2]")
            }
            Self::Slip {
                forward_ratio,
                turn_ratio,
                ..
            } => {
                number(*forward_ratio, 0.0, 1.0, "forward_ratio")?;
                number(*turn_ratio, 0.0, 1.0, "turn_ratio")
            }
        }
    }
}

impl Begin {
    /// At a run time. [s]
    #[must_use]
    pub const fn at(at_s: f64) -> Self {
        Self {
            at_s: Some(at_s),
            driven_m: None,
        }
    }

    /// After a distance driven. [m]
    #[must_use]
    pub const fn after(driven_m: f64) -> Self {
        Self {
            at_s: None,
            driven_m: Some(driven_m),
        }
    }

    fn check(&self) -> Result<(), SpecError> {
        match (self.at_s, self.driven_m) {
            (Some(at_s), None) => number(at_s, 0.0, TIME_S_MAX, "at_s"),
            (None, Some(driven_m)) => number(driven_m, 0.0, 1.0e6, "driven_m"),
            (Some(_), Some(_)) => Err(SpecError::new(
                "",
                "has both at_s and driven_m, give exactly one",
            )),
            (None, None) => Err(SpecError::new(
                "",
                "has neither at_s nor driven_m, give exactly one",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn refused(field: &str, text: &str) {
        let fault: FaultSpec = toml::from_str(text).expect("the words of a fault");
        assert_eq!(fault.check().unwrap_err().field, field);
    }

    #[test]
    fn every_number_is_looked_at() {
        refused("begins", "kind = 'lidar_frozen'\nbegins = {}");
        refused(
            "begins",
            "kind = 'lidar_frozen'\nbegins = { at_s = 1.0, driven_m = 1.0 }",
        );
        refused(
            "begins.driven_m",
            "kind = 'lidar_frozen'\nbegins = { driven_m = nan }",
        );
        refused(
            "lasts_s",
            "kind = 'lidar_blackout'\nbegins = { at_s = 1.0 }\nlasts_s = 0.0",
        );
        refused(
            "angle_rad",
            "kind = 'lidar_turned'\nbegins = { at_s = 1.0 }\nangle_rad = 4.0",
        );
        refused(
            "shift[2]",
            "kind = 'odometry_jump'\nbegins = { at_s = 1.0 }\nshift = [1.0, 1.0, inf]",
        );
        refused(
            "turn_ratio",
            "kind = 'slip'\nbegins = { at_s = 1.0 }\nturn_ratio = 1.1",
        );
    }

    #[test]
    fn a_word_that_is_not_its_own_is_refused() {
        for text in [
            "kind = 'lidar_frozen'\nbegins = { at_s = 1.0 }\nangle_rad = 1.0",
            "kind = 'odometry_jump'\nbegins = { at_s = 1.0 }\nshift = [0, 0, 0]\nlasts_s = 1.0",
            "kind = 'lidar_frozen'",
            "kind = 'lidar_melted'\nbegins = { at_s = 1.0 }",
        ] {
            assert!(toml::from_str::<FaultSpec>(text).is_err(), "{text}");
        }
    }
}
