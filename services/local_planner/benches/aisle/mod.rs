//! An aisle, a lidar's hits in it, robots and a crowd, and how a cycle of a controller is timed.

use criterion::Criterion;
use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use std::hint::black_box;
use zeronav_local_planner::pilot::Pilot;
use zeronav_local_planner::situation::{Future, Situation};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::map::COST_LETHAL;
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

/// What a robot at (5, 1.5) is to do: to the other end of the aisle, along its middle.
pub(crate) struct Aisle {
    cells: Vec<MapCell>,
    /// With less space beside the wall 1.2 m ahead, so that the cost-to-go is rebuilt.
    changed: Vec<MapCell>,
    path: [Waypoint; 2],
    goal: Goal,
}

impl Aisle {
    pub(crate) fn new() -> Self {
        let cells = cells();
        let mut changed = cells.clone();
        changed[23 * 400 + 124].clearance_mm -= 100;
        changed[23 * 400 + 125].clearance_mm -= 100;
        let waypoint = |x_m| Waypoint {
            x_m,
            y_m: 1.5,
            ..Waypoint::default()
        };
        Self {
            cells,
            changed,
            path: [waypoint(1.0), waypoint(19.0)],
            goal: Goal {
                pose: Pose::new(19.0, 1.5, 0.0),
                tolerance_m: 0.15,
                yaw_tolerance_rad: 4.0,
                id: 1,
            },
        }
    }

    /// A robot on its way whose scan hits `points`.
    pub(crate) fn situation<'a>(
        &'a self,
        (robot, corners): &'a (Description, Vec<Corner>),
        points: &'a [Point2<f64>],
        obstacles: &'a [Obstacle],
    ) -> Situation<'a> {
        Situation {
            map_from_base: Pose::new(5.0, 1.5, 0.0),
            v_mps: 0.6,
            w_radps: 0.1,
            robot,
            corners,
            path: &self.path,
            path_geometry: 1,
            map: Some(view(&self.cells)),
            map_cells: 1,
            obstacles,
            obstacles_age_s: 0.0,
            future: Future::default(),
            scan_points_in_base: points,
            past_hits_in_base: &[],
            goal: &self.goal,
            speed_factor: 1.0,
            zone_mps: f64::INFINITY,
            period_s: 0.02,
            ahead_s: 0.0,
        }
    }

    /// Times a cycle in which map and points lie where they lay ("ready"), and one with noisy
    /// points and a map some cells of which changed ("new scan").
    pub(crate) fn time(
        &self,
        criterion: &mut Criterion,
        name: &str,
        controller: &mut Pilot,
        situation: &Situation<'_>,
        least_rollouts: u32,
    ) {
        assert!(controller.decide(situation).rollouts >= least_rollouts);
        criterion.bench_function(&format!("{name}, ready"), |bencher| {
            bencher.iter(|| controller.decide(black_box(situation)));
        });
        let points = situation.scan_points_in_base;
        let scans = [noisy(points, 1), noisy(points, 2)];
        let mut n = 1;
        criterion.bench_function(&format!("{name}, new scan"), |bencher| {
            bencher.iter(|| {
                n += 1;
                let (cells, points) = if n % 2 == 0 {
                    (&self.cells, &scans[0])
                } else {
                    (&self.changed, &scans[1])
                };
                let situation = Situation {
                    map: Some(view(cells)),
                    map_cells: n,
                    scan_points_in_base: points,
                    ..*situation
                };
                controller.decide(black_box(&situation))
            });
        });
    }
}

fn view(cells: &[MapCell]) -> MapView<'_> {
    MapView {
        geometry: &GEOMETRY,
        cells,
    }
}

/// The aisle's clearance, to the walls alone.
fn cells() -> Vec<MapCell> {
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
            if cell.clearance_mm == 0 {
                cell.cost = COST_LETHAL;
            }
            std::iter::repeat_n(cell, 400)
        })
        .collect()
}

/// Hits of `n` beams on the walls, in `base` at (5, 1.5); `box_ahead` adds points 1.5 m ahead that
/// the map does not know.
pub(crate) fn scan(n: u32, box_ahead: bool) -> Vec<Point2<f64>> {
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

pub(crate) fn disc() -> (Description, Vec<Corner>) {
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

pub(crate) fn jackal() -> (Description, Vec<Corner>) {
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
pub(crate) fn crowd() -> Vec<Obstacle> {
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
