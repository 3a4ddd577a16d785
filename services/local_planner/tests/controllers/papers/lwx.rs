//! The potential field and the fit of LWX.

use super::*;
use zeronav_casts::Cast;

#[test]
fn lwx_apf_in_metres_goes_where_it_goes_in_cells() {
    // Cells of half a metre: the same place in both measures.
    let (post, goal) = (at(0.7, 0.5), at(6.0, 1.0));
    let force = |gains: &Gains, scale: f64| {
        let here = at(0.3, 0.2) * scale;
        let pull = attraction(gains.attract, here, goal * scale);
        (pull + repulsion(gains, here, post * scale)).normalize()
    };
    let (cells, metres) = (force(&Gains::LWX, 1.0), force(&Gains::LWX_M, 0.5));
    assert!((cells - metres).norm() < 1e-12, "{cells} {metres}");
    let pull = attraction(1.0, at(0.3, 0.2), goal).normalize();
    assert!((cells - pull).norm() > 0.01, "the post repels");
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

/// [LWX] in cells, with the gains as they are.
const IN_CELLS: Iteration = Iteration {
    walk: Walk::LWX,
    per_unit: 10.0,
    early_exit: true,
    restart: Restart::Robot,
    falls_back: false,
};

#[test]
fn lwx_oapf_restarts_at_turning_points_only_when_that_is_asked_for() {
    let gap = |restart| {
        let how = Iteration {
            restart,
            ..IN_CELLS
        };
        let trace = run(Gains::LWX, &[], &staircase(), &how);
        assert_eq!(trace.end, End::Reached);
        let pairs = trace.points.windows(2);
        pairs
            .map(|pair| (pair[1] - pair[0]).norm())
            .fold(0.0, f64::max)
    };
    // As printed the path jumps to a turning point; a robot cannot.
    let (jump, step) = (gap(Restart::Point), gap(Restart::Robot));
    assert!((0.5..4.0).contains(&jump), "{jump}");
    assert!((step - Walk::LWX.step).abs() < 1e-9, "{step}");
}

#[test]
fn lwx_oapf_takes_the_nearer_turning_point_once_and_then_asks_for_another_path() {
    let route = path(&[(0.5, 0.5), (5.5, 0.5), (5.5, 6.5)]);
    // Without any way the law is stuck, and stays so until the path changes.
    let wall = [Body::standing(at(2.0, 0.5), Extent::Disc(1.0))];
    let mut law = LwxOapf::new(Gains::LWX, 10.0, false);
    let mut asked = 0;
    let input = LawInput {
        path: &route,
        ..input(at(0.5, 0.5), at(5.5, 6.5), &wall)
    };
    while let Push::Along(_) = law.push(&input) {
        asked += 1;
        assert!(asked < 1000, "for ever");
    }
    // 8 cells to the second turning point, 5 to the first, ten steps each.
    assert_eq!(asked, 79 + 50);
    assert_eq!(law.push(&input), Push::Stuck);
    let other = LawInput {
        geometry: 2,
        ..input
    };
    assert!(matches!(law.push(&other), Push::Along(_)));
}

#[test]
fn lwx_oapf_walks_past_blocks_to_the_end() {
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
}

#[test]
fn lwx_iter_one_step_per_cell_is_too_few_and_ten_are_as_good_as_a_hundred() {
    let with = |per_unit| {
        let how = Iteration {
            per_unit,
            ..IN_CELLS
        };
        run(Gains::LWX, &[], &staircase(), &how)
    };
    let (one, ten, hundred) = (with(1.0), with(10.0), with(100.0));
    assert_eq!(one.end, End::Stuck);
    // A fifth of a cell for every cell of the way to the first interim goal.
    let walked = (one.points[one.points.len() - 1] - at(0.5, 0.5)).norm();
    let wanted = (at(5.5, 2.5) - at(0.5, 0.5)).norm();
    assert!((walked - 0.2 * wanted.ceil()).abs() < 0.05, "{walked}");
    assert_eq!((ten.end, hundred.end), (End::Reached, End::Reached));
    assert_eq!(ten.points, hundred.points);
}

#[test]
fn lwx_iter_without_early_exit_costs_what_it_costs() {
    let with = |per_unit| {
        let how = Iteration {
            per_unit,
            early_exit: false,
            walk: Walk {
                limit: 1_000_000,
                ..Walk::LWX
            },
            ..IN_CELLS
        };
        run(Gains::LWX, &[], &staircase(), &how)
    };
    let (ten, hundred) = (with(10.0), with(100.0));
    assert_eq!((ten.end, hundred.end), (End::Reached, End::Reached));
    // The paper: 100 cost 288 % more than 10. Every step is done, so that it is ten times as many.
    let count = |n: usize| f64::from(u32::try_from(n).expect("steps"));
    let more = count(hundred.steps) / count(ten.steps) - 1.0;
    println!(
        "{} and {} steps: {:+.0} %",
        ten.steps,
        hundred.steps,
        100.0 * more
    );
    assert!((7.0..9.5).contains(&more), "{more}");
}

/// A wall with a lip between the robot and the second turning point, not before the first.
fn lip() -> (Vec<Body>, Vec<Waypoint>) {
    let wall = [0.5, 1.5, 2.5, 3.5].map(|y| square(3.5, y));
    let bodies = wall.into_iter().chain([square(2.5, 3.5)]).collect();
    (bodies, path(&[(0.5, 0.5), (0.5, 5.5), (7.5, 5.5)]))
}

#[test]
fn lwx_iter_gives_up_where_lwx_oapf_takes_the_nearer_turning_point() {
    let (bodies, route) = lip();
    let walk_with = |strict| {
        let mut law = LwxOapf::new(Gains::LWX, 10.0, strict);
        let trace = walk(
            &mut law,
            at(0.5, 0.5),
            at(7.5, 5.5),
            &bodies,
            &route,
            &Walk::LWX,
        );
        assert_free(&trace, &bodies);
        println!(
            "strict {strict}: {:?} {} {:?}",
            trace.end,
            trace.steps,
            trace.points.last()
        );
        trace.end
    };
    assert_eq!(
        (walk_with(true), walk_with(false)),
        (End::Stuck, End::Reached)
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

/// [LWX] in cells.
fn cells() -> LwxLsqConfig {
    LwxLsqConfig {
        repel: Gains::LWX.repel,
        reach_m: Gains::LWX.reach,
        ..LwxLsqConfig::default()
    }
}

/// Only what lies on one side of a line is free.
#[derive(Debug)]
struct Below(f64);

impl Ground for Below {
    fn is_free(&self, from: Point2<f64>, to: Point2<f64>) -> bool {
        from.y.max(to.y) < self.0
    }

    fn bodies(&self, _: Point2<f64>, _: f64, _: &mut Vec<Body>) -> bool {
        false
    }
}

#[test]
fn lwx_lsq_drops_a_fit_that_a_later_scan_shows_to_be_blocked() {
    let route = path(&[(0.0, 0.0), (3.0, 0.0), (6.0, 1.0), (9.0, 1.0)]);
    let mut law = LwxLsq::new(&cells());
    let seen = |law: &mut LwxLsq, ground: &dyn Ground, x| {
        let input = LawInput {
            path: &route,
            ground: Some(ground),
            ..input(at(x, 0.0), at(9.0, 1.0), &[])
        };
        law.push(&input);
        law.is_fitted()
    };
    assert_eq!(seen(&mut law, &Below(2.0), 0.0), Ok(true));
    assert_eq!(seen(&mut law, &Below(2.0), 1.0), Ok(true));
    // The same path, but now a wall is seen across its end.
    assert_eq!(seen(&mut law, &Below(0.5), 1.2), Ok(false));
    assert_eq!(
        seen(&mut law, &Below(2.0), 1.3),
        Ok(false),
        "not taken again"
    );
}

#[test]
fn lwx_lsq_literal_fits_y_over_x_or_says_that_it_cannot() {
    let literal = LwxLsqConfig {
        mode: FitMode::YxLiteral,
        ..cells()
    };
    let fitted = |corners: &[(f64, f64)]| {
        let route = path(corners);
        let mut law = LwxLsq::new(&literal);
        let input = LawInput {
            path: &route,
            ..input(at(0.0, 0.0), at(5.0, 5.0), &[])
        };
        law.push(&input);
        law.is_fitted()
    };
    assert_eq!(fitted(&[(0.0, 0.0), (3.0, 0.0), (6.0, 2.0)]), Ok(true));
    assert_eq!(
        fitted(&[(0.0, 0.0), (0.0, 5.0)]),
        Err(FitError::NotMonotone)
    );
    assert_eq!(
        fitted(&[(0.0, 0.0), (3.0, 0.0), (1.0, 2.0)]),
        Err(FitError::NotMonotone)
    );
}

#[test]
fn lwx_lsq_joins_the_parts_of_a_split_path_in_one_direction() {
    // A serpentine between walls that no single polynomial follows closely enough.
    let route: Vec<(f64, f64)> = (0..16)
        .map(|i| {
            let right = i % 4 == 1 || i % 4 == 2;
            (if right { 6.0 } else { 0.0 }, 2.0 * f64::from(i / 2))
        })
        .collect();
    let points: Vec<Point2<f64>> = route
        .windows(2)
        .flat_map(|pair| {
            let (from, to) = (at(pair[0].0, pair[0].1), at(pair[1].0, pair[1].1));
            let n = ((to - from).norm() / 0.25).round().to_u32();
            (0..n).map(move |i| from + (to - from) * (f64::from(i) / f64::from(n)))
        })
        .chain([at(0.0, 14.0)])
        .collect();
    let near = |from: Point2<f64>, to: Point2<f64>| {
        [from, to]
            .iter()
            .all(|at| points.iter().any(|point| (point - at).norm() < 0.3))
    };
    assert!((3..=15).all(|degree| {
        let curve = fit(&points, degree).expect("points");
        curve.windows(2).any(|pair| !near(pair[0], pair[1]))
    }));
    let curve = free_fit(&points, near).expect("parts");
    assert!(curve.len() > 101);
    assert!((curve[0] - points[0]).norm() < 1e-9);
    assert!((curve[curve.len() - 1] - points[points.len() - 1]).norm() < 1e-9);
    // One-sided derivatives of second order on both sides of every joint, of parts of 100 pieces.
    for joint in (100..curve.len() - 1).step_by(100) {
        let slope = |a: usize, b: usize| {
            let (here, near, far) = (curve[joint].coords, curve[a].coords, curve[b].coords);
            near * 4.0 - here * 3.0 - far
        };
        let (before, after) = (-slope(joint - 1, joint - 2), slope(joint + 1, joint + 2));
        let turn = before.perp(&after).atan2(before.dot(&after)).abs();
        // The corner itself turns by a right angle.
        assert!(turn < 0.45, "{turn} rad at {joint}");
    }
}

#[test]
fn lwx_lsq_takes_no_fit_that_collides() {
    // A corner around a square: low degrees cut it.
    let bodies = [square(2.0, 1.0)];
    let mut law = LwxLsq::new(&cells());
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
    let mut law = LwxLsq::new(&cells());
    let input = LawInput {
        path: &corner,
        ..input(at(0.0, 0.0), at(3.0, 3.0), &walled)
    };
    law.push(&input);
    assert_eq!(law.is_fitted(), Ok(false), "a fit through the post");
}

#[test]
fn lwx_fusion_turns_less_than_its_path() {
    let bodies = [square(4.5, 3.5), square(6.5, 4.5), square(3.5, 2.5)];
    let law = LwxFusion::new(
        &LwxFusionConfig {
            repel: Gains::LWX.repel,
            reach_m: Gains::LWX.reach,
            steps_per_m: 10.0,
            ..LwxFusionConfig::default()
        },
        Walk::LWX,
    );
    let route = staircase();
    let input = LawInput {
        path: &route,
        ..input(at(0.5, 0.5), at(9.5, 6.5), &bodies)
    };
    let (trace, curve) = law.plan(&input);
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
    let deep = deepest(&curve, &bodies);
    assert!(deep <= 0.0, "{deep} inside an area");
}
