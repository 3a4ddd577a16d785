//! Somebody comes towards the robot in a corridor in which the two just pass: it moves aside in time.

#![allow(clippy::print_stdout, reason = "results of a failed run")]

use crate::support::{Loop, block, disc, path};
use zeronav_local_planner::beam;
use zeronav_local_planner::beam::options::BeamConfig;
use zeronav_local_planner::dwa::options::DwaConfig;
use zeronav_local_planner::dwa_t::options::DwaTConfig;
use zeronav_msgs::Pose;
use zeronav_msgs::obstacles::Obstacle;

const PERSON_M: f64 = 0.3;
const ROBOT_M: f64 = 0.25;
const LENGTH_M: f64 = 16.0;

/// A person who walks at `speed_mps` through a corridor of this width, `aside_m` beside its middle:
/// least distance between the two, and the time of arrival. [m], [s]
fn pass(width_m: f64, speed_mps: f64, aside_m: f64) -> (f64, Option<f64>) {
    let high_m = width_m + 0.4;
    let walls = [
        block(0.0, 0.0, LENGTH_M, 0.2),
        block(0.0, high_m - 0.2, LENGTH_M, high_m),
    ];
    let middle_m = 0.5 * high_m;
    let robot = disc(ROBOT_M, 0.9, 1.2, 1.9, 4.0);
    let corners = path(&[(1.0, middle_m), (LENGTH_M - 1.0, middle_m)]);
    let start = Pose::new(1.0, middle_m, 0.0);
    let mut run = Loop::new(robot, &walls, (LENGTH_M, high_m), start, corners);
    let mut controller = beam::beam(
        DwaConfig::default(),
        DwaTConfig::default(),
        BeamConfig::default(),
    );
    let mut least_m = f64::INFINITY;
    while run.time_s < 60.0 {
        let at = (LENGTH_M - 1.5 - speed_mps * run.time_s, middle_m + aside_m);
        run.blocks.truncate(2);
        run.obstacles.clear();
        if at.0 > -1.0 {
            run.obstacles.push(Obstacle {
                track: 1,
                x_m: at.0,
                y_m: at.1,
                vx_mps: -speed_mps,
                radius_m: PERSON_M,
                covariance: [1e-3, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.02, 0.0, 0.02],
                ..Obstacle::default()
            });
            let half_m = 0.7 * PERSON_M;
            run.blocks.push(block(
                at.0 - half_m,
                at.1 - half_m,
                at.0 + half_m,
                at.1 + half_m,
            ));
        }
        run.step(&mut controller);
        let apart_m = (run.pose.x_m - at.0).hypot(run.pose.y_m - at.1) - PERSON_M - ROBOT_M;
        least_m = least_m.min(apart_m);
        if run.pose.distance_m(&run.goal.pose) < run.goal.tolerance_m {
            return (least_m, Some(run.time_s));
        }
    }
    (least_m, None)
}

#[test]
fn a_person_who_comes_down_a_narrow_corridor_is_evaded() {
    for (width_m, speed_mps, aside_m) in [
        (2.0, 0.6, 0.1),
        (2.0, 0.75, 0.0),
        (2.0, 0.9, -0.15),
        (2.1, 0.6, 0.0),
        (2.1, 0.75, 0.0),
        (2.2, 0.9, 0.0),
    ] {
        let (least_m, time_s) = pass(width_m, speed_mps, aside_m);
        println!("{width_m} m, {speed_mps} m/s, {aside_m} m: {least_m:.3} m, {time_s:?}");
        assert!(least_m > 0.0, "{width_m} m, {speed_mps} m/s: touched");
        assert!(time_s.is_some(), "{width_m} m, {speed_mps} m/s: no arrival");
    }
}
