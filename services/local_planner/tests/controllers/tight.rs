//! Robots with corners where there is no room to turn: beside walls, in front of them, in aisles, round
//! bends, and at goals along a wall. Every command is checked in the real world; nothing is touched.

#![allow(clippy::print_stdout, reason = "results of a failed run")]

use crate::support::whole::Whole;
use crate::support::{Block, Loop, Robot, block, goal_at, path};
use core::f64::consts::{FRAC_PI_2, PI};
use zeronav_local_planner::recovery::Behaviour;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::task::TaskState;

/// A rectangle that reaches so far ahead, back and to either side of its axle, and may drive backwards.
fn rectangle(ahead_m: f64, back_m: f64, side_m: f64, back_mps: f64) -> Robot {
    let corner = |(x_m, y_m)| Corner { x_m, y_m };
    Robot {
        description: Description {
            inscribed_radius_m: side_m.min(ahead_m).min(back_m),
            circumscribed_radius_m: ahead_m.max(back_m).hypot(side_m),
            v_mps_max: 0.8,
            v_mps_min: -back_mps,
            w_radps_max: 1.5,
            a_mps2_max: 0.8,
            brake_mps2: 1.0,
            alpha_radps2_max: 2.0,
            angle_min_rad: -PI,
            angle_increment_rad: PI / 180.0,
            n_beams: 360,
            n_corners: 4,
            ..Description::default()
        },
        corners: [
            (ahead_m, side_m),
            (-back_m, side_m),
            (-back_m, -side_m),
            (ahead_m, -side_m),
        ]
        .map(corner)
        .to_vec(),
    }
}

/// A hall of 14 x 8 m with walls of 0.2 m.
fn hall() -> [Block; 4] {
    [
        block(0.0, 0.0, 14.0, 0.2),
        block(0.0, 7.8, 14.0, 8.0),
        block(0.0, 0.0, 0.2, 8.0),
        block(13.8, 0.0, 14.0, 8.0),
    ]
}

/// Drives until the goal is reached. Every command leaves room to brake in the real world.
#[track_caller]
fn check_reaches(name: &str, run: &mut Loop, controller: &str, limit_s: f64) {
    let mut whole = Whole::with(controller);
    let mut before = Twist::REST;
    while whole.state() != Some(TaskState::Reached) && run.time_s < limit_s {
        let pose = run.pose;
        let decision = run.step(&mut whole);
        if before != Twist::REST {
            run.check_command(before, &pose, &decision);
        }
        before = Twist::new(decision.v_mps, decision.w_radps);
    }
    println!(
        "{name}, {controller}: {:.1} s, {:.2} m, nearest {:.3} m, {:?} {:?}",
        run.time_s, run.driven_m, run.least_m, run.pose, whole.changes
    );
    assert!(run.least_m > 0.0, "{name}, {controller}: touched something");
    let state = whole.state();
    assert_eq!(state, Some(TaskState::Reached), "{name}, {controller}");
}

/// Beside the lower wall of the hall with a gap, facing along it.
fn beside_wall(robot: &Robot, gap_m: f64, yaw_rad: f64, to: (f64, f64)) -> Loop {
    let side_m = robot.description.inscribed_radius_m;
    let start = Pose::new(6.0, 0.2 + gap_m + side_m, yaw_rad);
    // Away from the wall first, as a planner leads that prices clearance.
    let middle = if to.0 > 6.0 { 7.0 } else { 5.0 };
    let corners = path(&[(6.0, start.y_m), (middle, to.1.max(1.3)), to]);
    Loop::new(robot.clone(), &hall(), (14.0, 8.0), start, corners)
}

#[test]
fn a_rectangle_beside_a_wall_gets_away() {
    let small = rectangle(0.3, 0.3, 0.2, 0.0);
    let long = rectangle(0.6, 0.6, 0.25, 0.0);
    let forklift = rectangle(0.4, 1.0, 0.3, 0.3);
    for (name, robot, gaps_m) in [
        ("0.6 x 0.4 m", &small, [0.03, 0.06, 0.15]),
        ("1.2 x 0.5 m", &long, [0.06, 0.12, 0.25]),
        ("off centre", &forklift, [0.06, 0.12, 0.25]),
    ] {
        for gap_m in gaps_m {
            for (yaw_rad, to) in [(0.0, (11.0, 1.3)), (PI, (3.0, 4.0)), (0.0, (3.0, 3.0))] {
                let mut run = beside_wall(robot, gap_m, yaw_rad, to);
                let name = format!("{name}, {gap_m} m from the wall, yaw {yaw_rad} to {to:?}");
                check_reaches(&name, &mut run, "beam", 60.0);
            }
        }
    }
}

#[test]
fn every_dynamic_window_gets_away_from_a_wall() {
    for controller in ["dwa", "dwa_t", "mppi"] {
        let robot = rectangle(0.6, 0.6, 0.25, 0.3);
        let mut run = beside_wall(&robot, 0.1, PI, (11.0, 3.0));
        check_reaches("beside a wall", &mut run, controller, 60.0);
    }
}

#[test]
fn a_goal_along_a_wall_is_reached_with_its_yaw() {
    for (robot, gap_m, yaw_rad) in [
        (rectangle(0.3, 0.3, 0.2, 0.0), 0.1, 0.0),
        (rectangle(0.3, 0.3, 0.2, 0.3), 0.06, PI),
        (rectangle(0.6, 0.6, 0.25, 0.0), 0.1, 0.0),
    ] {
        let goal_m = 0.2 + gap_m + robot.description.inscribed_radius_m;
        let corners = path(&[(3.0, 1.5), (8.0, 1.5), (9.0, goal_m)]);
        let start = Pose::new(3.0, 1.5, 0.0);
        let mut run = Loop::new(robot, &hall(), (14.0, 8.0), start, corners);
        run.goal = goal_at(&run.path, 0.1, yaw_rad, 0.2);
        check_reaches(
            &format!("along a wall, yaw {yaw_rad}"),
            &mut run,
            "beam",
            60.0,
        );
        assert!(run.pose.distance_m(&run.goal.pose) <= 0.1);
        assert!(wrap_angle(run.pose.yaw_rad - yaw_rad).abs() <= 0.2);
    }
}

#[test]
fn a_robot_with_its_nose_at_a_wall_backs_off() {
    for gap_m in [0.03, 0.08] {
        let robot = rectangle(0.6, 0.6, 0.25, 0.3);
        let start = Pose::new(0.2 + gap_m + 0.6, 4.0, PI);
        let corners = path(&[(start.x_m, 4.0), (8.0, 4.0)]);
        let mut run = Loop::new(robot, &hall(), (14.0, 8.0), start, corners);
        check_reaches(
            &format!("nose {gap_m} m from a wall"),
            &mut run,
            "beam",
            60.0,
        );
    }
}

#[test]
fn a_long_aisle_is_left_backwards() {
    let blocks = [
        block(0.0, 0.0, 12.0, 3.5),
        block(0.0, 4.5, 12.0, 8.0),
        block(0.0, 3.5, 0.5, 4.5),
    ];
    let start = Pose::new(1.3, 4.0, PI);
    let corners = path(&[(1.3, 4.0), (14.0, 4.0)]);
    let robot = rectangle(0.6, 0.6, 0.25, 0.3);
    let mut run = Loop::new(robot, &blocks, (16.0, 8.0), start, corners);
    check_reaches("an aisle of 12 m", &mut run, "beam", 90.0);
}

#[test]
fn a_long_robot_gets_round_the_corner_of_a_corridor() {
    for (robot, width_m) in [
        (rectangle(0.6, 0.6, 0.25, 0.0), 1.2),
        (rectangle(0.85, 0.85, 0.3, 0.3), 1.3),
        (rectangle(0.4, 1.2, 0.35, 0.3), 1.6),
    ] {
        let blocks = [
            block(0.0, 0.0, 9.0, 1.0),
            block(0.0, 1.0 + width_m, 8.0 - width_m, 9.0),
            block(8.0, 0.0, 9.0, 9.0),
        ];
        let (y, x) = (1.0 + 0.5 * width_m, 8.0 - 0.5 * width_m);
        let corners = path(&[(1.8, y), (x - 0.3, y), (x, y + 0.3), (x, 7.0)]);
        let start = Pose::new(1.8, y, 0.0);
        let mut run = Loop::new(robot, &blocks, (9.0, 9.0), start, corners);
        run.goal = goal_at(&run.path, 0.15, FRAC_PI_2, 0.3);
        check_reaches(&format!("corner of {width_m} m"), &mut run, "beam", 90.0);
    }
}

/// A robot that has to pass a passage too narrow to turn in, to turn round behind it for a path that leads back, goes on
/// ahead when a path comes that does.
#[test]
fn a_manoeuvre_ends_where_another_path_leads_on() {
    // It drives ahead only, so that it looks for room to turn.
    let robot = rectangle(0.3, 0.3, 0.2, 0.0);
    // A passage of 0.6 m from x = 5 to 7, and the robot in it: its outline of 0.72 m across cannot turn.
    let passage = [block(5.0, 0.2, 7.0, 3.7), block(5.0, 4.3, 7.0, 7.8)];
    let blocks = [&hall()[..], &passage].concat();
    let start = Pose::new(6.5, 4.0, 0.0);
    let back = path(&[(6.5, 4.0), (3.0, 4.0)]);
    let mut run = Loop::new(robot, &blocks, (14.0, 8.0), start, back);
    let mut whole = Whole::with("dwa_t");
    let passed = |run: &Loop| run.pose.x_m > 7.05 && run.pose.yaw_rad.abs() < 0.2;
    while !passed(&run) && run.time_s < 40.0 {
        run.step(&mut whole);
    }
    assert!(passed(&run), "{:?} {:?}", run.pose, whole.changes);
    let manoeuvres = |whole: &Whole| {
        let begun = whole
            .changes
            .iter()
            .filter(|change| change.to == Behaviour::Manoeuvre);
        begun.count()
    };
    let begun = manoeuvres(&whole);
    assert!(begun > 0, "{:?}", whole.changes);
    run.replan(path(&[(run.pose.x_m, 4.0), (12.0, 4.0)]));
    let (mut turned_rad, mut yaw_rad) = (0.0, run.pose.yaw_rad);
    while run.pose.x_m < 11.0 && run.time_s < 30.0 {
        run.step(&mut whole);
        turned_rad += wrap_angle(run.pose.yaw_rad - yaw_rad).abs();
        yaw_rad = run.pose.yaw_rad;
    }
    assert!(run.pose.x_m > 11.0, "{:?} {:?}", run.pose, whole.changes);
    assert!(turned_rad < 0.5, "turned {turned_rad} rad");
    assert_eq!(manoeuvres(&whole), begun, "{:?}", whole.changes);
}
