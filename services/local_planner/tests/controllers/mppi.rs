//! Model predictive path integral control: what every controller that follows a path has to do,
//! moving obstacles, the laws of what it publishes, and that a cycle costs no allocation.

#![allow(clippy::print_stdout, reason = "seeds and results of a failed run")]

use crate::support::cart::{Cart, cross};
use crate::support::{Loop, block, jackal, path};
use zeronav_local_planner::dwa::options::DwaConfig;
use zeronav_local_planner::dwa_t::options::DwaTConfig;
use zeronav_local_planner::mppi::options::MppiConfig;
use zeronav_local_planner::{mppi, pilot::Pilot};
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::command::RequestCause;

/// With fewer samples than on the robot, so that minutes of driving take seconds.
fn mppi(samples: u32) -> Pilot {
    let config = MppiConfig {
        samples,
        ..MppiConfig::default()
    };
    mppi::mppi(DwaConfig::default(), DwaTConfig::default(), config)
}

mod manoeuvres {
    use super::mppi;
    use crate::support::{Block, Loop, Robot, block, disc, goal_at, jackal, path};
    use core::f64::consts::{FRAC_PI_2, PI};
    use zeronav_local_planner::pilot::Pilot;
    use zeronav_msgs::Pose;
    use zeronav_msgs::command::Validity;
    use zeronav_msgs::pose::wrap_angle;

    /// Changes of direction allowed per metre at a corner.
    const WEAVING_PER_M_MAX: f64 = 0.6;
    /// The same on a path in steps.
    const STEPS_WEAVING_PER_M_MAX: f64 = 1.0;
    /// To get around a box on the way: it hesitates before it leaves the line. [s]
    const ROUND_THE_BOX_S: f64 = 60.0;

    fn dwa() -> Pilot {
        mppi(200)
    }

    include!("../support/manoeuvres.rs");
}

#[test]
fn a_crossing_cart_is_given_way() {
    for speed in [0.5, 1.0, 1.5] {
        for meets_at in [4.0, 6.0] {
            for side in [-1.0, 1.0] {
                let cart = Cart::crossing(speed, meets_at, side);
                let (least_m, _, time_s) = cross(&mut mppi(200), cart, true);
                println!("{speed} m/s at {meets_at} m from {side}: {least_m:.3} m, {time_s:?}");
                assert!(least_m > 0.0, "the robot drove into it");
                assert!(time_s.is_some(), "did not arrive");
            }
        }
    }
}

#[test]
fn commands_obey_the_limits_and_leave_room_to_brake() {
    let blocks = [
        block(0.0, 0.0, 8.0, 0.4),
        block(0.0, 3.0, 8.0, 3.4),
        block(3.0, 0.4, 3.2, 1.35),
        block(3.0, 2.0, 3.2, 3.0),
    ];
    for delay in [0, 2] {
        let corners = path(&[(1.0, 2.2), (2.5, 1.675), (4.0, 1.675), (7.0, 1.7)]);
        let pose = Pose::new(1.0, 2.2, 1.0);
        let mut run = Loop::new(jackal(), &blocks, (8.0, 3.4), pose, corners);
        run.delay = delay;
        // Neither the map nor the path know it.
        run.blocks.push(block(5.5, 1.2, 5.7, 2.0));
        let mut controller = mppi(400);
        let mut before = Twist::REST;
        for _ in 0..500 {
            let pose = run.pose;
            let decision = run.step(&mut controller);
            run.check_command(before, &pose, &decision);
            before = Twist::new(decision.v_mps, decision.w_radps);
            assert!(run.least_m > 0.0, "contact at {:?}", run.pose);
        }
        println!(
            "delay {delay}: {:.2} m driven, nearest {:.3}",
            run.driven_m, run.least_m
        );
        assert!(run.driven_m > 4.0, "hardly moved: {}", run.driven_m);
    }
}

#[test]
fn the_same_situations_give_the_same_decisions() {
    let decisions = || {
        let hall = [block(0.0, 0.0, 8.0, 0.4), block(0.0, 2.0, 8.0, 2.4)];
        let corners = path(&[(1.0, 1.2), (7.0, 1.2)]);
        let pose = Pose::new(1.0, 1.2, 0.4);
        let mut run = Loop::new(jackal(), &hall, (8.0, 2.4), pose, corners);
        let mut controller = mppi(400);
        for _ in 0..100 {
            run.step(&mut controller);
        }
        run.history
    };
    assert_eq!(decisions(), decisions());
}

/// How often each cause is named on a straight way between walls, until the robot slows down for its
/// goal.
fn causes_between_walls(apart_m: f64) -> Vec<(RequestCause, usize)> {
    let middle_m = 0.4 + 0.5 * apart_m;
    let top_m = 0.4 + apart_m;
    let walls = [
        block(0.0, 0.0, 9.0, 0.4),
        block(0.0, top_m, 9.0, top_m + 0.4),
    ];
    let corners = path(&[(1.0, middle_m), (8.0, middle_m)]);
    let pose = Pose::new(1.0, middle_m, 0.0);
    let mut run = Loop::new(jackal(), &walls, (9.0, top_m + 0.4), pose, corners);
    let mut controller = mppi(400);
    while run.pose.x_m < 6.5 {
        assert!(run.time_s < 60.0, "stuck at {:?}", run.pose);
        run.step(&mut controller);
    }
    let mut counts: Vec<(RequestCause, usize)> = Vec::new();
    for decision in &run.history {
        match counts
            .iter_mut()
            .find(|(cause, _)| *cause == decision.cause)
        {
            Some((_, count)) => *count += 1,
            None => counts.push((decision.cause, 1)),
        }
    }
    println!("{apart_m} m apart: {counts:?}");
    counts
}

#[test]
fn the_clearance_critic_explains_what_near_walls_do_to_the_speed() {
    let share = |counts: &[(RequestCause, usize)], of: RequestCause| {
        let all: usize = counts.iter().map(|(_, count)| count).sum();
        let named = counts.iter().find(|(cause, _)| *cause == of);
        100 * named.map_or(0, |(_, count)| *count) / all
    };
    let (near, far) = (causes_between_walls(0.62), causes_between_walls(4.0));
    assert!(share(&near, RequestCause::ClearanceCritic) > 10, "{near:?}");
    assert_eq!(share(&far, RequestCause::ClearanceCritic), 0, "{far:?}");
    assert!(share(&far, RequestCause::Free) > 80, "{far:?}");
}
