//! What a single beam says near the robot: dust where the scans before looked through, else an obstacle.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use zeronav_casts::Cast;
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::Pose;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::description::Description;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;

const PERIOD_NS: u64 = 20_000_000;
const PERIOD_S: f64 = 0.02;
/// Control periods per scan of ten in a second, and of fifty.
const SLOW: u64 = 5;
const FAST: u64 = 1;
const RADIUS_M: f64 = 0.25;
/// [m/s] asked for.
const ASKED_MPS: f64 = 0.9;
const NONE: f32 = f32::INFINITY;

/// A robot that drives ahead along x and obeys at once.
struct Bench {
    robot: Description,
    guard: Guard,
    /// Control periods per scan.
    each: u64,
    periods: u64,
    x_m: f64,
    v_mps: f64,
    scan_x_m: f64,
    ranges: Vec<f32>,
    /// Periods in which the guard did anything.
    interventions: u64,
}

impl Bench {
    fn new(n_beams: u32, each: u64) -> Self {
        Self {
            robot: Description {
                v_mps_max: ASKED_MPS,
                w_radps_max: 2.0,
                a_mps2_max: 1.2,
                brake_mps2: 1.2,
                alpha_radps2_max: 4.0,
                inscribed_radius_m: RADIUS_M,
                circumscribed_radius_m: RADIUS_M,
                angle_increment_rad: std::f64::consts::TAU / f64::from(n_beams),
                range_m_max: 12.0,
                scan_period_ns: each * PERIOD_NS,
                n_beams,
                ..Description::default()
            },
            guard: Guard::new(GuardConfig::default()),
            each,
            periods: 0,
            x_m: 0.0,
            v_mps: 0.0,
            scan_x_m: 0.0,
            ranges: vec![NONE; n_beams as usize],
            interventions: 0,
        }
    }

    /// The lidar from the next scan on until there is another.
    fn scan(&mut self, ranges: impl FnOnce(f64, &mut [f32])) {
        self.scan_x_m = self.x_m;
        // A wall far around: no field for which the lidar is blind.
        // It changes with the place, so that the lidar is not frozen.
        self.ranges.fill(5.0 + (self.x_m / 1000.0).to_f32());
        ranges(self.x_m, &mut self.ranges);
        for _ in 0..self.each {
            self.period();
        }
    }

    fn period(&mut self) {
        self.periods += 1;
        let (run_ns, number) = (self.periods * PERIOD_NS, (self.periods - 1) / self.each);
        let scan = Scan {
            n_beams: self.robot.n_beams,
            angle_increment_rad: self.robot.angle_increment_rad.to_f32(),
            range_m_max: 12.0,
            ..Scan::default()
        };
        let odometry = Odometry {
            pose: Pose::new(self.x_m, 0.0, 0.0),
            v_mps: self.v_mps,
            ..Odometry::default()
        };
        let request = VelocityRequest {
            v_mps: ASKED_MPS,
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        };
        let captured_ns = (number * self.each + 1) * PERIOD_NS;
        let command = self.guard.decide(&GuardInputs {
            robot: Some((&self.robot, &[])),
            request: Some((request, 0)),
            scan: Some(ScanInput {
                scan: &scan,
                ranges: &self.ranges,
                id: number + 1,
                run_ns: captured_ns,
                age_ns: run_ns - captured_ns,
                odom_from_base: Some(Pose::new(self.scan_x_m, 0.0, 0.0)),
            }),
            odometry: Some(OdometryInput {
                odometry: &odometry,
                id: self.periods,
                run_ns,
                age_ns: 0,
            }),
            period_ns: PERIOD_NS,
            stopping: false,
        });
        self.interventions += u64::from(command.v_mps < ASKED_MPS);
        let before_mps = self.v_mps;
        let step_mps = self.robot.brake_mps2 * PERIOD_S;
        self.v_mps = command
            .v_mps
            .clamp(before_mps - step_mps, before_mps + step_mps);
        self.x_m += 0.5 * (before_mps + self.v_mps) * PERIOD_S;
    }

    /// At full speed with nothing near.
    fn under_way(n_beams: u32, each: u64) -> Self {
        let mut bench = Self::new(n_beams, each);
        for _ in 0..50 / each {
            bench.scan(|_, _| ());
        }
        assert!((bench.v_mps - ASKED_MPS).abs() < 1e-9);
        bench.interventions = 0;
        bench
    }
}

/// A thing ahead at `post_m` that stops only the beam straight ahead.
fn post(post_m: f64) -> impl Fn(f64, &mut [f32]) {
    move |x_m, ranges| ranges[0] = (post_m - x_m).to_f32()
}

#[test]
fn what_one_beam_of_one_scan_says_in_the_open_is_dust() {
    let mut bench = Bench::under_way(360, SLOW);
    bench.scan(|_, ranges| ranges[0] = 0.5);
    for _ in 0..5 {
        bench.scan(|_, _| ());
    }
    assert_eq!(bench.interventions, 0);
    // Two neighbours that agree are not.
    bench.scan(|_, ranges| ranges[..2].fill(0.5));
    assert!(bench.interventions > 0);
}

/// What appears on the way and stands: with ten scans per second it is left out of one, with more of two.
#[test]
fn what_stands_is_there_with_the_second_or_the_third_scan() {
    for (each, left_out) in [(SLOW, 1), (FAST, 2)] {
        let mut bench = Bench::under_way(360, each);
        // Far enough for a stop that begins so much later: 0.9 m/s take 0.34 m.
        let late = u32::try_from(each * (left_out + 1)).unwrap();
        let late_m = ASKED_MPS * PERIOD_S * f64::from(late);
        let post_m = bench.x_m + RADIUS_M + 0.34 + late_m + 0.1;
        for n in 0..100 / each {
            bench.scan(post(post_m));
            assert!(n >= left_out || bench.interventions == 0);
        }
        assert!(bench.v_mps < 1e-9, "{} m/s", bench.v_mps);
        let left_m = post_m - bench.x_m - RADIUS_M;
        assert!((0.0..0.1).contains(&left_m), "{left_m} m");
    }
}

/// What comes so fast that it is nowhere twice is found on its even way, also when it is odometry that runs
/// away from what stands.
#[test]
fn what_moves_from_scan_to_scan_is_there_with_the_third_one() {
    for each_m in [0.1, 0.2] {
        let mut bench = Bench::under_way(360, SLOW);
        let begin_m = bench.x_m + RADIUS_M + 0.45 + 2.0 * each_m;
        for n in 0..3 {
            bench.scan(post(begin_m - each_m * f64::from(n)));
            assert_eq!(bench.interventions > 0, n == 2, "{each_m} m per scan");
        }
    }
    let mut bench = Bench::under_way(360, SLOW);
    for n in 0..3 {
        bench.scan(|_, ranges| ranges[0] = 0.5);
        assert_eq!(bench.interventions > 0, n == 2);
    }
}

#[test]
fn a_post_of_one_beam_that_was_always_seen_stops_the_robot_as_any_wall() {
    let mut bench = Bench::new(360, SLOW);
    for _ in 0..60 {
        bench.scan(post(2.5));
    }
    let left_m = 2.5 - bench.x_m - RADIUS_M;
    assert!(
        bench.v_mps < 1e-9 && (0.0..0.1).contains(&left_m),
        "{left_m} m"
    );
}

/// A beam in two misses it: the scan before the last one confirms it, too.
#[test]
fn a_post_that_every_second_scan_shows_is_no_dust() {
    let mut bench = Bench::new(360, SLOW);
    for n in 0..60 {
        let seen = post(2.5);
        bench.scan(|x_m, ranges| {
            if n % 2 == 0 {
                seen(x_m, ranges);
            }
        });
        assert!(bench.x_m + RADIUS_M < 2.5, "{} m", bench.x_m);
    }
}

#[test]
fn what_was_not_looked_through_counts_at_once() {
    // A guard that was restarted has seen nothing before.
    let mut bench = Bench::under_way(360, SLOW);
    bench.guard = Guard::new(GuardConfig::default());
    bench.scan(|_, ranges| ranges[0] = 0.5);
    assert!(bench.interventions >= SLOW);
    // Hidden by something nearer, or no answer of the beams there.
    for before in [0.4, f32::NAN] {
        let mut bench = Bench::under_way(360, SLOW);
        bench.scan(|_, ranges| {
            for beam in [358, 359, 0, 1, 2] {
                ranges[beam] = before;
            }
        });
        let so_far = bench.interventions;
        bench.scan(|_, ranges| ranges[0] = 0.6);
        assert!(bench.interventions > so_far, "{before}");
    }
    // Beams so far apart that a leg stops only one.
    let mut bench = Bench::under_way(36, SLOW);
    bench.scan(|_, ranges| ranges[0] = 0.5);
    assert!(bench.interventions > 0);
}

/// Up to five in a hundred beams come back from drops, near ones more often.
#[test]
fn rain_lets_the_robot_drive() {
    let scans = 200;
    for (n_beams, each, rate, least) in [
        (360, SLOW, 0.02, 0.9),
        (360, SLOW, 0.05, 0.7),
        (1080, FAST, 0.05, 0.7),
    ] {
        let mut random = Pcg32::seed_from_u64(3);
        let mut bench = Bench::under_way(n_beams, each);
        for _ in 0..scans {
            bench.scan(|_, ranges| {
                for range_m in ranges {
                    let (chance, share): (f64, f64) = (random.random(), random.random());
                    let short_m = -0.5 * (1.0 - share).ln();
                    if chance < rate && short_m > 0.1 {
                        *range_m = short_m.to_f32();
                    }
                }
            });
        }
        let periods = u32::try_from(scans * each).unwrap();
        let undisturbed = periods - u32::try_from(bench.interventions).unwrap();
        let share = f64::from(undisturbed) / f64::from(periods);
        assert!(share > least, "{n_beams} beams, {rate}: {share}");
    }
}
