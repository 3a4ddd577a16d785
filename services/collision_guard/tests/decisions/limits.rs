//! The guard's own limits against those that the local planner drives by (`zeronav_motion`).

use proptest::prelude::*;
use zeronav_collision_guard::Limits;
use zeronav_motion::{Twist, reachable, towards_rest};
use zeronav_msgs::description::Description;

fn robots() -> impl Strategy<Value = Description> {
    let speeds = (0.1..2.0_f64, -1.0..0.0_f64, 0.2..4.0_f64);
    let accelerations = (0.1..4.0_f64, 0.1..8.0_f64, 0.5..10.0_f64);
    (speeds, accelerations).prop_map(|((v_mps_max, v_mps_min, w_radps_max), (a, brake, alpha))| {
        Description {
            v_mps_max,
            v_mps_min,
            w_radps_max,
            a_mps2_max: a,
            brake_mps2: brake,
            alpha_radps2_max: alpha,
            ..Description::default()
        }
    })
}

fn twists() -> impl Strategy<Value = Twist> {
    (-2.0..2.0_f64, -4.0..4.0_f64).prop_map(|(v_mps, w_radps)| Twist::new(v_mps, w_radps))
}

proptest! {
    /// Both ramps to rest are the same, whatever the robot and the time step.
    #[test]
    fn ramps_to_rest_agree(robot in robots(), from in twists(), step_s in 0.001..0.2_f64) {
        let limits = Limits::of(&robot).expect("finite limits");
        let (ours, theirs) = (limits.towards_rest(from, step_s), towards_rest(&robot, from, step_s));
        prop_assert!((ours.v_mps - theirs.v_mps).abs() < 1.0e-12);
        prop_assert!((ours.w_radps - theirs.w_radps).abs() < 1.0e-12);
    }

    /// What the local planner can reach in a step, the guard expects; without a change of
    /// direction the two are equal.
    #[test]
    fn the_guard_expects_every_twist_that_the_planner_can_reach(
        robot in robots(),
        from in twists(),
        wanted in twists(),
        step_s in 0.001..0.2_f64,
    ) {
        let limits = Limits::of(&robot).expect("finite limits");
        let reached = reachable(&robot, from, wanted, step_s);
        let expected = limits.towards(from, reached, step_s);
        prop_assert!((expected.v_mps - reached.v_mps).abs() < 1.0e-12, "{expected:?} {reached:?}");
        prop_assert!((expected.w_radps - reached.w_radps).abs() < 1.0e-12);
        let towards = limits.towards(from, wanted, step_s);
        if towards.v_mps * from.v_mps >= 0.0 && reached.v_mps * from.v_mps > 0.0 {
            prop_assert!((towards.v_mps - reached.v_mps).abs() < 1.0e-12);
        }
    }
}
