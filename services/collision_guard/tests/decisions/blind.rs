//! A lidar that shows nothing where it should show something stops the robot, and nothing else does.

use core::f64::consts::{FRAC_PI_2, PI, TAU};
use zeronav_casts::Cast;
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::Pose;
use zeronav_msgs::command::{Intervention, Validity, VelocityRequest};
use zeronav_msgs::description::Description;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;

const PERIOD_NS: u64 = 20_000_000;
const SCAN_TICKS: u64 = 5;
const BEAMS: u32 = 360;

/// A box with walls all around: x and y from and to. [m]
type Box2 = [f64; 4];

/// From inside or outside to the first wall of a box; infinite past it. [m]
fn to_box(from: [f64; 2], direction: [f64; 2], [x0, y0, x1, y1]: Box2) -> f64 {
    let mut least = f64::INFINITY;
    for (axis, walls) in [(0, [x0, x1]), (1, [y0, y1])] {
        let across = [[y0, y1], [x0, x1]][axis];
        for wall in walls {
            let far_m = (wall - from[axis]) / direction[axis];
            let there = from[1 - axis] + far_m * direction[1 - axis];
            if far_m > 0.0 && (across[0]..=across[1]).contains(&there) {
                least = least.min(far_m);
            }
        }
    }
    least
}

/// A robot that obeys at once, with its lidar in a world of boxes.
struct Drive {
    guard: Guard,
    description: Description,
    boxes: Vec<Box2>,
    pose: Pose,
    speeds: (f64, f64),
    tick: u64,
    scan: (Scan, Vec<f32>, u64, Pose),
}

impl Drive {
    fn new(boxes: &[Box2], pose: Pose, laser_yaw_rad: f64, range_m_max: f64) -> Self {
        let step_rad = TAU / f64::from(BEAMS);
        let scan = Scan {
            n_beams: BEAMS,
            angle_increment_rad: step_rad.to_f32(),
            range_m_min: 0.1,
            range_m_max: range_m_max.to_f32(),
            ..Scan::default()
        };
        Self {
            guard: Guard::new(GuardConfig::default()),
            description: Description {
                inscribed_radius_m: 0.25,
                circumscribed_radius_m: 0.25,
                v_mps_max: 1.0,
                v_mps_min: -1.0,
                w_radps_max: 2.0,
                a_mps2_max: 1.0,
                brake_mps2: 1.0,
                alpha_radps2_max: 4.0,
                base_from_laser: Pose::new(0.0, 0.0, laser_yaw_rad),
                angle_increment_rad: step_rad,
                range_m_min: 0.1,
                range_m_max,
                scan_period_ns: SCAN_TICKS * PERIOD_NS,
                n_beams: BEAMS,
                ..Description::default()
            },
            boxes: boxes.to_vec(),
            pose,
            speeds: (0.0, 0.0),
            tick: 0,
            scan: (scan, vec![f32::INFINITY; BEAMS as usize], 0, pose),
        }
    }

    /// What the lidar shows when it works in directions of `base` for which `works` is true.
    fn look(&mut self, nothing: f32, works: &dyn Fn(f64) -> bool) {
        for beam in 0..BEAMS as usize {
            let in_base = self.scan.0.angle_of(beam) + self.description.base_from_laser.yaw_rad;
            let (sin, cos) = (self.pose.yaw_rad + in_base).sin_cos();
            let from = [self.pose.x_m, self.pose.y_m];
            let ranges = self.boxes.iter().map(|it| to_box(from, [cos, sin], *it));
            // Exact ranges along a wall would look frozen.
            let noise_m = 0.001 * ((self.tick * 31 + beam as u64 * 17) % 7).to_f64();
            let range_m = ranges.fold(f64::INFINITY, f64::min) + noise_m;
            self.scan.1[beam] = if !works(zeronav_msgs::pose::wrap_angle(in_base)) {
                nothing
            } else if range_m < self.description.range_m_max {
                range_m.to_f32()
            } else {
                f32::INFINITY
            };
        }
        (self.scan.2, self.scan.3) = (self.tick, self.pose);
    }

    /// One period in which the guard is asked for these speeds.
    fn step(
        &mut self,
        asked: (f64, f64),
        nothing: f32,
        works: &dyn Fn(f64) -> bool,
    ) -> Intervention {
        self.tick += 1;
        if self.tick % SCAN_TICKS == 1 {
            self.look(nothing, works);
        }
        let odometry = Odometry {
            pose: self.pose,
            v_mps: self.speeds.0,
            w_radps: self.speeds.1,
            ..Odometry::default()
        };
        let run_ns = self.tick * PERIOD_NS;
        let command = self.guard.decide(&GuardInputs {
            robot: Some((&self.description, &[])),
            request: Some((
                VelocityRequest {
                    v_mps: asked.0,
                    w_radps: asked.1,
                    validity: Validity::Drive.code(),
                    ..VelocityRequest::default()
                },
                0,
            )),
            scan: Some(ScanInput {
                scan: &self.scan.0,
                ranges: &self.scan.1,
                id: self.scan.2,
                run_ns: self.scan.2 * PERIOD_NS,
                age_ns: (self.tick - self.scan.2) * PERIOD_NS,
                odom_from_base: Some(self.scan.3),
            }),
            odometry: Some(OdometryInput {
                odometry: &odometry,
                id: self.tick,
                run_ns,
                age_ns: 0,
            }),
            period_ns: PERIOD_NS,
            stopping: false,
        });
        let step = |now: f64, wanted: f64, most: f64| now + (wanted - now).clamp(-most, most);
        self.speeds = (
            step(self.speeds.0, command.v_mps, 0.02),
            step(self.speeds.1, command.w_radps, 0.08),
        );
        let yaw_rad = self.pose.yaw_rad + 0.01 * self.speeds.1;
        let (sin, cos) = yaw_rad.sin_cos();
        let moved_m = 0.02 * self.speeds.0;
        self.pose = Pose::new(
            self.pose.x_m + moved_m * cos,
            self.pose.y_m + moved_m * sin,
            yaw_rad + 0.01 * self.speeds.1,
        );
        command.intervention().expect("a known intervention")
    }

    /// So many periods; how many of them the guard called blind.
    fn blind(
        &mut self,
        n: u64,
        asked: (f64, f64),
        nothing: f32,
        works: &dyn Fn(f64) -> bool,
    ) -> u64 {
        (0..n)
            .map(|_| u64::from(self.step(asked, nothing, works) == Intervention::ScanStale))
            .sum()
    }
}

const HALL: Box2 = [0.0, 0.0, 14.0, 8.0];
const ALL: &dyn Fn(f64) -> bool = &|_| true;
const NONE: &dyn Fn(f64) -> bool = &|_| false;

#[test]
fn walls_that_vanish_all_at_once_stop_the_robot_until_something_returns() {
    for (hall, range_m, laser_yaw_rad) in [
        (HALL, 12.0, 0.0),
        (HALL, 30.0, 2.0),
        // Of a wide hall a short lidar sees one wall.
        ([0.0, 2.0, 40.0, 30.0], 3.5, -1.0),
        // A corridor.
        ([0.0, 3.2, 40.0, 4.8], 8.0, PI),
    ] {
        for nothing in [f32::INFINITY, f32::NAN] {
            for speed_mps in [0.2, 1.0] {
                let mut drive =
                    Drive::new(&[hall], Pose::new(2.0, 4.0, 0.0), laser_yaw_rad, range_m);
                let forward = (speed_mps, 0.0);
                assert_eq!(drive.blind(60, forward, nothing, ALL), 0, "{hall:?}");
                let from_m = drive.pose.x_m;
                let blind = drive.blind(500, forward, nothing, NONE);
                let on_m = drive.pose.x_m - from_m;
                assert!(
                    blind >= 495,
                    "{hall:?}, {nothing}: {blind} periods, {on_m} m"
                );
                assert!(
                    on_m < 0.1 * speed_mps + 0.5 * speed_mps * speed_mps + 0.05,
                    "{on_m}"
                );
                assert_eq!(drive.speeds, (0.0, 0.0));
                drive.blind(6, forward, nothing, ALL);
                assert_eq!(drive.blind(60, forward, nothing, ALL), 0);
                assert!(drive.speeds.0 > 0.19, "it goes on");
            }
        }
    }
}

/// A lidar that turns with the robot stays blind where it is blind.
#[test]
fn a_blind_sector_holds_the_robot_that_would_drive_into_it() {
    let ahead_is_covered: &dyn Fn(f64) -> bool = &|angle_rad| angle_rad.abs() > 0.7;
    for nothing in [f32::INFINITY, f32::NAN] {
        for laser_yaw_rad in [0.0, 2.5] {
            let start = Pose::new(5.0, 4.0, 0.3);
            let mut drive = Drive::new(&[HALL], start, laser_yaw_rad, 12.0);
            assert_eq!(drive.blind(20, (0.5, 0.0), nothing, ALL), 0);
            assert!(drive.blind(100, (0.5, 0.0), nothing, ahead_is_covered) >= 95);
            // It may turn and back away, and not go on wherever it looks.
            assert_eq!(drive.blind(100, (0.0, 1.0), nothing, ahead_is_covered), 0);
            assert_eq!(drive.blind(50, (-0.5, 0.0), nothing, ahead_is_covered), 0);
            assert!(drive.blind(50, (0.5, 0.5), nothing, ahead_is_covered) >= 49);
            drive.blind(6, (0.5, 0.0), nothing, ALL);
            assert_eq!(drive.blind(50, (0.5, 0.0), nothing, ALL), 0);
        }
    }
}

#[test]
fn where_nothing_is_in_range_the_robot_drives() {
    // Eighty metres of nothing, alone and with a post on it.
    for boxes in [vec![[-40.0, -40.0, 40.0, 40.0]], vec![[2.0, 1.0, 2.3, 1.3]]] {
        let mut drive = Drive::new(&boxes, Pose::new(0.0, 0.0, 0.0), 0.0, 12.0);
        assert_eq!(drive.blind(1000, (1.0, 0.1), f32::INFINITY, ALL), 0);
        assert!(drive.speeds.0 > 0.9);
    }
    // Out of a hall through its open side, into the open, and past its corners.
    let sides = [
        [0.0, 0.0, 10.0, 0.1],
        [0.0, 5.0, 10.0, 5.1],
        [0.0, 0.0, 0.1, 5.0],
    ];
    for (yaw_rad, curve) in [(0.0, 0.0), (0.1, -0.05), (-0.1, 0.05)] {
        let mut drive = Drive::new(&sides, Pose::new(1.0, 2.5, yaw_rad), 0.0, 8.0);
        assert_eq!(drive.blind(1500, (1.0, curve), f32::INFINITY, ALL), 0);
        assert!(drive.pose.x_m > 12.0, "{:?}", drive.pose);
    }
}

#[test]
fn what_is_taken_away_or_drives_away_leaves_no_blindness_behind() {
    // A box right in front of the robot in the open.
    let mut drive = Drive::new(
        &[[0.6, -0.8, 1.2, 0.8]],
        Pose::new(0.0, 0.0, 0.0),
        0.0,
        12.0,
    );
    drive.blind(150, (0.5, 0.0), f32::INFINITY, ALL);
    assert!(drive.speeds.0 < 0.1, "it stands before the box");
    drive.boxes.clear();
    assert_eq!(drive.blind(100, (0.5, 0.0), f32::INFINITY, ALL), 0);
    assert!(drive.speeds.0 > 0.4);
    // A lorry that drives past, 3 m away.
    let mut drive = Drive::new(
        &[[-14.0, 3.0, -4.0, 5.5]],
        Pose::new(0.0, 0.0, FRAC_PI_2),
        0.0,
        12.0,
    );
    for _ in 0..1000 {
        for edge in [0, 2] {
            drive.boxes[0][edge] += 0.06;
        }
        assert_ne!(
            drive.step((0.02, 0.0), f32::INFINITY, ALL),
            Intervention::ScanStale
        );
    }
}
