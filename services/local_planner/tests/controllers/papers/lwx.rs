//! The potential field and the fit of LWX.

use super::*;

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

/// A law that counts how often it was asked.
#[derive(Debug)]
struct Counted {
    law: LwxOapf,
    asked: usize,
}

impl Law for Counted {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        self.asked += 1;
        self.law.push(input)
    }
}

/// `lwx_iter` with `L` steps per cell up the staircase, and how often the law was asked.
fn iterated(per_unit: f64, how: &Walk) -> (Trace, usize) {
    let mut law = Counted {
        law: LwxOapf::new(Gains::LWX, per_unit, true),
        asked: 0,
    };
    let trace = walk(&mut law, at(0.5, 0.5), at(9.5, 6.5), &[], &staircase(), how);
    (trace, law.asked)
}

#[test]
fn lwx_iter_one_step_per_cell_is_too_few_and_ten_are_as_good_as_a_hundred() {
    assert_eq!(iterated(1.0, &Walk::LWX).0.end, End::Stuck);
    let (ten, asked) = iterated(10.0, &Walk::LWX);
    let (hundred, _) = iterated(100.0, &Walk::LWX);
    assert_eq!((ten.end, hundred.end), (End::Reached, End::Reached));
    assert_eq!(ten.points, hundred.points);
    assert_eq!((ten.steps, hundred.steps), (asked, asked));
}

#[test]
fn lwx_iter_without_early_exit_pays_for_the_steps_that_it_does_not_need() {
    let late = Walk {
        early_exit: false,
        ..Walk::LWX
    };
    let (early, _) = iterated(10.0, &Walk::LWX);
    let (ten, ten_asked) = iterated(10.0, &late);
    let (hundred, hundred_asked) = iterated(100.0, &late);
    for (trace, asked) in [(&ten, ten_asked), (&hundred, hundred_asked)] {
        assert_eq!(trace.end, End::Reached);
        // The last question is the one that the law declines: its steps are used up.
        assert_eq!(trace.steps + 1, asked);
        // The same way there; what follows stays at the goal.
        let way = early.points.len();
        assert_eq!(trace.points[..way], early.points);
        for point in &trace.points[way..] {
            assert!((point - at(9.5, 6.5)).norm() < Walk::LWX.tolerance);
        }
    }
    println!(
        "steps: {} with early exit, {} without at L = 10, {} at L = 100",
        early.steps, ten.steps, hundred.steps
    );
    assert!(ten.steps > early.steps && hundred.steps > 2 * ten.steps);
    assert!(hundred.steps < late.limit, "the law ends the loop");
}

#[test]
fn a_walk_without_early_exit_goes_on_to_its_limit() {
    let late = Walk {
        early_exit: false,
        limit: 150,
        ..Walk::LWX
    };
    let mut law = JuApf::new(Gains::LWX);
    let trace = walk(&mut law, at(0.5, 0.5), at(9.5, 0.5), &[], &[], &late);
    assert_eq!((trace.end, trace.steps), (End::Reached, 150));
    let last = trace.points[trace.points.len() - 1];
    assert!((last - at(9.5, 0.5)).norm() < 1.0e-9);
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
    let input = LawInput {
        path: &corner,
        ..input(at(0.0, 0.0), at(3.0, 3.0), &walled)
    };
    law.push(&input);
    assert!(!law.is_fitted(), "a fit through the post");
}

#[test]
fn lwx_fusion_turns_less_than_its_path() {
    let bodies = [square(4.5, 3.5), square(6.5, 4.5), square(3.5, 2.5)];
    let law = LwxFusion::new(Gains::LWX, Walk::LWX);
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
