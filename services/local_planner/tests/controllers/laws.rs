//! Laws over random worlds, paths and robots: limits, accelerations, room to brake, no contact,
//! and the same answers twice.

#![allow(clippy::print_stdout, reason = "seeds and results of a failed run")]

use crate::support::{Block, Loop, Robot, block, disc, jackal, path};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use zeronav_casts::Cast;
use zeronav_local_planner::dwa;
use zeronav_local_planner::dwa::options::DwaConfig;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::command::Validity;

const SIDE_M: f64 = 8.0;

fn robot(random: &mut Pcg32) -> Robot {
    match random.random_range(0..4) {
        0 => jackal(),
        1 => disc(0.105, 0.22, 2.5, 2.84, 3.2),
        2 => disc(0.25, 1.0, 1.5, 1.8, 3.0),
        _ => disc(0.25, 0.8, 1.0, 1.8, 3.0),
    }
}

fn boxes(random: &mut Pcg32, n: usize) -> Vec<Block> {
    let mut blocks = vec![
        block(0.0, 0.0, SIDE_M, 0.2),
        block(0.0, SIDE_M - 0.2, SIDE_M, SIDE_M),
        block(0.0, 0.0, 0.2, SIDE_M),
        block(SIDE_M - 0.2, 0.0, SIDE_M, SIDE_M),
    ];
    for _ in 0..n {
        let (x, y) = (random.random_range(1.0..7.0), random.random_range(1.0..7.0));
        let (w, h) = (random.random_range(0.1..0.8), random.random_range(0.1..0.8));
        blocks.push(block(x, y, x + w, y + h));
    }
    blocks
}

/// True when a disc of `radius_m` passes from `a` to `b`.
fn is_clear(run: &Loop, a: (f64, f64), b: (f64, f64), radius_m: f64) -> bool {
    let outer_m = run.robot.description.circumscribed_radius_m;
    (0..=100).all(|step| {
        let share = f64::from(step) / 100.0;
        let at = Pose::new(a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share, 0.0);
        let centre_m = run.blocks.iter().map(|block| block.distance_m(at.point()));
        centre_m.fold(f64::INFINITY, f64::min) > radius_m.max(outer_m)
    })
}

/// A random world with a path of up to three legs that is free of what the map knows.
/// `unknown` boxes stand wherever they like and are seen by the lidar alone.
fn random_loop(seed: u64, unknown: usize) -> Loop {
    let mut random = Pcg32::seed_from_u64(seed);
    let robot = robot(&mut random);
    let margin_m = robot.description.circumscribed_radius_m + 0.15;
    let known = boxes(&mut random, 6);
    let place = |random: &mut Pcg32| (random.random_range(0.8..7.2), random.random_range(0.8..7.2));
    let mut start = place(&mut random);
    let mut run = Loop::new(
        robot,
        &known,
        (SIDE_M, SIDE_M),
        Pose::default(),
        path(&[(0.0, 0.0)]),
    );
    while !is_clear(&run, start, start, margin_m) {
        start = place(&mut random);
    }
    let mut corners = vec![start];
    for _ in 0..50 {
        let next = place(&mut random);
        if corners.len() < 4 && is_clear(&run, corners[corners.len() - 1], next, margin_m) {
            corners.push(next);
        }
    }
    run.replan(path(&corners));
    run.pose = Pose::new(start.0, start.1, random.random_range(-3.0..3.0));
    for block in boxes(&mut random, unknown).split_off(4) {
        run.blocks.push(block);
        if run.distance_m(&run.pose) < 0.1 {
            run.blocks.pop();
        }
    }
    run.delay = random.random_range(0..3);
    run
}

/// Runs for a while and checks every command; true when the robot arrived.
fn check_laws(run: &mut Loop, periods: usize) -> bool {
    let mut controller = dwa::dwa(DwaConfig::default());
    let mut before = Twist::REST;
    for _ in 0..periods {
        let pose = run.pose;
        let decision = run.step(&mut controller);
        run.check_command(before, &pose, &decision);
        before = Twist::new(decision.v_mps, decision.w_radps);
        assert!(run.least_m > 0.0, "contact at {:?}", run.pose);
        if decision.validity == Validity::AtGoal && run.twist.is_stopped() {
            return true;
        }
    }
    false
}

#[test]
fn free_paths_are_driven_to_their_ends_by_the_rules() {
    for seed in 0..20 {
        println!("seed {seed}");
        let mut run = random_loop(seed, 0);
        let fastest_mps = run.robot.description.v_mps_max;
        let length_m: f64 = run
            .path
            .windows(2)
            .map(|leg| (leg[1].x_m - leg[0].x_m).hypot(leg[1].y_m - leg[0].y_m))
            .sum();
        // Half the speed, and ten seconds for turns on the spot.
        let limit_s = length_m / (0.5 * fastest_mps) + 10.0;
        let periods = (limit_s / crate::support::PERIOD_S).to_usize();
        let arrived = check_laws(&mut run, periods);
        println!(
            "{length_m:.1} m in {:.1} s, nearest {:.3}",
            run.time_s, run.least_m
        );
        assert!(arrived, "stands at {:?}", run.pose);
    }
}

#[test]
fn unknown_obstacles_on_the_path_are_never_touched() {
    let (mut driven_m, mut arrived) = (0.0, 0);
    for seed in 0..24 {
        println!("seed {seed}");
        let mut run = random_loop(seed, 4);
        arrived += u32::from(check_laws(&mut run, 600));
        driven_m += run.driven_m;
    }
    // The laws would hold for a robot that never moves.
    println!("{driven_m:.1} m driven, {arrived} of 24 arrived past the obstacles");
    assert!(driven_m > 50.0);
    assert!(arrived >= 2);
}

#[test]
fn the_same_situations_give_the_same_decisions() {
    for seed in 100..105 {
        println!("seed {seed}");
        let decisions = || {
            let mut run = random_loop(seed, 4);
            let mut controller = dwa::dwa(DwaConfig::default());
            for _ in 0..200 {
                run.step(&mut controller);
            }
            run.history
        };
        assert_eq!(decisions(), decisions());
    }
}
