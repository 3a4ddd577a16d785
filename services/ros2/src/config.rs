//! What launch tells the program in the robot's seat.

use crate::inputs::Expected;
use crate::network::NetworkConfig;
use serde::{Deserialize, Serialize};
use zeronav_msgs::pose::Pose;
use zeronav_params::{Parameter, describe, parameters};
use zeronav_robot_description::RobotSpec;
use zeronav_shell::StartError;

parameters! {
    /// The robot's side of ROS 2: topics, frames, clock.
    pub struct RosConfig {
        /// Topic of the lidar, `sensor_msgs/LaserScan`.
        scan_topic: String = "/scan".to_owned();
        /// Topic of the odometry, `nav_msgs/Odometry`.
        odom_topic: String = "/odom".to_owned();
        /// Topic of the velocity commands.
        cmd_vel_topic: String = "/cmd_vel".to_owned();
        /// Topic of the transforms that change; robots with a name space have one of their own.
        tf_topic: String = "/tf".to_owned();
        /// Topic of those that do not.
        tf_static_topic: String = "/tf_static".to_owned();
        /// Commands are `geometry_msgs/TwistStamped`, as bases want them from Jazzy on; otherwise `Twist`.
        cmd_vel_stamped: bool = false;
        /// Frame of the odometry.
        odom_frame: String = "odom".to_owned();
        /// Frame of the robot, `base` of the contract.
        base_frame: String = "base_link".to_owned();
        /// Where the lidar is comes from `/tf` and `/tf_static`; otherwise from `robot.lidar.pose`.
        laser_from_tf: bool = true;
        /// Stamps are those of a simulation, which may be slower or faster than time.
        use_sim_time: bool = false;
        /// Where they meet.
        network: NetworkConfig;
    }
}

/// The name of a topic with its name space.
///
/// # Errors
/// What is wrong with it.
pub fn whole_name(name: &str) -> Result<ros2_client::Name, String> {
    let parsed = ros2_client::Name::parse(name);
    let parsed =
        parsed.map_err(|why| format!("{name:?} cannot be the name of a topic: {why:?}"))?;
    if parsed.is_absolute() {
        Ok(parsed)
    } else {
        Err(format!("{name:?} must begin with a slash"))
    }
}

impl RosConfig {
    /// Accepts names that topics can have.
    ///
    /// # Errors
    /// The field, and what is wrong with it.
    pub fn check_names(&self) -> Result<(), (&'static str, String)> {
        let topics = [
            ("scan_topic", &self.scan_topic),
            ("odom_topic", &self.odom_topic),
            ("cmd_vel_topic", &self.cmd_vel_topic),
            ("tf_topic", &self.tf_topic),
            ("tf_static_topic", &self.tf_static_topic),
        ];
        for (field, name) in topics {
            whole_name(name).map_err(|why| (field, why))?;
        }
        Ok(())
    }
}

/// The configuration file: what the simulated robot is told, of which this program takes start and robot, and its own
/// table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeatConfig {
    /// `map_from_base` at the start as `[x, y, yaw]`. [m, m, rad]
    pub start: [f64; 3],
    /// The robot: outline, limits, delay.
    pub robot: RobotSpec,
    /// The side of ROS.
    #[serde(default)]
    pub ros: RosConfig,
    /// The world of the scenario; not used.
    pub world: toml::Table,
}

impl SeatConfig {
    /// Start, robot and topics.
    #[must_use]
    pub fn parameters() -> Vec<Parameter> {
        let doc = "`map_from_base` at the start as `[x, y, yaw]`.";
        let start = Parameter::new(&None::<[f64; 3]>, "", "start", "m, m, rad", None, &[], doc);
        let robot = RobotSpec::parameters("robot");
        let ros = describe::<RosConfig>()
            .into_iter()
            .map(|parameter| Parameter {
                path: format!("ros.{}", parameter.path),
                ..parameter
            });
        core::iter::once(start).chain(robot).chain(ros).collect()
    }

    /// What is expected of the robot.
    #[must_use]
    pub fn expected(&self) -> Expected {
        let pose = |[x, y, yaw]: [f64; 3]| Pose::new(x, y, yaw);
        Expected {
            odom_frame: self.ros.odom_frame.clone(),
            base_frame: self.ros.base_frame.clone(),
            fixed_laser: (!self.ros.laser_from_tf).then(|| pose(self.robot.lidar.pose)),
            start: pose(self.start),
        }
    }

    /// Accepts configurations with which a robot can be heard.
    ///
    /// # Errors
    /// [`StartError::Config`] naming the field.
    pub fn check(&self) -> Result<(), StartError> {
        let robot = self.robot.check();
        robot.map_err(|it| StartError::config(format!("robot.{}", it.field), it.why))?;
        zeronav_params::check(&self.ros).map_err(|it| StartError::config("ros", it.to_string()))?;
        let names = self.ros.check_names();
        names.map_err(|(field, why)| StartError::config(format!("ros.{field}"), why))?;
        if self.start.iter().any(|it| !it.is_finite()) {
            return Err(StartError::config("start", "it is not finite"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const TEXT: &str = r#"
        start = [1.0, 2.0, 0.5]
        [world]
        area_m = [[0.0, 0.0], [10.0, 8.0]]
        [robot]
        preset = "jackal"
        [ros]
        scan_topic = "/front/scan"
    "#;

    #[test]
    fn a_config_is_read_and_written_alike() {
        let config: SeatConfig = toml::from_str(TEXT).expect("a config");
        assert!(config.check().is_ok());
        assert_eq!(config.ros.odom_topic, "/odom");
        assert_eq!(config.expected().fixed_laser, None);
        let written = toml::to_string(&config).expect("TOML");
        assert_eq!(toml::from_str::<SeatConfig>(&written), Ok(config));
    }

    #[test]
    fn names_that_cannot_be_are_rejected_with_their_field() {
        let text = TEXT.replace("/front/scan", "/front//scan");
        let config: SeatConfig = toml::from_str(&text).expect("a config");
        let why = config.check().expect_err("a bad name").to_string();
        assert!(
            why.contains("ros.scan_topic") && why.contains("/front//scan"),
            "{why}"
        );
        let text = TEXT.replace("/front/scan", "scan");
        let config: SeatConfig = toml::from_str(&text).expect("a config");
        let why = config.check().expect_err("a relative name").to_string();
        assert!(why.contains("\"scan\" must begin with a slash"), "{why}");
        let unknown = toml::from_str::<SeatConfig>(&TEXT.replace("scan_topic", "scn_topic"));
        assert!(unknown.unwrap_err().to_string().contains("scn_topic"));
    }

    #[test]
    fn topics_of_shipped_robots_are_those_that_such_robots_have() {
        let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
        // The TurtleBot 4 whose topics were listed has a name space.
        for (name, space) in [("turtlebot4", "/robot1"), ("jackal", "")] {
            let read = |file: String| std::fs::read_to_string(robots.join(file)).expect("a file");
            let list = read(format!("topics/{name}.txt"));
            let file: toml::Table = read(format!("{name}.toml")).parse().expect("TOML");
            let ros = &file["services"]["robot"]["config"]["ros"];
            let ros: RosConfig = ros.clone().try_into().expect("topics");
            assert_eq!(ros.check_names(), Ok(()));
            for topic in [
                &ros.scan_topic,
                &ros.odom_topic,
                &ros.cmd_vel_topic,
                &ros.tf_topic,
                &ros.tf_static_topic,
            ] {
                let topic = format!("{space}{topic}");
                assert!(list.lines().any(|it| it == topic), "{name}: {topic}");
            }
        }
    }
}
