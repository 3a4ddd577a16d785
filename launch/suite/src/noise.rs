//! How badly the robot does: what a suite changes of its wheels, its odometry and its lidar.

use clap::ValueEnum;
use toml::Table;
use zeronav_robot_description::{ACTUATION_DELAY_S_MAX, RobotPreset, RobotSpec, SLIP_MAX};

/// How badly the robot does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Noise {
    /// Exact wheels, odometry and lidar, and no delay.
    Off,
    /// What the robot's preset says and 50 ms from a command to its effect; a folder's scenarios
    /// as they are.
    #[default]
    Default,
    /// Twice that.
    Hard,
}

impl Noise {
    /// The one of that name.
    #[must_use]
    pub fn from_label(label: &str) -> Option<Self> {
        let all = [Self::Off, Self::Default, Self::Hard];
        all.into_iter().find(|noise| noise.label() == label)
    }

    /// Its name on the command line.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Default => "default",
            Self::Hard => "hard",
        }
    }
}

/// Time from a command's arrival to its effect on the robot of the data sets. [s]
const DELAY_S: f64 = 0.05;

/// What of a Jackal is not as its preset says.
pub(super) fn jackal(noise: Noise) -> Table {
    let spec = RobotSpec {
        actuation_delay_s: DELAY_S,
        ..RobotPreset::Jackal.robot()
    };
    let mut table = robot(noise, &spec);
    if noise == Noise::Default {
        table.insert("actuation_delay_s".into(), DELAY_S.into());
    }
    table
}

/// What is not as `robot` says.
pub(super) fn robot(noise: Noise, robot: &RobotSpec) -> Table {
    match noise {
        Noise::Off => exact(),
        Noise::Default => Table::new(),
        Noise::Hard => doubled(robot),
    }
}

fn exact() -> Table {
    let mut lidar = Table::new();
    lidar.insert("motion_distortion".into(), false.into());
    for name in [
        "sigma_m",
        "sigma_ratio",
        "quantum_m",
        "dropout_ratio",
        "short_ratio",
        "edge_ratio",
    ] {
        lidar.insert(name.into(), 0.0.into());
    }
    let mut table = Table::new();
    table.insert("slip".into(), false.into());
    table.insert("odometry".into(), false.into());
    table.insert("actuation_delay_s".into(), 0.0.into());
    table.insert("lidar".into(), lidar.into());
    table
}

fn doubled(robot: &RobotSpec) -> Table {
    let twice = |pairs: &[(&str, f64, f64)]| -> Table {
        pairs
            .iter()
            .map(|(name, value, most)| ((*name).to_owned(), (2.0 * value).min(*most).into()))
            .collect()
    };
    let seen = &robot.lidar;
    let mut table = twice(&[(
        "actuation_delay_s",
        robot.actuation_delay_s,
        ACTUATION_DELAY_S_MAX,
    )]);
    let lidar = twice(&[
        ("sigma_m", seen.sigma_m, 1.0),
        ("sigma_ratio", seen.sigma_ratio, 1.0),
        ("dropout_ratio", seen.dropout_ratio, 1.0),
        ("short_ratio", seen.short_ratio, 1.0),
        ("edge_ratio", seen.edge_ratio, 1.0),
    ]);
    table.insert("lidar".into(), lidar.into());
    if let Some(slip) = robot.slip {
        let slip = twice(&[
            ("forward_ratio", slip.forward_ratio, SLIP_MAX),
            ("turn_ratio", slip.turn_ratio, SLIP_MAX),
            ("sigma_ratio", slip.sigma_ratio, 1.0),
        ]);
        table.insert("slip".into(), slip.into());
    }
    if let Some(errs) = robot.odometry {
        let errs = twice(&[
            ("distance_per_distance", errs.distance_per_distance, 1.0),
            ("distance_per_turn", errs.distance_per_turn, 1.0),
            ("turn_per_turn", errs.turn_per_turn, 1.0),
            ("turn_per_distance", errs.turn_per_distance, 1.0),
        ]);
        table.insert("odometry".into(), errs.into());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(mut table: Table) -> RobotSpec {
        table.insert("preset".into(), "jackal".into());
        let robot: RobotSpec = table.try_into().expect("a robot");
        robot.check().expect("numbers that can be");
        robot
    }

    #[test]
    fn off_is_exact_default_is_the_preset_and_hard_is_twice_that() {
        let preset = RobotPreset::Jackal.robot();
        let off = read(jackal(Noise::Off));
        assert_eq!((off.slip, off.odometry), (None, None));
        assert!(off.actuation_delay_s.abs() < 1e-12);
        let exact = [
            off.lidar.sigma_m,
            off.lidar.dropout_ratio,
            off.lidar.edge_ratio,
        ];
        assert!(exact.iter().all(|value| value.abs() < 1e-12), "{exact:?}");
        let default = read(jackal(Noise::Default));
        assert_eq!(default.slip, preset.slip);
        assert_eq!(default.lidar, preset.lidar);
        assert!((default.actuation_delay_s - 0.05).abs() < 1e-12);
        let hard = read(jackal(Noise::Hard));
        assert!((hard.actuation_delay_s - 0.1).abs() < 1e-12);
        assert!((hard.slip.unwrap().turn_ratio - 0.06).abs() < 1e-12);
        let odometry = hard.odometry.unwrap();
        assert!((odometry.turn_per_turn - 0.02).abs() < 1e-12 && odometry.gyro);
        assert!((hard.lidar.sigma_m - 2.0 * preset.lidar.sigma_m).abs() < 1e-12);
        assert!((hard.lidar.edge_ratio - 0.6).abs() < 1e-12);
        assert_eq!(hard.lidar.n_beams, preset.lidar.n_beams);
    }

    #[test]
    fn twice_is_never_more_than_a_robot_may_have() {
        let mut robot = RobotPreset::Jackal.robot();
        robot.actuation_delay_s = 0.8;
        robot.lidar.edge_ratio = 0.7;
        let hard = read(super::robot(Noise::Hard, &robot));
        assert!((hard.actuation_delay_s - 1.0).abs() < 1e-12);
        assert!((hard.lidar.edge_ratio - 1.0).abs() < 1e-12);
    }
}
