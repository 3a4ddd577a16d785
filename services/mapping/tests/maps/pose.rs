//! `map_from_odom`: right over long drives with odometry that drifts, exactly the identity with
//! odometry that does not.

use crate::support::{Rng, description};
use nalgebra::Vector2;
use parry2d::math::Vec2;
use parry2d::query::Ray;
use zeronav_casts::Cast;
use zeronav_mapping::localiser::CorrectionMode;
use zeronav_mapping::{Mapping, MappingConfig, Observation};
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::map::{FLAG_SENSED, MapInfo};
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::scan::Scan;
use zeronav_world::{World, WorldSpec};

/// What a lidar can do.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lidar {
    pub(crate) n_beams: u32,
    /// [m]
    pub(crate) range_m_max: f32,
    /// Standard deviation of a range, and as a share of it. [m]
    pub(crate) sigma_m: f64,
    pub(crate) sigma_ratio: f64,
}

/// A good one: noise of 1 cm.
const GOOD: Lidar = Lidar {
    n_beams: 180,
    range_m_max: 12.0,
    sigma_m: 0.01,
    sigma_ratio: 0.0,
};

#[derive(serde::Deserialize)]
struct WorldFile {
    world: WorldSpec,
}

/// The world of a file's text.
pub(crate) fn world_of(text: &str) -> World {
    let file: WorldFile = toml::from_str(text).expect("a world");
    World::new(&file.world, None).expect("a world")
}

/// The world of `blocked_aisle`.
fn warehouse() -> World {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../launch/worlds/warehouse.toml"
    );
    let text = std::fs::read_to_string(file).expect("the world");
    world_of(&text)
}

/// What the lidar sees from a pose; infinite where nothing returns.
pub(crate) fn look(lidar: &Lidar, world: &World, from: &Pose, rng: &mut Rng) -> (Scan, Vec<f32>) {
    let scan = Scan {
        n_beams: lidar.n_beams,
        angle_min_rad: -std::f32::consts::PI,
        angle_increment_rad: std::f32::consts::TAU / lidar.n_beams.to_f32(),
        range_m_min: 0.1,
        range_m_max: lidar.range_m_max,
        ..Scan::default()
    };
    let range_m = |beam: usize| {
        let angle = from.yaw_rad + scan.angle_of(beam);
        let ray = Ray::new(
            Vec2::new(from.x_m, from.y_m),
            Vec2::new(angle.cos(), angle.sin()),
        );
        world
            .shapes()
            .iter()
            .filter_map(|shape| {
                let placed = shape.placed();
                let farthest_m = f64::from(lidar.range_m_max);
                placed
                    .form()
                    .cast_ray(placed.pose(), &ray, farthest_m, true)
            })
            .fold(f64::INFINITY, f64::min)
    };
    let ranges = (0..lidar.n_beams as usize)
        .map(|beam| {
            let range_m = range_m(beam);
            let sigma_m = lidar.sigma_m.hypot(lidar.sigma_ratio * range_m);
            (range_m + sigma_m * rng.normal()).to_f32()
        })
        .collect();
    (scan, ranges)
}

/// What a drive came to.
#[derive(Debug, Default)]
struct Drive {
    driven_m: f64,
    worst_m: f64,
    worst_rad: f64,
    odometry_off_m: f64,
    sensed: usize,
    identity: bool,
}

/// Round and round through both aisles, turning on the spot at the corners. Odometry errs as a
/// calibrated differential drive without a gyro does: random walks of 1 cm and 0.01 rad in 1 m and
/// of 0.02 rad in a turn of 1 rad, and the yaw drifts by `drift_rad_per_m` besides.
fn drive(config: &MappingConfig, length_m: f64, noise: f64, drift_rad_per_m: f64) -> Drive {
    let world = warehouse();
    let map = world.rasterise();
    let known = config.area_m.is_none().then_some(&map);
    let mut mapping = Mapping::new(config, known, &description(), &[]).expect("a map");
    let mut rng = Rng(3);
    let corners = [(25.5, 6.425), (25.5, 13.575), (4.5, 13.575), (4.5, 6.425)];
    let mut next = 0;
    let mut truth = Pose::new(4.5, 6.425, 0.0);
    let mut odometry = truth;
    let mut drive = Drive {
        identity: true,
        ..Drive::default()
    };
    let mut run_ns = 0;
    while drive.driven_m < length_m {
        let to = Vector2::new(corners[next].0, corners[next].1) - truth.point().coords;
        let turn = wrap_angle(to.y.atan2(to.x) - truth.yaw_rad);
        let (step_m, turn_rad) = if to.norm() < 0.1 {
            next = (next + 1) % corners.len();
            continue;
        } else if turn.abs() > 0.05 {
            (0.0, turn.clamp(-0.15, 0.15))
        } else {
            (0.08_f64.min(to.norm()), turn)
        };
        let moved = |pose: &Pose, step_m: f64, turn_rad: f64| {
            let yaw = pose.yaw_rad + 0.5 * turn_rad;
            Pose::new(
                pose.x_m + step_m * yaw.cos(),
                pose.y_m + step_m * yaw.sin(),
                wrap_angle(pose.yaw_rad + turn_rad),
            )
        };
        truth = moved(&truth, step_m, turn_rad);
        drive.driven_m += step_m;
        let erred_m = step_m + noise * 0.01 * step_m.sqrt() * rng.normal();
        let erred_rad = turn_rad
            + noise * (0.02 * turn_rad.abs().sqrt() + 0.01 * step_m.sqrt()) * rng.normal()
            + drift_rad_per_m * step_m;
        odometry = moved(&odometry, erred_m, erred_rad);
        run_ns += 100_000_000;
        let (scan, ranges) = look(&GOOD, &world, &truth, &mut rng);
        mapping.take_in(&Observation {
            scan: &scan,
            ranges: &ranges,
            run_ns,
            odom_from_base_first: odometry,
            odom_from_base: odometry,
            odometry_variance: [noise * drive.driven_m; 3],
            goal: None,
            told: None,
        });
        let (map_from_odom, _) = mapping.map_from_odom();
        drive.identity &= map_from_odom == Pose::default();
        let estimate = map_from_odom.then(&odometry);
        drive.worst_m = drive.worst_m.max(estimate.distance_m(&truth));
        drive.worst_rad = drive
            .worst_rad
            .max(wrap_angle(estimate.yaw_rad - truth.yaw_rad).abs());
        drive.odometry_off_m = drive.odometry_off_m.max(odometry.distance_m(&truth));
    }
    let cells = mapping.mapper().cells();
    drive.sensed = cells
        .iter()
        .filter(|cell| cell.flags & FLAG_SENSED != 0)
        .count();
    drive
}

/// The robot looks around where it stands, `n` times, while odometry says that it stands at
/// `odometry`; where mapping has it then.
fn stand(mapping: &mut Mapping, truth: &Pose, odometry: &Pose, n: u64, told: Option<Pose>) -> Pose {
    let world = warehouse();
    let mut rng = Rng(5);
    for index in 0..n {
        let (scan, ranges) = look(&GOOD, &world, truth, &mut rng);
        let observation = Observation {
            scan: &scan,
            ranges: &ranges,
            run_ns: (index + 1) * 100_000_000,
            odom_from_base_first: *odometry,
            odom_from_base: *odometry,
            odometry_variance: [1.0e-4; 3],
            goal: None,
            told: None,
        };
        if let Some(pose) = told.filter(|_| index == 0) {
            let base_from_odom = odometry.isometry().inverse();
            let map_from_odom = Pose::from(pose.isometry() * base_from_odom);
            mapping.relocate(map_from_odom, PoseCertainty::Unconfirmed, &observation);
        }
        mapping.take_in(&observation);
    }
    mapping.map_from_odom().0.then(odometry)
}

fn n_sensed(mapping: &Mapping) -> usize {
    let cells = mapping.mapper().cells().iter();
    cells.filter(|cell| cell.flags & FLAG_SENSED != 0).count()
}

#[test]
fn a_robot_that_is_told_where_it_is_is_laid_on_the_static_map_there() {
    let (config, map) = (MappingConfig::default(), warehouse().rasterise());
    let mut mapping = Mapping::new(&config, Some(&map), &description(), &[]).expect("a map");
    let truth = Pose::new(7.0, 6.425, 0.0);
    // It believes itself in the other aisle, turned, and fills the map with what is not there until it notices.
    let odometry = Pose::new(11.0, 13.6, 0.9);
    let lost = stand(&mut mapping, &truth, &odometry, 15, None);
    assert!(lost.distance_m(&truth) > 2.0, "{lost:?}");
    let wrong = n_sensed(&mapping);
    assert!(wrong > 50, "{wrong} cells");
    let about = Pose::new(truth.x_m + 0.15, truth.y_m - 0.1, truth.yaw_rad + 0.08);
    let found = stand(&mut mapping, &truth, &odometry, 20, Some(about));
    assert!(found.distance_m(&truth) < 0.05, "{found:?}");
    assert!(
        wrap_angle(found.yaw_rad - truth.yaw_rad).abs() < 0.02,
        "{found:?}"
    );
    let sensed = n_sensed(&mapping);
    assert!(10 * sensed < wrong, "{sensed} of {wrong} cells are left");
}

/// There is nothing else to go by than the map so far: it stays.
#[test]
fn without_a_static_map_the_robot_is_put_on_the_map_as_it_is() {
    let config = MappingConfig {
        area_m: Some([[-1.0, -1.0], [31.0, 21.0]]),
        ..MappingConfig::default()
    };
    let mut mapping = Mapping::new(&config, None, &description(), &[]).expect("a map");
    let truth = Pose::new(7.0, 6.425, 0.0);
    let known = stand(&mut mapping, &truth, &truth, 20, None);
    assert!(known.distance_m(&truth) < 0.01, "{known:?}");
    let jumped = Pose::new(9.0, 5.0, 0.5);
    let about = Pose::new(truth.x_m + 0.1, truth.y_m - 0.1, truth.yaw_rad + 0.05);
    let found = stand(&mut mapping, &truth, &jumped, 20, Some(about));
    // The told pose is 14 cm off; scans of one place take half of that away.
    assert!(found.distance_m(&truth) < 0.1, "{found:?}");
}

#[test]
fn over_200_m_the_pose_stays_within_10_cm_and_2_degrees() {
    let drive = drive(&MappingConfig::default(), 200.0, 1.0, 0.002);
    eprintln!("{drive:?}");
    assert!(
        drive.odometry_off_m > 1.0,
        "odometry alone is lost: {drive:?}"
    );
    assert!(drive.worst_m < 0.10, "{drive:?}");
    assert!(drive.worst_rad < 2.0_f64.to_radians(), "{drive:?}");
    // The map does not smear: nothing is there that the static map does not hold.
    assert!(drive.sensed < 60, "{drive:?}");
}

/// Without a map to begin with the pose drifts with every key scan, but far less than odometry.
#[test]
fn on_an_unknown_map_the_pose_drifts_far_less_than_odometry() {
    let config = MappingConfig {
        area_m: Some([[-1.0, -1.0], [31.0, 21.0]]),
        ..MappingConfig::default()
    };
    let drive = drive(&config, 60.0, 1.0, 0.01);
    eprintln!("{drive:?}");
    assert!(drive.odometry_off_m > 2.0, "{drive:?}");
    assert!(drive.worst_m < 0.2, "{drive:?}");
}

#[test]
fn exact_odometry_is_never_corrected() {
    let drive = drive(&MappingConfig::default(), 15.0, 0.0, 0.0);
    assert!(drive.identity, "{drive:?}");
    assert_eq!(drive.sensed, 0);
}

/// Also when it is asked for, a correction that is not needed does no harm.
#[test]
fn an_unneeded_correction_is_harmless() {
    let mut config = MappingConfig::default();
    config.pose_correction.mode = CorrectionMode::On;
    let drive = drive(&config, 15.0, 0.0, 0.0);
    eprintln!("{drive:?}");
    assert!(drive.worst_m < 0.05 && drive.worst_rad < 0.01, "{drive:?}");
}

#[test]
fn correction_can_be_switched_off() {
    let mut config = MappingConfig::default();
    config.pose_correction.mode = CorrectionMode::Off;
    let drive = drive(&config, 15.0, 1.0, 0.02);
    assert!(drive.identity && drive.worst_m > 0.5, "{drive:?}");
}

/// Down an aisle with wheels that spin on the spot from the 15th scan to the 45th; how far mapping and odometry are
/// off at most. [m]
fn spin(config: &MappingConfig, variance: f64) -> (f64, f64) {
    let world = warehouse();
    let map = world.rasterise();
    let known = config.area_m.is_none().then_some(&map);
    let mut mapping = Mapping::new(config, known, &description(), &[]).expect("a map");
    let mut rng = Rng(7);
    let mut truth = Pose::new(1.8, 6.425, 0.0);
    let mut odometry = truth;
    let (mut worst_m, mut odometry_m) = (0.0_f64, 0.0_f64);
    for n in 0..60_u32 {
        let step = Pose::new(0.08, 0.0, 0.0);
        if !(15..45).contains(&n) {
            truth = truth.then(&step);
        }
        odometry = odometry.then(&step);
        let (scan, ranges) = look(&GOOD, &world, &truth, &mut rng);
        mapping.take_in(&Observation {
            scan: &scan,
            ranges: &ranges,
            run_ns: u64::from(n + 1) * 100_000_000,
            odom_from_base_first: odometry,
            odom_from_base: odometry,
            odometry_variance: [variance * f64::from(n); 3],
            goal: None,
            told: None,
        });
        assert!(!mapping.is_uncertain(), "scan {n}");
        let estimate = mapping.map_from_odom().0.then(&odometry);
        worst_m = worst_m.max(estimate.distance_m(&truth));
        odometry_m = odometry_m.max(odometry.distance_m(&truth));
    }
    (worst_m, odometry_m)
}

#[test]
fn wheels_that_spin_do_not_carry_the_robot_away() {
    let unknown = MappingConfig {
        area_m: Some([[-1.0, -1.0], [31.0, 21.0]]),
        ..MappingConfig::default()
    };
    for config in [MappingConfig::default(), unknown] {
        // Odometry that says how far it may be off, and one that claims to be exact.
        for variance in [1.0e-5, 0.0] {
            let (worst_m, odometry_m) = spin(&config, variance);
            assert!(odometry_m > 2.3, "{odometry_m}");
            assert!(worst_m < 0.15, "{variance}: {worst_m}");
        }
    }
}

/// The scans of a moment ago and of now have nothing in common while odometry says that the robot has driven on: it
/// does not know where it is. Nobody may rely on its pose, and the map stays as it is, until the scan lies on it again.
#[test]
fn a_robot_that_has_lost_contact_says_so_until_it_is_found() {
    let map = warehouse().rasterise();
    let mut mapping =
        Mapping::new(&MappingConfig::default(), Some(&map), &description(), &[]).expect("a map");
    let knows = |mapping: &Mapping| {
        let info = MapInfo {
            covariance: mapping.map_from_odom().1,
            ..MapInfo::default()
        };
        assert_eq!(info.certainty().is_known(), !mapping.is_uncertain());
        info.certainty().is_known()
    };
    let mut rng = Rng(9);
    let world = warehouse();
    let truth = Pose::new(1.8, 6.425, 0.0);
    let mut take = |mapping: &mut Mapping, n: u64, from: Option<&Pose>, odometry: &Pose| {
        let (scan, mut ranges) = look(&GOOD, &world, from.unwrap_or(&truth), &mut rng);
        if from.is_none() {
            // Somebody stands around it.
            for (n, range_m) in (0_u16..).zip(&mut ranges) {
                *range_m = 0.8 + 0.3 * (0.3 * f32::from(n)).sin();
            }
        }
        mapping.take_in(&Observation {
            scan: &scan,
            ranges: &ranges,
            run_ns: n * 100_000_000,
            odom_from_base_first: *odometry,
            odom_from_base: *odometry,
            odometry_variance: [1.0e-4; 3],
            goal: None,
            told: None,
        });
    };
    for n in 1..10 {
        take(&mut mapping, n, Some(&truth), &truth);
    }
    assert!(knows(&mapping));
    let sensed = n_sensed(&mapping);
    let mut odometry = truth;
    for n in 10..13 {
        odometry = odometry.then(&Pose::new(0.15, 0.0, 0.0));
        take(&mut mapping, n, None, &odometry);
    }
    assert!(!knows(&mapping));
    assert_eq!(n_sensed(&mapping), sensed, "the map stays");
    for n in 13..20 {
        take(&mut mapping, n, Some(&truth), &odometry);
    }
    assert!(knows(&mapping), "it is found");
    let found = mapping.map_from_odom().0.then(&odometry);
    assert!(found.distance_m(&truth) < 0.05, "{found:?}");
}
