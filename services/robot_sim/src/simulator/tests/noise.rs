//! Delay, slip, odometry and noise.

use super::*;
use zeronav_casts::Cast;

#[test]
fn same_seed_same_bits_other_seed_other_noise() {
    let (first, _) = random_drive(SEED, 0.01);
    assert!(first == random_drive(SEED, 0.01).0);
    let (other, _) = random_drive(SEED + 1, 0.01);
    assert!(first != other);
    // The seed draws noise and nothing else.
    assert!(random_drive(SEED, 0.0).0 == random_drive(SEED + 1, 0.0).0);
}

/// A robot with every kind of noise on, in a world where everything moves.
fn awkward() -> SimConfig {
    let disc = |x: f64, y: f64| ShapeSpec::Disc {
        centre_m: [x, y],
        radius_m: 0.3,
    };
    let obstacles = vec![
        ObstacleSpec {
            bounces_mps: Some([0.7, 0.4]),
            ..ObstacleSpec::standing("bounces", disc(3.0, 2.0))
        },
        ObstacleSpec {
            waypoints_m: vec![[4.0, -3.0], [-4.0, -3.0]],
            speed_mps: 0.8,
            repeat: true,
            ..ObstacleSpec::standing("walks", disc(4.0, -3.0))
        },
        ObstacleSpec {
            track: vec![[0.0, -5.0, 4.0], [3.0, 5.0, 4.0]],
            repeat: true,
            ..ObstacleSpec::standing("played", disc(-5.0, 4.0))
        },
    ];
    let shapes = vec![
        a_box([6.0, 0.0], [0.2, 12.0]),
        a_box([0.0, 6.0], [12.0, 0.2]),
    ];
    let mut config = config(shapes, obstacles);
    config.robot = zeronav_robot_description::RobotPreset::Turtlebot2.robot();
    config
}

/// Every bit that a drive through curves gives to others.
fn bits_of_a_drive(config: &SimConfig, seed: u64) -> Vec<u64> {
    let mut robot = Simulator::new(config, world_of(config), seed, TICK).expect("a simulator");
    let mut ranges = vec![0.0; robot.n_beams()];
    let mut obstacles = Vec::new();
    let mut bits = Vec::new();
    for tick in 1..=500_u64 {
        if tick % 50 == 1 {
            robot.set_command(0.4, if tick % 100 == 1 { 0.8 } else { -0.5 });
        }
        robot.step(tick * TICK, (tick % 50) * TICK / 10);
        if robot.scan(&mut ranges).is_some() {
            bits.extend(ranges.iter().map(|range| u64::from(range.to_bits())));
        }
        let odometry = robot.odometry();
        assert_eq!(odometry.check(), Ok(()));
        let pose = odometry.pose;
        let numbers = [
            pose.x_m,
            pose.y_m,
            pose.yaw_rad,
            odometry.v_mps,
            odometry.variance[2],
        ];
        bits.extend(numbers.map(f64::to_bits));
        let truth = robot.truth(&mut obstacles);
        assert_eq!(truth.check(&obstacles), Ok(()));
        bits.extend([truth.pose.x_m, truth.pose.yaw_rad, truth.clearance_m].map(f64::to_bits));
        bits.extend(obstacles.iter().map(|obstacle| obstacle.pose.x_m.to_bits()));
    }
    bits
}

#[test]
fn with_every_source_of_noise_on_a_run_is_the_same_by_seed() {
    let config = awkward();
    let lidar = &config.robot.lidar;
    assert!(lidar.motion_distortion && lidar.sigma_m > 0.0 && lidar.quantum_m > 0.0);
    assert!(lidar.dropout_ratio > 0.0 && lidar.short_ratio > 0.0 && lidar.edge_ratio > 0.0);
    assert!(config.robot.slip.is_some() && config.robot.odometry.is_some());
    assert!(config.robot.actuation_delay_s > 0.0);
    let first = bits_of_a_drive(&config, 7);
    assert!(first.len() > 20_000, "{}", first.len());
    assert!(first == bits_of_a_drive(&config, 7), "the same seed");
    let differ = |other: &[u64]| first.iter().zip(other).filter(|(a, b)| a != b).count();
    assert!(differ(&bits_of_a_drive(&config, 8)) > first.len() / 4);
    // A scan that is not taken, or taken twice, changes nothing: the truth is the last of a tick.
    let mut robot = Simulator::new(&config, world_of(&config), 7, TICK).expect("a simulator");
    let mut again = vec![0.0; robot.n_beams()];
    let mut ranges = again.clone();
    drive(&mut robot, 20, 0.4, 0.8);
    while robot.scan_due().is_none() {
        drive(&mut robot, 1, 0.4, 0.8);
    }
    robot.scan(&mut ranges);
    robot.scan(&mut again);
    let bits =
        |ranges: &[f32]| -> Vec<u32> { ranges.iter().map(|range| range.to_bits()).collect() };
    assert_eq!(bits(&ranges), bits(&again));
}

#[test]
fn commands_take_effect_after_the_actuation_delay() {
    let mut config = config(Vec::new(), Vec::new());
    config.robot.actuation_delay_s = 0.05;
    let mut robot = simulator(&config);
    // Given at 0, in force from the first tick that begins 50 ms later: at 60 ms.
    drive(&mut robot, 3, 1.0, 0.0);
    close(robot.odometry().v_mps, 0.0, 0.0);
    drive(&mut robot, 1, 1.0, 0.0);
    close(robot.odometry().v_mps, 2.0 * 0.02, 1e-12);
    // Also to stop.
    drive(&mut robot, 50, 1.0, 0.0);
    let before_m = robot.odometry().pose.x_m;
    drive(&mut robot, 3, 0.0, 0.0);
    close(robot.odometry().pose.x_m - before_m, 0.06, 1e-12);
    drive(&mut robot, 1, 0.0, 0.0);
    assert!(robot.odometry().v_mps < 1.0);
}

#[test]
fn slip_is_seen_by_the_truth_and_not_by_odometry() {
    let mut config = config(Vec::new(), Vec::new());
    config.robot.slip = Some(zeronav_robot_description::SlipSpec {
        forward_ratio: 0.1,
        turn_ratio: 0.2,
        sigma_ratio: 0.0,
    });
    let mut robot = simulator(&config);
    drive(&mut robot, 50, 1.0, 0.0);
    drive(&mut robot, 100, 1.0, 1.0);
    let (odometry, truth) = (robot.odometry(), truth(&mut robot));
    close(odometry.v_mps, 1.0, 1e-12);
    close(truth.v_mps, 0.9, 1e-12);
    close(truth.w_radps, 0.8, 1e-12);
    // 2 s of turning, 0.1 s of it to gain speed: 1.95 rad by the wheels.
    close(odometry.pose.yaw_rad, 1.95, 1e-9);
    close(truth.pose.yaw_rad, 0.8 * 1.95, 1e-9);
    close(truth.driven_m, 0.9 * 2.75, 1e-9);
    assert_eq!(odometry.variance.map(f64::to_bits), [0; 3]);
}

#[test]
fn odometry_drifts_as_far_as_it_says() {
    let mut config = config(Vec::new(), Vec::new());
    config.robot.odometry = Some(zeronav_robot_description::OdometrySpec::default());
    let mut n_far = 0;
    for seed in 1..=40 {
        let mut robot =
            Simulator::new(&config, world_of(&config), seed, TICK).expect("a simulator");
        drive(&mut robot, 500, 1.0, 0.5);
        let (odometry, truth) = (robot.odometry(), truth(&mut robot));
        let error_rad = wrap_angle(odometry.pose.yaw_rad - truth.pose.yaw_rad);
        let sigma_rad = odometry.variance[2].sqrt();
        // 9.75 m and 4.99 rad.
        let expected = (0.01_f64.powi(2) * 9.75 + 0.02_f64.powi(2) * 4.99).sqrt();
        close(sigma_rad / expected, 1.0, 0.01);
        n_far += u32::from(error_rad.abs() > sigma_rad);
        assert!(
            error_rad.abs() > 0.0 && error_rad.abs() < 5.0 * sigma_rad,
            "seed {seed}"
        );
    }
    // Beyond one deviation: 0.317 of 40 on average.
    assert!((4..=23).contains(&n_far), "{n_far} of 40");
}

#[test]
fn a_scan_of_a_turning_robot_is_distorted_and_says_so() {
    // A long wall, 2.9 m away.
    let mut config = config(vec![a_box([3.0, 0.0], [0.2, 30.0])], Vec::new());
    config.robot.lidar.motion_distortion = true;
    let mut robot = simulator(&config);
    drive(&mut robot, 100, 0.0, 3.0);
    while robot.scan_due().is_none() {
        drive(&mut robot, 1, 0.0, 3.0);
    }
    let mut ranges = vec![0.0; 360];
    let scan = robot.scan(&mut ranges).expect("a scan");
    assert!((f64::from(scan.time_increment_s) - 0.1 / 360.0).abs() < 1e-9);
    let end_rad = robot.odometry().pose.yaw_rad;
    for (beam, range) in ranges.iter().enumerate() {
        let age_s = (359.0 - beam.to_f64()) * 0.1 / 360.0;
        let angle = end_rad - 3.0 * age_s + scan.angle_of(beam);
        let expected = if angle.cos() > 0.0 {
            2.9 / angle.cos()
        } else {
            f64::INFINITY
        };
        if expected < 9.9 {
            close(f64::from(*range), expected, 1e-4);
        } else if expected > 10.1 {
            assert!(range.is_infinite(), "{range} at beam {beam}");
        }
    }
}
