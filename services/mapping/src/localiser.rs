//! `map_from_odom`: what odometry has drifted away by.

use crate::config::{MappingError, ensure};
use crate::scan_match::Surfaces;
use nalgebra::{Matrix3, Point2, Vector3};
use serde::{Deserialize, Serialize};
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;

/// Whether the pose is corrected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CorrectionMode {
    /// When odometry says of itself that it is not exact: a variance above 0.
    #[default]
    Auto,
    /// Always.
    On,
    /// Never: `odom` is `map`.
    Off,
}

/// How the pose is corrected, and how far odometry is trusted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CorrectionConfig {
    /// Whether.
    pub mode: CorrectionMode,
    /// [m/sqrt(m)] standard deviation of the place after 1 m.
    pub noise_m_per_sqrt_m: f64,
    /// [rad/sqrt(rad)] standard deviation of the yaw after a turn of 1 rad.
    pub noise_rad_per_sqrt_rad: f64,
    /// [rad/sqrt(m)] standard deviation of the yaw after 1 m.
    pub noise_rad_per_sqrt_m: f64,
}

impl Default for CorrectionConfig {
    fn default() -> Self {
        Self {
            mode: CorrectionMode::Auto,
            noise_m_per_sqrt_m: 0.03,
            noise_rad_per_sqrt_rad: 0.04,
            noise_rad_per_sqrt_m: 0.02,
        }
    }
}

impl CorrectionConfig {
    /// Accepts noise that can be.
    ///
    /// # Errors
    /// [`MappingError::OutOfRange`].
    pub fn check(&self) -> Result<(), MappingError> {
        for (field, value) in [
            (
                "pose_correction.noise_m_per_sqrt_m",
                self.noise_m_per_sqrt_m,
            ),
            (
                "pose_correction.noise_rad_per_sqrt_rad",
                self.noise_rad_per_sqrt_rad,
            ),
            (
                "pose_correction.noise_rad_per_sqrt_m",
                self.noise_rad_per_sqrt_m,
            ),
        ] {
            ensure((0.0..=1.0).contains(&value), field, value, "must be 0 to 1")?;
        }
        Ok(())
    }
}

/// Least standard deviations of the pose, for what neither scan nor map can tell. [m, rad]
const FLOOR: (f64, f64) = (0.005, 0.002);

/// Largest standard deviations: a robot that has been lost for long is not lost everywhere.
const CEILING: (f64, f64) = (0.5, 0.2);

/// Keeps `map_from_odom` right.
#[derive(Debug)]
pub struct Localiser {
    config: CorrectionConfig,
    map_from_odom: Pose,
    covariance: Matrix3<f64>,
    last_odom_from_base: Option<Pose>,
    active: bool,
}

impl Localiser {
    /// `odom` is `map`.
    #[must_use]
    pub fn new(config: &CorrectionConfig) -> Self {
        Self {
            config: *config,
            map_from_odom: Pose::default(),
            covariance: Matrix3::zeros(),
            last_odom_from_base: None,
            active: false,
        }
    }

    /// True when the pose is corrected, given the variances that odometry states of itself.
    pub fn is_active(&mut self, odometry_variance: &[f64; 3]) -> bool {
        self.active = match self.config.mode {
            CorrectionMode::Off => false,
            CorrectionMode::On => true,
            CorrectionMode::Auto => {
                self.active || odometry_variance.iter().any(|variance| *variance > 0.0)
            }
        };
        self.active
    }

    /// `map_from_odom`.
    #[must_use]
    pub fn map_from_odom(&self) -> Pose {
        self.map_from_odom
    }

    /// `map_from_base`; exactly `odom_from_base` as long as nothing was corrected.
    #[must_use]
    pub fn map_from_base(&self, odom_from_base: &Pose) -> Pose {
        if self.map_from_odom == Pose::default() {
            *odom_from_base
        } else {
            self.map_from_odom.then(odom_from_base)
        }
    }

    /// Covariance of the robot's pose in the map, upper triangle by rows. [m, m, rad]
    #[must_use]
    pub fn covariance(&self) -> [f64; 6] {
        let c = &self.covariance;
        [
            c[(0, 0)],
            c[(0, 1)],
            c[(0, 2)],
            c[(1, 1)],
            c[(1, 2)],
            c[(2, 2)],
        ]
    }

    /// Takes in where odometry says the robot is, and where beams ended that are on what stands, in
    /// `base`. [m]
    pub fn correct(&mut self, odom_from_base: &Pose, ends: &[Point2<f64>], surfaces: &Surfaces) {
        let predicted = self.predict(odom_from_base);
        if let Some(matched) = surfaces.lay(ends, &predicted, &self.covariance) {
            self.covariance = matched.covariance;
            self.limit();
            let base_from_odom = odom_from_base.isometry().inverse();
            let map_from_odom = matched.pose.isometry() * base_from_odom;
            self.map_from_odom = Pose::from(map_from_odom);
        }
    }

    /// Where odometry says the robot is now, with what that is worth.
    fn predict(&mut self, odom_from_base: &Pose) -> Pose {
        let predicted = self.map_from_odom.then(odom_from_base);
        let last = self.last_odom_from_base.replace(*odom_from_base);
        let last = last.unwrap_or(*odom_from_base);
        let length_m = last.distance_m(odom_from_base);
        let turn_rad = wrap_angle(odom_from_base.yaw_rad - last.yaw_rad).abs();
        let came = predicted.point() - self.map_from_odom.then(&last).point();
        // A wrong yaw swings the step's end around its beginning.
        let mut step = Matrix3::identity();
        step[(0, 2)] = -came.y;
        step[(1, 2)] = came.x;
        let config = &self.config;
        let place = config.noise_m_per_sqrt_m.powi(2) * length_m;
        let yaw = config.noise_rad_per_sqrt_rad.powi(2) * turn_rad
            + config.noise_rad_per_sqrt_m.powi(2) * length_m;
        self.covariance = step * self.covariance * step.transpose()
            + Matrix3::from_diagonal(&Vector3::new(place, place, yaw));
        self.limit();
        predicted
    }

    /// Keeps the covariance between floor and ceiling.
    fn limit(&mut self) {
        for (axis, (low, high)) in [
            (FLOOR.0, CEILING.0),
            (FLOOR.0, CEILING.0),
            (FLOOR.1, CEILING.1),
        ]
        .into_iter()
        .enumerate()
        {
            let variance = self.covariance[(axis, axis)];
            if variance < low * low {
                self.covariance[(axis, axis)] = low * low;
            } else if variance > high * high {
                let shrink = high / variance.sqrt();
                for other in 0..3 {
                    self.covariance[(axis, other)] *= shrink;
                    self.covariance[(other, axis)] *= shrink;
                }
            }
        }
    }
}
