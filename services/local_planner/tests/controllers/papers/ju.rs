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
    assert_eq!(trace.end, End::Stuck, "after {}", trace.steps);
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
    let mut law = JuR6::new(&JuR6Config::default());
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

/// The way out of the trap and around it, far from its walls or near.
fn way_out(aside: f64) -> Vec<Waypoint> {
    let corners = [
        (4.5, 0.0),
        (1.0, 0.0),
        (1.0, aside),
        (9.0, aside),
        (9.0, 0.0),
    ];
    path(&corners)
}

#[test]
fn ju_r6_and_ju_r7_reach_a_goal_behind_a_trap() {
    let bodies = u_trap();
    let (start, goal) = (at(4.5, 0.0), at(9.0, 0.0));
    let mut law = JuApf::new(Gains::JU);
    let plain = walk(&mut law, start, goal, &bodies, &[], &Walk::JU);
    assert_eq!(plain.end, End::Stuck);
    for aside in [4.5, 5.5] {
        let route = way_out(aside);
        let mut r6 = JuR6::new(&JuR6Config::default());
        let mut r7 = JuR7::new(&JuR7Config::default());
        let laws: [&mut dyn Law; 2] = [&mut r6, &mut r7];
        for law in laws {
            let trace = walk(law, start, goal, &bodies, &route, &Walk::JU);
            println!("{aside}: {:?} {} steps {law:?}", trace.end, trace.steps);
            assert_eq!(trace.end, End::Reached, "{aside}");
            assert_free(&trace, &bodies);
        }
    }
}

#[test]
fn ju_r7_progress_never_falls() {
    let route = path(&[(0.0, 0.0), (5.0, 0.0), (5.0, 0.6), (0.0, 0.6)]);
    let mut law = JuR7::new(&JuR7Config::default());
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
        let mut law = JuFusion::new(&JuFusionConfig::default());
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
        let mut law = JuFusion::new(&JuFusionConfig {
            normalised,
            ..JuFusionConfig::default()
        });
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
fn ju_fusion_takes_the_points_of_a_star() {
    // Corners of a path of cells of a metre: three straight steps, two diagonal ones.
    let route = path(&[(0.0, 0.0), (3.0, 0.0), (5.0, 2.0)]);
    let mut law = JuFusion::new(&JuFusionConfig {
        attract: 1.0,
        r1_m: 1.9,
        ..JuFusionConfig::default()
    });
    let pull = |law: &mut JuFusion, x, y| {
        law.path_pull(&LawInput {
            path: &route,
            ..input(at(x, y), at(5.0, 2.0), &[])
        })
    };
    // Cells (1, 0) and (2, 0) lie within 1.9 m of the robot at 0.2 m; (0, 0) is behind it.
    let found = pull(&mut law, 0.2, 0.0);
    assert!(
        (found - Vector2::new(0.8 + 1.8, 0.0)).norm() < 1e-9,
        "{found}"
    );
    // From (2.5, 0): the corner (3, 0) and the diagonal cell (4, 1).
    let found = pull(&mut law, 2.5, 0.0);
    assert!(
        (found - Vector2::new(0.5 + 1.5, 1.0)).norm() < 1e-9,
        "{found}"
    );
}

#[test]
fn ju_fusion_yields_to_a_disc_that_crosses_its_path() {
    let route = path(&[(0.0, 0.0), (10.0, 0.0)]);
    for side in [-1.0, 1.0] {
        let mut law = JuFusion::new(&JuFusionConfig::default());
        let (mut here, goal) = (at(0.0, 0.0), at(10.0, 0.0));
        let mut body = Body {
            at: at(5.0, side * 5.0),
            extent: Extent::Disc(0.5),
            velocity: Vector2::new(0.0, -side),
        };
        let mut least = f64::INFINITY;
        for _ in 0..400 {
            let input = LawInput {
                path: &route,
                ..input(here, goal, core::slice::from_ref(&body))
            };
            if let Push::Along(force) = law.push(&input) {
                here += force.try_normalize(1e-9).unwrap_or_default() * 0.05;
            }
            body.at += body.velocity * 0.05;
            least = least.min((here - body.at).norm() - 0.5);
        }
        assert!(least > 0.0, "side {side}: {least}");
        assert!((here - goal).norm() < 0.2, "side {side}: {here}");
    }
}
