//! What moves: found soon, followed well, never made up, and gone without a trail.

#[path = "../../../../launch/measure/src/tracking_score.rs"]
#[allow(unreachable_pub, reason = "public in the crate that it is of")]
mod tracking_score;

use crate::support::{Rng, Room, config, description};
use nalgebra::{Point2, Vector2};
use tracking_score::TrackingScore;
use zeronav_casts::Cast;
use zeronav_mapping::{Mapping, MappingConfig, Observation};
use zeronav_msgs::map::FLAG_SENSED;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::truth::TruthObstacle;
use zeronav_msgs::{MapCell, Pose};

const PERIOD_NS: u64 = 100_000_000;

#[derive(Debug, Clone, Copy)]
struct Disc {
    at: Point2<f64>,
    velocity: Vector2<f64>,
    radius_m: f64,
}

/// A room, discs in it, and noise.
struct Scene {
    room: Room,
    discs: Vec<Disc>,
    rng: Rng,
    sigma_m: f64,
    n: u64,
    beams_on: Vec<u32>,
}

impl Scene {
    fn new(room: Room, sigma_m: f64) -> Self {
        Self {
            room,
            discs: Vec::new(),
            rng: Rng(5),
            sigma_m,
            n: 0,
            beams_on: Vec::new(),
        }
    }

    /// Discs bounce off the walls of the room.
    fn step(&mut self) {
        self.n += 1;
        let g = self.room.geometry;
        let high = Point2::new(
            g.origin_x_m + f64::from(g.width) * g.resolution_m,
            g.origin_y_m + f64::from(g.height) * g.resolution_m,
        );
        for disc in &mut self.discs {
            disc.at += disc.velocity * 0.1;
            for axis in 0..2 {
                let low = if axis == 0 {
                    g.origin_x_m
                } else {
                    g.origin_y_m
                };
                let margin = disc.radius_m + 0.4;
                if (disc.at[axis] < low + margin && disc.velocity[axis] < 0.0)
                    || (disc.at[axis] > high[axis] - margin && disc.velocity[axis] > 0.0)
                {
                    disc.velocity[axis] = -disc.velocity[axis];
                }
            }
        }
    }

    fn scan(&mut self, from: &Pose) -> (Scan, Vec<f32>) {
        let (scan, mut ranges) = self.room.scan(from);
        self.beams_on = vec![0; self.discs.len()];
        for (n, range_m) in ranges.iter_mut().enumerate() {
            let angle = from.yaw_rad + scan.angle_of(n);
            let direction = Vector2::new(angle.cos(), angle.sin());
            let mut on = None;
            for (d, disc) in self.discs.iter().enumerate() {
                let to = disc.at - from.point();
                let along = to.dot(&direction);
                let inside = disc.radius_m.powi(2) - (to.norm_squared() - along * along);
                if along > 0.0 && inside > 0.0 {
                    let hit = (along - inside.sqrt()).to_f32();
                    if hit < *range_m {
                        *range_m = hit;
                        on = Some(d);
                    }
                }
            }
            if let Some(d) = on {
                self.beams_on[d] += 1;
            }
            if range_m.is_finite() {
                *range_m += (self.rng.normal() * self.sigma_m).to_f32();
            }
        }
        (scan, ranges)
    }

    fn observe(&mut self, mapping: &mut Mapping, from: &Pose) {
        self.observe_with(mapping, from, from, 0.0);
    }

    /// From a robot whose odometry says something else, and says so.
    fn observe_with(&mut self, mapping: &mut Mapping, from: &Pose, odometry: &Pose, variance: f64) {
        let (scan, ranges) = self.scan(from);
        mapping.take_in(&Observation {
            scan: &scan,
            ranges: &ranges,
            run_ns: self.n * PERIOD_NS,
            odom_from_base_first: *odometry,
            odom_from_base: *odometry,
            odometry_variance: [variance; 3],
            goal: None,
            told: None,
        });
    }

    fn truth(&self) -> Vec<TruthObstacle> {
        let discs = self.discs.iter().zip(&self.beams_on);
        (0..)
            .zip(discs)
            .map(|(index, (disc, beams))| TruthObstacle {
                index,
                beams: *beams,
                pose: Pose::new(disc.at.x, disc.at.y, 0.0),
                ..TruthObstacle::default()
            })
            .collect()
    }
}

fn mapping(config: &MappingConfig, known: Option<&Room>) -> Mapping {
    let known = known.map(Room::as_static_map);
    Mapping::new(config, known.as_ref(), &description(), &[]).unwrap()
}

fn point(room: &Room, x: f64, y: f64) -> Point2<f64> {
    room.pose(x, y, 0.0).point()
}

/// A robot that drives a circle in the middle of the room.
fn circling(room: &Room, n: u64) -> Pose {
    let angle = 0.05 * n.to_f64();
    let (w, h) = (
        f64::from(room.geometry.width),
        f64::from(room.geometry.height),
    );
    room.pose(
        0.5 * w + 20.0 * angle.cos(),
        0.5 * h + 20.0 * angle.sin(),
        angle + 1.5,
    )
}

#[test]
fn walkers_are_found_within_four_scans_and_their_velocity_is_right() {
    let mut room = Room::walled(240, 200, 2);
    room.n_beams = 360;
    let mut scene = Scene::new(room.clone(), 0.01);
    for (x, y, vx, vy, radius_m) in [
        (40.0, 40.0, 0.9, 0.3, 0.3),
        (200.0, 50.0, -0.5, 0.7, 0.25),
        (60.0, 160.0, 1.2, -0.2, 0.35),
        (180.0, 150.0, -0.6, -0.6, 0.2),
    ] {
        scene.discs.push(Disc {
            at: point(&room, x, y),
            velocity: Vector2::new(vx, vy),
            radius_m,
        });
    }
    let mut mapping = mapping(&config(&room), Some(&room));
    let mut score = TrackingScore::default();
    for n in 0..900 {
        scene.step();
        scene.observe(&mut mapping, &circling(&room, n));
        let tracked: Vec<Obstacle> = mapping.obstacles().collect();
        score.add(scene.n * PERIOD_NS, &scene.truth(), &tracked);
    }
    let report = score.report();
    let mut delays_s = report.delays_s.clone();
    delays_s.sort_by(f64::total_cmp);
    eprintln!("{report:?}");
    assert!(delays_s.len() >= 4);
    assert!(delays_s[delays_s.len() / 2] <= 0.4, "{delays_s:?}");
    // Discs that bounce have no constant velocity for a moment.
    assert!(report.velocity_samples > 1500, "{report:?}");
    assert!(report.velocity_rmse_mps <= 0.3, "{report:?}");
    assert_eq!(report.false_tracks, 0, "{report:?}");
}

/// A wall of 1 m, 3 m before the robot, and a pedestrian who comes out from behind it. With 10 scans a
/// second the third hit comes 0.2 s after the first; by then the velocity is right, though part
/// of him may be hidden still.
#[test]
fn who_comes_out_from_behind_a_wall_is_known_with_his_velocity() {
    let mut room = Room::empty(200, 160);
    room.fill(80, 60, 100, 64, true);
    let robot = room.pose(90.0, 0.0, core::f64::consts::FRAC_PI_2);
    for (seed, speed_mps) in (1..=20).zip([0.6, 0.8, 1.0, 1.2, 1.4].into_iter().cycle()) {
        let mut scene = Scene::new(room.clone(), 0.01);
        scene.rng = Rng(seed);
        scene.discs.push(Disc {
            // He begins hidden.
            at: point(&room, 90.0, 80.0),
            velocity: Vector2::new(speed_mps, 0.0),
            radius_m: 0.3,
        });
        let mut mapping = mapping(&config(&room), None);
        let mut first_seen = None;
        for _ in 0..30 {
            scene.step();
            scene.observe(&mut mapping, &robot);
            if scene.beams_on[0] >= 5 && first_seen.is_none() {
                first_seen = Some(scene.n);
            }
            let Some(seen_for) = first_seen.map(|first| scene.n - first) else {
                assert_eq!(mapping.obstacles().count(), 0, "seed {seed}");
                continue;
            };
            if seen_for == 4 {
                let found: Vec<Obstacle> = mapping.obstacles().collect();
                let [walker] = &found[..] else {
                    panic!("seed {seed}: {found:?}");
                };
                let off_mps = (walker.vx_mps - speed_mps).hypot(walker.vy_mps);
                assert!(off_mps < 0.3, "seed {seed}: {walker:?}");
                let at = scene.discs[0].at;
                let off_m = (walker.x_m - at.x).hypot(walker.y_m - at.y);
                assert!(off_m < 0.1, "seed {seed}: {walker:?}");
            }
        }
        assert!(first_seen.is_some(), "seed {seed}: nobody came out");
    }
}

/// Posts in the open, people who walk, so that scans are doubted, and a robot that turns to and fro
/// with odometry that errs by 0.03 rad in a turn of 1 rad.
#[test]
fn posts_do_not_walk_because_the_robot_turns() {
    let mut room = Room::empty(240, 200);
    room.n_beams = 360;
    for (x, y) in [
        (50, 50),
        (70, 120),
        (100, 160),
        (170, 130),
        (190, 60),
        (120, 30),
        (60, 90),
    ] {
        room.fill(x, y, x + 3, y + 3, true);
    }
    let mut scene = Scene::new(room.clone(), 0.01);
    for (x, y, vx, vy) in [(60.0, 160.0, 0.9, 0.3), (200.0, 100.0, -0.6, 0.7)] {
        scene.discs.push(Disc {
            at: point(&room, x, y),
            velocity: Vector2::new(vx, vy),
            radius_m: 0.3,
        });
    }
    let mut mapping = mapping(&config(&room), None);
    let mut rng = Rng(11);
    let (mut truth, mut odometry) = (room.pose(120.0, 100.0, 0.0), room.pose(120.0, 100.0, 0.0));
    let (mut walkers, mut posts) = (0, 0);
    for n in 0..600 {
        scene.step();
        let turn_rad = match n / 15 % 4 {
            0 => 0.2,
            2 => -0.2,
            _ => 0.0_f64,
        };
        truth.yaw_rad += turn_rad;
        odometry.yaw_rad += turn_rad + 0.03 * turn_rad.abs().sqrt() * rng.normal();
        scene.observe_with(&mut mapping, &truth, &odometry, 1.0e-4);
        for obstacle in mapping.obstacles().filter(|one| !one.is_guess()) {
            let at = Point2::new(obstacle.x_m, obstacle.y_m);
            let is_walker = scene.discs.iter().any(|disc| (disc.at - at).norm() < 1.0);
            *(if is_walker { &mut walkers } else { &mut posts }) += 1;
        }
    }
    eprintln!("{walkers} sights of walkers, {posts} of posts");
    assert!(walkers > 300, "{walkers}");
    assert_eq!(posts, 0, "posts that were taken for walkers");
}

/// Five minutes past boxes, posts and wall ends that no map knows: nothing moves.
#[test]
fn what_stands_is_never_called_moving() {
    let mut room = Room::walled(240, 200, 2);
    room.n_beams = 360;
    let known = room.clone();
    for (x, y, w, h) in [
        (60, 60, 8, 8),
        (150, 50, 3, 12),
        (180, 140, 10, 2),
        (70, 150, 2, 2),
        (100, 30, 20, 1),
        (30, 100, 4, 4),
        (200, 90, 6, 6),
        (115, 170, 1, 1),
    ] {
        room.fill(x, y, x + w, y + h, true);
    }
    for with_map in [true, false] {
        let mut scene = Scene::new(room.clone(), 0.01);
        let mut mapping = mapping(&config(&room), with_map.then_some(&known));
        let mut score = TrackingScore::default();
        for n in 0..1500 {
            scene.step();
            scene.observe(&mut mapping, &circling(&room, n));
            let tracked: Vec<Obstacle> = mapping.obstacles().collect();
            score.add(scene.n * PERIOD_NS, &[], &tracked);
        }
        let report = score.report();
        assert_eq!(report.false_tracks, 0, "map known: {with_map}, {report:?}");
    }
}

fn sensed(cells: &[MapCell]) -> usize {
    cells
        .iter()
        .filter(|cell| cell.flags & FLAG_SENSED != 0)
        .count()
}

/// A walker is on the list of obstacles and not on the map, and when it vanishes the list is empty
/// within 0.4 s at 10 Hz.
#[test]
fn a_dynamic_obstacle_is_tracked_and_not_on_the_map() {
    let mut room = Room::walled(240, 120, 2);
    room.n_beams = 720;
    let mut scene = Scene::new(room.clone(), 0.008);
    scene.discs.push(Disc {
        at: point(&room, 60.0, 80.0),
        velocity: Vector2::new(1.0, 0.0),
        radius_m: 0.3,
    });
    let mut mapping = mapping(&config(&room), Some(&room));
    let free = mapping.mapper().cells().to_vec();
    let from = room.pose(120.0, 20.0, 1.5);
    for n in 0..50 {
        scene.step();
        scene.observe(&mut mapping, &from);
        if n < 8 {
            continue;
        }
        assert_eq!(mapping.mapper().cells(), free, "scan {n}");
        let tracked: Vec<Obstacle> = mapping.obstacles().collect();
        assert_eq!(tracked.len(), 1, "scan {n}");
        let at = Point2::new(tracked[0].x_m, tracked[0].y_m);
        let far_m = (at - scene.discs[0].at).norm();
        assert!(far_m < 0.15, "scan {n}: {at} is {far_m} m away");
    }
    scene.discs.clear();
    for _ in 0..4 {
        scene.step();
        scene.observe(&mut mapping, &from);
    }
    assert_eq!(mapping.mapper().cells(), free);
    assert_eq!(mapping.obstacles().count(), 0);
}

/// An obstacle is on the map while it is static and on the list while it moves, without a gap.
#[test]
fn an_obstacle_that_stops_moves_from_the_list_to_the_map() {
    let mut room = Room::walled(200, 120, 2);
    room.n_beams = 720;
    let mut scene = Scene::new(room.clone(), 0.008);
    scene.discs.push(Disc {
        at: point(&room, 60.0, 80.0),
        velocity: Vector2::new(1.0, 0.0),
        radius_m: 0.3,
    });
    let mut mapping = mapping(&config(&room), Some(&room));
    let mut were_listed = 0;
    let from = room.pose(100.0, 20.0, 1.5);
    for n in 0..70 {
        if n == 25 {
            scene.discs[0].velocity = Vector2::zeros();
        }
        scene.step();
        scene.observe(&mut mapping, &from);
        let (mapped, listed) = (
            sensed(mapping.mapper().cells()),
            mapping.obstacles().count(),
        );
        assert!(mapped > 3 || listed == 1, "scan {n}: {mapped} {listed}");
        were_listed += listed;
    }
    assert!(were_listed > 10, "{were_listed}");
    assert_eq!(mapping.obstacles().count(), 0);
    assert!(sensed(mapping.mapper().cells()) > 3);
}

#[test]
fn tracking_can_be_switched_off() {
    let room = Room::walled(120, 120, 2);
    let mut scene = Scene::new(room.clone(), 0.0);
    scene.discs.push(Disc {
        at: point(&room, 30.0, 80.0),
        velocity: Vector2::new(1.0, 0.0),
        radius_m: 0.3,
    });
    let mut config = config(&room);
    config.tracking.enabled = false;
    let mut mapping = mapping(&config, Some(&room));
    for _ in 0..15 {
        scene.step();
        scene.observe(&mut mapping, &room.pose(60.0, 20.0, 1.5));
    }
    assert_eq!(mapping.obstacles().count(), 0);
    assert!(sensed(mapping.mapper().cells()) > 3);
}
