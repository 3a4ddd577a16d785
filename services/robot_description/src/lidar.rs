//! The lidar: where it sits, what it sees, and its noise.

use crate::field::{Missing, described, plain};
use crate::{RATE_MAX, RATE_MIN};
use core::f64::consts::{PI, TAU};
use zeronav_msgs::scan::BEAMS_MAX;
use zeronav_params::choices;
use zeronav_world::{SpecError, error::number};

/// Field of view of a lidar that looks all around, with some room for rounding. [rad]
const FOV_RAD_MAX: f64 = TAU + 1.0e-6;

#[allow(clippy::cast_possible_truncation, reason = "a few thousand")]
const N_BEAMS_MAX: u32 = BEAMS_MAX as u32;

described! {
    /// A planar lidar. Noise is laid over the exact ranges in the order of the fields from
    /// `motion_distortion` on.
    pub struct LidarSpec from LidarWords with preset LidarPreset {
        /// `base_from_laser` as `[x, y, yaw]`.
        pose: [f64; 3] = [0.0; 3], [-100.0, 100.0] "m, m, rad";
        /// Beams of a turn.
        n_beams: u32, [2, N_BEAMS_MAX];
        /// Field of view, 2 pi = all around. Beams lie evenly in it; all around, the last beam is
        /// one step before the first.
        fov_rad: f64 = TAU, [1.0e-3, FOV_RAD_MAX] "rad";
        /// Turns per second.
        rate_hz: f64, [0.1, RATE_MAX] "Hz";
        /// Closest range.
        range_m_min: f64, [0.0, RATE_MAX] "m";
        /// Farthest range.
        range_m_max: f64, [0.01, RATE_MAX] "m";
        /// Beams are taken one after the other while the mirror turns and robot and obstacles move;
        /// the scan is captured with its last beam. Otherwise all at once.
        motion_distortion: bool = false;
        /// Standard deviation of a range.
        sigma_m: f64 = 0.0, [0.0, 10.0] "m";
        /// The same as a share of the range; the larger of the two counts.
        sigma_ratio: f64 = 0.0, [0.0, 1.0];
        /// Step of the ranges, 0 = none.
        quantum_m: f64 = 0.0, [0.0, 1.0] "m";
        /// Share of the returns that get lost.
        dropout_ratio: f64 = 0.0, [0.0, 1.0];
        /// What a lost return looks like.
        dropout_as: Dropout = Dropout::NoReturn;
        /// Share of the returns that come from something nearer (dust, rain, a fly).
        short_ratio: f64 = 0.0, [0.0, 1.0];
        /// Mean range of such a return; they are exponential up to the true range.
        short_mean_m: f64 = 0.5, [RATE_MIN, RATE_MAX] "m";
        /// Share of the beams beside an edge that hit both sides of it and give a range between.
        edge_ratio: f64 = 0.0, [0.0, 1.0];
    }
}

choices! {
    /// What a lost return looks like in a scan.
    pub enum Dropout {
        /// +inf: nothing came back.
        #[default]
        NoReturn = "no_return",
        /// NaN: something was wrong.
        Invalid = "invalid",
    }
}

plain!(Dropout);

impl LidarWords {
    /// The words for all of `lidar`.
    pub(crate) fn of(lidar: LidarSpec) -> Self {
        Self {
            start: Some(lidar),
            ..Self::default()
        }
    }

    /// The lidar: these words, then its preset, then `mounted`, the one that the robot's preset
    /// carries. A preset of its own sits where the robot's sat.
    fn on(self, mounted: Option<LidarSpec>) -> Result<LidarSpec, Missing> {
        let place = mounted.as_ref().map(|it| it.pose);
        let preset = self.preset.map(LidarPreset::lidar).map(|preset| LidarSpec {
            pose: place.unwrap_or(preset.pose),
            ..preset
        });
        self.over(preset.or(mounted))
    }
}

impl LidarSpec {
    /// A lidar without any noise that looks all around from the middle of the robot.
    ///
    /// # Panics
    /// Never: every field that has no default is given.
    #[must_use]
    pub fn exact(n_beams: u32, rate_hz: f64, range_m: core::ops::Range<f64>) -> Self {
        let words = LidarWords {
            n_beams: Some(n_beams),
            rate_hz: Some(rate_hz),
            range_m_min: Some(range_m.start),
            range_m_max: Some(range_m.end),
            ..LidarWords::default()
        };
        words.over(None).expect("every other field has a default")
    }

    /// Direction of beam 0 and the step from beam to beam, counter-clockwise. [rad] `laser`
    /// frame. The field of view is centred on +x; all around, the last beam is one step before
    /// the first.
    #[must_use]
    pub fn directions_rad(&self) -> (f64, f64) {
        let n_beams = f64::from(self.n_beams);
        if self.fov_rad >= TAU - 1.0e-6 {
            (-PI, TAU / n_beams)
        } else {
            (-self.fov_rad / 2.0, self.fov_rad / (n_beams - 1.0).max(1.0))
        }
    }

    /// Accepts what ranges alone do not say: that the numbers fit each other.
    pub(crate) fn check(&self) -> Result<(), SpecError> {
        number(self.pose[2], -TAU, TAU, "pose[2]")?;
        let (_, step_rad) = self.directions_rad();
        if !(1.0e-5..=1.6).contains(&step_rad) {
            let why = format!("beams lie {step_rad:.6} rad apart, must be 0.00001 to 1.6 rad");
            return Err(SpecError::new("n_beams", why));
        }
        // The robot drives forward, and stops for what it sees.
        let half_rad = 0.5 * self.fov_rad;
        let aside_rad = zeronav_msgs::pose::wrap_angle(self.pose[2]).abs();
        if aside_rad > half_rad && self.fov_rad < TAU - 1.0e-6 {
            let why = format!(
                "the lidar looks {half_rad:.3} rad to either side of its yaw and does not see straight \
                 ahead of the robot: a yaw within {half_rad:.3} of 0 would do, or a fov_rad of {:.3}",
                2.0 * aside_rad
            );
            return Err(SpecError::new("pose[2]", why));
        }
        if self.range_m_min >= self.range_m_max {
            let why = format!("must be below range_m_max {}", self.range_m_max);
            return Err(SpecError::new("range_m_min", why));
        }
        Ok(())
    }

    /// Time from beam to beam, 0 when all are taken at once. [s] The mirror turns evenly, also
    /// where it sees nothing.
    #[must_use]
    pub fn beam_period_s(&self) -> f64 {
        if self.motion_distortion {
            self.directions_rad().1 / (TAU * self.rate_hz)
        } else {
            0.0
        }
    }
}

// From data sheets, whose accuracies are taken as three standard deviations. Dropouts and short
// returns are in no data sheet: they are typical values, to be replaced by measured ones.
choices! {
    /// A lidar by name.
    pub enum LidarPreset {
        /// Slamtec `RPLidar` A1M8 at 5.5 turns a second.
        RplidarA1 = "rplidar_a1",
        /// Hokuyo UST-10LX.
        Ust10lx = "ust_10lx",
        /// Hokuyo UTM-30LX.
        Utm30lx = "utm_30lx",
        /// LDS-01 of the `TurtleBot3`.
        Lds01 = "lds_01",
    }
}

impl LidarPreset {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::RplidarA1, Self::Ust10lx, Self::Utm30lx, Self::Lds01];

    /// Its numbers, in the middle of the robot.
    #[must_use]
    pub fn lidar(self) -> LidarSpec {
        let hokuyo_rad = 270.0_f64.to_radians();
        match self {
            // Slamtec data sheet LD108: 0.15 to 12 m on white, 1 degree at 5.5 Hz, below 1 % of
            // the distance; distances in quarters of a millimetre.
            Self::RplidarA1 => LidarSpec {
                motion_distortion: true,
                sigma_m: 0.005,
                sigma_ratio: 0.01 / 3.0,
                quantum_m: 0.000_25,
                dropout_ratio: 0.01,
                short_ratio: 0.001,
                edge_ratio: 0.3,
                ..LidarSpec::exact(360, 5.5, 0.15..12.0)
            },
            // Hokuyo UST-10LX: 270 degrees in steps of 0.25, 25 ms, 0.06 to 10 m, +-40 mm.
            Self::Ust10lx => LidarSpec {
                fov_rad: hokuyo_rad,
                motion_distortion: true,
                sigma_m: 0.040 / 3.0,
                quantum_m: 0.001,
                dropout_ratio: 0.005,
                short_ratio: 0.000_5,
                edge_ratio: 0.3,
                ..LidarSpec::exact(1081, 40.0, 0.06..10.0)
            },
            // Hokuyo UTM-30LX: 270 degrees in steps of 0.25, 25 ms, 0.1 to 30 m, +-30 mm up to
            // 10 m and +-50 mm beyond.
            Self::Utm30lx => LidarSpec {
                fov_rad: hokuyo_rad,
                motion_distortion: true,
                sigma_m: 0.010,
                sigma_ratio: 0.050 / 3.0 / 30.0,
                quantum_m: 0.001,
                dropout_ratio: 0.005,
                short_ratio: 0.000_5,
                edge_ratio: 0.3,
                ..LidarSpec::exact(1081, 40.0, 0.1..30.0)
            },
            // Robotis LDS-01: 1 degree, 300 rpm, 0.12 to 3.5 m, +-15 mm up to 0.5 m and +-5 %
            // beyond.
            Self::Lds01 => LidarSpec {
                motion_distortion: true,
                sigma_m: 0.005,
                sigma_ratio: 0.05 / 3.0,
                quantum_m: 0.001,
                dropout_ratio: 0.01,
                dropout_as: Dropout::NoReturn,
                short_ratio: 0.001,
                edge_ratio: 0.3,
                ..LidarSpec::exact(360, 5.0, 0.12..3.5)
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lidar() -> LidarSpec {
        LidarSpec::exact(360, 10.0, 0.1..12.0)
    }

    #[test]
    fn a_mirror_takes_its_beams_one_after_the_other() {
        let mut lidar = lidar();
        assert!(lidar.beam_period_s().abs() < 1e-15);
        lidar.motion_distortion = true;
        assert!((lidar.beam_period_s() * 360.0 - 0.1).abs() < 1e-12);
        // A quarter of the turn sees nothing.
        lidar.n_beams = 271;
        lidar.fov_rad = 1.5 * PI;
        assert!((lidar.beam_period_s() * 270.0 - 0.075).abs() < 1e-12);
    }

    #[test]
    fn beams_are_spread_over_the_field_of_view() {
        let mut lidar = lidar();
        lidar.n_beams = 4;
        let (first, step) = lidar.directions_rad();
        assert!((first + PI).abs() < 1e-12 && (step - PI / 2.0).abs() < 1e-12);
        lidar.n_beams = 181;
        lidar.fov_rad = PI;
        let (first, step) = lidar.directions_rad();
        assert!((first + PI / 2.0).abs() < 1e-12 && (step - PI / 180.0).abs() < 1e-12);
    }
}
