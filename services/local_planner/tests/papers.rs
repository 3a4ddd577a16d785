//! The controllers of the papers: the acceptance tests of the paper notes, by key.

#![allow(clippy::print_stdout, reason = "shares and seeds of a failed run")]

mod support;

use nalgebra::{Point2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use support::{Loop, block, disc, path};
use zeronav_local_planner::LocalPlannerConfig;
use zeronav_local_planner::motion::Twist;
use zeronav_local_planner::papers::bao_dwa::{BaoWeights, Sample, choose, is_admissible, window};
use zeronav_local_planner::papers::fit::{FitError, fit, fit_literal};
use zeronav_local_planner::papers::ju_apf::JuApf;
use zeronav_local_planner::papers::ju_fusion::JuFusion;
use zeronav_local_planner::papers::ju_r6::JuR6;
use zeronav_local_planner::papers::ju_r7::JuR7;
use zeronav_local_planner::papers::lwx_fusion::LwxFusion;
use zeronav_local_planner::papers::lwx_lsq::LwxLsq;
use zeronav_local_planner::papers::lwx_oapf::LwxOapf;
use zeronav_local_planner::papers::potential::{
    Gains, all_goal_repulsions, attraction, goal_repulsion, goal_repulsion_potential, repulsion,
    repulsion_potential, velocity_repulsion,
};
use zeronav_local_planner::papers::route::turning_points;
use zeronav_local_planner::papers::walk::{End, Trace, Walk, is_free, walk};
use zeronav_local_planner::papers::zm_esc::ZmEsc;
use zeronav_local_planner::papers::zm_rep::ZmRep;
use zeronav_local_planner::papers::{Body, Extent, Law, Push, Scene};
use zeronav_local_planner::table::controller;
use zeronav_msgs::Pose;
use zeronav_msgs::path::Waypoint;

fn at(x: f64, y: f64) -> Point2<f64> {
    Point2::new(x, y)
}

fn square(x: f64, y: f64) -> Body {
    Body::standing(at(x, y), Extent::Square(0.5))
}

/// A U of unit squares that opens to the left, around (5, 0).
fn u_trap() -> Vec<Body> {
    let back = (-2..=2).map(|y| square(6.0, f64::from(y)));
    let arms = [3.0, 4.0, 5.0]
        .into_iter()
        .flat_map(|x| [square(x, 2.0), square(x, -2.0)]);
    back.chain(arms).collect()
}

fn scene(from: Point2<f64>, goal: Point2<f64>, bodies: &[Body]) -> Scene<'_> {
    Scene {
        at: from,
        velocity: Vector2::zeros(),
        goal,
        bodies,
        path: &[],
        geometry: 1,
        literal: false,
    }
}

/// Central differences of a potential.
fn slope(potential: impl Fn(Point2<f64>) -> f64, x: Point2<f64>) -> Vector2<f64> {
    let h = 1.0e-6;
    let along = |d: Vector2<f64>| (potential(x + d * h) - potential(x - d * h)) / (2.0 * h);
    -Vector2::new(along(Vector2::x()), along(Vector2::y()))
}

fn assert_free(trace: &Trace, bodies: &[Body]) {
    for pair in trace.points.windows(2) {
        assert!(is_free(bodies, pair[0], pair[1]), "contact at {}", pair[1]);
    }
}

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
        let scene = Scene {
            path: &route,
            ..scene(here, at(0.0, 0.6), &[])
        };
        if let Push::Along(force) = law.push(&scene) {
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
        let scene = Scene {
            path: &route,
            ..scene(from, goal, &[])
        };
        let pull = law.path_pull(&scene);
        assert!(pull.norm() > 1.0, "no point was taken");
        assert!(pull.normalize().dot(&(goal - from).normalize()) > 0.999);
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
        let free = |pair: &[Point2<f64>]| is_free(&bodies, pair[0], pair[1]);
        crossed += u32::from(!trace.points.windows(2).all(free));
    }
    println!("areas: {arrived} of 40 arrive; points: {crossed} of 40 cross an obstacle");
    assert!(crossed > 20, "points were no worse than areas");
}

#[test]
fn zm_rep_force_is_the_full_gradient() {
    let (post, goal) = (at(0.3, -0.2), at(2.0, 1.0));
    for n in [1, 2, 3] {
        for x in [at(1.0, 0.5), at(0.5, -0.9), at(-0.7, 0.4)] {
            let found = goal_repulsion(&Gains::JU, n, x, post, goal);
            let expected = slope(
                |x| goal_repulsion_potential(&Gains::JU, n, x, post, goal),
                x,
            );
            assert!(
                (found - expected).norm() < 1.0e-5 * expected.norm(),
                "{n} {x}"
            );
        }
    }
    assert!(goal_repulsion(&Gains::JU, 1, at(2.4, -0.2), post, goal).norm() < 1.0e-12);
    // The part away from the obstacle fades at the goal.
    let near = |d: f64| {
        let x = goal - Vector2::new(d, 0.0);
        goal_repulsion(&Gains::JU, 2, x, post, goal).norm()
    };
    assert!(near(0.01) < 0.2 * near(0.1));
}

#[test]
fn zm_rep_reaches_the_goal_beside_an_obstacle() {
    let goal = at(5.0, 0.0);
    let bodies = [Body::standing(at(5.3, 0.0), Extent::Disc(0.0))];
    let mut law = ZmRep::new(Gains::JU);
    let trace = walk(&mut law, at(0.0, 0.0), goal, &bodies, &[], &Walk::JU);
    assert_eq!(trace.end, End::Reached, "{:?}", trace.points.last());
    let last = scene(goal, goal, &bodies);
    assert!(all_goal_repulsions(&Gains::JU, 2, &last, goal).norm() < 1.0e-9);
}

#[test]
fn zm_esc_leaves_a_symmetric_minimum() {
    let bodies = [Body::standing(at(5.0, 0.0), Extent::Disc(0.8))];
    let mut law = ZmEsc::new(Gains::JU, Walk::JU.step);
    let trace = walk(
        &mut law,
        at(0.0, 0.0),
        at(10.0, 0.0),
        &bodies,
        &[],
        &Walk::JU,
    );
    assert_eq!(trace.end, End::Reached, "{:?}", trace.points.last());
    assert!(law.escapes() > 0);
    let caught = 45;
    assert!(trace.steps < caught + 200, "{} steps", trace.steps);
    assert_free(&trace, &bodies);
}

#[test]
fn zm_esc_does_not_stir_in_the_open_and_gives_up_in_a_pocket() {
    let mut law = ZmEsc::new(Gains::JU, Walk::JU.step);
    let trace = walk(&mut law, at(0.0, 0.0), at(10.0, 3.0), &[], &[], &Walk::JU);
    assert_eq!((trace.end, law.escapes()), (End::Reached, 0));
    let ring: Vec<Body> = (0..40)
        .map(|i| {
            let (sin, cos) = (core::f64::consts::TAU * f64::from(i) / 40.0).sin_cos();
            Body::standing(at(2.0 * cos, 2.0 * sin), Extent::Disc(0.2))
        })
        .collect();
    let mut law = ZmEsc::new(Gains::JU, Walk::JU.step);
    let trace = walk(&mut law, at(0.0, 0.0), at(10.0, 3.0), &ring, &[], &Walk::JU);
    assert!(
        matches!(trace.end, End::Stuck | End::Collision),
        "{:?}",
        trace.end
    );
    assert!(trace.steps < 1000);
    assert_free(&trace, &ring);
}

#[test]
fn zm_rv_pushes_sideways_from_what_approaches_alone() {
    let body = |x: f64, y: f64, vx: f64, vy: f64| Body {
        at: at(x, y),
        extent: Extent::Disc(0.3),
        velocity: Vector2::new(vx, vy),
    };
    let force = |body: &Body| velocity_repulsion(1.0, 3.0, at(0.0, 0.0), Vector2::x(), body);
    let head_on = force(&body(2.0, 0.0, -1.0, 0.0));
    assert!(head_on.x.abs() < 1e-12 && head_on.y.abs() > 0.5);
    assert!(
        force(&body(2.0, 0.0, 2.0, 0.0)).norm() < 1e-12,
        "it recedes"
    );
    assert!(
        force(&body(3.1, 0.0, -1.0, 0.0)).norm() < 1e-12,
        "it is far"
    );
    let (left, right) = (
        force(&body(2.0, 0.5, -1.0, 0.1)),
        force(&body(2.0, -0.5, -1.0, -0.1)),
    );
    assert!((left.x - right.x).abs() < 1e-12 && (left.y + right.y).abs() < 1e-12);
}

/// A point robot of constant speed against a disc on a collision course, as in the notes:
/// share of seeds without contact.
fn crossing_share(gain: f64) -> f64 {
    let mut clear = 0;
    for seed in 0..300 {
        let mut random = Pcg32::seed_from_u64(seed);
        let speed = [0.5, 1.0, 1.5][random.random_range(0..3)];
        let angle: f64 = random.random_range(-2.6..2.6);
        let meet = at(5.0, random.random_range(-0.3..0.3));
        let velocity = Vector2::new(angle.cos(), angle.sin()) * speed;
        let mut body = Body {
            at: meet - velocity * 5.0,
            extent: Extent::Disc(0.0),
            velocity,
        };
        let (mut here, goal) = (at(0.0, 0.0), at(10.0, 0.0));
        let mut heading = Vector2::x();
        let gains = Gains {
            attract: 1.0,
            repel: 1.0,
            reach: 2.5,
        };
        let mut least = f64::INFINITY;
        for _ in 0..200 {
            let push = attraction(gains.attract, here, goal).normalize()
                + repulsion(&gains, here, body.at)
                + velocity_repulsion(gain, gains.reach, here, heading, &body);
            heading = push.try_normalize(1e-9).unwrap_or(heading);
            here += heading * 0.05;
            body.at += body.velocity * 0.05;
            least = least.min((here - body.at).norm());
        }
        clear += u32::from(least > 0.6);
    }
    f64::from(clear) / 300.0
}

#[test]
fn zm_rv_avoids_what_crosses_and_is_not_worse_than_off() {
    let (on, off) = (crossing_share(1.0), crossing_share(0.0));
    println!("without contact: {on:.3} with, {off:.3} without");
    assert!(on >= 0.9 && on >= off, "{on} {off}");
}

#[test]
fn lwx_apf_uses_the_circle_of_its_paper() {
    let post = at(0.0, 0.0);
    assert!(repulsion(&Gains::LWX, at(1.51, 0.0), post).norm() < 1.0e-12);
    assert!(repulsion(&Gains::LWX, at(1.49, 0.0), post).norm() > 0.0);
    let mut law = JuApf::new(Gains::LWX);
    let bodies = [square(5.0, 1.2)];
    let trace = walk(
        &mut law,
        at(0.5, 0.5),
        at(9.5, 0.5),
        &bodies,
        &[],
        &Walk::LWX,
    );
    assert_eq!(trace.end, End::Reached);
    assert_free(&trace, &bodies);
}

#[test]
fn lwx_oapf_turning_points_are_exact() {
    let check = |corners: &[(f64, f64)], expected: &[(f64, f64)]| {
        let expected: Vec<Point2<f64>> = expected.iter().map(|&(x, y)| at(x, y)).collect();
        assert_eq!(turning_points(&path(corners)), expected);
    };
    check(&[(0., 0.), (1., 0.), (2., 0.)], &[(0., 0.), (2., 0.)]);
    check(&[(0., 0.), (0., 1.), (0., 2.)], &[(0., 0.), (0., 2.)]);
    check(&[(0., 0.), (1., 1.), (2., 2.)], &[(0., 0.), (2., 2.)]);
    check(
        &[(0., 0.), (1., 0.), (2., 1.)],
        &[(0., 0.), (1., 0.), (2., 1.)],
    );
    check(
        &[(0., 0.), (2., 0.), (1., 0.)],
        &[(0., 0.), (2., 0.), (1., 0.)],
    );
    check(&[], &[]);
}

fn staircase() -> Vec<Waypoint> {
    path(&[(0.5, 0.5), (3.5, 0.5), (5.5, 2.5), (5.5, 6.5), (9.5, 6.5)])
}

#[test]
fn lwx_oapf_walks_without_gaps_to_the_end() {
    let bodies = [square(4.5, 3.5), square(6.5, 4.5), square(3.5, 2.5)];
    let mut law = LwxOapf::new(Gains::LWX, 10.0, false);
    let trace = walk(
        &mut law,
        at(0.5, 0.5),
        at(9.5, 6.5),
        &bodies,
        &staircase(),
        &Walk::LWX,
    );
    assert_eq!(trace.end, End::Reached, "{:?}", trace.points.last());
    assert_free(&trace, &bodies);
    for pair in trace.points.windows(2) {
        assert!((pair[1] - pair[0]).norm() <= Walk::LWX.step + 1e-12);
    }
}

#[test]
fn lwx_iter_one_step_per_cell_is_too_few_and_ten_are_as_good_as_a_hundred() {
    let run = |per_unit: f64| {
        let mut law = LwxOapf::new(Gains::LWX, per_unit, true);
        walk(
            &mut law,
            at(0.5, 0.5),
            at(9.5, 6.5),
            &[],
            &staircase(),
            &Walk::LWX,
        )
    };
    assert_eq!(run(1.0).end, End::Stuck);
    let (ten, hundred) = (run(10.0), run(100.0));
    assert_eq!((ten.end, hundred.end), (End::Reached, End::Reached));
    assert_eq!(ten.points, hundred.points);
    assert_eq!(ten.steps, hundred.steps);
    let late = Walk {
        early_exit: false,
        ..Walk::LWX
    };
    let mut law = LwxOapf::new(Gains::LWX, 10.0, true);
    let trace = walk(
        &mut law,
        at(0.5, 0.5),
        at(9.5, 6.5),
        &[],
        &staircase(),
        &late,
    );
    assert_eq!(
        trace.steps, late.limit,
        "without early exit the loop goes on"
    );
}

#[test]
fn lwx_lsq_recovers_a_cubic_with_exact_ends() {
    let cubic = |x: f64| 0.2 * x * x * x - 0.5 * x + 1.0;
    let points: Vec<Point2<f64>> = (0..=40)
        .map(|i| {
            let x = f64::from(i) * 0.05 - 1.0;
            at(x, cubic(x))
        })
        .collect();
    for (found, expected) in fit_literal(&points, 3)
        .expect("monotone")
        .iter()
        .zip(&points)
    {
        assert!((found - expected).norm() < 1e-9);
    }
    let curve = fit(&points, 9).expect("points");
    assert!((curve[0] - points[0]).norm() < 1e-9);
    assert!((curve[100] - points[40]).norm() < 1e-9);
    for point in &curve {
        assert!((point.y - cubic(point.x)).abs() < 2e-3, "{point}");
    }
    let vertical: Vec<Point2<f64>> = (0..10).map(|i| at(2.0, f64::from(i))).collect();
    assert_eq!(fit_literal(&vertical, 3), Err(FitError::NotMonotone));
    let curve = fit(&vertical, 5).expect("parametric");
    assert!(curve.iter().all(|point| (point.x - 2.0).abs() < 1e-9));
    assert_eq!(fit(&[at(1.0, 1.0)], 3), Err(FitError::TooFew));
}

#[test]
fn lwx_lsq_takes_no_fit_that_collides() {
    // A corner around a square: low degrees cut it.
    let bodies = [square(2.0, 1.0)];
    let mut law = LwxLsq::new(Gains::LWX);
    let corner = path(&[(0.0, 0.0), (3.0, 0.0), (3.0, 3.0)]);
    let trace = walk(
        &mut law,
        at(0.0, 0.0),
        at(3.0, 3.0),
        &bodies,
        &corner,
        &Walk::LWX,
    );
    assert_eq!(trace.end, End::Reached);
    assert_free(&trace, &bodies);
    // Across the path itself: whatever fits the path collides.
    let walled = [Body::standing(at(1.5, 0.0), Extent::Disc(0.3))];
    let mut law = LwxLsq::new(Gains::LWX);
    let scene = Scene {
        path: &corner,
        ..scene(at(0.0, 0.0), at(3.0, 3.0), &walled)
    };
    law.push(&scene);
    assert!(!law.is_fitted(), "a fit through the post");
}

#[test]
fn lwx_fusion_turns_less_than_its_path() {
    let bodies = [square(4.5, 3.5), square(6.5, 4.5), square(3.5, 2.5)];
    let law = LwxFusion::new(Gains::LWX, Walk::LWX);
    let route = staircase();
    let scene = Scene {
        path: &route,
        ..scene(at(0.5, 0.5), at(9.5, 6.5), &bodies)
    };
    let (trace, curve) = law.plan(&scene);
    assert_eq!(trace.end, End::Reached);
    let curve = curve.expect("a free fit");
    let sharpest = |points: &[Point2<f64>]| {
        points
            .windows(3)
            .map(|w| {
                let (a, b) = (w[1] - w[0], w[2] - w[1]);
                a.perp(&b).atan2(a.dot(&b)).abs()
            })
            .fold(0.0, f64::max)
    };
    assert!(sharpest(&curve) < 0.3, "{}", sharpest(&curve));
    assert!(sharpest(&turning_points(&route)) > 0.7);
    assert!(
        curve
            .windows(2)
            .all(|pair| is_free(&bodies, pair[0], pair[1]))
    );
}

#[test]
fn bao_dwa_windows_are_those_of_the_paper() {
    let robot = zeronav_msgs::description::Description {
        v_mps_max: 0.5,
        w_radps_max: 1.2,
        a_mps2_max: 0.5,
        brake_mps2: 0.5,
        alpha_radps2_max: 2.0,
        ..Default::default()
    };
    let (v, w) = window(&robot, Twist::new(0.2, 1.1), 0.1);
    assert!((v.low - 0.15).abs() < 1e-12 && (v.high - 0.25).abs() < 1e-12);
    assert!((w.low - 0.9).abs() < 1e-12 && (w.high - 1.2).abs() < 1e-12);
    // sqrt(2 * 0.16 * 0.5) = 0.4.
    assert!(is_admissible(&robot, Twist::new(0.399, 0.0), 0.16));
    assert!(!is_admissible(&robot, Twist::new(0.401, 0.0), 0.16));
    // w^2 <= 2 (dist |w| / v) alpha: 1.0 <= 2 * 0.16 / 0.3 * 2.
    assert!(is_admissible(&robot, Twist::new(0.3, 1.0), 0.16));
    assert!(!is_admissible(&robot, Twist::new(0.3, 1.2), 0.08));
}

#[test]
fn bao_dwa_choice_does_not_depend_on_sigma() {
    for seed in 0..50 {
        let mut random = Pcg32::seed_from_u64(seed);
        let samples: Vec<Sample> = (0..40)
            .map(|_| Sample {
                twist: Twist::new(
                    random.random_range(0.0..0.5),
                    random.random_range(-1.2..1.2),
                ),
                head: random.random_range(0.0..3.1),
                dist: random.random_range(0.0..2.0),
            })
            .collect();
        let chosen = choose(&samples, &BaoWeights::default());
        for sigma in [0.1, 7.0] {
            let weights = BaoWeights {
                sigma,
                ..BaoWeights::default()
            };
            assert_eq!(choose(&samples, &weights), chosen, "seed {seed}");
        }
    }
    assert_eq!(choose(&[], &BaoWeights::default()), None);
}

/// Drives a controller of the table along an aisle: seconds, or none, and the nearest approach.
fn aisle(key: &str, goal_m: f64) -> (Option<f64>, f64) {
    let walls = [block(0.0, 0.0, 10.0, 0.4), block(0.0, 3.4, 10.0, 3.8)];
    let robot = disc(0.25, 0.8, 1.0, 1.8, 3.0);
    let corners = path(&[(1.0, 1.9), (goal_m, 1.9)]);
    let mut run = Loop::new(
        robot,
        &walls,
        (10.0, 3.8),
        Pose::new(1.0, 1.9, 0.6),
        corners,
    );
    let row = controller(key).expect("in the table");
    let mut controller = (row.build)(&LocalPlannerConfig::default());
    let arrived = run.run(controller.as_mut(), 40.0);
    println!(
        "{key}: {arrived} after {:.1} s, nearest {:.3} m",
        run.time_s, run.least_m
    );
    (arrived.then_some(run.time_s), run.least_m)
}

macro_rules! drives_an_aisle {
    ($($name:ident $key:literal,)*) => {$(
        #[test]
        fn $name() {
            let (time_s, least_m) = aisle($key, 8.0);
            assert!(least_m > 0.0, "touched something");
            assert!(time_s.is_some(), "did not arrive");
        }
    )*};
}

drives_an_aisle! {
    ju_apf_drives_an_aisle "ju_apf",
    ju_r6_drives_an_aisle "ju_r6",
    ju_r7_drives_an_aisle "ju_r7",
    ju_fusion_drives_an_aisle "ju_fusion",
    zm_rep_drives_an_aisle "zm_rep",
    zm_esc_drives_an_aisle "zm_esc",
    zm_rv_drives_an_aisle "zm_rv",
    lwx_apf_drives_an_aisle "lwx_apf",
    lwx_oapf_drives_an_aisle "lwx_oapf",
    lwx_iter_drives_an_aisle "lwx_iter",
    lwx_lsq_drives_an_aisle "lwx_lsq",
    lwx_fusion_drives_an_aisle "lwx_fusion",
    bao_dwa_drives_an_aisle "bao_dwa",
}

#[test]
fn every_controller_stops_before_a_wall_across_its_path() {
    for key in [
        "ju_apf",
        "ju_r6",
        "ju_r7",
        "ju_fusion",
        "zm_rep",
        "zm_esc",
        "zm_rv",
        "lwx_apf",
        "lwx_oapf",
        "lwx_iter",
        "lwx_lsq",
        "lwx_fusion",
        "bao_dwa",
    ] {
        let walls = [
            block(0.0, 0.0, 10.0, 0.4),
            block(0.0, 3.4, 10.0, 3.8),
            block(6.0, 0.4, 6.3, 3.4),
        ];
        let robot = disc(0.25, 0.8, 1.0, 1.8, 3.0);
        let corners = path(&[(1.0, 1.9), (8.0, 1.9)]);
        let mut run = Loop::new(
            robot,
            &walls,
            (10.0, 3.8),
            Pose::new(1.0, 1.9, 0.0),
            corners,
        );
        run.delay = 2;
        let row = controller(key).expect("in the table");
        let mut controller = (row.build)(&LocalPlannerConfig::default());
        let arrived = run.run(controller.as_mut(), 12.0);
        assert!(!arrived && run.least_m > 0.0, "{key}: {}", run.least_m);
        assert!(run.driven_m > 2.0, "{key} hardly moved: {}", run.driven_m);
    }
}
