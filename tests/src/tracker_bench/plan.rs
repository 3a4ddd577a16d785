//! How the worlds are played.

use zeronav_robot_description::{LidarSpec, RobotPreset, RobotSpec};

/// How long, and with which robot.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Run time of every run. [s]
    pub duration_s: f64,
    /// Scans a second; `None` = as many as the robot's lidar takes. [Hz]
    pub rate_hz: Option<f64>,
    /// True for a robot whose wheels, odometry and lidar are exact.
    pub exact: bool,
}

impl Plan {
    /// A Jackal.
    #[must_use]
    pub fn robot(&self) -> RobotSpec {
        let jackal = RobotPreset::Jackal.robot();
        let lidar = LidarSpec {
            rate_hz: self.rate_hz.unwrap_or(jackal.lidar.rate_hz),
            ..jackal.lidar.clone()
        };
        if !self.exact {
            return RobotSpec { lidar, ..jackal };
        }
        let range_m = lidar.range_m_min..lidar.range_m_max;
        RobotSpec {
            slip: None,
            odometry: None,
            lidar: LidarSpec {
                pose: lidar.pose,
                fov_rad: lidar.fov_rad,
                ..LidarSpec::exact(lidar.n_beams, lidar.rate_hz, range_m)
            },
            ..jackal
        }
    }
}
