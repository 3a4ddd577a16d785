//! BAO-SPL.

use super::generate::{any, corners};
use super::{assert_close, plain, plan};
use crate::papers::spline::{Spline, SplineEnds, curve_of, point_on, segments};
use crate::support::{Map, Rng};
use crate::waypoints::waypoints_along;
use crate::{CornerRule, PlannerOptions};
use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_msgs::map::COST_LETHAL;
use zeronav_msgs::{Cell, Pose};

fn points(list: &[(f64, f64)]) -> Vec<Point2<f64>> {
    list.iter().map(|(x, y)| Point2::new(*x, *y)).collect()
}

/// Densely along the curve.
fn sampled(control: &[Point2<f64>], ends: SplineEnds) -> Vec<Point2<f64>> {
    segments(control, ends)
        .flat_map(|segment| (0..=20).map(move |k| point_on(&segment, f64::from(k) / 20.0).at))
        .collect()
}

fn length(points: &[Point2<f64>]) -> f64 {
    points
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).norm())
        .sum()
}

#[test]
fn bao_spl_starts_and_ends_exactly() {
    let control = points(&[(0.0, 0.0), (1.0, 1.0), (2.0, 1.0), (3.0, 0.0), (3.0, -1.0)]);
    for (ends, n) in [(SplineEnds::Phantom, 4), (SplineEnds::Triple, 6)] {
        assert_eq!(segments(&control, ends).count(), n);
        let curve = sampled(&control, ends);
        let (first, last) = (curve[0], curve[curve.len() - 1]);
        assert_close((first - control[0]).norm(), 0.0, 1e-12, "start");
        assert_close((last - control[4]).norm(), 0.0, 1e-12, "end");
    }
    // With phantom points the curve leaves along the path and without curvature.
    let start = point_on(
        &segments(&control, SplineEnds::Phantom).next().unwrap(),
        0.0,
    );
    assert_close(
        start.tangent.perp(&(control[1] - control[0])),
        0.0,
        1e-12,
        "tangent",
    );
    assert_close(start.curvature, 0.0, 1e-12, "curvature");
    // Without, the curve of (0, 0), (1, 1), (2, 1) would begin at (1, 0.83).
    let raw = [control[0], control[1], control[2], control[3]];
    let begin = point_on(&raw, 0.0).at;
    assert_close(
        (begin - Point2::new(1.0, 5.0 / 6.0)).norm(),
        0.0,
        1e-12,
        "unclamped",
    );
}

#[test]
fn bao_spl_few_points() {
    assert_eq!(segments(&[], SplineEnds::Phantom).count(), 0);
    let one = points(&[(2.0, 3.0)]);
    assert_eq!(segments(&one, SplineEnds::Phantom).count(), 0);
    let two = points(&[(0.0, 0.0), (2.0, 1.0)]);
    for point in sampled(&two, SplineEnds::Phantom) {
        assert_close(
            point.coords.perp(&(two[1] - two[0])),
            0.0,
            1e-12,
            "straight",
        );
    }
    assert_eq!(segments(&two, SplineEnds::Off).count(), 0);
}

#[test]
fn bao_spl_weights_add_up_and_the_curve_stays_in_the_hull() {
    let mut rng = Rng(5);
    for _ in 0..200 {
        let mut draw = || f64::from(rng.below(2000)) / 100.0 - 10.0;
        let shift = Point2::new(draw(), draw());
        let same = point_on(&[shift; 4], 0.3);
        assert_close((same.at - shift).norm(), 0.0, 1e-12, "partition of unity");
        let control = [(); 4].map(|()| Point2::new(draw(), draw()));
        for k in 0..=10 {
            let at = point_on(&control, f64::from(k) / 10.0).at;
            // No direction in which the curve lies beyond every control point.
            for angle in 0..16 {
                let (sin, cos) = (f64::from(angle) * 0.4).sin_cos();
                let reach = |point: &Point2<f64>| cos * point.x + sin * point.y;
                let furthest = control.iter().map(reach).fold(f64::MIN, f64::max);
                assert!(reach(&at) <= furthest + 1e-12, "beyond the hull");
            }
        }
    }
}

#[test]
fn bao_spl_joins_in_place_direction_and_curvature() {
    let control = points(&[
        (0.0, 0.0),
        (1.0, 0.0),
        (2.0, 1.0),
        (2.0, 2.0),
        (1.0, 3.0),
        (0.0, 3.0),
    ]);
    for ends in [SplineEnds::Phantom, SplineEnds::Triple] {
        let all: Vec<_> = segments(&control, ends).collect();
        for pair in all.windows(2) {
            let (before, after) = (point_on(&pair[0], 1.0), point_on(&pair[1], 0.0));
            assert_close((before.at - after.at).norm(), 0.0, 1e-12, "C0");
            assert_close((before.tangent - after.tangent).norm(), 0.0, 1e-12, "C1");
            assert_close(before.curvature, after.curvature, 1e-9, "C2");
        }
        // Derivatives against differences.
        for segment in &all {
            let h = 1e-5;
            let (a, b, c) = (
                point_on(segment, 0.4 - h),
                point_on(segment, 0.4),
                point_on(segment, 0.4 + h),
            );
            let tangent = (c.at - a.at) / (2.0 * h);
            assert_close((tangent - b.tangent).norm(), 0.0, 1e-8, "tangent");
            let second = (c.tangent - a.tangent) / (2.0 * h);
            let curvature = b.tangent.perp(&second) / b.tangent.norm().powi(3);
            assert_close(b.curvature, curvature, 1e-6, "curvature");
        }
    }
}

#[test]
fn bao_spl_deviates_by_a_sixth_of_the_second_difference() {
    let deviation = |turn: (f64, f64)| {
        let control = points(&[
            (-2.0, 0.0),
            (-1.0, 0.0),
            (0.0, 0.0),
            turn,
            (2.0 * turn.0, 2.0 * turn.1),
        ]);
        let curve = sampled(&control, SplineEnds::Phantom);
        let to_corner = |point: &Point2<f64>| point.coords.norm();
        curve.iter().map(to_corner).fold(f64::INFINITY, f64::min)
    };
    assert_close(
        deviation((0.0, 1.0)),
        2_f64.sqrt() / 6.0,
        1e-3,
        "90 degrees",
    );
    // A straight step, then a diagonal one.
    assert_close(deviation((1.0, 1.0)), 1.0 / 6.0, 2e-2, "45 degrees");
}

#[test]
fn bao_spl_keeps_its_distance_on_1000_maps() {
    let mut gains = Vec::new();
    let mut nearest = f64::INFINITY;
    for seed in 0..1000 {
        let map = any(20, 16, seed);
        let Ok(found) = plan("bao_iaa", &plain(), &map, CornerRule::Allow, corners(&map)) else {
            continue;
        };
        let cells = &found.path.cells;
        let control: Vec<_> = cells
            .iter()
            .map(|cell| Point2::new(f64::from(cell.x), f64::from(cell.y)))
            .collect();
        let curve = sampled(&control, SplineEnds::Phantom);
        for point in &curve {
            nearest = nearest.min(clearance(&map, point));
        }
        assert!(
            length(&curve) <= found.path.length_cells() + 1e-9,
            "seed {seed}"
        );
        assert!(
            !found.path.curve.is_empty(),
            "seed {seed}: the curve was refused"
        );
        let remarks = found.stats().remarks;
        assert!(!remarks.curve_dropped, "seed {seed}");
        // A right angle from step to step turns as sharply as 1 / 0.3 cells.
        let sharpest = remarks.curvature_max_1pm * map.geometry.resolution_m;
        assert!((0.0..4.0).contains(&sharpest), "seed {seed}: {sharpest}");
        gains.push(length(&curve) / found.path.length_cells() - 1.0);
    }
    assert!(nearest >= 0.465, "{nearest} cells from an obstacle");
    assert!(gains.len() > 500);
    let mean = gains.iter().sum::<f64>() / f64::from(u32::try_from(gains.len()).unwrap());
    assert!(
        (-0.045..-0.01).contains(&mean),
        "mean change of length {mean}"
    );
}

/// Distance to the nearest obstacle square, 1 when there is none near. [cells]
fn clearance(map: &Map, point: &Point2<f64>) -> f64 {
    let mut nearest = 1.0_f64;
    let (x, y) = (point.x.round().to_i32(), point.y.round().to_i32());
    for cell in (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| Cell::new(x + dx, y + dy))) {
        if map
            .view()
            .get(cell)
            .is_some_and(|cell| cell.cost == COST_LETHAL)
        {
            let gap = |point: f64, cell: i32| ((point - f64::from(cell)).abs() - 0.5).max(0.0);
            nearest = nearest.min(gap(point.x, cell.x).hypot(gap(point.y, cell.y)));
        }
    }
    nearest
}

#[test]
fn bao_spl_leads_from_the_robots_cell_to_the_goal_itself() {
    let (map, at) = Map::drawn("......G\n...#...\n...#...\nS..#...");
    let mut goal = map.pose(at('G'));
    goal.x_m += 0.012;
    goal.y_m -= 0.017;
    let mut query = super::query(&map, CornerRule::ForbidAny, at('S'), at('G'));
    query.goal = goal;
    for (ends, has_curve) in [
        (SplineEnds::Phantom, true),
        (SplineEnds::Triple, true),
        (SplineEnds::Off, false),
    ] {
        let mut options = PlannerOptions::default();
        options.papers.spline = ends;
        let mut path = crate::CellPath::default();
        let row = crate::row_of("bao_iaa").unwrap();
        (row.build)(&options)
            .plan(&query, &mut super::go, &mut path)
            .unwrap();
        assert_eq!(!path.curve.is_empty(), has_curve);
        let mut waypoints = Vec::new();
        let result = waypoints_along(&query.map, &path.curve, &goal, &mut waypoints);
        assert_eq!(result.is_ok(), has_curve);
        let Ok(length_m) = result else {
            continue;
        };
        let start = map.geometry.centre_of(at('S'));
        assert_close(waypoints[0].x_m, start.x, 1e-12, "start");
        let last = waypoints[waypoints.len() - 1];
        assert_close(last.x_m, goal.x_m, 1e-12, "goal");
        assert_close(last.y_m, goal.y_m, 1e-12, "goal");
        assert_close(f64::from(last.yaw_rad), 0.25, 1e-6, "yaw of the goal");
        assert_close(length_m, length(&path.curve), 1e-12, "length");
        assert!(waypoints.len() > 5, "{} waypoints", waypoints.len());
    }
    // The yaw of a goal is wrapped as on any other path.
    let mut waypoints = Vec::new();
    let line = points(&[(0.0, 0.0), (0.1, 0.0)]);
    let goal = Pose::new(0.1, 0.0, 7.0);
    waypoints_along(&query.map, &line, &goal, &mut waypoints).unwrap();
    assert_close(
        f64::from(waypoints[1].yaw_rad),
        7.0 - core::f64::consts::TAU,
        1e-6,
        "wrapped",
    );
}

#[test]
fn bao_spl_a_curve_into_an_obstacle_is_dropped_and_said() {
    // A zig-zag between blocks that touch at corners, which only cutting them can follow.
    let (map, at) = Map::drawn(
        "....#G
         ...#.#
         ..#.#.
         .#.#..
         #.#...
         S#....",
    );
    let query = super::query(&map, CornerRule::Allow, at('S'), at('G'));
    let spline = Spline {
        ends: SplineEnds::Phantom,
        samples: 20,
    };
    let cells = [(0, 0), (1, 1), (2, 2), (3, 1), (4, 2), (5, 5)].map(|(x, y)| Cell::new(x, y));
    let (mut curve, mut remarks) = (Vec::new(), crate::Remarks::default());
    curve_of(&query, &cells, spline, &mut remarks, &mut curve);
    assert!(curve.is_empty() && remarks.curve_dropped);
    assert_close(remarks.curvature_max_1pm, 0.0, 1e-12, "no curve");
    // Straight ahead nothing is cut.
    let (mut curve, mut remarks) = (Vec::new(), crate::Remarks::default());
    curve_of(&query, &cells[..3], spline, &mut remarks, &mut curve);
    assert!(!curve.is_empty() && !remarks.curve_dropped);
}

#[test]
fn bao_spl_a_curve_of_too_many_points_is_sampled_less_densely() {
    let map = Map::free(200, 3);
    // A step up, a step down, again and again: no span is straight.
    let cells: Vec<Cell> = (0..200).map(|x| Cell::new(x, 1 + x % 2)).collect();
    let query = super::query(&map, CornerRule::Allow, cells[0], cells[199]);
    let spline = Spline {
        ends: SplineEnds::Phantom,
        samples: 20,
    };
    let (mut curve, mut remarks) = (Vec::new(), crate::Remarks::default());
    curve_of(&query, &cells, spline, &mut remarks, &mut curve);
    assert_eq!(curve.len(), 1 + 199 * 10);
    assert!(!remarks.curve_dropped);
}
