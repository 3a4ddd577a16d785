//! What a stop is checked against, each source on its own.

use super::*;
use crate::situation::Future;
use zeronav_msgs::obstacles::Obstacle;

const REACTION_S: f64 = 0.1;

/// A disc of 0.25 m, or with corners a rectangle of 0.5 m by 0.3 m.
fn robot(corners: &[Corner]) -> Description {
    Description {
        inscribed_radius_m: if corners.is_empty() { 0.25 } else { 0.15 },
        circumscribed_radius_m: if corners.is_empty() { 0.25 } else { 0.2916 },
        v_mps_max: 1.0,
        w_radps_max: 2.0,
        a_mps2_max: 1.0,
        brake_mps2: 1.0,
        alpha_radps2_max: 4.0,
        n_corners: u32::try_from(corners.len()).unwrap_or(0),
        ..Description::default()
    }
}

fn rectangle() -> Vec<Corner> {
    [(0.25, 0.15), (-0.25, 0.15), (-0.25, -0.15), (0.25, -0.15)]
        .map(|(x_m, y_m)| Corner { x_m, y_m })
        .to_vec()
}

/// Surroundings without a map, with these points of the scan; those of `stamped` are in the
/// clearance field, too.
fn looked(
    corners: &[Corner],
    points: &[Point2<f64>],
    stamped: &[Point2<f64>],
) -> (Description, Surroundings) {
    let robot = robot(corners);
    let mut surroundings = Surroundings::default();
    surroundings.describe(&robot, corners);
    surroundings.look(
        None,
        &Pose::new(3.0, -2.0, 0.7),
        (points, &[]),
        stamped,
        Reach {
            field_m: 1.5,
            stop_m: 1.0,
            soft_m: 0.2,
            margin_m: 0.03,
        },
    );
    (robot, surroundings)
}

fn arc_m(
    (robot, surroundings): &(Description, Surroundings),
    v_mps: f64,
    moving: &DynamicObstacles,
) -> Option<f64> {
    surroundings.stop_arc_m(robot, Twist::new(v_mps, 0.0), REACTION_S, moving)
}

/// Braking from 1 m/s takes 0.1 m and 0.5 m: the outline reaches to 0.85 m, the margin to 0.88 m.
#[test]
fn points_of_the_scan_alone_stop_the_robot() {
    for corners in [Vec::new(), rectangle()] {
        let none = DynamicObstacles::default();
        // Known to the scan, not to the field: as what moves is kept out of it.
        let ahead = |x_m: f64| looked(&corners, &[Point2::new(x_m, 0.05)], &[]);
        assert!(arc_m(&ahead(0.95), 1.0, &none).is_some());
        assert_eq!(arc_m(&ahead(0.80), 1.0, &none), None);
        // A slower robot stops in time, and one beside whose way it lies passes.
        assert!(arc_m(&ahead(0.80), 0.5, &none).is_some());
        let beside = looked(&corners, &[Point2::new(0.5, 0.35)], &[]);
        assert!(arc_m(&beside, 1.0, &none).is_some());
    }
}

#[test]
fn points_in_the_clearance_field_alone_stop_the_robot() {
    let none = DynamicObstacles::default();
    let ahead = |x_m: f64| looked(&[], &[], &[Point2::new(x_m, 0.0)]);
    assert_eq!(arc_m(&ahead(0.8), 1.0, &none), None);
    assert!(arc_m(&ahead(1.1), 1.0, &none).is_some());
}

/// An obstacle of 0.3 m with this place and velocity in `base`.
fn tracked(x_m: f64, y_m: f64, vx_mps: f64, vy_mps: f64) -> DynamicObstacles {
    let mut moving = DynamicObstacles::default();
    let map_from_base = Pose::new(3.0, -2.0, 0.7);
    let (sin, cos) = map_from_base.yaw_rad.sin_cos();
    let at = map_from_base.transform(Point2::new(x_m, y_m));
    moving.take(
        &[Obstacle {
            track: 1,
            x_m: at.x,
            y_m: at.y,
            vx_mps: cos * vx_mps - sin * vy_mps,
            vy_mps: sin * vx_mps + cos * vy_mps,
            radius_m: 0.3,
            ..Obstacle::default()
        }],
        (0.0, 0.0),
        &Future::default(),
        &map_from_base,
    );
    moving
}

#[test]
fn a_stop_must_be_free_of_where_what_moves_will_be() {
    for corners in [Vec::new(), rectangle()] {
        let open = looked(&corners, &[], &[]);
        let check = |moving: DynamicObstacles, expected: bool, what: &str| {
            let found = arc_m(&open, 1.0, &moving).is_some();
            assert_eq!(found, expected, "{what}, {} corners", corners.len());
        };
        check(DynamicObstacles::default(), true, "nobody");
        check(tracked(2.0, 0.0, -1.0, 0.0), false, "who comes");
        check(tracked(2.0, 0.0, 1.0, 0.0), true, "who leaves");
        // After half a second in the middle of the way.
        check(tracked(0.9, -0.9, 0.0, 1.6), false, "who crosses now");
        check(tracked(0.9, -0.9, 0.0, -1.6), true, "who has crossed");
        check(tracked(0.9, -3.5, 0.0, 1.0), true, "who crosses later");
    }
}

#[test]
fn near_what_moves_the_robot_may_only_not_come_nearer() {
    let open = looked(&[], &[], &[]);
    // Less than the margin is left to a pedestrian who walks away.
    let leaving = tracked(0.57, 0.0, 0.5, 0.0);
    assert!(arc_m(&open, 0.05, &leaving).is_some());
    assert_eq!(arc_m(&open, 1.0, &leaving), None);
}

#[test]
fn a_robot_that_brakes_is_hit_by_who_comes_its_way() {
    for corners in [Vec::new(), rectangle()] {
        let (robot, open) = looked(&corners, &[], &[]);
        let check = |v_mps: f64, moving: DynamicObstacles, expected: bool, what: &str| {
            let twist = Twist::new(v_mps, 0.0);
            let free = open.rest_is_free(&robot, twist, &moving, 1.5);
            assert_eq!(free, expected, "{what}, {} corners", corners.len());
        };
        check(1.0, DynamicObstacles::default(), true, "nobody");
        check(1.0, tracked(-1.8, 0.0, 1.6, 0.0), false, "who catches up");
        check(1.0, tracked(-1.8, 1.1, 1.6, 0.0), true, "who overtakes");
        check(0.0, tracked(1.8, 0.0, -1.6, 0.0), false, "who meets it");
        check(0.0, tracked(1.8, 1.1, -1.6, 0.0), true, "who passes it");
        check(0.0, tracked(1.8, 0.0, -0.5, 0.0), true, "who comes later");
        // It comes to rest half a metre ahead, where nobody is now.
        check(
            1.0,
            tracked(0.5, -1.8, 0.0, 1.6),
            false,
            "who crosses there",
        );
        check(
            1.0,
            tracked(-0.6, -1.8, 0.0, 1.6),
            true,
            "who crosses behind",
        );
    }
}

#[test]
fn a_stop_for_a_flight_is_free_of_what_is_static_alone() {
    let flight_m = |(robot, around): &(Description, Surroundings)| {
        around.static_stop_arc_m(robot, Twist::new(1.0, 0.0), REACTION_S)
    };
    let point = [Point2::new(0.8, 0.0)];
    // What moves is seen by the scan and kept out of the field.
    let arc_m = flight_m(&looked(&[], &point, &[])).expect("free");
    assert!((arc_m - 0.6).abs() < STOP_SPACING_M, "{arc_m}");
    assert_eq!(flight_m(&looked(&[], &point, &point)), None);
}

/// The rectangle in a corridor of 0.63 m along y, between columns of cells of 5 cm whose surfaces lie at
/// their far sides; the scan measures the left one only.
#[test]
fn a_wall_behind_is_where_it_was_measured_last_and_not_where_its_cells_begin() {
    use zeronav_msgs::{GridGeometry, MapCell, MapView};
    let geometry = GridGeometry {
        origin_x_m: 0.0,
        origin_y_m: 0.0,
        resolution_m: 0.05,
        width: 80,
        height: 80,
    };
    let (low_m, high_m) = (1.7, 2.33);
    // Squares from 1.65 to 1.7 m and from 2.25 to 2.3 m.
    let cell = |index: u16| {
        let column = index % 80;
        let steps = column.abs_diff(33).min(column.abs_diff(45));
        MapCell {
            clearance_mm: (50 * steps).saturating_sub(25),
            ..MapCell::default()
        }
    };
    let cells: Vec<MapCell> = (0..80 * 80).map(cell).collect();
    let map = MapView {
        geometry: &geometry,
        cells: &cells,
    };
    let corners = rectangle();
    let robot = robot(&corners);
    let here = Pose::new(0.5 * (low_m + high_m), 2.0, core::f64::consts::FRAC_PI_2);
    // Ahead is along y: what is at a smaller x is to the left.
    let side = |y_m: f64| (-40..40).map(move |n| Point2::new(0.02 * f64::from(n), y_m));
    let left: Vec<_> = side(here.x_m - low_m).collect();
    let right = side(here.x_m - high_m);
    let right: Vec<_> = right.map(|at| Hit::of(Point2::origin(), at)).collect();
    let turns = |past: &[Hit]| {
        let mut surroundings = Surroundings::default();
        surroundings.describe(&robot, &corners);
        let reach = Reach {
            field_m: 1.5,
            stop_m: 0.1,
            soft_m: 0.2,
            margin_m: 0.01,
        };
        surroundings.look(Some((map, 1)), &here, (&left, past), &left, reach);
        surroundings.turn_is_free(3.0)
    };
    assert!(!turns(&[]), "0.26 m to a cell, 0.29 m to a corner");
    assert!(turns(&right));
    // What is measured nearer counts.
    let near = right
        .iter()
        .map(|hit| Hit::of(Point2::origin(), Point2::new(hit.at.x, hit.at.y + 0.03)));
    assert!(!turns(&near.collect::<Vec<_>>()));
}
