//! The potential fields of JU.

use super::*;

#[test]
fn ju_apf_force_is_the_gradient_of_its_potential() {
    let (post, goal) = (at(0.3, -0.2), at(4.0, 1.0));
    for x in [at(1.0, 0.5), at(0.5, -0.9), at(-0.7, 0.4)] {
        let found = repulsion(&Gains::JU, x, post);
        let expected = slope(|x| repulsion_potential(&Gains::JU, x, post), x);
        assert!((found - expected).norm() < 1.0e-5 * expected.norm(), "{x}");
        let found = attraction(40.0, x, goal);
        let expected = slope(|x| 20.0 * (x - goal).norm_squared(), x);
        assert!((found - expected).norm() < 1.0e-5 * expected.norm());
    }
    let beyond = at(0.3 + 2.0001, -0.2);
    assert!(repulsion(&Gains::JU, beyond, post).norm() < 1.0e-12);
}

#[test]
fn ju_apf_is_stuck_before_an_obstacle_on_its_line() {
    let bodies = [Body::standing(at(5.0, 0.0), Extent::Disc(0.8))];
    let mut law = JuApf::new(Gains::JU);
    let trace = walk(
        &mut law,
        at(0.0, 0.0),
        at(10.0, 0.0),
        &bodies,
        &[],
        &Walk::JU,
    );
    assert!(
        matches!(trace.end, End::Stuck | End::Collision),
        "{:?} after {}",
        trace.end,
        trace.steps
    );
    assert_free(&trace, &bodies);
}

#[test]
fn ju_apf_does_not_reach_a_goal_beside_an_obstacle() {
    // Repulsion at the goal outweighs the pull at the edge of the tolerance.
    let goal = at(5.0, 0.0);
    let bodies = [Body::standing(at(5.3, 0.0), Extent::Disc(0.0))];
    let mut law = JuApf::new(Gains::JU);
    let trace = walk(&mut law, at(0.0, 0.0), goal, &bodies, &[], &Walk::JU);
    assert_eq!(trace.end, End::Stuck, "{:?}", trace.points.last());
    let last = trace.points[trace.points.len() - 1];
    assert!((last - goal).norm() > 0.2);
}

#[test]
fn ju_r6_visits_its_sub_goals_in_order() {
    let corners = path(&[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (8.0, 4.0)]);
    let mut law = JuR6::new(Gains::JU);
    let trace = walk(
        &mut law,
        at(0.0, 0.0),
        at(8.0, 4.0),
        &[],
        &corners,
        &Walk::JU,
    );
    assert_eq!(trace.end, End::Reached);
    let mut from = 0;
    for corner in &corners[1..] {
        let near = trace.points[from..]
            .iter()
            .position(|point| (point - at(corner.x_m, corner.y_m)).norm() < 0.35);
        from += near.expect("a sub-goal was left out");
    }
    assert_eq!(law.subgoal(), 3);
}

#[test]
fn ju_r6_and_ju_r7_reach_a_goal_behind_a_trap() {
    let bodies = u_trap();
    let goal = at(9.0, 0.0);
    let route = path(&[(4.5, 0.0), (1.0, 0.0), (1.0, 4.5), (9.0, 4.5), (9.0, 0.0)]);
    let start = at(4.5, 0.0);
    let gains = Gains {
        reach: 1.0,
        ..Gains::JU
    };
    let plain = walk(&mut JuApf::new(gains), start, goal, &bodies, &[], &Walk::JU);
    assert_ne!(plain.end, End::Reached);
    let r6 = walk(
        &mut JuR6::new(gains),
        start,
        goal,
        &bodies,
        &route,
        &Walk::JU,
    );
    assert_eq!(r6.end, End::Reached);
    assert_free(&r6, &bodies);
    let r7 = walk(
        &mut JuR7::new(gains),
        start,
        goal,
        &bodies,
        &route,
        &Walk::JU,
    );
    assert_eq!(r7.end, End::Reached);
    assert_free(&r7, &bodies);
}

#[test]
fn ju_r7_progress_never_falls() {
    let route = path(&[(0.0, 0.0), (5.0, 0.0), (5.0, 0.6), (0.0, 0.6)]);
    let mut law = JuR7::new(Gains::JU);
    let mut last_m = 0.0;
    let mut here = at(0.0, 0.0);
    for _ in 0..200 {
        let input = LawInput {
            path: &route,
            ..input(here, at(0.0, 0.6), &[])
        };
        if let Push::Along(force) = law.push(&input) {
            here += force.normalize() * 0.05;
        }
        assert!(law.arc_m() >= last_m);
        last_m = law.arc_m();
    }
    assert!(last_m > 9.0, "{last_m}");
}

#[test]
fn ju_fusion_takes_the_points_ahead_in_every_quadrant() {
    for (x, y) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        let route = path(&[(0.0, 0.0), (10.0 * x, 10.0 * y)]);
        let goal = at(10.0 * x, 10.0 * y);
        let from = at(5.0 * x, 5.0 * y);
        let mut law = JuFusion::new(Gains::JU, false);
        let input = LawInput {
            path: &route,
            ..input(from, goal, &[])
        };
        let pull = law.path_pull(&input);
        assert!(pull.norm() > 1.0, "no point was taken");
        assert!(pull.normalize().dot(&(goal - from).normalize()) > 0.999);
    }
}

#[test]
fn ju_fusion_is_drawn_to_the_goal_as_well_as_to_the_path() {
    // The path leads off to the side: its points pull along +y, the goal along +x.
    let route = path(&[(0.0, 0.0), (0.0, 10.0)]);
    for normalised in [false, true] {
        let mut law = JuFusion::new(Gains::JU, normalised);
        let input = LawInput {
            path: &route,
            ..input(at(0.0, 0.0), at(6.0, 0.0), &[])
        };
        let path_pull = law.path_pull(&input);
        assert!(path_pull.x.abs() < 1e-9 && path_pull.y > 1.0);
        let Push::Along(force) = law.push(&input) else {
            panic!("a field always says where to");
        };
        let goal_pull = force - path_pull;
        let expected = Gains::JU.attract * if normalised { 1.0 } else { 6.0 };
        assert!((goal_pull.x - expected).abs() < 1e-9, "{goal_pull}");
        assert!(goal_pull.y.abs() < 1e-9, "{goal_pull}");
    }
}

#[test]
fn ju_fusion_never_collides_in_area_mode_and_crosses_in_point_mode() {
    let (mut arrived, mut crossed) = (0, 0);
    for seed in 0..40 {
        let mut random = Pcg32::seed_from_u64(seed);
        let bodies: Vec<Body> = (0..20)
            .map(|_| {
                square(
                    f64::from(random.random_range(2..14)),
                    f64::from(random.random_range(2..14)),
                )
            })
            .collect();
        let route = path(&[(0.0, 0.0), (15.0, 15.0)]);
        let (start, goal) = (at(0.0, 0.0), at(15.0, 15.0));
        let mut law = JuFusion::new(Gains::JU, false);
        let trace = walk(&mut law, start, goal, &bodies, &route, &Walk::JU);
        assert_free(&trace, &bodies);
        arrived += u32::from(trace.end == End::Reached);
        let literal = Walk {
            literal: true,
            ..Walk::JU
        };
        let mut law = JuFusion::new(Gains::JU, false);
        let trace = walk(&mut law, start, goal, &bodies, &route, &literal);
        crossed += u32::from(deepest(&trace.points, &bodies) > 0.0);
    }
    println!("areas: {arrived} of 40 arrive; points: {crossed} of 40 cross an obstacle");
    assert!(arrived >= 20, "areas: {arrived} of 40 arrive");
    assert!(crossed > 20, "points were no worse than areas");
}
