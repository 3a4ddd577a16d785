//! What stops the robot, and how it is counted.

use super::*;

#[test]
fn a_thin_wall_stops_a_fast_robot() {
    let wall = a_box([10.0, 0.0], [0.01, 8.0]);
    let mut robot = simulator(&config(vec![wall], Vec::new()));
    for _ in 0..400 {
        drive(&mut robot, 1, 5.0, 0.0);
        assert!(robot.odometry().pose.x_m < 9.995 - 0.25);
    }
    let truth = truth(&mut robot);
    close(truth.pose.x_m, 9.995 - 0.25, 2e-4);
    assert_eq!((truth.contacts_moving, truth.contacts_standing), (1, 0));
    assert_eq!(truth.in_contact, 1);
    close(truth.clearance_m, 0.0, 0.0);
    close(truth.v_mps, 0.0, 0.0);
}

#[test]
fn a_contact_counts_once_until_the_robot_has_left() {
    let wall = a_box([2.0, 0.0], [1.0, 4.0]);
    let mut robot = simulator(&config(vec![wall], Vec::new()));
    drive(&mut robot, 200, 1.0, 0.0);
    let touching = truth(&mut robot);
    assert_eq!((touching.contacts_moving, touching.in_contact), (1, 1));
    // It pushes, turns on the spot, and pushes again: the same contact.
    drive(&mut robot, 500, 1.0, 0.0);
    drive(&mut robot, 50, 0.0, 1.0);
    let turned = truth(&mut robot);
    assert!(turned.pose.yaw_rad > 0.5, "a disc turns in contact");
    drive(&mut robot, 50, 0.0, -1.0);
    assert_eq!(truth(&mut robot).contacts_moving, 1);
    // Back, which is free, and into it again.
    drive(&mut robot, 100, -0.5, 0.0);
    let away = truth(&mut robot);
    assert_eq!(away.in_contact, 0);
    close(away.clearance_m, 1.25 - away.pose.x_m, 1e-9);
    assert!(away.clearance_m > 0.5);
    drive(&mut robot, 200, 1.0, 0.0);
    let again = truth(&mut robot);
    assert_eq!((again.contacts_moving, again.contacts_standing), (2, 0));
}

#[test]
fn pushing_for_long_makes_no_hole() {
    let wall = a_box([2.0, 0.0], [0.001, 30.0]);
    let mut config = config(vec![wall], Vec::new());
    config.robot.radius_m = None;
    config.robot.footprint_m = Some(vec![[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]);
    let mut robot = simulator(&config);
    for _ in 0..20 {
        drive(&mut robot, 500, 1.0, 0.0);
        drive(&mut robot, 500, 1.0, 0.02);
        drive(&mut robot, 500, 1.0, -0.02);
        assert!(robot.odometry().pose.x_m < 1.9995 - 0.2);
    }
}

#[test]
fn a_corner_that_swings_into_a_wall_moves() {
    let wall = a_box([0.0, 1.0], [4.0, 1.4]);
    let mut config = config(vec![wall], Vec::new());
    config.robot.radius_m = None;
    config.robot.footprint_m = Some(vec![[-0.5, -0.2], [0.5, -0.2], [0.5, 0.2], [-0.5, 0.2]]);
    let mut robot = simulator(&config);
    drive(&mut robot, 100, 0.0, 1.0);
    let truth = truth(&mut robot);
    assert_eq!((truth.contacts_moving, truth.contacts_standing), (1, 0));
    // The corner (0.5, 0.2) reaches y = 0.3: r sin(yaw + atan 0.4) = 0.3.
    let yaw_rad = (0.3 / 0.5_f64.hypot(0.2)).asin() - 0.4_f64.atan();
    close(truth.pose.yaw_rad, yaw_rad, 5e-4);
    drive(&mut robot, 20, 0.0, -1.0);
    assert!(robot.odometry().pose.yaw_rad < 0.0);
}

#[test]
fn a_wall_alongside_does_not_hold_the_robot() {
    // 0.05 mm beside a long wall, which touches; parallel and away are free, towards it is not.
    let wall = a_box([0.0, 0.75], [30.0, 1.0]);
    let mut config = config(vec![wall], Vec::new());
    config.start = [0.0, -1.0, 0.0];
    let mut robot = simulator(&config);
    robot.state.pose.y_m = 0.25 - 0.25 - 5.0e-5;
    drive(&mut robot, 200, 1.0, 0.0);
    assert!(robot.odometry().pose.x_m > 3.0);
    drive(&mut robot, 50, 0.0, 0.2);
    let before = robot.odometry().pose;
    assert!(before.yaw_rad > 0.1);
    drive(&mut robot, 50, 0.5, 0.0);
    close(robot.odometry().pose.x_m, before.x_m, 1e-3);
    drive(&mut robot, 50, -0.5, 0.0);
    assert!(robot.odometry().pose.x_m < before.x_m - 0.2);
    assert_eq!(truth(&mut robot).in_contact, 0);
}

#[test]
fn an_obstacle_that_walks_into_the_robot_is_a_contact() {
    let mut walker = obstacle(a_box([3.0, 0.0], [0.5, 0.5]), None);
    walker.waypoints_m = vec![[-3.0, 0.0]];
    walker.speed_mps = 1.0;
    let config = config(Vec::new(), vec![walker]);
    let mut robot = simulator(&config);
    // Gap 3 - 0.25 - 0.25 = 2.5 m at 1 m/s.
    drive(&mut robot, 124, 0.0, 0.0);
    assert_eq!(truth(&mut robot).in_contact, 0);
    drive(&mut robot, 2, 0.0, 0.0);
    let hit = truth(&mut robot);
    assert_eq!((hit.contacts_standing, hit.contacts_moving), (1, 0));
    assert_eq!(hit.in_contact, 1);
    close(truth_of_obstacles(&mut robot)[0].pose.x_m, 3.0 - 2.52, 1e-9);
    // It walks through and leaves on the other side.
    drive(&mut robot, 174, 0.0, 0.0);
    let left = truth(&mut robot);
    assert_eq!((left.in_contact, left.contacts_standing), (0, 1));
    close(left.clearance_m, 2.5, 1e-9);

    // The same walker meets a robot on its way: its doing too. 0.09 m to get going, then
    // 1.6 m/s of closing speed: 1.62 s, in tick 81.
    let mut robot = simulator(&config);
    drive(&mut robot, 80, 0.6, 0.0);
    assert_eq!(truth(&mut robot).in_contact, 0);
    drive(&mut robot, 1, 0.6, 0.0);
    let hit = truth(&mut robot);
    assert_eq!((hit.contacts_standing, hit.contacts_moving), (0, 1));
    close(hit.v_mps, 0.0, 0.0);
}

#[test]
fn a_fast_obstacle_is_not_missed_between_ticks() {
    let mut ball = obstacle(
        ShapeSpec::Disc {
            centre_m: [0.25, 5.03],
            radius_m: 0.01,
        },
        None,
    );
    ball.waypoints_m = vec![[0.25, -5.0]];
    ball.speed_mps = 20.0;
    let mut robot = simulator(&config(Vec::new(), vec![ball]));
    // 0.4 m a tick, and the disc of the robot is met for 0.14 m only.
    drive(&mut robot, 20, 0.0, 0.0);
    assert_eq!(truth(&mut robot).contacts_standing, 1);
}

#[test]
fn a_robot_may_leave_what_appeared_on_it_but_not_go_deeper() {
    let spawned = obstacle(a_box([0.6, 0.0], [1.0, 1.0]), Some(at(0.01)));
    let mut robot = simulator(&config(Vec::new(), vec![spawned]));
    drive(&mut robot, 1, 0.0, 0.0);
    assert_eq!(truth(&mut robot).contacts_standing, 1);
    drive(&mut robot, 100, 1.0, 0.0);
    close(robot.odometry().pose.x_m, 0.0, 1e-6);
    drive(&mut robot, 100, -1.0, 0.0);
    let truth = truth(&mut robot);
    assert!(truth.pose.x_m < -1.0 && truth.in_contact == 0);
    assert_eq!((truth.contacts_standing, truth.contacts_moving), (1, 0));
}

#[test]
fn clutter_is_touched_often_and_never_entered() {
    let (_, mut robot) = random_drive(SEED, 0.0);
    let truth = truth(&mut robot);
    assert!(truth.contacts_moving > 10, "{truth:?}");
    assert!(truth.driven_m > 10.0, "{truth:?}");
}

#[test]
fn clearance_is_that_of_the_footprint() {
    let mut config = config(vec![a_box([0.0, 3.0], [2.0, 2.0])], Vec::new());
    config.robot.radius_m = None;
    config.robot.footprint_m = Some(vec![[-0.3, -0.2], [0.3, -0.2], [0.3, 0.2], [-0.3, 0.2]]);
    config.start = [0.0, 0.0, FRAC_PI_2];
    close(truth(&mut simulator(&config)).clearance_m, 1.7, 1e-12);
    config.world.shapes.clear();
    close(truth(&mut simulator(&config)).clearance_m, 1000.0, 0.0);
    let there = obstacle(a_box([-2.0, 0.0], [1.0, 1.0]), None);
    config.world.obstacles = vec![there];
    close(truth(&mut simulator(&config)).clearance_m, 1.3, 1e-12);
}

#[test]
fn what_bounces_into_a_standing_robot_is_not_its_doing() {
    let disc = ShapeSpec::Disc {
        centre_m: [3.0, 0.0],
        radius_m: 0.3,
    };
    let bounces = ObstacleSpec {
        bounces_mps: Some([-1.0, 0.0]),
        ..obstacle(disc.clone(), None)
    };
    let mut robot = simulator(&config(Vec::new(), vec![bounces]));
    drive(&mut robot, 200, 0.0, 0.0);
    let standing = truth(&mut robot);
    assert_eq!(
        (standing.contacts_moving, standing.contacts_standing),
        (0, 1)
    );
    // A recorded one that the robot drives into is.
    let played = ObstacleSpec {
        track: vec![[0.0, 3.0, 0.0], [9.0, 3.0, 0.1]],
        ..obstacle(disc, None)
    };
    let mut robot = simulator(&config(Vec::new(), vec![played]));
    drive(&mut robot, 200, 1.0, 0.0);
    let moving = truth(&mut robot);
    assert_eq!((moving.contacts_moving, moving.contacts_standing), (1, 0));
}

#[test]
fn a_track_that_jumps_onto_the_robot_touches_it_at_that_moment() {
    let disc = ShapeSpec::Disc {
        centre_m: [0.3, 0.0],
        radius_m: 0.3,
    };
    // Away from the robot, and back on it after 1.01 s, between two ticks.
    let played = ObstacleSpec {
        track: vec![[0.0, 0.3, 0.0], [1.0, 5.0, 0.0]],
        track_from_s: 0.99,
        repeat: true,
        ..obstacle(disc, Some(at(1.0)))
    };
    let mut robot = simulator(&config(Vec::new(), vec![played]));
    drive(&mut robot, 50, 0.0, 0.0);
    assert_eq!(truth(&mut robot).contacts_standing, 0);
    drive(&mut robot, 1, 0.0, 0.0);
    assert_eq!(truth(&mut robot).contacts_standing, 1);
}
