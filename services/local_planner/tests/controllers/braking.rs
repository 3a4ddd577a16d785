//! The way back from an emergency stop, for controllers whose commands are limited in jerk.

#![allow(clippy::print_stdout, reason = "speeds of a failed run")]

use crate::support::{Loop, PERIOD_S, block, disc, path};
use zeronav_local_planner::LocalPlannerConfig;
use zeronav_local_planner::table::controller;
use zeronav_msgs::Pose;

/// A wall drops before a robot at speed and is gone again before it has come to rest: the braking
/// ends with its cause, not when the jerk would have ended it.
#[test]
fn braking_ends_with_its_cause() {
    let mut config = LocalPlannerConfig::default();
    config.shaping.jerk_mps3 = 10.0;
    for key in ["dwa_t", "dwa", "ju_r7"] {
        let walls = [block(0.0, 0.0, 14.0, 0.4), block(0.0, 3.6, 14.0, 4.0)];
        let corners = path(&[(1.0, 2.0), (13.0, 2.0)]);
        let mut run = Loop::new(
            disc(0.25, 1.0, 1.5, 1.8, 3.0),
            &walls,
            (14.0, 4.0),
            Pose::new(1.0, 2.0, 0.0),
            corners,
        );
        let row = controller(key).expect("in the table");
        let mut controller = (row.build)(&config);
        let mut speed_mps = 0.0;
        while run.time_s < 4.0 {
            speed_mps = run.step(&mut controller).v_mps;
        }
        assert!(speed_mps > 0.8, "{key}: {speed_mps}");
        let wall_m = run.pose.x_m + 0.25 + 0.45;
        run.blocks.push(block(wall_m, 0.4, wall_m + 0.2, 3.6));
        let mut braked = 0;
        for _ in 0..8 {
            let next_mps = run.step(&mut controller).v_mps;
            braked += u32::from(speed_mps - next_mps > 1.4 * PERIOD_S);
            speed_mps = next_mps;
        }
        assert!(braked >= 5, "{key} braked {braked} times");
        run.blocks.pop();
        let next_mps = run.step(&mut controller).v_mps;
        println!("{key}: {speed_mps} to {next_mps}");
        let jerk_mps2 = config.shaping.jerk_mps3 * PERIOD_S;
        assert!(
            next_mps >= speed_mps - jerk_mps2 * PERIOD_S,
            "{key} goes on braking: {speed_mps} to {next_mps}"
        );
    }
}
