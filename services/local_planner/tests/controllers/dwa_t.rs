//! What the time-indexed dynamic window is for: moving obstacles, and that it costs no allocation.

#![allow(clippy::print_stdout, reason = "results of a failed run")]

use crate::support::cart::{Cart, cross};
use crate::support::{Loop, PERIOD_S, block, jackal, path};
use zeronav_local_planner::dwa::options::DwaConfig;
use zeronav_local_planner::dwa_t::options::DwaTConfig;
use zeronav_local_planner::{dwa_t, pilot::Pilot};
use zeronav_msgs::Pose;
use zeronav_msgs::obstacles::Obstacle;

fn dwa_t() -> Pilot {
    dwa_t::dwa_t(DwaConfig::default(), DwaTConfig::default())
}

#[test]
fn a_crossing_cart_is_given_way() {
    let mut without = 0;
    for speed in [0.5, 1.0, 1.5] {
        for meets_at in [3.0, 4.0, 5.0, 6.0, 7.0] {
            for side in [-1.0, 1.0] {
                let cart = Cart::crossing(speed, meets_at, side);
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

/// A stopped Jackal with its path behind it, and a pedestrian: runs until `until` is true.
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
