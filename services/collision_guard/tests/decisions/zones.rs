//! Zones: random commands lead into none, out of them when the robot is inside, and no faster than
//! they allow.

use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use zeronav_casts::Cast;
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, Limits, OdometryInput, ScanInput};
use zeronav_motion::Twist;
use zeronav_msgs::command::{Intervention, Validity, VelocityCommand, VelocityRequest};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::map::MapInfo;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::way_out::WayOut;
use zeronav_msgs::zones::{ZoneKind, ZonePart, Zones};
use zeronav_msgs::{Pose, ZoneSet};

const PERIOD_S: f64 = 0.02;
const PERIOD_NS: u64 = 20_000_000;
const SCAN_TICKS: u64 = 5;
const BEAMS: u16 = 36;

fn set(parts: &[ZonePart]) -> ZoneSet {
    let zones = Zones {
        revision: 1,
        n_parts: parts.len() as u64,
        ..Zones::default()
    };
    zones.check(parts).expect("zones");
    ZoneSet::of(&zones, parts)
}

fn rect(kind: ZoneKind, value: f64, [x0, y0, x1, y1]: [f64; 4]) -> ZonePart {
    let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
    ZonePart::new("zone", kind, value, &corners)
}

fn keepout(corners: [f64; 4]) -> ZonePart {
    rect(ZoneKind::Keepout, 0.0, corners)
}

/// What mapping says.
fn map(map_from_odom: Pose, is_known: bool) -> MapInfo {
    let most = if is_known { 0.0 } else { 100.0 };
    MapInfo {
        map_from_odom,
        covariance: [most, 0.0, 0.0, most, 0.0, most],
        ..MapInfo::default()
    }
}

/// A robot in an empty plain; the map lies turned to odometry.
struct Drive {
    guard: Guard,
    description: Description,
    corners: Vec<Corner>,
    limits: Limits,
    map_from_odom: Pose,
    /// `map_from_base`.
    pose: Pose,
    twist: Twist,
    tick: u64,
    ranges: Vec<f32>,
    scan: Scan,
    captured: (u64, Pose),
}

impl Drive {
    fn new(pose: Pose, zones: &ZoneSet) -> Self {
        let half = [[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]];
        let corners: Vec<Corner> = half.map(|[x_m, y_m]| Corner { x_m, y_m }).into();
        let step_rad = std::f64::consts::TAU / f64::from(BEAMS);
        let description = Description {
            inscribed_radius_m: 0.2,
            circumscribed_radius_m: 0.3_f64.hypot(0.2),
            v_mps_max: 1.0,
            v_mps_min: -0.5,
            w_radps_max: 1.5,
            a_mps2_max: 1.5,
            brake_mps2: 1.5,
            alpha_radps2_max: 4.0,
            angle_increment_rad: step_rad,
            range_m_max: 20.0,
            scan_period_ns: SCAN_TICKS * PERIOD_NS,
            n_beams: u32::from(BEAMS),
            n_corners: 4,
            ..Description::default()
        };
        let scan = Scan {
            n_beams: u32::from(BEAMS),
            angle_increment_rad: step_rad.to_f32(),
            range_m_max: 20.0,
            ..Scan::default()
        };
        let mut guard = Guard::new(GuardConfig::default());
        guard.take_zones(zones);
        let map_from_odom = Pose::new(3.0, -2.0, 0.7);
        guard.locate(&map(map_from_odom, true));
        Self {
            guard,
            limits: Limits::of(&description).expect("limits"),
            description,
            corners,
            map_from_odom,
            pose,
            twist: Twist::REST,
            tick: 0,
            ranges: vec![f32::INFINITY; usize::from(BEAMS)],
            scan,
            captured: (0, Pose::default()),
        }
    }

    fn odom_from_base(&self) -> Pose {
        let inverse = Pose::from(self.map_from_odom.isometry().inverse());
        inverse.then(&self.pose)
    }

    fn step(&mut self, asked: Twist) -> VelocityCommand {
        self.tick += 1;
        let odom_from_base = self.odom_from_base();
        if self.tick % SCAN_TICKS == 1 {
            // Far walls with some noise, so that the lidar is no frozen one.
            for (n, range) in self.ranges.iter_mut().enumerate() {
                *range = if (n as u64 + self.tick).is_multiple_of(7) {
                    15.0
                } else {
                    15.01
                };
            }
            self.captured = (self.tick, odom_from_base);
        }
        let odometry = Odometry {
            pose: odom_from_base,
            v_mps: self.twist.v_mps,
            w_radps: self.twist.w_radps,
            ..Odometry::default()
        };
        let request = VelocityRequest {
            v_mps: asked.v_mps,
            w_radps: asked.w_radps,
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        };
        let (captured, at) = self.captured;
        let command = self.guard.decide(&GuardInputs {
            robot: Some((&self.description, &self.corners)),
            request: Some((request, 1_000_000)),
            scan: Some(ScanInput {
                scan: &self.scan,
                ranges: &self.ranges,
                id: captured,
                run_ns: captured * PERIOD_NS,
                age_ns: (self.tick - captured) * PERIOD_NS,
                odom_from_base: Some(at),
            }),
            odometry: Some(OdometryInput {
                odometry: &odometry,
                id: self.tick,
                run_ns: self.tick * PERIOD_NS,
                age_ns: 0,
            }),
            period_ns: PERIOD_NS,
            stopping: false,
        });
        let sent = Twist::new(command.v_mps, command.w_radps);
        let next = self.limits.towards(self.twist, sent, PERIOD_S);
        let mean = self.twist.mean(next);
        self.pose = self.pose.then(&mean.arc(PERIOD_S));
        self.twist = next;
        command
    }

    /// How far the outline is outside of all keepout zones; below 0 inside. [m]
    fn outline_margin_m(&self, zones: &ZoneSet) -> f64 {
        let next = self.corners.iter().cycle().skip(1);
        let mut least_m = f64::INFINITY;
        for (from, to) in self.corners.iter().zip(next) {
            for n in 0..12 {
                let share = f64::from(n) / 12.0;
                let at = Point2::new(
                    from.x_m + (to.x_m - from.x_m) * share,
                    from.y_m + (to.y_m - from.y_m) * share,
                );
                least_m = least_m.min(zones.keepout_margin_m(self.pose.transform(at)));
            }
        }
        least_m
    }
}

fn any(random: &mut Pcg32) -> Twist {
    let w_radps = match random.random_range(0..3) {
        0 => 0.0,
        _ => random.random_range(-1.5..1.5),
    };
    Twist::new(random.random_range(-0.5..1.0), w_radps)
}

/// Rectangles, triangles and overlaps around the origin, which they leave free.
fn any_zones(random: &mut Pcg32) -> ZoneSet {
    let parts = (0..random.random_range(3..9)).map(|_| {
        let (angle, away) = (
            random.random_range(-3.2..3.2_f64),
            random.random_range(1.6..3.0),
        );
        let (x, y) = (away * angle.cos(), away * angle.sin());
        let mut side = || random.random_range(0.2..0.9);
        if side() < 0.5 {
            keepout([x - side(), y - side(), x + side(), y + side()])
        } else {
            let corners = [[x - side(), y - side()], [x + side(), y], [x, y + side()]];
            ZonePart::new("zone", ZoneKind::Keepout, 0.0, &corners)
        }
    });
    set(&parts.collect::<Vec<_>>())
}

#[test]
fn random_commands_lead_into_no_keepout_zone() {
    let (mut worst_m, mut stops, mut driven_m) = (f64::INFINITY, 0, 0.0);
    for seed in 0..120 {
        let mut random = Pcg32::seed_from_u64(seed);
        let zones = any_zones(&mut random);
        let mut drive = Drive::new(Pose::new(0.0, 0.0, random.random_range(-3.0..3.0)), &zones);
        if drive.outline_margin_m(&zones) < 0.0 {
            continue;
        }
        for _ in 0..40 {
            let asked = any(&mut random);
            for _ in 0..random.random_range(10..60) {
                let before = drive.pose.point();
                let command = drive.step(asked);
                driven_m += (drive.pose.point() - before).norm();
                stops += u32::from(command.intervention() == Some(Intervention::ZoneStopped));
                worst_m = worst_m.min(drive.outline_margin_m(&zones));
            }
        }
    }
    assert!(stops > 1000 && driven_m > 300.0, "{stops} {driven_m}");
    // What is between two points of the outline, and a curve that the wheels had not reached yet.
    assert!(worst_m > -0.04, "{worst_m}");
}

#[test]
fn a_robot_inside_gets_out_and_never_farther_in() {
    let zones = set(&[
        keepout([0.0, 0.0, 4.0, 3.0]),
        keepout([2.0, 2.0, 6.0, 3.5]),
        keepout([3.9, -1.0, 5.0, 2.5]),
    ]);
    for seed in 0..60 {
        let mut random = Pcg32::seed_from_u64(seed);
        let start = Pose::new(
            random.random_range(0.1..3.9),
            random.random_range(0.1..2.9),
            random.random_range(-3.0..3.0),
        );
        let mut drive = Drive::new(start, &zones);
        let mut best_m = zones.keepout_margin_m(drive.pose.point());
        for _ in 0..60 {
            let asked = any(&mut random);
            for _ in 0..random.random_range(10..40) {
                drive.step(asked);
                let now_m = zones.keepout_margin_m(drive.pose.point());
                assert!(
                    now_m > best_m.min(0.2) - 0.03,
                    "seed {seed}: {now_m} after {best_m}"
                );
                best_m = best_m.max(now_m);
            }
        }
    }
    // Straight out, backwards, too.
    for (yaw_rad, v_mps) in [(-1.57, 0.5), (1.57, -0.4)] {
        let mut drive = Drive::new(Pose::new(1.5, 0.5, yaw_rad), &zones);
        for _ in 0..200 {
            drive.step(Twist::new(v_mps, 0.0));
        }
        assert!(drive.outline_margin_m(&zones) > 0.0, "{:?}", drive.pose);
    }
}

#[test]
fn a_zone_that_appears_in_front_of_the_robot_stops_it_and_lets_it_back_out() {
    let mut drive = Drive::new(Pose::new(0.0, 0.0, 0.0), &ZoneSet::default());
    for _ in 0..60 {
        drive.step(Twist::new(1.0, 0.0));
    }
    assert!(drive.twist.v_mps > 0.95);
    // Nearer than it can stop.
    let front_m = drive.pose.x_m + 0.3;
    let zones = set(&[keepout([front_m + 0.1, -2.0, front_m + 3.0, 2.0])]);
    drive.guard.take_zones(&zones);
    let mut braked = 0;
    while drive.twist.v_mps > 0.0 {
        let before = drive.twist.v_mps;
        drive.step(Twist::new(1.0, 0.0));
        assert!(
            drive.twist.v_mps < before,
            "it brakes from the first period on"
        );
        braked += 1;
    }
    // 1 m/s at 1.5 m/s^2.
    assert!(braked <= 40, "{braked}");
    let inside = drive.outline_margin_m(&zones);
    assert!((-0.3..0.0).contains(&inside), "{inside}");
    let stopped = drive.step(Twist::new(0.3, 0.0));
    assert_eq!(stopped.intervention(), Some(Intervention::ZoneStopped));
    for _ in 0..100 {
        drive.step(Twist::new(-0.3, 0.0));
    }
    assert!(drive.outline_margin_m(&zones) > 0.1);
}

#[test]
fn the_lowest_limit_holds_inside_and_none_outside() {
    let zones = set(&[
        rect(ZoneKind::SpeedPercent, 50.0, [2.0, -3.0, 8.0, 3.0]),
        rect(ZoneKind::SpeedLimit, 0.3, [4.0, -3.0, 6.0, 3.0]),
    ]);
    let mut drive = Drive::new(Pose::new(0.0, 0.0, 0.0), &zones);
    let mut fastest = [0.0_f64; 4];
    while drive.pose.x_m < 11.0 {
        let command = drive.step(Twist::new(1.0, 0.2 * drive.pose.yaw_rad));
        let slowed = command.intervention() == Some(Intervention::ZoneSlowed);
        let at = match drive.pose.x_m {
            x if x < 1.8 => 0,
            // It has had the room to brake in.
            x if (2.4..3.8).contains(&x) => 1,
            x if (4.2..5.9).contains(&x) => 2,
            x if x > 8.1 => 3,
            _ => continue,
        };
        assert_eq!(slowed, at == 1 || at == 2, "x = {}", drive.pose.x_m);
        fastest[at] = fastest[at].max(drive.twist.v_mps);
    }
    assert!(fastest[0] > 0.99 && fastest[3] > 0.99, "{fastest:?}");
    assert!(fastest[1] < 0.501 && fastest[2] < 0.301, "{fastest:?}");
}

#[test]
fn an_uncertain_pose_lifts_no_limit_and_opens_no_zone() {
    let zones = set(&[
        rect(ZoneKind::SpeedLimit, 0.3, [-1.0, -1.0, 1.0, 1.0]),
        keepout([2.0, -3.0, 3.0, 3.0]),
    ]);
    let mut drive = Drive::new(Pose::new(0.0, 0.0, 0.0), &zones);
    for _ in 0..50 {
        drive.step(Twist::new(1.0, 0.0));
    }
    // It is lost; what mapping says now is not believed.
    drive.guard.locate(&map(Pose::new(50.0, 50.0, 1.0), false));
    for _ in 0..600 {
        drive.step(Twist::new(1.0, 0.0));
        assert!(drive.twist.v_mps < 0.301, "beyond the zone, too");
    }
    assert!(
        (1.4..1.7).contains(&drive.pose.x_m),
        "before the keepout zone: {:?}",
        drive.pose
    );
}

#[test]
fn a_robot_that_never_knew_its_pose_is_slow_and_only_turns_among_keepout_zones() {
    let slow = rect(ZoneKind::SpeedLimit, 0.3, [-1.0, -1.0, 1.0, 1.0]);
    let mut lost = Drive::new(Pose::new(20.0, 0.0, 0.0), &ZoneSet::default());
    lost.guard = Guard::new(GuardConfig::default());
    lost.guard.take_zones(&set(&[slow]));
    lost.guard.locate(&map(Pose::default(), false));
    for _ in 0..100 {
        lost.step(Twist::new(1.0, 0.0));
    }
    assert!((0.29..0.301).contains(&lost.twist.v_mps));
    // Wherever the zone is, the robot may be right before it.
    lost.guard
        .take_zones(&set(&[slow, keepout([2.0, -3.0, 3.0, 3.0])]));
    for _ in 0..50 {
        let command = lost.step(Twist::new(0.5, 0.4));
        assert_eq!(command.intervention(), Some(Intervention::ZoneStopped));
    }
    assert!(lost.twist.is_stopped());
    for _ in 0..50 {
        lost.step(Twist::new(0.0, 0.4));
    }
    assert!((lost.twist.w_radps - 0.4).abs() < 0.01);
}

#[test]
fn a_pose_that_odometry_jumped_away_from_is_not_gone_on_from() {
    let zones = set(&[keepout([9.0, -3.0, 12.0, 3.0])]);
    let mut drive = Drive::new(Pose::new(0.0, 0.0, 0.0), &zones);
    for _ in 0..50 {
        drive.step(Twist::new(0.5, 0.0));
    }
    assert!(drive.twist.v_mps > 0.4);
    // By its odometry it is 4 m behind where it was; in truth it stands where it stood.
    let truth = drive.map_from_odom;
    drive.map_from_odom = truth.then(&Pose::new(4.0, 0.0, 0.0));
    for _ in 0..100 {
        drive.step(Twist::new(0.5, 0.0));
    }
    assert!(drive.twist.is_stopped());
    // Mapping has found it.
    drive.guard.locate(&map(drive.map_from_odom, true));
    for _ in 0..50 {
        drive.step(Twist::new(0.5, 0.0));
    }
    assert!(drive.twist.v_mps > 0.4);
}

#[test]
fn zones_that_were_announced_and_have_not_come_stop_the_robot() {
    let mut drive = Drive::new(Pose::new(0.0, 0.0, 0.0), &ZoneSet::default());
    for _ in 0..50 {
        drive.step(Twist::new(1.0, 0.0));
    }
    drive.guard.lacks_zones(true);
    for _ in 0..50 {
        let command = drive.step(Twist::new(1.0, 0.0));
        assert_eq!(command.intervention(), Some(Intervention::ZonesMissing));
    }
    assert!(drive.twist.is_stopped());
    drive.guard.lacks_zones(false);
    let command = drive.step(Twist::new(1.0, 0.0));
    assert_eq!(command.intervention(), Some(Intervention::None));
}

/// A blind aisle, and a zone from its back wall to beyond the robot: the nearest edge lies behind the wall.
#[test]
fn a_robot_gets_out_by_the_way_that_mapping_has_opened() {
    let zones = set(&[keepout([0.0, -1.2, 6.0, 1.2])]);
    let mut drive = Drive::new(Pose::new(0.6, 0.0, 0.0), &zones);
    for _ in 0..50 {
        drive.step(Twist::new(0.5, 0.0));
    }
    let command = drive.step(Twist::new(0.5, 0.0));
    assert_eq!(command.intervention(), Some(Intervention::ZoneStopped));
    assert!(drive.pose.x_m < 0.63, "{:?}", drive.pose);
    let out = MapInfo {
        way_out: WayOut {
            from_m: [0.6, 0.0],
            until_m: [6.5, 0.0],
            radius_m: 0.5,
        },
        ..map(drive.map_from_odom, true)
    };
    drive.guard.locate(&out);
    // Off the way the edge still counts.
    let mut aside = Drive::new(Pose::new(0.6, 0.0, 0.0), &zones);
    let off_m = [1.0, 2.0].map(|y_m| [0.6, y_m]);
    let off = MapInfo {
        way_out: WayOut {
            from_m: off_m[0],
            until_m: off_m[1],
            radius_m: 0.5,
        },
        ..out
    };
    aside.guard.locate(&off);
    for (drive, least_m, most_m) in [(&mut drive, 6.4, 9.0), (&mut aside, 0.6, 0.63)] {
        for _ in 0..800 {
            drive.step(Twist::new(0.5, 0.0));
        }
        let x_m = drive.pose.x_m;
        assert!((least_m..most_m).contains(&x_m), "{x_m}");
    }
}
