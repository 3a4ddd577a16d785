//! The controllers of the papers: the acceptance tests of the paper notes, by key.

#![allow(clippy::print_stdout, reason = "shares and seeds of a failed run")]

mod bao;
mod ju;
mod lwx;
mod lwx_fusion;
mod zm;

use crate::support::{Loop, PERIOD_S, block, disc, path};
use nalgebra::{Point2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use zeronav_casts::Cast;
use zeronav_local_planner::LocalPlannerConfig;
use zeronav_local_planner::papers::bao_dwa::{Sample, choose, decisive, is_admissible, window};
use zeronav_local_planner::papers::fit::{FitError, fit, fit_literal, free_fit};
use zeronav_local_planner::papers::ju_apf::JuApf;
use zeronav_local_planner::papers::ju_fusion::JuFusion;
use zeronav_local_planner::papers::ju_r6::JuR6;
use zeronav_local_planner::papers::ju_r7::JuR7;
use zeronav_local_planner::papers::lwx_fusion::LwxFusion;
use zeronav_local_planner::papers::lwx_loop::{Loop as Iteration, Restart, run};
use zeronav_local_planner::papers::lwx_lsq::LwxLsq;
use zeronav_local_planner::papers::lwx_oapf::LwxOapf;
use zeronav_local_planner::papers::options::{
    BaoDwaConfig, FitMode, JuFusionConfig, JuR6Config, JuR7Config, LwxFusionConfig, LwxLsqConfig,
    Normalise, Smooth, Switch, ZmEscConfig, ZmFullConfig, ZmRepConfig, ZmRvConfig,
};
use zeronav_local_planner::papers::potential::{
    Eta, Gains, attraction, eta_repulsion, eta_repulsion_potential, goal_repulsion,
    goal_repulsion_potential, repulsion, repulsion_potential, velocity_repulsion,
};
use zeronav_local_planner::papers::route::turning_points;
use zeronav_local_planner::papers::walk::{End, Trace, Walk, walk};
use zeronav_local_planner::papers::zm_esc::ZmEsc;
use zeronav_local_planner::papers::zm_full::ZmFull;
use zeronav_local_planner::papers::zm_rep::ZmRep;
use zeronav_local_planner::papers::zm_rv::ZmRv;
use zeronav_local_planner::papers::{Body, Extent, Ground, Law, LawInput, Push};
use zeronav_local_planner::table::controller;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::command::{RequestCause, Validity};
use zeronav_msgs::obstacles::Obstacle;
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

fn input(from: Point2<f64>, goal: Point2<f64>, bodies: &[Body]) -> LawInput<'_> {
    LawInput {
        at: from,
        velocity: Vector2::zeros(),
        goal,
        bodies,
        path: &[],
        geometry: 1,
        literal: false,
        steps: 1.0,
        ground: None,
    }
}

/// Central differences of a potential.
fn slope(potential: impl Fn(Point2<f64>) -> f64, x: Point2<f64>) -> Vector2<f64> {
    let h = 1.0e-6;
    let along = |d: Vector2<f64>| (potential(x + d * h) - potential(x - d * h)) / (2.0 * h);
    -Vector2::new(along(Vector2::x()), along(Vector2::y()))
}

/// How deep a segment enters a body, from its outline alone: not by the predicate that the walk
/// asks before it takes a step. Looked at every half millimetre and at the nearest approach.
fn depth(body: &Body, from: Point2<f64>, to: Point2<f64>) -> f64 {
    let way = to - from;
    let nearest = ((body.at - from).dot(&way) / way.norm_squared().max(1e-18)).clamp(0.0, 1.0);
    let steps = (way.norm() / 0.0005).ceil().max(1.0).to_u32();
    (0..=steps)
        .map(|step| f64::from(step) / f64::from(steps))
        .chain([nearest])
        .map(|share| {
            let offset = from + way * share - body.at;
            match body.extent {
                Extent::Disc(radius) => radius - offset.norm(),
                Extent::Square(half) => half - offset.x.abs().max(offset.y.abs()),
            }
        })
        .fold(f64::NEG_INFINITY, f64::max)
}

/// The deepest that a polyline enters any of the bodies; negative when it touches none.
fn deepest(points: &[Point2<f64>], bodies: &[Body]) -> f64 {
    points
        .windows(2)
        .flat_map(|pair| bodies.iter().map(|body| depth(body, pair[0], pair[1])))
        .fold(f64::NEG_INFINITY, f64::max)
}

fn assert_free(trace: &Trace, bodies: &[Body]) {
    let deep = deepest(&trace.points, bodies);
    assert!(deep <= 0.0, "{deep} inside an area");
}

#[test]
fn a_polyline_is_measured_against_outlines() {
    let bodies = [square(0.0, 0.0)];
    let check = |points: &[(f64, f64)], expected: f64| {
        let points: Vec<_> = points.iter().map(|&(x, y)| at(x, y)).collect();
        let found = deepest(&points, &bodies);
        assert!((found - expected).abs() < 1e-3, "{found}");
    };
    check(&[(-2.0, 0.6), (2.0, 0.6)], -0.1);
    check(&[(-2.0, 0.4), (2.0, 0.4)], 0.1);
    // Across a corner, both ends outside.
    check(&[(0.3, 0.6), (0.6, 0.3)], 0.05);
    let disc = [Body::standing(at(0.0, 0.0), Extent::Disc(0.3))];
    let found = deepest(&[at(-1.0, 0.2), at(1.0, 0.2)], &disc);
    assert!((found - 0.1).abs() < 1e-9, "{found}");
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
    let arrived = run.run(&mut controller, 40.0);
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
    zm_full_drives_an_aisle "zm_full",
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
        "zm_full",
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
        let arrived = run.run(&mut controller, 12.0);
        assert!(!arrived && run.least_m > 0.0, "{key}: {}", run.least_m);
        assert!(run.driven_m > 2.0, "{key} hardly moved: {}", run.driven_m);
    }
}

/// An aisle in which a law's force points along +x, seen from this pose and with this twist.
fn in_the_aisle(yaw_rad: f64, v_mps: f64) -> Loop {
    let walls = [block(0.0, 0.0, 12.0, 0.4), block(0.0, 5.4, 12.0, 5.8)];
    let robot = disc(0.25, 0.8, 1.0, 1.8, 3.0);
    let corners = path(&[(1.0, 2.9), (11.0, 2.9)]);
    let pose = Pose::new(1.0, 2.9, yaw_rad);
    let mut run = Loop::new(robot, &walls, (12.0, 5.8), pose, corners);
    run.twist = Twist::new(v_mps, 0.0);
    run
}

#[test]
fn laws_explain_their_speed() {
    for key in ["ju_apf", "ju_r7", "zm_esc", "lwx_oapf"] {
        let first = |mut run: Loop| {
            let row = controller(key).expect("in the table");
            let mut controller = (row.build)(&LocalPlannerConfig::default());
            let decision = run.step(&mut controller);
            (decision.cause, decision.limit_mps)
        };
        let (cause, limit_mps) = first(in_the_aisle(0.0, 0.8));
        assert_eq!(cause, RequestCause::Free, "{key}");
        assert!((limit_mps - 0.8).abs() < 1e-9, "{key}: {limit_mps}");
        let (cause, limit_mps) = first(in_the_aisle(1.0, 0.8));
        assert_eq!(cause, RequestCause::PotentialField, "{key}");
        assert!((0.2..0.7).contains(&limit_mps), "{key}: {limit_mps}");
        let mut run = in_the_aisle(0.0, 0.8);
        run.obstacles.push(Obstacle {
            track: 1,
            x_m: 3.2,
            y_m: 2.9,
            vx_mps: -0.3,
            radius_m: 0.3,
            covariance: [1e-3, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.02, 0.0, 0.02],
            ..Obstacle::default()
        });
        let (cause, _) = first(run);
        assert_eq!(cause, RequestCause::Yield, "{key}");
    }
}
