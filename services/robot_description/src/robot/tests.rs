use super::*;
use crate::faults::{Begin, FaultSpec};
use core::f64::consts::TAU;

fn robot() -> RobotSpec {
    RobotSpec::exact(0.25, 1.0, 2.0, LidarSpec::exact(360, 10.0, 0.1..12.0))
}

#[track_caller]
fn refused(field: &str, change: impl FnOnce(&mut RobotSpec)) {
    let mut spec = robot();
    change(&mut spec);
    assert_eq!(spec.check().unwrap_err().field, field);
}

#[test]
fn a_robot_that_can_exist_is_accepted() {
    assert_eq!(robot().check(), Ok(()));
    assert!((robot().reliable_brake_mps2() - 1.0).abs() < 1e-15);
}

#[test]
fn every_number_is_looked_at() {
    refused("radius_m", |r| r.radius_m = None);
    refused("radius_m", |r| r.radius_m = Some(-1.0));
    refused("footprint_m", |r| r.footprint_m = Some(Vec::new()));
    refused("v_mps_max", |r| r.v_mps_max = 0.0);
    refused("v_mps_min", |r| r.v_mps_min = 0.5);
    refused("w_radps_max", |r| r.w_radps_max = f64::NAN);
    refused("a_mps2_max", |r| r.a_mps2_max = -1.0);
    refused("brake_mps2", |r| r.brake_mps2 = Some(0.0));
    refused("alpha_radps2_max", |r| r.alpha_radps2_max = f64::INFINITY);
    refused("command_timeout_s", |r| r.command_timeout_s = 0.0);
    refused("lidar.pose", |r| r.lidar.pose[1] = f64::NAN);
    refused("lidar.n_beams", |r| r.lidar.n_beams = 4097);
    refused("lidar.n_beams", |r| r.lidar.n_beams = 2);
    refused("lidar.fov_rad", |r| r.lidar.fov_rad = 7.0);
    refused("lidar.rate_hz", |r| r.lidar.rate_hz = 0.0);
    refused("lidar.range_m_min", |r| r.lidar.range_m_min = 12.0);
    refused("lidar.range_m_max", |r| r.lidar.range_m_max = -1.0);
    refused("lidar.sigma_m", |r| r.lidar.sigma_m = -0.1);
    refused("lidar.sigma_ratio", |r| r.lidar.sigma_ratio = f64::NAN);
    refused("lidar.quantum_m", |r| r.lidar.quantum_m = -1.0);
    refused("lidar.dropout_ratio", |r| r.lidar.dropout_ratio = 1.1);
    refused("lidar.short_ratio", |r| r.lidar.short_ratio = -0.1);
    refused("lidar.short_mean_m", |r| r.lidar.short_mean_m = 0.0);
    refused("lidar.edge_ratio", |r| r.lidar.edge_ratio = 2.0);
    refused("actuation_delay_s", |r| r.actuation_delay_s = 1.5);
    refused("slip.turn_ratio", |r| {
        r.slip = Some(SlipSpec {
            turn_ratio: 0.95,
            ..SlipSpec::default()
        });
    });
    refused("faults[1].begins.at_s", |r| {
        let frozen = |at_s| FaultSpec::LidarFrozen {
            begins: Begin::at(at_s),
            lasts_s: None,
        };
        r.faults = vec![frozen(1.0), frozen(-1.0)];
    });
    refused("odometry.turn_per_turn", |r| {
        r.odometry = Some(OdometrySpec {
            turn_per_turn: f64::NAN,
            ..OdometrySpec::default()
        });
    });
}

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
