//! Robots and lidars that one can buy, from their data sheets.
//!
//! Accuracies of data sheets are taken as three standard deviations. Delays, slip, dropouts and
//! the errors of odometry are in no data sheet: they are typical values, to be replaced by
//! measured ones.

use crate::lidar::{Dropout, LidarSpec};
use crate::robot::{OdometrySpec, RobotSpec, SlipSpec};
use zeronav_params::choices;

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
    use core::f64::consts::TAU;

    #[test]
    fn every_preset_can_exist_and_is_written_and_read_alike() {
        for preset in RobotPreset::ALL {
            let robot = preset.robot();
            assert_eq!(robot.check(), Ok(()), "{preset:?}");
            let written = toml::to_string(&robot).expect("TOML");
            assert_eq!(toml::from_str::<RobotSpec>(&written), Ok(robot));
        }
        for preset in LidarPreset::ALL {
            let robot = RobotSpec::exact(0.2, 1.0, 1.0, preset.lidar());
            assert_eq!(robot.check(), Ok(()), "{preset:?}");
        }
    }

    #[test]
    fn beams_of_the_hokuyos_lie_a_quarter_of_a_degree_apart() {
        for preset in [LidarPreset::Ust10lx, LidarPreset::Utm30lx] {
            let (first, step) = preset.lidar().directions_rad();
            assert!((step.to_degrees() - 0.25).abs() < 1e-9);
            assert!((first.to_degrees() + 135.0).abs() < 1e-9);
        }
        assert!((LidarPreset::Lds01.lidar().fov_rad - TAU).abs() < 1e-12);
    }

    #[test]
    fn single_fields_replace_those_of_a_preset() {
        let robot: RobotSpec = toml::from_str(
            r#"
            preset = "jackal"
            radius_m = 0.3
            slip = false
            odometry = { turn_per_turn = 0.5 }
            lidar = { preset = "utm_30lx", sigma_m = 0.0 }
            "#,
        )
        .expect("a robot");
        assert_eq!((robot.radius_m, &robot.footprint_m), (Some(0.3), &None));
        assert!((robot.v_mps_max - 2.0).abs() < 1e-12);
        assert_eq!(robot.slip, None);
        let odometry = robot.odometry.expect("odometry");
        assert!((odometry.turn_per_turn - 0.5).abs() < 1e-12);
        assert!((odometry.distance_per_distance - 0.02).abs() < 1e-12);
        assert!((robot.lidar.range_m_max - 30.0).abs() < 1e-12);
        assert!(robot.lidar.sigma_m.abs() < 1e-12);
        // The other lidar sits where the robot's own sat.
        assert!((robot.lidar.pose[0] - 0.12).abs() < 1e-12);
        let mut own: RobotSpec =
            toml::from_str("preset = \"turtlebot2\"\nlidar.n_beams = 90").expect("a robot");
        own.lidar.n_beams = 360;
        assert_eq!(own, RobotPreset::Turtlebot2.robot());
    }

    #[test]
    fn what_neither_words_nor_preset_give_is_missing() {
        let missing = |text: &str| toml::from_str::<RobotSpec>(text).unwrap_err().to_string();
        assert!(missing("v_mps_max = 1.0").contains("missing field `w_radps_max`"));
        assert!(missing("preset = \"roomba\"").contains("roomba"));
        let lidar = "v_mps_max = 1.0\nw_radps_max = 1.0\na_mps2_max = 1.0\nalpha_radps2_max = 1.0";
        assert!(missing(lidar).contains("missing field `lidar`"));
        assert!(missing(&format!("{lidar}\nlidar.rate_hz = 1.0")).contains("`n_beams`"));
    }
}
