//! One control cycle of the dynamic windows: disc and rectangle, known and unknown surroundings,
//! and of `dwa_t` with 20 tracked obstacles. "ready" is a cycle between two scans, in which map and
//! points lie where they lay; "new scan" one with noisy points and a map some cells of which changed.
//!
//! `cargo bench -p zeronav-local-planner --no-default-features`

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use std::hint::black_box;
use zeronav_local_planner::config::{DwaConfig, DwaTConfig};
use zeronav_local_planner::controller::{Controller, Situation};
use zeronav_local_planner::dwa::Dwa;
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::path::Waypoint;
use zeronav_msgs::task::Goal;
use zeronav_msgs::{Cell, GridGeometry, MapCell, MapView, Pose};

/// An aisle of 20 x 3 m, 1.4 m wide.
const GEOMETRY: GridGeometry = GridGeometry {
    origin_x_m: 0.0,
    origin_y_m: 0.0,
    resolution_m: 0.05,
    width: 400,
    height: 60,
};

/// [m] y of the walls.
const WALLS_M: (f64, f64) = (0.8, 2.2);

/// The aisle's clearance, to the walls alone.
fn aisle() -> Vec<MapCell> {
    let clearance = |y: i32| {
        let at = GEOMETRY.centre_of(Cell::new(0, y)).y;
        (at - WALLS_M.0).min(WALLS_M.1 - at).max(0.0)
    };
    (0..60)
        .flat_map(|y| {
            let mut cell = MapCell::default();
            while f64::from(cell.clearance_mm) + 1.0 <= clearance(y) * 1000.0 {
                cell.clearance_mm += 1;
            }
            std::iter::repeat_n(cell, 400)
        })
        .collect()
}

/// Hits of `n` beams on the walls, in `base` at (5, 1.5); `box_ahead` adds points 1.5 m ahead that
/// the map does not know.
fn scan(n: u32, box_ahead: bool) -> Vec<Point2<f64>> {
    let mut points: Vec<Point2<f64>> = (0..n)
        .filter_map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            let range = 0.701 / angle.sin().abs().max(1e-3);
            (range < 10.0).then(|| Point2::new(range * angle.cos(), range * angle.sin()))
        })
        .collect();
    if box_ahead {
        points.extend((0..60).map(|i| Point2::new(1.5, -0.3 + 0.01 * f64::from(i))));
    }
    points
}

/// The points with a centimetre of noise.
fn noisy(points: &[Point2<f64>], seed: u64) -> Vec<Point2<f64>> {
    let mut random = Pcg32::seed_from_u64(seed);
    let mut off = || random.random_range(-0.017..0.017);
    points
        .iter()
        .map(|point| Point2::new(point.x + off(), point.y + off()))
        .collect()
}

fn disc() -> (Description, Vec<Corner>) {
    let robot = Description {
        inscribed_radius_m: 0.25,
        circumscribed_radius_m: 0.25,
        v_mps_max: 0.8,
        w_radps_max: 1.8,
        a_mps2_max: 1.0,
        brake_mps2: 1.0,
        alpha_radps2_max: 3.0,
        ..Description::default()
    };
    (robot, Vec::new())
}

fn jackal() -> (Description, Vec<Corner>) {
    let corner = |(x_m, y_m)| Corner { x_m, y_m };
    let outline = [
        (0.254, 0.215),
        (-0.254, 0.215),
        (-0.254, -0.215),
        (0.254, -0.215),
    ];
    let robot = Description {
        inscribed_radius_m: 0.215,
        circumscribed_radius_m: 0.333,
        n_corners: 4,
        ..disc().0
    };
    (robot, outline.map(corner).to_vec())
}

/// Twenty that walk along the aisle and across it, some within reach.
fn crowd() -> Vec<Obstacle> {
    (0..20)
        .map(|i| Obstacle {
            track: i + 1,
            x_m: 6.5 + 0.3 * f64::from(u8::try_from(i).unwrap_or(0)),
            y_m: if i % 2 == 0 { 1.2 } else { 1.9 },
            vx_mps: if i % 3 == 0 { -0.8 } else { 0.4 },
            vy_mps: if i % 2 == 0 { 0.2 } else { -0.2 },
            radius_m: 0.2,
            ..Obstacle::default()
        })
        .collect()
}

fn cycle(criterion: &mut Criterion) {
    let cells = aisle();
    let mut others = cells.clone();
    // 1.2 m ahead less space beside the wall, so that the cost-to-go is made anew.
    others[23 * 400 + 124].clearance_mm -= 100;
    others[23 * 400 + 125].clearance_mm -= 100;
    let waypoint = |x_m| Waypoint {
        x_m,
        y_m: 1.5,
        ..Waypoint::default()
    };
    let path = [waypoint(1.0), waypoint(19.0)];
    let goal = Goal {
        pose: Pose::new(19.0, 1.5, 0.0),
        tolerance_m: 0.15,
        yaw_tolerance_rad: 4.0,
        id: 1,
    };
    for (name, (robot, corners), points) in [
        ("disc, known aisle, 360 beams", disc(), scan(360, false)),
        (
            "disc, unknown box ahead, 360 beams",
            disc(),
            scan(360, true),
        ),
        ("disc, known aisle, 1080 beams", disc(), scan(1080, false)),
        (
            "rectangle, known aisle, 360 beams",
            jackal(),
            scan(360, false),
        ),
    ] {
        let situation = Situation {
            map_from_base: Pose::new(5.0, 1.5, 0.0),
            v_mps: 0.6,
            w_radps: 0.1,
            robot: &robot,
            corners: &corners,
            path: &path,
            path_geometry: 1,
            map: Some(MapView {
                geometry: &GEOMETRY,
                cells: &cells,
            }),
            map_cells: 1,
            obstacles: &[],
            obstacles_age_s: 0.0,
            scan_points_in_base: &points,
            goal: &goal,
            speed_factor: 1.0,
            period_s: 0.02,
        };
        let mut controllers = [
            ("dwa", Dwa::new(DwaConfig::default())),
            (
                "dwa_t",
                Dwa::timed(DwaConfig::default(), DwaTConfig::default()),
            ),
        ];
        let obstacles = crowd();
        let crowded = Situation {
            obstacles: &obstacles,
            ..situation
        };
        let rings = [noisy(&points, 1), noisy(&points, 2)];
        for (key, controller) in &mut controllers {
            for (with, situation) in [("", situation), (", 20 tracked", crowded)] {
                if *key == "dwa" && !with.is_empty() {
                    continue;
                }
                assert!(controller.decide(&situation).rollouts >= 800);
                criterion.bench_function(&format!("{key}, {name}{with}, ready"), |bencher| {
                    bencher.iter(|| controller.decide(black_box(&situation)));
                });
                let mut scans = 1;
                criterion.bench_function(&format!("{key}, {name}{with}, new scan"), |bencher| {
                    bencher.iter(|| {
                        scans += 1;
                        let changed = scans % 2;
                        let situation = Situation {
                            map: Some(MapView {
                                geometry: &GEOMETRY,
                                cells: if changed == 0 { &cells } else { &others },
                            }),
                            map_cells: scans,
                            scan_points_in_base: if changed == 0 { &rings[0] } else { &rings[1] },
                            ..situation
                        };
                        controller.decide(black_box(&situation))
                    });
                });
            }
        }
    }
}

criterion_group!(benches, cycle);
criterion_main!(benches);
