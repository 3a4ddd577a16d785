//! What the guard makes of odometry and of single beams, and how far it slows a request down.

use std::f32::consts::FRAC_PI_2;
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::command::{Intervention, Validity, VelocityCommand, VelocityRequest};
use zeronav_msgs::description::Description;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;

const TICK_NS: u64 = 20_000_000;

/// A disc of 0.25 m with four beams: ahead, left, back, right.
fn robot() -> Description {
    Description {
        v_mps_max: 1.0,
        v_mps_min: -2.0,
        w_radps_max: 2.0,
        a_mps2_max: 2.0,
        brake_mps2: 1.0,
        alpha_radps2_max: 4.0,
        inscribed_radius_m: 0.25,
        circumscribed_radius_m: 0.25,
        angle_increment_rad: f64::from(FRAC_PI_2),
        range_m_max: 10.0,
        scan_period_ns: 5 * TICK_NS,
        n_beams: 4,
        ..Description::default()
    }
}

/// A guard and the scan that it sees.
struct Bench {
    guard: Guard,
    tick: u64,
    scan: Scan,
    ranges: [f32; 4],
    odometry: Odometry,
    /// Tick of the newest scan, which is its id.
    scan_tick: u64,
}

impl Bench {
    fn new(config: GuardConfig) -> Self {
        Self {
            guard: Guard::new(config),
            tick: 0,
            scan: Scan {
                n_beams: 4,
                angle_increment_rad: FRAC_PI_2,
                range_m_max: 10.0,
                ..Scan::default()
            },
            ranges: [f32::INFINITY; 4],
            odometry: Odometry::default(),
            scan_tick: 1,
        }
    }

    /// The next tick, with the scan of that tick when `fresh`.
    fn step(&mut self, v_mps: f64, fresh: bool) -> VelocityCommand {
        self.tick += 1;
        if fresh {
            self.scan_tick = self.tick;
        }
        let request = VelocityRequest {
            v_mps,
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        };
        self.guard.decide(&GuardInputs {
            robot: Some((&robot(), &[])),
            request: Some((request, 0)),
            scan: Some(ScanInput {
                scan: &self.scan,
                ranges: &self.ranges,
                id: self.scan_tick,
                run_ns: self.scan_tick * TICK_NS,
                age_ns: (self.tick - self.scan_tick) * TICK_NS,
                odom_from_base: Some(self.odometry.pose),
            }),
            odometry: Some(OdometryInput {
                odometry: &self.odometry,
                id: self.tick,
                run_ns: self.tick * TICK_NS,
                age_ns: 0,
            }),
            period_ns: TICK_NS,
            stopping: false,
        })
    }

    fn intervention(&mut self, v_mps: f64, fresh: bool) -> Intervention {
        let command = self.step(v_mps, fresh);
        command.intervention().expect("a known intervention")
    }
}

/// A robot that backs up faster than it drives ahead is not taken for one whose odometry jumps.
#[test]
fn backing_up_at_full_speed_is_no_jump_of_odometry() {
    let mut bench = Bench::new(GuardConfig::default());
    bench.odometry.v_mps = -2.0;
    for _ in 0..5 {
        // 2 m/s and half as much again, which no drive ahead could reach.
        bench.odometry.pose.x_m -= 0.07;
        assert_eq!(bench.intervention(-0.5, false), Intervention::None);
    }
    bench.odometry.pose.x_m -= 0.1;
    assert_eq!(bench.intervention(-0.5, false), Intervention::ScanStale);
}

/// A message that is no number does not hide the jump between those around it.
#[test]
fn a_jump_is_noticed_across_a_malformed_message() {
    let mut bench = Bench::new(GuardConfig::default());
    assert_eq!(bench.intervention(0.1, true), Intervention::None);
    bench.odometry.v_mps = f64::NAN;
    bench.odometry.pose.x_m = f64::NAN;
    assert_eq!(bench.intervention(0.1, false), Intervention::OdometryStale);
    bench.odometry = Odometry::default();
    bench.odometry.pose.x_m = 1.0;
    assert_eq!(bench.intervention(0.1, false), Intervention::ScanStale);
}

/// Where points of before the jump lie nobody knows: they do not stand in the way after it.
#[test]
fn what_was_seen_before_a_jump_is_forgotten() {
    let mut bench = Bench::new(GuardConfig::default());
    bench.ranges[0] = 0.8;
    assert_eq!(bench.intervention(0.3, true), Intervention::None);
    bench.ranges[0] = f32::INFINITY;
    // Half a centimetre in front of the robot, by odometry of now.
    bench.odometry.pose.x_m += 0.545;
    assert_eq!(bench.intervention(0.3, true), Intervention::None);
}

/// The command comes to rest in its time whatever the robot does.
#[test]
fn a_ramp_ends_in_time_though_the_robot_goes_on() {
    let mut bench = Bench::new(GuardConfig::default());
    bench.odometry.v_mps = 0.5;
    bench.step(0.5, true);
    bench.scan_tick = 0;
    // 0.5 m/s at 1 m/s^2 are 25 ticks.
    for n in 1..=26 {
        bench.odometry.pose.x_m += 0.01;
        bench.scan.range_m_max = f32::NAN;
        let command = bench.step(0.5, false);
        assert_eq!(command.intervention(), Some(Intervention::ScanStale));
        let expected_mps = (0.5 - 0.02 * f64::from(n)).max(0.0);
        let off_mps = (command.v_mps - expected_mps).abs();
        assert!(off_mps < 1e-9, "tick {n}: {} m/s", command.v_mps);
    }
}

#[test]
fn the_scan_of_the_tick_in_which_odometry_jumped_counts() {
    let mut bench = Bench::new(GuardConfig::default());
    assert_eq!(bench.intervention(0.1, true), Intervention::None);
    bench.odometry.pose.x_m += 1.0;
    assert_eq!(bench.intervention(0.1, true), Intervention::None);
}

/// A scan may be turned a little against the description: its points lie where its own angles say.
#[test]
fn a_scan_of_another_geometry_is_placed_by_its_own_angles() {
    let mut bench = Bench::new(GuardConfig {
        reaction_s: 0.5,
        ..GuardConfig::default()
    });
    // Something ahead that slows the robot down and is named in each command.
    bench.ranges[0] = 0.3;
    for turned_rad in [0.0, 0.015, -0.015, 0.0] {
        bench.scan.angle_min_rad = turned_rad;
        // Twice, so that the scan before has the same angles.
        bench.step(1.0, true);
        let command = bench.step(1.0, true);
        assert_ne!(command.beam, 0, "{command:?}");
        let y_m = 0.3 * f64::from(turned_rad).sin();
        let found_m = command.point_m[1];
        assert!(
            (found_m - y_m).abs() < 1e-6,
            "{turned_rad} rad: {found_m} m"
        );
    }
}

/// Beams are taken one after another while the robot moves: each has the time of its own.
#[test]
fn every_beam_is_placed_where_the_robot_was_at_its_time() {
    // 20 ms from beam to beam at 1 m/s, the last at the capture: 60, 40, 20 and 0 mm back.
    for (beam, (x_m, y_m)) in [(0, (0.44, 0.0)), (1, (-0.04, 0.5)), (3, (0.0, -0.5))] {
        let mut bench = Bench::new(GuardConfig {
            // All around is within the margin, so that any point stops and is named.
            margin_m: 0.3,
            ..GuardConfig::default()
        });
        bench.scan.time_increment_s = 0.02;
        bench.odometry.v_mps = 1.0;
        bench.ranges[beam] = 0.5;
        let command = bench.step(1.0, true);
        assert_ne!(command.beam, 0, "{command:?}");
        let [found_x_m, found_y_m] = command.point_m;
        let off_m = (found_x_m - x_m).hypot(found_y_m - y_m);
        assert!(off_m < 1e-6, "beam {beam}: {:?}", command.point_m);
    }
}

/// Of a request that is too fast as much is left as five halvings find.
#[test]
fn a_request_is_slowed_no_more_than_needed() {
    let config = GuardConfig {
        reaction_s: 0.5,
        slow_zone_m: 0.0,
        ..GuardConfig::default()
    };
    for range_m in [0.35, 0.4, 0.5, 0.6] {
        let command = |v_mps: f64| {
            let mut bench = Bench::new(config);
            bench.ranges[0] = range_m;
            bench.step(v_mps, true)
        };
        let steps = (0..=1000_u16).map(|n| f64::from(n) / 1000.0);
        let passes = |v_mps: &f64| command(*v_mps).intervention() == Some(Intervention::None);
        let fastest_mps = steps.filter(passes).fold(0.0, f64::max);
        assert!((0.05..0.95).contains(&fastest_mps), "{fastest_mps} m/s");
        let slowed = command(1.0);
        assert_eq!(slowed.intervention(), Some(Intervention::Slowed));
        let short_mps = fastest_mps - slowed.v_mps;
        assert!(
            (-1e-3..=1.0 / 32.0 + 1e-3).contains(&short_mps),
            "{range_m} m: {} of {fastest_mps} m/s",
            slowed.v_mps
        );
    }
}

/// A robot with a wide slow zone that drives at this speed, and what it sees ahead and on its left.
fn passing(v_mps: f64, [ahead_m, left_m]: [f32; 2]) -> VelocityCommand {
    let mut bench = Bench::new(GuardConfig {
        reaction_s: 0.1,
        slow_zone_m: 0.1,
        ..GuardConfig::default()
    });
    bench.odometry.v_mps = v_mps;
    (bench.ranges[0], bench.ranges[1]) = (ahead_m, left_m);
    bench.step(v_mps, true)
}

/// Near obstacles it brakes, over the 60 ms by which a command may be ahead of it.
#[test]
fn in_the_slow_zone_the_speed_falls_as_the_brakes_allow() {
    let command = passing(1.0, [f32::INFINITY, 0.3]);
    assert_eq!(command.intervention(), Some(Intervention::Slowed));
    assert!((command.v_mps - 0.94).abs() < 1e-9, "{command:?}");
}

/// At 0.6 m/s it stops within 0.24 m: what is 0.37 m ahead has no part in that.
#[test]
fn what_lies_beyond_the_way_is_not_named() {
    let command = passing(0.6, [0.62, 0.3]);
    assert_eq!(command.intervention(), Some(Intervention::Slowed));
    assert_eq!(command.beam, 2, "{command:?}");
}

/// What is nearest at first, on the left, is passed; what is ahead comes nearer.
#[test]
fn what_comes_nearest_on_the_way_is_named() {
    let command = passing(0.6, [0.58, 0.4]);
    assert_eq!(command.intervention(), Some(Intervention::Slowed));
    assert_eq!(command.beam, 1, "{command:?}");
    assert!((command.point_clearance_m - 0.09).abs() < 0.02);
}

/// A robot that something stands nearer to than the margin may come as near to something else.
#[test]
fn inside_the_margin_nothing_comes_nearer_than_the_nearest() {
    let creeps = |ahead_m: f32| {
        let mut bench = Bench::new(GuardConfig::default());
        (bench.ranges[0], bench.ranges[1]) = (ahead_m, 0.252);
        bench.intervention(0.02, true)
    };
    assert_eq!(creeps(0.259), Intervention::None);
    assert_ne!(creeps(0.2525), Intervention::None);
}
