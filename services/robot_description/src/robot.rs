//! The robot: outline, limits, and how badly its wheels and its odometry do.
//!
//! A robot and a lidar may start from a preset ([`crate::RobotPreset`]); every field that is given
//! replaces the preset's, and without a preset those without a default must be given. What has
//! been read has no preset any more: it is written with all its numbers.
//!
//! ```
//! use zeronav_robot_description::RobotSpec;
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

use crate::faults::{FAULTS_MAX, FaultSpec};
use crate::field::{Declared, Field, Missing, described, switched, visit};
use crate::lidar::{LidarPreset, LidarSpec, LidarWords};
use crate::{RATE_MAX, RATE_MIN};
use zeronav_params::{Parameter, choices};
use zeronav_world::SpecError;
use zeronav_world::footprint::{Footprint, RADIUS_M};

#[cfg(test)]
mod tests;

/// Largest share of the wheels' motion that may be lost.
pub const SLIP_MAX: f64 = 0.9;

/// Longest [`RobotSpec::actuation_delay_s`]. [s]
pub const ACTUATION_DELAY_S_MAX: f64 = 1.0;

described! {
    /// The robot: outline, limits, lidar, and how badly its wheels and its odometry do. The simulator
    /// turns it into `robot/description`.
    pub struct RobotSpec from RobotWords with preset RobotPreset {
        /// Radius of a round footprint. Exactly one of this and `footprint_m`.
        #[serde(skip_serializing_if = "Option::is_none")]
        radius_m: Option<f64>, [RADIUS_M[0], RADIUS_M[1]] "m";
        /// Corners `[x, y]` of a convex footprint around the origin of `base`, counter-clockwise, in
        /// metres.
        #[serde(skip_serializing_if = "Option::is_none")]
        footprint_m: Option<Vec<[f64; 2]>>;
        /// Fastest forward speed.
        v_mps_max: f64, [RATE_MIN, RATE_MAX] "m/s";
        /// Fastest backward speed.
        v_mps_min: f64 = 0.0, [-RATE_MAX, 0.0] "m/s";
        /// Fastest yaw rate.
        w_radps_max: f64, [RATE_MIN, RATE_MAX] "rad/s";
        /// Largest acceleration.
        a_mps2_max: f64, [RATE_MIN, RATE_MAX] "m/s^2";
        /// Braking that can be relied on; without, `a_mps2_max`.
        #[serde(skip_serializing_if = "Option::is_none")]
        brake_mps2: Option<f64>, [RATE_MIN, RATE_MAX] "m/s^2";
        /// Largest yaw acceleration.
        alpha_radps2_max: f64, [RATE_MIN, RATE_MAX] "rad/s^2";
        /// Age of the last command from which the robot brakes by itself.
        command_timeout_s: f64 = 0.2, [0.01, 10.0] "s";
        /// Time from a command's arrival to its taking effect, in whole ticks rounded up.
        actuation_delay_s: f64 = 0.0, [0.0, ACTUATION_DELAY_S_MAX] "s";
        /// How the wheels slip; without, they do not.
        #[serde(skip_serializing_if = "Option::is_none")]
        slip: Option<SlipSpec>;
        /// How odometry errs; without, it is exact but for what slips.
        #[serde(skip_serializing_if = "Option::is_none")]
        odometry: Option<OdometrySpec>;
        /// The lidar.
        lidar: LidarSpec;
        /// Faults of the lidar, the odometry and the floor by script.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        faults: Vec<FaultSpec> = Vec::new();
    }
}

described! {
    /// Wheels that slip: the ground sees less of the motion than the wheels do. Odometry cannot tell,
    /// but for the yaw of one with a gyro ([`OdometrySpec::gyro`]). The defaults are those of rubber
    /// wheels on a hard floor.
    #[derive(Copy)]
    pub struct SlipSpec from SlipWords {
        /// Share of the wheels' forward motion that is lost on average.
        forward_ratio: f64 = 0.005, [0.0, SLIP_MAX];
        /// Share of the wheels' turning that is lost on average.
        turn_ratio: f64 = 0.01, [0.0, SLIP_MAX];
        /// Standard deviation of both, drawn again every 0.1 s of run time.
        sigma_ratio: f64 = 0.01, [0.0, SLIP_MAX];
    }
}

described! {
    /// Errors of odometry: random walks whose variances grow with the distance driven and with the
    /// angle turned (the model of Thrun, Burgard, Fox, "Probabilistic Robotics", 2005, table 5.6,
    /// with variances instead of deviations that are linear in the way, so that the tick does not
    /// matter). The defaults are those of a calibrated differential drive without a gyro.
    #[derive(Copy)]
    pub struct OdometrySpec from OdometryWords {
        /// Deviation of the distance after 1 m.
        distance_per_distance: f64 = 0.01, [0.0, 1.0] "m/sqrt(m)";
        /// Deviation of the distance after a turn of 1 rad.
        distance_per_turn: f64 = 0.002, [0.0, 1.0] "m/sqrt(rad)";
        /// Deviation of the yaw after a turn of 1 rad.
        turn_per_turn: f64 = 0.02, [0.0, 1.0] "rad/sqrt(rad)";
        /// Deviation of the yaw after 1 m.
        turn_per_distance: f64 = 0.01, [0.0, 1.0] "rad/sqrt(m)";
        /// The yaw is a gyro's: it sees the robot turn and not its wheels, whose slip is not in it.
        gyro: bool = false;
    }
}

switched!(SlipSpec, OdometrySpec);

impl RobotWords {
    fn on(self, base: Option<RobotSpec>) -> Result<RobotSpec, Missing> {
        let mut base = self.preset.map(RobotPreset::robot).or(base);
        // An outline of its own replaces the preset's, whatever the kind of either.
        if let Some(base) = &mut base
            && (self.radius_m.is_some() || self.footprint_m.is_some())
        {
            (base.radius_m, base.footprint_m) = (None, None);
        }
        self.over(base)
    }
}

impl SlipWords {
    fn on(self, base: Option<SlipSpec>) -> Result<SlipSpec, Missing> {
        self.over(base)
    }
}

impl OdometryWords {
    fn on(self, base: Option<OdometrySpec>) -> Result<OdometrySpec, Missing> {
        self.over(base)
    }
}

impl Default for SlipSpec {
    fn default() -> Self {
        let words = SlipWords::default();
        words.over(None).expect("every field has a default")
    }
}

impl Default for OdometrySpec {
    fn default() -> Self {
        let words = OdometryWords::default();
        words.over(None).expect("every field has a default")
    }
}

impl Field for Vec<FaultSpec> {
    type Words = Self;

    fn laid(words: Option<Self>, base: Option<Self>) -> Result<Option<Self>, Missing> {
        Ok(words.or(base))
    }

    fn visit(_: Option<&Self>, declared: &Declared, visitor: &mut dyn FnMut(Parameter)) {
        visit(&Vec::<f64>::new(), declared, visitor);
    }
}

impl RobotSpec {
    /// A disc that goes forward at most `v_mps_max` and turns at most `w_radps_max`, with
    /// accelerations that take it there in a second, and does exactly what it is told.
    ///
    /// # Panics
    /// Never: every field that has no default is given.
    #[must_use]
    pub fn exact(radius_m: f64, v_mps_max: f64, w_radps_max: f64, lidar: LidarSpec) -> Self {
        let words = RobotWords {
            radius_m: Some(radius_m),
            v_mps_max: Some(v_mps_max),
            w_radps_max: Some(w_radps_max),
            a_mps2_max: Some(v_mps_max),
            alpha_radps2_max: Some(w_radps_max),
            lidar: Some(LidarWords::of(lidar)),
            ..RobotWords::default()
        };
        words.over(None).expect("every other field has a default")
    }

    /// Accepts robots that can exist.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), SpecError> {
        self.footprint()?;
        zeronav_params::check(self)?;
        self.lidar.check().map_err(|error| error.within("lidar"))?;
        if self.faults.len() > FAULTS_MAX {
            let why = format!("{} faults, at most {FAULTS_MAX}", self.faults.len());
            return Err(SpecError::new("faults", why));
        }
        for (index, fault) in self.faults.iter().enumerate() {
            fault
                .check()
                .map_err(|error| error.within(&format!("faults[{index}]")))?;
        }
        Ok(())
    }

    /// The outline.
    ///
    /// # Errors
    /// Both or none of `radius_m` and `footprint_m`; else see [`Footprint::disc`] and
    /// [`Footprint::polygon`].
    pub fn footprint(&self) -> Result<Footprint, SpecError> {
        match (self.radius_m, &self.footprint_m) {
            (Some(radius_m), None) => Footprint::disc(radius_m),
            (None, Some(corners_m)) => Footprint::polygon(corners_m),
            (Some(_), Some(_)) => Err(SpecError::new(
                "footprint_m",
                "a robot has either a radius_m or a footprint_m, not both",
            )),
            (None, None) => Err(SpecError::new(
                "radius_m",
                "missing: a robot needs a radius_m or a footprint_m",
            )),
        }
    }

    /// Braking that can be relied on: `brake_mps2`, or else `a_mps2_max`. [m/s^2]
    #[must_use]
    pub fn reliable_brake_mps2(&self) -> f64 {
        self.brake_mps2.unwrap_or(self.a_mps2_max)
    }
}

// From data sheets. Delays, slip and the errors of odometry are in no data sheet: they are typical
// values, to be replaced by measured ones.
choices! {
    /// A robot by name.
    pub enum RobotPreset {
        /// `TurtleBot` 2 on a Kobuki base, with an `RPLidar` A1.
        Turtlebot2 = "turtlebot2",
        /// `TurtleBot3` burger, with its LDS-01.
        Turtlebot3Burger = "turtlebot3_burger",
        /// Clearpath Jackal, skid-steered, with a Hokuyo UST-10LX in front.
        Jackal = "jackal",
    }
}

impl RobotPreset {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Turtlebot2, Self::Turtlebot3Burger, Self::Jackal];

    // long: one table of numbers per robot
    /// Its numbers.
    #[must_use]
    pub fn robot(self) -> RobotSpec {
        match self {
            // Yujin Robot: Kobuki user guide (0.7 m/s, 180 deg/s; the gyro is good up to 110 deg/s,
            // kobuki_driver's appendix), acceleration of the usual navigation parameters.
            Self::Turtlebot2 => RobotSpec {
                a_mps2_max: 1.0,
                alpha_radps2_max: 2.0,
                command_timeout_s: 0.6,
                actuation_delay_s: 0.04,
                slip: Some(SlipSpec::default()),
                odometry: Some(OdometrySpec {
                    turn_per_turn: 0.01,
                    turn_per_distance: 0.005,
                    gyro: true,
                    ..OdometrySpec::default()
                }),
                ..RobotSpec::exact(0.177, 0.65, 1.9, LidarPreset::RplidarA1.lidar())
            },
            // Robotis e-Manual (0.22 m/s, 2.84 rad/s), accelerations of its navigation parameters,
            // base_scan of its URDF.
            Self::Turtlebot3Burger => RobotSpec {
                a_mps2_max: 2.5,
                alpha_radps2_max: 3.2,
                command_timeout_s: 0.5,
                actuation_delay_s: 0.04,
                slip: Some(SlipSpec::default()),
                odometry: Some(OdometrySpec::default()),
                ..RobotSpec::exact(
                    0.105,
                    0.22,
                    2.84,
                    LidarSpec {
                        pose: [-0.032, 0.0, 0.0],
                        ..LidarPreset::Lds01.lidar()
                    },
                )
            },
            // Clearpath data sheet (0.508 x 0.430 m, 2.0 m/s, 4.0 rad/s); its controller allows
            // 20 m/s^2, which its tyres do not.
            Self::Jackal => RobotSpec {
                radius_m: None,
                footprint_m: Some(vec![
                    [-0.254, -0.215],
                    [0.254, -0.215],
                    [0.254, 0.215],
                    [-0.254, 0.215],
                ]),
                a_mps2_max: 3.0,
                alpha_radps2_max: 8.0,
                command_timeout_s: 0.25,
                actuation_delay_s: 0.04,
                // Four scrubbing wheels turn it by less than they should, by how much varies with
                // the floor.
                slip: Some(SlipSpec {
                    forward_ratio: 0.01,
                    turn_ratio: 0.03,
                    sigma_ratio: 0.03,
                }),
                odometry: Some(OdometrySpec {
                    distance_per_distance: 0.02,
                    // That is why the odometry that it comes with takes its yaw from the inertial
                    // unit on board (`jackal_control`, robot_localization.yaml).
                    turn_per_turn: 0.01,
                    turn_per_distance: 0.005,
                    gyro: true,
                    ..OdometrySpec::default()
                }),
                ..RobotSpec::exact(
                    0.3,
                    2.0,
                    4.0,
                    LidarSpec {
                        pose: [0.12, 0.0, 0.0],
                        ..LidarPreset::Ust10lx.lidar()
                    },
                )
            },
        }
    }
}
