//! What the time-indexed dynamic window is for: moving obstacles, and that it costs no allocation.

#![allow(clippy::print_stdout, reason = "results of a failed run")]

mod support;

use support::{Loop, PERIOD_S, block, disc, jackal, path};
use zeronav_local_planner::config::{DwaConfig, DwaTConfig};
use zeronav_local_planner::controller::Controller;
use zeronav_local_planner::dwa::Dwa;
use zeronav_msgs::Pose;
use zeronav_msgs::obstacles::Obstacle;

fn dwa_t() -> Dwa {
    Dwa::timed(DwaConfig::default(), DwaTConfig::default())
}

/// A cart of 0.4 m that crosses the way of a robot in a hall: where it starts and how fast.
#[derive(Debug, Clone, Copy)]
struct Cart {
    from: (f64, f64),
    velocity: (f64, f64),
}

/// Drives along the hall while the cart passes: least distance while the robot moved faster than
/// 0.05 m/s, least distance at all, seconds to the goal.
fn cross(controller: &mut dyn Controller, cart: Cart, told: bool) -> (f64, f64, Option<f64>) {
    let hall = [block(0.0, 0.0, 14.0, 0.2), block(0.0, 7.8, 14.0, 8.0)];
    let robot = disc(0.25, 0.8, 1.0, 1.8, 3.0);
    let corners = path(&[(1.0, 4.0), (12.0, 4.0)]);
    let mut run = Loop::new(robot, &hall, (14.0, 8.0), Pose::new(1.0, 4.0, 0.0), corners);
    let radius_m = 0.4;
    let (mut moving_m, mut any_m) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..2000 {
        let (x, y) = (
            cart.from.0 + cart.velocity.0 * run.time_s,
            cart.from.1 + cart.velocity.1 * run.time_s,
        );
        run.obstacles.clear();
        if told {
            run.obstacles.push(Obstacle {
                track: 1,
                x_m: x,
                y_m: y,
                vx_mps: cart.velocity.0,
                vy_mps: cart.velocity.1,
                radius_m,
                covariance: [1e-3, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.02, 0.0, 0.02],
                ..Obstacle::default()
            });
        }
        // The lidar sees the cart as a square of its size.
        run.blocks.truncate(2);
        let half_m = 0.7 * radius_m;
        run.blocks
            .push(block(x - half_m, y - half_m, x + half_m, y + half_m));
        run.step(controller);
        let distance_m = (run.pose.x_m - x).hypot(run.pose.y_m - y) - radius_m - 0.25;
        any_m = any_m.min(distance_m);
        if run.twist.v_mps.abs() > 0.05 {
            moving_m = moving_m.min(distance_m);
        }
        if run.pose.distance_m(&run.goal.pose) < run.goal.tolerance_m && run.twist.is_standing() {
            return (moving_m, any_m, Some(run.time_s));
        }
    }
    (moving_m, any_m, None)
}

#[test]
fn a_crossing_cart_is_given_way() {
    let mut without = 0;
    for speed in [0.5, 1.0, 1.5] {
        for meets_at in [3.0, 4.0, 5.0, 6.0, 7.0] {
            // On the robot's line when an undisturbed robot would be there.
            let arrives_s = (meets_at - 1.0) / 0.8 + 0.4;
            for side in [-1.0, 1.0] {
                let cart = Cart {
                    from: (meets_at, 4.0 + side * speed * arrives_s),
                    velocity: (0.0, -side * speed),
                };
                let (moving_m, any_m, time_s) = cross(&mut dwa_t(), cart, true);
                println!("{cart:?}: {moving_m:.3} m, {any_m:.3} m, {time_s:?}");
                assert!(moving_m > 0.0, "{cart:?}: the robot drove into it");
                assert!(any_m > 0.0, "{cart:?}: it was run into");
                assert!(time_s.is_some_and(|s| s < 30.0), "{cart:?}: {time_s:?}");
                let (_, any_m, _) = cross(&mut dwa_t(), cart, false);
                without += u32::from(any_m <= 0.0);
            }
        }
    }
    println!("{without} of 30 touch without prediction");
    assert!(without > 5, "the carts were no danger");
}

/// A Jackal that stands with its path behind it, and somebody who walks: runs until `until` is true.
fn behind_it(
    from: (f64, f64),
    velocity: (f64, f64),
    mut until: impl FnMut(&Loop, (f64, f64)) -> bool,
) {
    let hall = [block(0.0, 0.0, 14.0, 0.2), block(0.0, 7.8, 14.0, 8.0)];
    let corners = path(&[(4.0, 4.0), (12.0, 4.0)]);
    let facing_away = Pose::new(4.0, 4.0, core::f64::consts::PI);
    let mut run = Loop::new(jackal(), &hall, (14.0, 8.0), facing_away, corners);
    let mut controller = dwa_t();
    while run.time_s < 5.0 {
        let at = |from: f64, speed: f64| from + speed * run.time_s;
        let (x_m, y_m) = (at(from.0, velocity.0), at(from.1, velocity.1));
        run.obstacles.clear();
        run.obstacles.push(Obstacle {
            track: 1,
            x_m,
            y_m,
            vx_mps: velocity.0,
            vy_mps: velocity.1,
            radius_m: 0.3,
            covariance: [1e-3, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.02, 0.0, 0.02],
            ..Obstacle::default()
        });
        run.step(&mut controller);
        if until(&run, (x_m, y_m)) {
            return;
        }
    }
    panic!("nothing happened");
}

#[test]
fn near_somebody_who_walks_a_turn_waits_a_moment() {
    let turns_after_s = |from, velocity| {
        let mut turned_s = 0.0;
        behind_it(from, velocity, |run, _| {
            turned_s = run.time_s;
            run.twist.w_radps.abs() > 0.05
        });
        turned_s
    };
    let passes_s = turns_after_s((3.0, 5.8), (0.8, 0.0));
    assert!((0.5..0.8).contains(&passes_s), "{passes_s} s");
    for (what, from, velocity) in [
        ("far away", (3.0, 7.4), (0.8, 0.0)),
        (
            "the end of a wall that seems to move",
            (3.0, 5.8),
            (0.2, 0.0),
        ),
    ] {
        let after_s = turns_after_s(from, velocity);
        assert!(after_s <= 4.0 * PERIOD_S, "{what}: {after_s} s");
    }
}

#[test]
fn no_corner_swings_into_who_comes() {
    let mut fastest_radps: f64 = 0.0;
    behind_it((6.9, 4.0), (-1.5, 0.0), |run, (x_m, y_m)| {
        fastest_radps = fastest_radps.max(run.twist.w_radps.abs());
        let reach_m = run.robot.description.circumscribed_radius_m + 0.3;
        let gap_m = (x_m - run.pose.x_m).hypot(y_m - run.pose.y_m) - reach_m;
        let swings = run.twist.w_radps.abs() > 0.1;
        assert!(
            gap_m > 0.02 || !swings,
            "{:?} with {gap_m} m left",
            run.twist
        );
        gap_m < 0.0
    });
    assert!(fastest_radps > 0.5, "it never turned: {fastest_radps}");
}
