//! Scans and odometry over time: what waits, what is old, and what a jump makes of both.

use zeronav_casts::Cast;
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::Pose;
use zeronav_msgs::command::{Intervention, Validity, VelocityRequest};
use zeronav_msgs::description::Description;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;

const MS: u64 = 1_000_000;
const TICK_MS: u64 = 20;

/// A guard, and a robot that drives along x in the open.
struct Bench {
    guard: Guard,
    tick: u64,
    /// Where odometry says that the robot is. [m]
    x_m: f64,
    /// Tick of the newest scan, which is its id, and whether odometry reaches there.
    scan_tick: u64,
    scan_placed: bool,
}

impl Bench {
    fn new() -> Self {
        Self {
            guard: Guard::new(GuardConfig::default()),
            tick: 0,
            x_m: 0.0,
            scan_tick: 1,
            scan_placed: true,
        }
    }

    /// Takes the scan of now.
    fn scan(&mut self, placed: bool) -> &mut Self {
        (self.scan_tick, self.scan_placed) = (self.tick + 1, placed);
        self
    }

    /// One control period under a request to drive.
    fn step(&mut self) -> Intervention {
        self.tick += 1;
        self.x_m += 0.006;
        let robot = Description {
            v_mps_max: 1.0,
            w_radps_max: 1.8,
            a_mps2_max: 1.0,
            brake_mps2: 1.5,
            alpha_radps2_max: 3.0,
            inscribed_radius_m: 0.25,
            circumscribed_radius_m: 0.25,
            angle_increment_rad: 0.1,
            range_m_max: 10.0,
            scan_period_ns: 100 * MS,
            n_beams: 4,
            ..Description::default()
        };
        let scan = Scan {
            n_beams: 4,
            angle_increment_rad: 0.1,
            range_m_max: 10.0,
            ..Scan::default()
        };
        let odometry = Odometry {
            pose: Pose::new(self.x_m, 0.0, 0.0),
            v_mps: 0.3,
            ..Odometry::default()
        };
        let request = VelocityRequest {
            v_mps: 0.3,
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        };
        let behind = self.tick - self.scan_tick;
        let scan_x_m = self.x_m - 0.006 * behind.to_f64();
        let command = self.guard.decide(&GuardInputs {
            robot: Some((&robot, &[])),
            request: Some((request, MS)),
            scan: Some(ScanInput {
                scan: &scan,
                ranges: &[f32::INFINITY; 4],
                id: self.scan_tick,
                run_ns: self.scan_tick * TICK_MS * MS,
                age_ns: behind * TICK_MS * MS,
                odom_from_base: self.scan_placed.then(|| Pose::new(scan_x_m, 0.0, 0.0)),
            }),
            odometry: Some(OdometryInput {
                odometry: &odometry,
                id: self.tick,
                run_ns: self.tick * TICK_MS * MS,
                age_ns: 0,
            }),
            period_ns: TICK_MS * MS,
            stopping: false,
        });
        command.intervention().expect("a known intervention")
    }
}

#[test]
fn after_a_jump_of_odometry_the_scan_is_stale_until_one_from_after_it() {
    let mut bench = Bench::new();
    for _ in 0..3 {
        assert_eq!(bench.step(), Intervention::None);
    }
    bench.x_m += 1.0;
    assert_eq!(bench.step(), Intervention::ScanStale);
    let jumped = bench.tick;
    // Odometry goes on from there, but where the points are is unknown.
    assert_eq!(bench.step(), Intervention::ScanStale);
    // A newer scan, from before the jump.
    bench.scan_tick = jumped - 1;
    assert_eq!(bench.step(), Intervention::ScanStale);
    assert_eq!(bench.scan(true).step(), Intervention::None);
    assert_eq!(bench.step(), Intervention::None);
}

#[test]
fn motion_is_no_jump() {
    let mut bench = Bench::new();
    for _ in 0..10 {
        // As fast as the robot can be, and a little noise.
        bench.x_m += 0.014;
        assert_eq!(bench.step(), Intervention::None);
    }
}

/// While the newest scan waits for its odometry, the one before is looked at, and grows old.
#[test]
fn scans_that_wait_for_their_odometry_do_not_make_the_one_before_younger() {
    let mut bench = Bench::new();
    assert_eq!(bench.scan(true).step(), Intervention::None);
    let seen = bench.tick;
    // 350 ms are 17 ticks and a half.
    while bench.tick < seen + 17 {
        assert_eq!(bench.scan(false).step(), Intervention::None);
    }
    assert_eq!(bench.scan(false).step(), Intervention::ScanStale);
    assert_eq!(bench.scan(true).step(), Intervention::None);
}
