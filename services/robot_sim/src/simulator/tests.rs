use super::*;
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use nalgebra::Point2;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use zeronav_robot_description::{LidarSpec, RobotSpec};
use zeronav_world::spec::{Near, Trigger};
use zeronav_world::{ObstacleSpec, ShapeSpec, WorldSpec};

mod contacts;
mod noise;

const SEED: u64 = 1;
const TICK: u64 = 20_000_000;
const SECOND: u64 = 1_000_000_000;

fn config(shapes: Vec<ShapeSpec>, obstacles: Vec<ObstacleSpec>) -> SimConfig {
    SimConfig {
        start: [0.0, 0.0, 0.0],
        world: WorldSpec {
            shapes,
            obstacles,
            ..WorldSpec::area([-20.0, -20.0], [20.0, 20.0])
        },
        robot: RobotSpec {
            v_mps_min: -1.0,
            a_mps2_max: 2.0,
            brake_mps2: Some(4.0),
            alpha_radps2_max: 10.0,
            ..RobotSpec::exact(0.25, 5.0, 3.0, LidarSpec::exact(360, 10.0, 0.1..10.0))
        },
    }
}

fn a_box(centre_m: [f64; 2], size_m: [f64; 2]) -> ShapeSpec {
    ShapeSpec::Box {
        centre_m,
        size_m,
        yaw_rad: 0.0,
    }
}

fn obstacle(shape: ShapeSpec, appears: Option<Trigger>) -> ObstacleSpec {
    ObstacleSpec {
        appears,
        ..ObstacleSpec::standing("box", shape)
    }
}

fn at(seconds: f64) -> Trigger {
    Trigger {
        at_s: Some(seconds),
        robot_near: None,
    }
}

fn world_of(config: &SimConfig) -> World {
    let (world, _) = zeronav_world_files::load(&config.world).expect("a world");
    world
}

fn simulator(config: &SimConfig) -> Simulator {
    Simulator::new(config, world_of(config), SEED, TICK).expect("a simulator")
}

/// Runs `ticks` ticks under one command that never grows old.
fn drive(robot: &mut Simulator, ticks: u64, v_mps: f64, w_radps: f64) {
    robot.set_command(v_mps, w_radps);
    for _ in 0..ticks {
        robot.step(robot.run_ns() + TICK, 0);
    }
}

fn truth(robot: &mut Simulator) -> Truth {
    let mut obstacles = Vec::new();
    let truth = robot.truth(&mut obstacles);
    assert_eq!(truth.check(&obstacles), Ok(()));
    assert_eq!(robot.odometry().check(), Ok(()));
    truth
}

fn truth_of_obstacles(robot: &mut Simulator) -> Vec<TruthObstacle> {
    let mut obstacles = Vec::new();
    robot.truth(&mut obstacles);
    obstacles
}

#[track_caller]
fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{found}, not {expected} +- {tolerance}"
    );
}

#[test]
fn the_description_is_the_robot_of_the_config() {
    let mut config = config(Vec::new(), Vec::new());
    config.robot.radius_m = None;
    config.robot.footprint_m = Some(vec![[-0.2, -0.3], [0.4, -0.3], [0.4, 0.3], [-0.2, 0.3]]);
    config.robot.lidar.pose = [0.1, 0.0, 1.0];
    let (description, corners) = simulator(&config).description();
    assert_eq!(description.check(&corners), Ok(()));
    assert_eq!(corners.len(), 4);
    close(description.inscribed_radius_m, 0.2, 1e-12);
    close(description.circumscribed_radius_m, 0.5, 1e-12);
    close(description.brake_mps2, 4.0, 0.0);
    close(description.base_from_laser.yaw_rad, 1.0, 0.0);
    assert_eq!(description.scan_period_ns, 100_000_000);
    // Readers of the scan and of the description see the same beams.
    let mut robot = simulator(&config);
    drive(&mut robot, 5, 0.0, 0.0);
    let scan = robot.scan(&mut vec![0.0; 360]).expect("a scan is due");
    let last = description.angle_min_rad + 359.0 * description.angle_increment_rad;
    close(scan.angle_of(359), last, 0.0);
}

#[test]
fn speed_and_stop_follow_the_limits() {
    let mut robot = simulator(&config(Vec::new(), Vec::new()));
    // 2 m/s^2 for 1 s, then a stop with 4 m/s^2 over v^2 / 2a = 0.5 m.
    drive(&mut robot, 50, 2.0, 0.0);
    close(robot.odometry().v_mps, 2.0, 1e-12);
    close(robot.odometry().pose.x_m, 1.0, 1e-12);
    drive(&mut robot, 50, 0.0, 0.0);
    close(robot.odometry().v_mps, 0.0, 0.0);
    close(robot.odometry().pose.x_m, 1.5, 1e-12);
    close(truth(&mut robot).driven_m, 1.5, 1e-12);
    // Backwards no faster than allowed.
    drive(&mut robot, 100, -9.0, 0.0);
    close(robot.odometry().v_mps, -1.0, 1e-12);
    close(truth(&mut robot).driven_m, 1.5 + 0.25 + 1.5, 1e-9);
}

#[test]
fn a_steady_twist_drives_an_exact_circle() {
    let mut robot = simulator(&config(Vec::new(), Vec::new()));
    drive(&mut robot, 100, 1.0, 0.5);
    let start = robot.odometry();
    close(start.v_mps, 1.0, 0.0);
    // Radius 2 m; 5 s at 0.5 rad/s.
    drive(&mut robot, 250, 1.0, 0.5);
    let end = robot.odometry().pose;
    let chord = |yaw: f64| Point2::new(2.0 * yaw.sin(), -2.0 * yaw.cos());
    let moved = chord(start.pose.yaw_rad + 2.5) - chord(start.pose.yaw_rad);
    close(end.x_m, start.pose.x_m + moved.x, 1e-9);
    close(end.y_m, start.pose.y_m + moved.y, 1e-9);
    close(end.yaw_rad, wrap_angle(start.pose.yaw_rad + 2.5), 1e-9);
}

#[test]
fn an_old_command_ramps_to_a_stop_and_a_new_one_goes_on() {
    let mut config = config(Vec::new(), Vec::new());
    config.robot.brake_mps2 = Some(1.0);
    let mut robot = simulator(&config);
    drive(&mut robot, 100, 2.0, 1.0);
    let before = robot.odometry().pose;
    let start_ns = robot.run_ns();
    for tick in 1..=250 {
        robot.step(start_ns + tick * TICK, (tick - 1) * TICK);
        // Obeyed while the age is at most 0.2 s: eleven ticks, then 1 m/s^2.
        let braked_s = f64::from(u32::try_from(tick.saturating_sub(11)).unwrap()) * 0.02;
        close(robot.odometry().v_mps, (2.0 - braked_s).max(0.0), 1e-9);
    }
    close(robot.odometry().w_radps, 0.0, 0.0);
    assert!(robot.odometry().pose.distance_m(&before) > 0.5);
    // v t + v^2 / 2a of way in all.
    close(truth(&mut robot).driven_m, 3.0 + 2.0 * 0.22 + 2.0, 1e-9);
    drive(&mut robot, 5, 2.0, 0.0);
    close(robot.odometry().v_mps, 0.2, 1e-9);
    robot.no_command();
    robot.step(robot.run_ns() + 10 * TICK, 0);
    close(robot.odometry().v_mps, 0.18, 1e-9);
}

#[test]
fn nothing_moves_before_the_first_command_and_nan_stops() {
    let mut robot = simulator(&config(Vec::new(), Vec::new()));
    robot.step(TICK, 0);
    assert_eq!(robot.odometry().pose, Pose::default());
    drive(&mut robot, 50, 1.0, 0.0);
    drive(&mut robot, 50, f64::NAN, 1.0);
    close(robot.odometry().v_mps, 0.0, 0.0);
    close(robot.odometry().w_radps, 0.0, 0.0);
}

#[test]
fn an_obstacle_by_time_appears_at_its_exact_time() {
    let mut spawned = obstacle(a_box([3.0, 0.0], [1.0, 1.0]), Some(at(0.095)));
    spawned.lasts_s = Some(0.1);
    let mut robot = simulator(&config(Vec::new(), vec![spawned]));
    let mut ranges = vec![0.0; 360];
    for tick in 1..=15 {
        robot.step(tick * TICK, 0);
        let there = (5..=9).contains(&tick);
        assert_eq!(truth_of_obstacles(&mut robot).len(), usize::from(there));
        if robot.scan(&mut ranges).is_some() {
            // Half the box from 2.5 m: atan 0.2 to either side, beams one degree apart.
            let beams = truth_of_obstacles(&mut robot);
            let seen = ranges.iter().filter(|range| range.is_finite()).count();
            assert_eq!(seen, if there { 23 } else { 0 }, "tick {tick}");
            if there {
                assert_eq!(beams[0].beams, 23);
                assert_eq!(beams[0].appeared_run_ns, 95_000_000);
                close(f64::from(ranges[180]), 2.5, 1e-6);
            }
        } else if let Some(obstacle) = truth_of_obstacles(&mut robot).first() {
            assert_eq!(obstacle.beams, 0);
        }
    }
}

#[test]
fn an_obstacle_by_nearness_appears_once_in_the_tick_of_the_robot() {
    let near = Some(Trigger {
        at_s: None,
        robot_near: Some(Near {
            point_m: [2.0, 0.0],
            distance_m: 0.5,
        }),
    });
    let mut spawned = obstacle(a_box([5.0, 0.0], [1.0, 1.0]), near);
    spawned.lasts_s = Some(1.0);
    let mut robot = simulator(&config(Vec::new(), vec![spawned]));
    let mut appeared = 0;
    while robot.odometry().pose.x_m < 1.5 {
        assert!(truth_of_obstacles(&mut robot).is_empty());
        drive(&mut robot, 1, 1.0, 0.0);
        appeared = robot.run_ns();
    }
    assert_eq!(truth_of_obstacles(&mut robot)[0].appeared_run_ns, appeared);
    drive(&mut robot, 49, -0.5, 0.0);
    assert_eq!(truth_of_obstacles(&mut robot).len(), 1);
    // It vanishes, the robot comes again, and nothing more happens.
    drive(&mut robot, 100, 1.0, 0.0);
    assert!(robot.odometry().pose.x_m > 2.0);
    assert!(truth_of_obstacles(&mut robot).is_empty());
}

#[test]
fn a_scan_between_ticks_is_taken_at_its_capture() {
    let mut walker = obstacle(a_box([-4.0, 0.0], [1.0, 9.0]), None);
    walker.waypoints_m = vec![[-9.0, 0.0]];
    walker.speed_mps = 0.5;
    let mut config = config(vec![a_box([9.5, 0.0], [1.0, 9.0])], vec![walker]);
    config.robot.lidar.rate_hz = 15.0;
    let mut robot = simulator(&config);
    let mut ranges = vec![0.0; 360];
    robot.set_command(1.0, 0.0);
    let mut due_ticks = Vec::new();
    for tick in 1..=40 {
        robot.step(tick * TICK, 0);
        assert_eq!(robot.odometry().scan_due(), robot.scan_due().is_some());
        let Some(due) = robot.scan_due() else {
            assert_eq!(robot.scan(&mut ranges), None);
            continue;
        };
        due_ticks.push(tick);
        robot.scan(&mut ranges).expect("a scan is due");
        // 2 m/s^2 up to 1 m/s.
        let t = seconds(due.capture_run_ns);
        let x_m = if t < 0.5 { t * t } else { 0.25 + t - 0.5 };
        close(f64::from(ranges[180]), 9.0 - x_m, 1e-6);
        close(f64::from(ranges[0]), x_m + 3.5 + 0.5 * t, 1e-6);
    }
    assert_eq!(due_ticks[..6], [4, 7, 10, 14, 17, 20]);
}

/// In lockstep a scan between two ticks is taken after the tick, in real time at its capture.
#[test]
fn a_tick_in_two_steps_sees_and_ends_as_in_one() {
    let mut config = config(vec![a_box([9.5, 0.0], [1.0, 9.0])], Vec::new());
    config.robot.lidar.rate_hz = 15.0;
    let (mut whole, mut split) = (simulator(&config), simulator(&config));
    let (mut late, mut at_once) = (vec![0.0; 360], vec![0.0; 360]);
    let mut between = 0;
    for tick in 1..=60 {
        if tick % 15 == 1 {
            let w_radps = if tick < 30 { 0.4 } else { -0.7 };
            whole.set_command(1.0, w_radps);
            split.set_command(1.0, w_radps);
        }
        whole.step(tick * TICK, 0);
        let due = whole.scan_due();
        assert_eq!(
            split.next_capture_run_ns(tick * TICK),
            due.map(|due| due.capture_run_ns)
        );
        if let Some(due) = due.filter(|due| due.capture_run_ns < tick * TICK) {
            split.step(due.capture_run_ns, 0);
            assert_eq!(split.scan_due(), Some(due));
            assert_eq!(split.odometry().scan_due, 1);
            assert_eq!(split.next_capture_run_ns(tick * TICK), None);
            let scan = split.scan(&mut at_once);
            assert_eq!(whole.scan(&mut late), scan);
            for (late, at_once) in late
                .iter()
                .zip(&at_once)
                .filter(|(late, _)| late.is_finite())
            {
                close(f64::from(*at_once), f64::from(*late), 1e-6);
            }
            between += 1;
            split.step(tick * TICK, 0);
            assert!(!split.truth_due(), "told once");
        } else {
            split.step(tick * TICK, 0);
            assert_eq!(split.scan_due(), due);
        }
        let (one, other) = (truth(&mut whole), truth(&mut split));
        close(other.pose.x_m, one.pose.x_m, 1e-12);
        close(other.pose.y_m, one.pose.y_m, 1e-12);
        close(other.pose.yaw_rad, one.pose.yaw_rad, 1e-12);
        close(other.v_mps, one.v_mps, 1e-12);
        close(other.driven_m, one.driven_m, 1e-12);
    }
    assert_eq!(between, 12, "of 18 scans six fall on a tick");
}

#[test]
fn the_map_file_is_seen_and_touched_cell_by_cell() {
    let folder = tempfile::tempdir().expect("a folder");
    let yaml = "image: hall.pgm\nresolution: 0.5\norigin: [-4.0, -2.0, 0.0]\nnegate: 0\n\
                occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    std::fs::write(folder.path().join("hall.yaml"), yaml).expect("written");
    // 16 x 8 cells; the only black one is column 12 of the row above y = 0, so x 2.0 to 2.5,
    // y 0.0 to 0.5. An unknown one is in front of it.
    let mut image = b"P5\n16 8\n255\n".to_vec();
    let mut pixels = [254_u8; 16 * 8];
    pixels[3 * 16 + 12] = 0;
    pixels[3 * 16 + 10] = 205;
    image.extend(pixels);
    std::fs::write(folder.path().join("hall.pgm"), image).expect("written");
    let mut config = config(Vec::new(), Vec::new());
    config.world.area_m = None;
    config.world.map = Some(folder.path().join("hall.yaml"));
    config.start = [0.0, 0.2, 0.0];
    let mut robot = simulator(&config);
    drive(&mut robot, 5, 0.0, 0.0);
    let mut ranges = vec![0.0; 360];
    robot.scan(&mut ranges).expect("a scan is due");
    close(f64::from(ranges[180]), 2.0, 1e-6);
    let hits = ranges.iter().filter(|range| range.is_finite()).count();
    // From atan(-0.2 / 2) to atan(0.3 / 2): -5.7 to 8.5 degrees.
    assert_eq!(hits, 14);
    close(truth(&mut robot).clearance_m, 1.75, 1e-9);
    drive(&mut robot, 200, 2.0, 0.0);
    let truth = truth(&mut robot);
    close(truth.pose.x_m, 1.75, 2e-4);
    assert_eq!(truth.contacts_moving, 1);
}

/// A drive through clutter, as bits of poses and ranges.
fn random_drive(seed: u64, sigma_m: f64) -> (Vec<u64>, Simulator) {
    let shapes = (0..60_i32)
        .map(|i| {
            let (column, row) = (f64::from(i % 8 - 4), f64::from(i / 8 - 4));
            let centre_m = [1.6 * column + 0.8, 1.6 * row + 0.8];
            match i % 3 {
                0 => a_box(centre_m, [0.02, 0.9]),
                1 => ShapeSpec::Disc {
                    centre_m,
                    radius_m: 0.15,
                },
                _ => ShapeSpec::Box {
                    centre_m,
                    size_m: [0.4, 0.4],
                    yaw_rad: FRAC_PI_4,
                },
            }
        })
        .collect();
    let mut config = config(shapes, Vec::new());
    config.robot.lidar.sigma_m = sigma_m;
    config.robot.radius_m = None;
    config.robot.footprint_m = Some(vec![[-0.2, -0.15], [0.3, -0.15], [0.3, 0.15], [-0.2, 0.15]]);
    let mut robot = Simulator::new(&config, world_of(&config), seed, TICK).expect("a simulator");
    let mut rng = Pcg64Mcg::seed_from_u64(99);
    let mut bits = Vec::new();
    let mut ranges = vec![0.0; 360];
    for _ in 0..300 {
        drive(
            &mut robot,
            10,
            rng.random_range(-2.0..5.0),
            rng.random_range(-3.0..3.0),
        );
        let pose = robot.odometry().pose;
        assert!(
            !robot.world.touches(robot.body.footprint(), &pose),
            "in a wall at {pose:?}"
        );
        robot.scan(&mut ranges);
        bits.extend([pose.x_m, pose.y_m, pose.yaw_rad].map(f64::to_bits));
        bits.extend(ranges.iter().map(|range| u64::from(range.to_bits())));
    }
    (bits, robot)
}

#[test]
fn what_cannot_be_simulated_is_refused_by_name() {
    let refused = |change: &dyn Fn(&mut SimConfig), tick_ns: u64| {
        let mut config = config(
            vec![a_box([5.0, 0.0], [1.0, 1.0])],
            vec![obstacle(a_box([0.0, 5.0], [1.0, 1.0]), None)],
        );
        change(&mut config);
        Simulator::new(&config, world_of(&config), SEED, tick_ns)
            .expect_err("refused")
            .to_string()
    };
    let start = |x, y| move |config: &mut SimConfig| config.start = [x, y, 0.0];
    assert_eq!(
        refused(&start(4.3, 0.0), TICK),
        "start: the robot touches something static there"
    );
    assert_eq!(
        refused(&start(0.0, 5.0), TICK),
        "start: the robot touches box there"
    );
    assert!(refused(&start(f64::NAN, 5.0), TICK).starts_with("start"));
    assert!(refused(&|config| config.robot.v_mps_max = 0.0, TICK).starts_with("robot.v_mps_max"));
    assert!(refused(&|_| (), 2 * SECOND).starts_with("a tick of 2000000000 ns"));
    let fast = refused(&|config| config.robot.lidar.rate_hz = 51.0, TICK);
    assert!(fast.starts_with("robot.lidar.rate_hz: 51"), "{fast}");
}
