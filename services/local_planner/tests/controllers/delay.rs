//! Robots whose commands take effect late, as their description says: every controller arrives without
//! contact, about as soon as without delay.

#![allow(clippy::print_stdout, reason = "results of a failed run")]

use crate::support::whole::Whole;
use crate::support::{Block, Loop, Robot, block, disc, goal_at, jackal, path};
use zeronav_msgs::Pose;
use zeronav_msgs::task::TaskState;

/// The controllers of this project, and one of a paper.
const CONTROLLERS: [&str; 5] = ["beam", "dwa", "dwa_t", "mppi", "ju_r6"];

/// A robot that obeys `periods` late.
fn late(mut robot: Robot, periods: usize) -> Robot {
    robot.description.actuation_delay_ns = 20_000_000 * periods as u64;
    robot
}

fn walls(width_m: f64, height_m: f64) -> Vec<Block> {
    vec![
        block(0.0, 0.0, width_m, 0.2),
        block(0.0, height_m - 0.2, width_m, height_m),
        block(0.0, 0.0, 0.2, height_m),
        block(width_m - 0.2, 0.0, width_m, height_m),
    ]
}

/// Between walls round two corners, to a goal with a yaw: how long it takes. [s]
fn around(robot: Robot, delay: usize, controller: &str) -> f64 {
    let mut blocks = walls(9.0, 6.0);
    blocks.push(block(2.8, 0.0, 3.2, 4.0));
    blocks.push(block(5.8, 2.0, 6.2, 6.0));
    let corners = [
        (1.5, 1.5),
        (1.5, 3.0),
        (2.5, 4.8),
        (3.5, 4.8),
        (5.5, 1.2),
        (6.5, 1.2),
        (7.5, 4.5),
    ];
    let mut run = Loop::new(
        late(robot, delay),
        &blocks,
        (9.0, 6.0),
        Pose::new(1.5, 1.5, -1.0),
        path(&corners),
    );
    run.goal = goal_at(&run.path, 0.15, -1.6, 0.2);
    run.delay = delay;
    let mut whole = Whole::with(controller);
    while run.time_s < 90.0 && whole.state() != Some(TaskState::Reached) {
        run.step(&mut whole);
    }
    let name = format!("{controller}, {delay} periods late");
    println!("{name}: {:.2} s, nearest {:.3} m", run.time_s, run.least_m);
    assert_eq!(whole.state(), Some(TaskState::Reached), "{name}");
    assert!(run.least_m > 0.0, "{name}: contact");
    // Nothing on its way to the wheels carries it off the goal.
    for _ in 0..50 {
        run.step(&mut whole);
    }
    let off_m = run.pose.distance_m(&run.goal.pose);
    assert!(off_m <= 0.16, "{name}: {off_m} m off");
    run.time_s
}

#[test]
fn late_robots_arrive_as_others_do() {
    for robot in [disc(0.25, 0.9, 1.2, 1.9, 4.0), jackal()] {
        for controller in CONTROLLERS {
            let at_once_s = around(robot.clone(), 0, controller);
            for delay in [3, 8, 15, 25] {
                let late_s = around(robot.clone(), delay, controller);
                assert!(
                    late_s < 1.3 * at_once_s + 1.0,
                    "{controller}: {late_s} s instead of {at_once_s} s"
                );
            }
        }
    }
}
