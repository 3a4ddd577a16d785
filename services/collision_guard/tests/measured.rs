//! What the guard makes of odometry and of single beams, and how far it slows a request down.

use std::f32::consts::FRAC_PI_2;
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::Pose;
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
