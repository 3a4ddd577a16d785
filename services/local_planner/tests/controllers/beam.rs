//! The search in time: dynamic obstacles are passed, static ones are kept clear of, and the laws of what it
//! publishes.

#![allow(clippy::print_stdout, reason = "seeds and results of a failed run")]

use crate::support::cart::{Cart, cross};
use crate::support::{Loop, block, jackal, path};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use zeronav_local_planner::beam::options::BeamConfig;
use zeronav_local_planner::dwa::options::DwaConfig;
use zeronav_local_planner::dwa_t::options::DwaTConfig;
use zeronav_local_planner::{beam, pilot::Pilot};
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::obstacles::Obstacle;

fn beam() -> Pilot {
    beam::beam(
        DwaConfig::default(),
        DwaTConfig::default(),
        BeamConfig::default(),
    )
}

#[test]
fn a_crossing_cart_is_given_way() {
    for speed in [0.5, 1.0, 1.5] {
        for meets_at in [3.0, 5.0, 7.0] {
            for side in [-1.0, 1.0] {
                let cart = Cart::crossing(speed, meets_at, side);
                let (moving_m, any_m, time_s) = cross(&mut beam(), cart, true);
                println!("{cart:?}: {moving_m:.3} m, {any_m:.3} m, {time_s:?}");
                assert!(moving_m > 0.0, "{cart:?}: the robot drove into it");
                assert!(any_m > 0.0, "{cart:?}: it was run into");
                assert!(time_s.is_some_and(|s| s < 30.0), "{cart:?}: {time_s:?}");
            }
        }
    }
}

#[test]
fn a_cart_that_comes_head_on_is_evaded() {
    for speed in [0.5, 1.0, 1.5] {
        for aside_m in [-0.2, 0.0, 0.2] {
            check_untouched(Cart {
                from: (11.0, 4.0 + aside_m),
                velocity: (-speed, 0.0),
            });
        }
    }
}

/// A robot that brakes is hit by it; at 0.8 m/s it can only leave its way.
#[test]
fn a_cart_that_catches_up_is_let_pass() {
    for speed in [1.2, 1.6] {
        check_untouched(Cart {
            from: (-4.0, 4.0),
            velocity: (speed, 0.0),
        });
    }
}

fn check_untouched(cart: Cart) {
    let (_, any_m, time_s) = cross(&mut beam(), cart, true);
    println!("{cart:?}: {any_m:.3} m, {time_s:?}");
    assert!(any_m > 0.0, "{cart:?}: touched");
    assert!(time_s.is_some_and(|s| s < 40.0), "{cart:?}: {time_s:?}");
}

/// Somebody who walks to and fro between two walls, for ever.
#[derive(Debug, Clone, Copy)]
struct Walker {
    x_m: f64,
    vy_mps: f64,
    phase_s: f64,
}

const WALKER_M: f64 = 0.3;
/// Where they turn round, which no prediction has, so far from the robot's way.
const TURNS_M: (f64, f64) = (1.0, 15.0);

impl Walker {
    fn at(&self, time_s: f64) -> Obstacle {
        let span_m = TURNS_M.1 - TURNS_M.0;
        let gone_m = (self.vy_mps * (time_s + self.phase_s)).rem_euclid(2.0 * span_m);
        let (y_m, vy_mps) = if gone_m < span_m {
            (TURNS_M.0 + gone_m, self.vy_mps)
        } else {
            (TURNS_M.1 + span_m - gone_m, -self.vy_mps)
        };
        Obstacle {
            track: 1,
            x_m: self.x_m,
            y_m,
            vy_mps,
            radius_m: WALKER_M,
            covariance: [1e-3, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.02, 0.0, 0.02],
            ..Obstacle::default()
        }
    }
}

/// A Jackal that crosses a hall through ten walkers, one lane each.
fn through_walkers(seed: u64) -> (Loop, Vec<Walker>) {
    let mut dice = Pcg32::seed_from_u64(seed);
    let walkers = (0..10)
        .map(|lane| Walker {
            x_m: 3.0 + 1.1 * f64::from(lane),
            vy_mps: dice.random_range(0.4..1.3),
            phase_s: dice.random_range(0.0..30.0),
        })
        .collect();
    let hall = [block(0.0, 0.0, 16.0, 0.2), block(0.0, 15.8, 16.0, 16.0)];
    let corners = path(&[(1.0, 8.0), (15.0, 8.0)]);
    let pose = Pose::new(1.0, 8.0, 0.0);
    (
        Loop::new(jackal(), &hall, (16.0, 16.0), pose, corners),
        walkers,
    )
}

/// Tells the robot where the walkers are, as tracks and as squares for the lidar.
fn place(run: &mut Loop, walkers: &[Walker]) {
    run.blocks.truncate(2);
    run.obstacles.clear();
    for (track, walker) in (1..).zip(walkers) {
        let there = walker.at(run.time_s);
        let half_m = 0.7 * WALKER_M;
        let (x, y) = (there.x_m, there.y_m);
        run.obstacles.push(Obstacle { track, ..there });
        run.blocks
            .push(block(x - half_m, y - half_m, x + half_m, y + half_m));
    }
}

#[test]
fn ten_walkers_are_passed_without_driving_into_any() {
    for seed in 1..=6 {
        let (mut run, walkers) = through_walkers(seed);
        let mut controller = beam();
        let mut before = Twist::REST;
        let arrived = (0..3000).any(|_| {
            place(&mut run, &walkers);
            let decision = run.step(&mut controller);
            let now = Twist::new(decision.v_mps, decision.w_radps);
            let robot = &run.robot.description;
            assert!(now.v_mps >= robot.v_mps_min && now.v_mps <= robot.v_mps_max);
            assert!(now.w_radps.abs() <= robot.w_radps_max);
            assert!((now.v_mps - before.v_mps).abs() <= 0.02 * robot.brake_mps2 + 1e-9);
            assert!((now.w_radps - before.w_radps).abs() <= 0.02 * robot.alpha_radps2_max + 1e-9);
            before = now;
            place(&mut run, &walkers);
            let touched = run.distance_m(&run.pose) <= 0.0;
            assert!(
                !touched || run.twist.v_mps.abs() < 0.05,
                "seed {seed}: drove into somebody at {:?}",
                run.pose
            );
            run.pose.distance_m(&run.goal.pose) < run.goal.tolerance_m
        });
        println!("seed {seed}: {arrived} after {:.1} s", run.time_s);
        // 14 m at 1 m/s, and as much again.
        assert!(
            arrived && run.time_s < 30.0,
            "seed {seed}: {:.1} s",
            run.time_s
        );
    }
}

#[test]
fn what_stands_is_never_touched_for_who_walks() {
    // A narrow gap in a wall, a pedestrian behind it.
    let blocks = [
        block(4.0, 0.0, 4.2, 1.6),
        block(4.0, 2.5, 4.2, 4.0),
        block(0.0, 0.0, 8.0, 0.1),
        block(0.0, 3.9, 8.0, 4.0),
    ];
    let corners = path(&[(1.0, 2.05), (7.0, 2.05)]);
    let pose = Pose::new(1.0, 2.05, 0.0);
    let mut run = Loop::new(jackal(), &blocks, (8.0, 4.0), pose, corners);
    let mut controller = beam();
    let mut before = Twist::REST;
    for _ in 0..700 {
        let walks = 1.2 * (0.8 * run.time_s).sin();
        run.obstacles = vec![Obstacle {
            track: 1,
            x_m: 5.5,
            y_m: 2.0 + walks,
            vy_mps: 0.96 * (0.8 * run.time_s).cos(),
            radius_m: WALKER_M,
            covariance: [1e-3, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.02, 0.0, 0.02],
            ..Obstacle::default()
        }];
        let pose = run.pose;
        let decision = run.step(&mut controller);
        run.check_command(before, &pose, &decision);
        before = Twist::new(decision.v_mps, decision.w_radps);
    }
    assert!(run.least_m > 0.0, "touched the wall");
    assert!(run.pose.x_m > 6.0, "did not get through: {:?}", run.pose);
}

#[test]
fn the_same_situations_give_the_same_decisions() {
    let decisions = || {
        let (mut run, walkers) = through_walkers(3);
        let mut controller = beam();
        for _ in 0..150 {
            place(&mut run, &walkers);
            run.step(&mut controller);
        }
        run.history
    };
    assert_eq!(decisions(), decisions());
}
