//! The words of a scenario for the robot and its lidar. Metres, radians, seconds.
//!
//! A robot and a lidar may start from a preset ([`crate::preset`]); every field that is given
//! replaces the preset's, and without a preset those without a default must be given. What has
//! been read has no preset any more: it is written with all its numbers.
//!
//! ```
//! use zeronav_world::RobotSpec;
//! let robot: RobotSpec = toml::from_str(
//!     r#"
//!     preset = "turtlebot3_burger"
//!     v_mps_max = 0.2
//!     lidar = { preset = "rplidar_a1", n_beams = 720 }
//!     "#,
//! )
//! .unwrap();
//! assert_eq!((robot.v_mps_max, robot.lidar.n_beams), (0.2, 720));
//! ```

use crate::faults::FaultSpec;
use crate::preset::{LidarPreset, RobotPreset};
use core::fmt::Formatter;
use core::marker::PhantomData;
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// The robot: outline, limits, lidar, and how badly its wheels and its odometry do. The simulator
/// turns it into `robot/description`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RobotWords")]
pub struct RobotSpec {
    /// Radius of a round footprint. [m] Exactly one of this and `footprint_m`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Corners `[x, y]` of a convex footprint around the origin of `base`, counter-clockwise. [m]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub footprint_m: Option<Vec<[f64; 2]>>,
    /// Fastest forward speed. [m/s]
    pub v_mps_max: f64,
    /// Fastest backward speed as a number <= 0. [m/s]
    pub v_mps_min: f64,
    /// Fastest yaw rate. [rad/s]
    pub w_radps_max: f64,
    /// Largest acceleration. [m/s^2]
    pub a_mps2_max: f64,
    /// Braking that can be relied on; without, `a_mps2_max`. [m/s^2]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub brake_mps2: Option<f64>,
    /// Largest yaw acceleration. [rad/s^2]
    pub alpha_radps2_max: f64,
    /// Age of the last command from which the robot brakes by itself. [s]
    pub command_timeout_s: f64,
    /// Time from a command's arrival to its taking effect, 0 to 1 s, in whole ticks rounded up. [s]
    pub actuation_delay_s: f64,
    /// How the wheels slip; without, they do not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip: Option<SlipSpec>,
    /// How odometry errs; without, it is exact but for what slips.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry: Option<OdometrySpec>,
    /// The lidar.
    pub lidar: LidarSpec,
    /// What breaks in the course of a run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<FaultSpec>,
}

/// Wheels that slip: the ground sees less of the motion than the wheels do. Odometry cannot tell,
/// but for the yaw of one with a gyro ([`OdometrySpec::gyro`]).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SlipSpec {
    /// Share of the wheels' forward motion that is lost on average, 0 to 0.9.
    pub forward_ratio: f64,
    /// Share of the wheels' turning that is lost on average, 0 to 0.9.
    pub turn_ratio: f64,
    /// Standard deviation of both, drawn anew every 0.1 s of run time.
    pub sigma_ratio: f64,
}

impl Default for SlipSpec {
    /// Rubber wheels on a hard floor.
    fn default() -> Self {
        Self {
            forward_ratio: 0.005,
            turn_ratio: 0.01,
            sigma_ratio: 0.01,
        }
    }
}

/// Errors of odometry: random walks whose variances grow with the distance driven and with the
/// angle turned (the model of Thrun, Burgard, Fox, "Probabilistic Robotics", 2005, table 5.6, with
/// variances instead of deviations that are linear in the way, so that the tick does not matter).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OdometrySpec {
    /// Deviation of the distance after 1 m. [m/sqrt(m)]
    pub distance_per_distance: f64,
    /// Deviation of the distance after a turn of 1 rad. [m/sqrt(rad)]
    pub distance_per_turn: f64,
    /// Deviation of the yaw after a turn of 1 rad. [rad/sqrt(rad)]
    pub turn_per_turn: f64,
    /// Deviation of the yaw after 1 m. [rad/sqrt(m)]
    pub turn_per_distance: f64,
    /// The yaw is a gyro's: it sees the robot turn and not its wheels, whose slip is not in it.
    pub gyro: bool,
}

impl Default for OdometrySpec {
    /// A calibrated differential drive without a gyro.
    fn default() -> Self {
        Self {
            distance_per_distance: 0.01,
            distance_per_turn: 0.002,
            turn_per_turn: 0.02,
            turn_per_distance: 0.01,
            gyro: false,
        }
    }
}

/// A planar lidar. Noise is laid over the exact ranges in the order of the fields from
/// `motion_distortion` on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "LidarWords")]
pub struct LidarSpec {
    /// `base_from_laser` as `[x, y, yaw]`. [m, m, rad]
    pub pose: [f64; 3],
    /// Beams of a turn.
    pub n_beams: u32,
    /// Field of view, 2 pi = all around. [rad] Beams lie evenly in it; all around, the last beam
    /// is one step before the first.
    pub fov_rad: f64,
    /// Turns per second. [Hz]
    pub rate_hz: f64,
    /// Closest range. [m]
    pub range_m_min: f64,
    /// Farthest range. [m]
    pub range_m_max: f64,
    /// Beams are taken one after the other while the mirror turns and robot and obstacles move;
    /// the scan is captured with its last beam. Otherwise all at once.
    pub motion_distortion: bool,
    /// Standard deviation of a range. [m]
    pub sigma_m: f64,
    /// The same as a share of the range; the larger of the two counts.
    pub sigma_ratio: f64,
    /// Step of the ranges, 0 = none. [m]
    pub quantum_m: f64,
    /// Share of the returns that get lost, 0 to 1.
    pub dropout_ratio: f64,
    /// What a lost return looks like.
    pub dropout_as: Dropout,
    /// Share of the returns that come from something nearer (dust, rain, a fly), 0 to 1.
    pub short_ratio: f64,
    /// Mean range of such a return; they are exponential up to the true range. [m]
    pub short_mean_m: f64,
    /// Share of the beams beside an edge that hit both sides of it and give a range between, 0 to
    /// 1.
    pub edge_ratio: f64,
}

/// What a lost return looks like in a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Dropout {
    /// +inf: nothing came back.
    #[default]
    NoReturn,
    /// NaN: something was wrong.
    Invalid,
}

/// Field of view of a lidar that looks all around. [rad]
const ALL_AROUND_RAD: f64 = core::f64::consts::TAU;

/// Age of the last command from which a robot brakes that says nothing else. [s]
const COMMAND_TIMEOUT_S: f64 = 0.2;

/// Mean range of a short return that says nothing else. [m]
const SHORT_MEAN_M: f64 = 0.5;

/// A robot as it is written.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RobotWords {
    preset: Option<RobotPreset>,
    radius_m: Option<f64>,
    footprint_m: Option<Vec<[f64; 2]>>,
    v_mps_max: Option<f64>,
    v_mps_min: Option<f64>,
    w_radps_max: Option<f64>,
    a_mps2_max: Option<f64>,
    brake_mps2: Option<f64>,
    alpha_radps2_max: Option<f64>,
    command_timeout_s: Option<f64>,
    actuation_delay_s: Option<f64>,
    slip: Option<Perhaps<SlipWords>>,
    odometry: Option<Perhaps<OdometryWords>>,
    lidar: Option<LidarWords>,
    faults: Vec<FaultSpec>,
}

/// A table, or `false` for none: so a preset's can be switched off.
#[derive(Debug)]
enum Perhaps<T> {
    Flag(bool),
    Table(T),
}

/// By hand: an untagged enum does not say what is wrong with the table.
impl<'de, T: Deserialize<'de>> Deserialize<'de> for Perhaps<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Either<T> {
            type Value = Perhaps<T>;

            fn expecting(&self, formatter: &mut Formatter<'_>) -> core::fmt::Result {
                formatter.write_str("true, false or a table")
            }

            fn visit_bool<E>(self, wanted: bool) -> Result<Self::Value, E> {
                Ok(Perhaps::Flag(wanted))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(Perhaps::Table)
            }
        }
        deserializer.deserialize_any(Either(PhantomData))
    }
}

/// Slip as it is written.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[allow(clippy::struct_field_names, reason = "the words of a scenario")]
struct SlipWords {
    forward_ratio: Option<f64>,
    turn_ratio: Option<f64>,
    sigma_ratio: Option<f64>,
}

impl SlipWords {
    fn on(self, base: SlipSpec) -> SlipSpec {
        SlipSpec {
            forward_ratio: self.forward_ratio.unwrap_or(base.forward_ratio),
            turn_ratio: self.turn_ratio.unwrap_or(base.turn_ratio),
            sigma_ratio: self.sigma_ratio.unwrap_or(base.sigma_ratio),
        }
    }
}

/// Errors of odometry as they are written.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct OdometryWords {
    distance_per_distance: Option<f64>,
    distance_per_turn: Option<f64>,
    turn_per_turn: Option<f64>,
    turn_per_distance: Option<f64>,
    gyro: Option<bool>,
}

impl OdometryWords {
    fn on(self, base: OdometrySpec) -> OdometrySpec {
        OdometrySpec {
            distance_per_distance: self
                .distance_per_distance
                .unwrap_or(base.distance_per_distance),
            distance_per_turn: self.distance_per_turn.unwrap_or(base.distance_per_turn),
            turn_per_turn: self.turn_per_turn.unwrap_or(base.turn_per_turn),
            turn_per_distance: self.turn_per_distance.unwrap_or(base.turn_per_distance),
            gyro: self.gyro.unwrap_or(base.gyro),
        }
    }
}

/// What `words` and `preset` make together; `true` is the preset's, or the default.
fn laid<W, T: Copy + Default>(
    words: Option<Perhaps<W>>,
    preset: Option<T>,
    on: impl Fn(W, T) -> T,
) -> Option<T> {
    let base = preset.unwrap_or_default();
    match words {
        None => preset,
        Some(Perhaps::Flag(wanted)) => wanted.then_some(base),
        Some(Perhaps::Table(words)) => Some(on(words, base)),
    }
}

/// A lidar as it is written.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct LidarWords {
    preset: Option<LidarPreset>,
    pose: Option<[f64; 3]>,
    n_beams: Option<u32>,
    fov_rad: Option<f64>,
    rate_hz: Option<f64>,
    range_m_min: Option<f64>,
    range_m_max: Option<f64>,
    motion_distortion: Option<bool>,
    sigma_m: Option<f64>,
    sigma_ratio: Option<f64>,
    quantum_m: Option<f64>,
    dropout_ratio: Option<f64>,
    dropout_as: Option<Dropout>,
    short_ratio: Option<f64>,
    short_mean_m: Option<f64>,
    edge_ratio: Option<f64>,
}

/// A field that must be given and was not, worded as serde does.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("missing field `{0}`")]
struct Missing(&'static str);

impl TryFrom<RobotWords> for RobotSpec {
    type Error = Missing;

    fn try_from(words: RobotWords) -> Result<Self, Missing> {
        let preset = words.preset.map(RobotPreset::robot);
        let of = |pick: fn(&RobotSpec) -> f64| preset.as_ref().map(pick);
        let need = |given: Option<f64>, pick, name| given.or_else(|| of(pick)).ok_or(Missing(name));
        let or = |given: Option<f64>, pick, other| given.or_else(|| of(pick)).unwrap_or(other);
        // An outline of its own replaces the preset's, whatever the kind of either.
        let (radius_m, footprint_m) = match (words.radius_m, words.footprint_m, &preset) {
            (None, None, Some(preset)) => (preset.radius_m, preset.footprint_m.clone()),
            (radius_m, footprint_m, _) => (radius_m, footprint_m),
        };
        Ok(Self {
            radius_m,
            footprint_m,
            v_mps_max: need(words.v_mps_max, |it| it.v_mps_max, "v_mps_max")?,
            v_mps_min: or(words.v_mps_min, |it| it.v_mps_min, 0.0),
            w_radps_max: need(words.w_radps_max, |it| it.w_radps_max, "w_radps_max")?,
            a_mps2_max: need(words.a_mps2_max, |it| it.a_mps2_max, "a_mps2_max")?,
            brake_mps2: words
                .brake_mps2
                .or_else(|| preset.as_ref().and_then(|it| it.brake_mps2)),
            alpha_radps2_max: need(
                words.alpha_radps2_max,
                |it| it.alpha_radps2_max,
                "alpha_radps2_max",
            )?,
            command_timeout_s: or(
                words.command_timeout_s,
                |it| it.command_timeout_s,
                COMMAND_TIMEOUT_S,
            ),
            actuation_delay_s: or(words.actuation_delay_s, |it| it.actuation_delay_s, 0.0),
            slip: laid(
                words.slip,
                preset.as_ref().and_then(|it| it.slip),
                SlipWords::on,
            ),
            odometry: laid(
                words.odometry,
                preset.as_ref().and_then(|it| it.odometry),
                OdometryWords::on,
            ),
            lidar: match (words.lidar, preset) {
                (Some(lidar), preset) => lidar.on(preset.map(|it| it.lidar))?,
                (None, Some(preset)) => preset.lidar,
                (None, None) => return Err(Missing("lidar")),
            },
            faults: words.faults,
        })
    }
}

impl TryFrom<LidarWords> for LidarSpec {
    type Error = Missing;

    fn try_from(words: LidarWords) -> Result<Self, Missing> {
        words.on(None)
    }
}

impl LidarWords {
    /// The lidar: these words, then its preset, then `mounted`, the one that the robot's preset
    /// carries. A preset of its own sits where the robot's sat.
    fn on(self, mounted: Option<LidarSpec>) -> Result<LidarSpec, Missing> {
        let place = mounted.as_ref().map(|it| it.pose);
        let base = self.preset.map(LidarPreset::lidar).or(mounted);
        let of = |pick: fn(&LidarSpec) -> f64| base.as_ref().map(pick);
        let need = |given: Option<f64>, pick, name| given.or_else(|| of(pick)).ok_or(Missing(name));
        let or = |given: Option<f64>, pick, other| given.or_else(|| of(pick)).unwrap_or(other);
        Ok(LidarSpec {
            pose: self.pose.or(place).unwrap_or([0.0; 3]),
            n_beams: self
                .n_beams
                .or_else(|| base.as_ref().map(|it| it.n_beams))
                .ok_or(Missing("n_beams"))?,
            fov_rad: or(self.fov_rad, |it| it.fov_rad, ALL_AROUND_RAD),
            rate_hz: need(self.rate_hz, |it| it.rate_hz, "rate_hz")?,
            range_m_min: need(self.range_m_min, |it| it.range_m_min, "range_m_min")?,
            range_m_max: need(self.range_m_max, |it| it.range_m_max, "range_m_max")?,
            motion_distortion: self
                .motion_distortion
                .unwrap_or_else(|| base.as_ref().is_some_and(|it| it.motion_distortion)),
            sigma_m: or(self.sigma_m, |it| it.sigma_m, 0.0),
            sigma_ratio: or(self.sigma_ratio, |it| it.sigma_ratio, 0.0),
            quantum_m: or(self.quantum_m, |it| it.quantum_m, 0.0),
            dropout_ratio: or(self.dropout_ratio, |it| it.dropout_ratio, 0.0),
            dropout_as: self
                .dropout_as
                .or_else(|| base.as_ref().map(|it| it.dropout_as))
                .unwrap_or_default(),
            short_ratio: or(self.short_ratio, |it| it.short_ratio, 0.0),
            short_mean_m: or(self.short_mean_m, |it| it.short_mean_m, SHORT_MEAN_M),
            edge_ratio: or(self.edge_ratio, |it| it.edge_ratio, 0.0),
        })
    }
}

impl LidarSpec {
    /// A lidar without any noise that looks all around from the middle of the robot.
    #[must_use]
    pub fn exact(n_beams: u32, rate_hz: f64, range_m: core::ops::Range<f64>) -> Self {
        Self {
            pose: [0.0; 3],
            n_beams,
            fov_rad: ALL_AROUND_RAD,
            rate_hz,
            range_m_min: range_m.start,
            range_m_max: range_m.end,
            motion_distortion: false,
            sigma_m: 0.0,
            sigma_ratio: 0.0,
            quantum_m: 0.0,
            dropout_ratio: 0.0,
            dropout_as: Dropout::NoReturn,
            short_ratio: 0.0,
            short_mean_m: SHORT_MEAN_M,
            edge_ratio: 0.0,
        }
    }
}

impl RobotSpec {
    /// A disc that goes forward at most `v_mps_max` and turns at most `w_radps_max`, with
    /// accelerations that take it there in a second, and does exactly what it is told.
    #[must_use]
    pub fn exact(radius_m: f64, v_mps_max: f64, w_radps_max: f64, lidar: LidarSpec) -> Self {
        Self {
            radius_m: Some(radius_m),
            footprint_m: None,
            v_mps_max,
            v_mps_min: 0.0,
            w_radps_max,
            a_mps2_max: v_mps_max,
            brake_mps2: None,
            alpha_radps2_max: w_radps_max,
            command_timeout_s: COMMAND_TIMEOUT_S,
            actuation_delay_s: 0.0,
            slip: None,
            odometry: None,
            lidar,
            faults: Vec::new(),
        }
    }
}
