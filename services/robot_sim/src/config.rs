//! What launch tells the simulated robot.

use serde::{Deserialize, Serialize};
use zeronav_params::Parameter;
use zeronav_robot_description::RobotSpec;
use zeronav_world::WorldSpec;

/// The robot's config file: the world, the robot, and where it starts. Seed and tick are those of
/// the run and stand in `run/clock`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimConfig {
    /// `map_from_base` at the start as `[x, y, yaw]`. [m, m, rad]
    pub start: [f64; 3],
    /// The world and what happens in it.
    pub world: WorldSpec,
    /// The robot, the same that the scenario describes.
    pub robot: RobotSpec,
}

impl SimConfig {
    /// Start and robot; the parts of the world are lists of shapes and obstacles and no parameters.
    #[must_use]
    pub fn parameters() -> Vec<Parameter> {
        let doc = "`map_from_base` at the start as `[x, y, yaw]`.";
        let start = Parameter::new(&None::<[f64; 3]>, "", "start", "m, m, rad", None, &[], doc);
        let robot = RobotSpec::parameters("robot");
        core::iter::once(start).chain(robot).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"
        start = [1.0, 2.0, 0.5]
        [world]
        area_m = [[0.0, 0.0], [10.0, 8.0]]
        [[world.shapes]]
        kind = "disc"
        centre_m = [5.0, 5.0]
        radius_m = 0.5
        [robot]
        radius_m = 0.25
        v_mps_max = 1.0
        w_radps_max = 2.0
        a_mps2_max = 1.0
        alpha_radps2_max = 4.0
        [robot.lidar]
        n_beams = 720
        rate_hz = 10.0
        range_m_min = 0.1
        range_m_max = 12.0
    "#;

    #[test]
    fn a_config_is_read_and_written_alike() {
        let config: SimConfig = toml::from_str(TEXT).expect("a config");
        assert_eq!(config.world.shapes.len(), 1);
        assert!((config.robot.command_timeout_s - 0.2).abs() < 1e-15);
        let written = toml::to_string(&config).expect("TOML");
        assert_eq!(toml::from_str::<SimConfig>(&written), Ok(config));
    }

    #[test]
    fn unknown_fields_are_refused() {
        let error = toml::from_str::<SimConfig>(&format!("sart = 1\n{TEXT}")).unwrap_err();
        assert!(error.to_string().contains("sart"), "{error}");
    }
}
