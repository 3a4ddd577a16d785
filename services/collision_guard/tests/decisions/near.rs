//! Near obstacles: how fast the robot may still be, and from when on it must be able to stop.

use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, Limits, OdometryInput, ScanInput};
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::command::{Intervention, Validity, VelocityCommand, VelocityRequest};
use zeronav_msgs::description::Description;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;

const BEAMS: u16 = 1440;
const PERIOD_NS: u64 = 20_000_000;
const RADIUS_M: f64 = 0.25;
const POST_M: f64 = 0.1;

fn robot() -> Description {
    Description {
        v_mps_max: 1.5,
        w_radps_max: 3.0,
        a_mps2_max: 2.0,
        brake_mps2: 1.0,
        alpha_radps2_max: 12.0,
        inscribed_radius_m: RADIUS_M,
        circumscribed_radius_m: RADIUS_M,
        angle_increment_rad: std::f64::consts::TAU / f64::from(BEAMS),
        range_m_max: 20.0,
        scan_period_ns: 100_000_000,
        n_beams: u32::from(BEAMS),
        ..Description::default()
    }
}

/// Ranges to a round post, seen from the middle of the robot. [m]
fn ranges_to(post: Point2<f64>) -> (Scan, Vec<f32>) {
    let robot = robot();
    let scan = Scan {
        n_beams: robot.n_beams,
        angle_increment_rad: robot.angle_increment_rad.to_f32(),
        range_m_max: 20.0,
        ..Scan::default()
    };
    let ranges = (0..usize::from(BEAMS)).map(|beam| {
        let (sin, cos) = scan.angle_of(beam).sin_cos();
        let along = post.coords.dot(&Vector2::new(cos, sin));
        let squared = POST_M * POST_M - (post.coords.norm_squared() - along * along);
        if along > 0.0 && squared > 0.0 {
            (along - squared.sqrt()).to_f32()
        } else {
            f32::INFINITY
        }
    });
    let ranges = ranges.collect();
    (scan, ranges)
}

/// One answer of a fresh guard to a robot at the origin with this motion.
fn decide(
    config: GuardConfig,
    measured: Twist,
    asked: Twist,
    post: Point2<f64>,
) -> VelocityCommand {
    let robot = robot();
    let (scan, ranges) = ranges_to(post);
    let odometry = Odometry {
        v_mps: measured.v_mps,
        w_radps: measured.w_radps,
        ..Odometry::default()
    };
    let request = VelocityRequest {
        v_mps: asked.v_mps,
        w_radps: asked.w_radps,
        validity: Validity::Drive.code(),
        ..VelocityRequest::default()
    };
    Guard::new(config).decide(&GuardInputs {
        robot: Some((&robot, &[])),
        request: Some((request, 0)),
        scan: Some(ScanInput {
            scan: &scan,
            ranges: &ranges,
            id: 1,
            run_ns: PERIOD_NS,
            age_ns: 0,
            odom_from_base: Some(Pose::default()),
        }),
        odometry: Some(OdometryInput {
            odometry: &odometry,
            id: 1,
            run_ns: PERIOD_NS,
            age_ns: 0,
        }),
        period_ns: PERIOD_NS,
        stopping: false,
    })
}

fn straight(v_mps: f64) -> Twist {
    Twist {
        v_mps,
        w_radps: 0.0,
    }
}

#[test]
fn within_the_slow_zone_the_robot_is_slow_and_says_so() {
    let config = GuardConfig {
        slow_zone_m: 0.1,
        ..GuardConfig::default()
    };
    // Beside the way, with this much left between outline and post.
    let post = |gap_m: f64| Point2::new(0.2, RADIUS_M + gap_m + POST_M);
    let near = post(config.margin_m + 0.05);
    // The speed falls as the brakes allow, then stays.
    let mut v_mps = 1.0;
    for _ in 0..100 {
        let command = decide(config, straight(v_mps), straight(1.0), near);
        assert_eq!(command.validity(), Some(Validity::Drive));
        assert_eq!(command.intervention(), Some(Intervention::Slowed));
        assert!(command.v_mps < v_mps || command.v_mps <= config.slow_mps);
        v_mps = command.v_mps;
        assert_named(&command, near, config.margin_m + config.slow_zone_m);
    }
    assert!((v_mps - config.slow_mps).abs() < 1e-9, "{v_mps}");
    // No faster is asked for: nothing to do.
    let slow = straight(config.slow_mps);
    let command = decide(config, slow, slow, near);
    assert_eq!(command.intervention(), Some(Intervention::None));
    assert_eq!(
        (command.beam, command.point_m),
        (0, [0.0; 2]),
        "nothing decided"
    );
    // Beyond the zone, and without one.
    let fast = straight(1.0);
    let free = post(config.margin_m + config.slow_zone_m + 0.01);
    let command = decide(config, fast, fast, free);
    assert_eq!(command.intervention(), Some(Intervention::None));
    let off = GuardConfig {
        slow_zone_m: 0.0,
        ..config
    };
    let command = decide(off, fast, fast, near);
    assert_eq!(command.intervention(), Some(Intervention::None));
}

/// The command names a point of the post, the beam that goes there, and how near it comes.
#[track_caller]
fn assert_named(command: &VelocityCommand, post: Point2<f64>, clearance_m_max: f64) {
    let point = Point2::from(command.point_m);
    assert!((point - post).norm() < POST_M + 1e-3, "{command:?}");
    let (scan, _) = ranges_to(post);
    let angle_rad = scan.angle_of(usize::from(command.beam) - 1);
    let towards = Vector2::new(angle_rad.cos(), angle_rad.sin());
    let beside_m = towards.perp(&point.coords).abs();
    assert!(
        beside_m < 1e-3 && towards.dot(&point.coords) > 0.0,
        "{command:?}"
    );
    assert!(command.point_clearance_m < clearance_m_max, "{command:?}");
    assert_eq!(command.check(), Ok(()));
}

#[test]
fn a_stop_names_the_point_that_it_is_made_for() {
    let config = GuardConfig::default();
    // At 1 m/s it needs half a metre to stop.
    let post = Point2::new(RADIUS_M + POST_M + 0.3, 0.02);
    let command = decide(config, straight(1.0), straight(1.0), post);
    assert_eq!(command.intervention(), Some(Intervention::StoppedShort));
    assert_named(&command, post, config.margin_m);
    // Behind a robot that drives ahead nothing is in the way.
    let behind = Point2::new(-1.0, 0.0);
    let command = decide(config, straight(0.0), straight(0.2), behind);
    assert_eq!(command.beam, 0, "{command:?}");
}

/// What the scan shows of a post.
fn hits_on(post: Point2<f64>) -> Vec<Point2<f64>> {
    let (scan, ranges) = ranges_to(post);
    let hits = ranges.iter().enumerate().filter(|hit| hit.1.is_finite());
    hits.map(|(beam, range_m)| {
        let (sin, cos) = scan.angle_of(beam).sin_cos();
        Point2::new(cos, sin) * f64::from(*range_m)
    })
    .collect()
}

/// Least distance between outline and hits while the robot obeys for a time and then brakes. [m]
fn least_m(from: Twist, command: Twist, obeys_s: f64, hits: &[Point2<f64>]) -> f64 {
    const STEP_S: f64 = 2.0e-3;
    let limits = Limits::of(&robot()).expect("limits");
    let (mut pose, mut twist, mut elapsed_s) = (Pose::default(), from, 0.0);
    let mut least_m = f64::INFINITY;
    while elapsed_s < obeys_s || twist != Twist::REST {
        let next = if elapsed_s < obeys_s {
            limits.towards(twist, command, STEP_S)
        } else {
            limits.towards_rest(twist, STEP_S)
        };
        let mean = Twist {
            v_mps: 0.5 * (twist.v_mps + next.v_mps),
            w_radps: 0.5 * (twist.w_radps + next.w_radps),
        };
        pose = pose.then(&mean.arc(STEP_S));
        twist = next;
        elapsed_s += STEP_S;
        for hit in hits {
            least_m = least_m.min((pose.point() - hit).norm() - RADIUS_M);
        }
    }
    least_m
}

/// A robot that has begun to turn in is on another arc than one that has done so: a stop from
/// either must be free, wherever a post is.
#[test]
fn what_passes_leaves_a_free_stop_early_and_late_in_the_reaction_time() {
    let config = GuardConfig {
        reaction_s: 0.5,
        slow_zone_m: 0.0,
        ..GuardConfig::default()
    };
    let (mut driven, mut stopped, mut early_is_worse) = (0, 0, 0);
    for (from_radps, asked_radps) in [(0.0, 2.5), (0.0, -2.5), (2.5, -2.5), (-2.5, 2.5)] {
        let from = Twist {
            v_mps: 1.0,
            w_radps: from_radps,
        };
        let asked = Twist {
            v_mps: 1.0,
            w_radps: asked_radps,
        };
        for cell in 0..13 * 19 {
            let (x, y) = (f64::from(cell % 13), f64::from(cell / 13) - 9.0);
            let post = Point2::new(0.08 * x, 0.08 * y);
            if post.coords.norm() < RADIUS_M + POST_M + 0.05 {
                continue;
            }
            let command = decide(config, from, asked, post);
            if command.validity() != Some(Validity::Drive) {
                stopped += 1;
                continue;
            }
            driven += 1;
            let hits = hits_on(post);
            let sent = Twist {
                v_mps: command.v_mps,
                w_radps: command.w_radps,
            };
            for share in [0.25, 0.6, 1.0] {
                let left_m = least_m(from, sent, share * config.reaction_s, &hits);
                assert!(
                    left_m > 0.0,
                    "{from:?} to {sent:?}, brakes after {share}: {left_m} m left of {post}"
                );
            }
            let of_asked = |share: f64| least_m(from, asked, share * config.reaction_s, &hits);
            early_is_worse += u32::from(of_asked(0.25) < 0.0 && of_asked(1.0) > 0.02);
        }
    }
    assert!(driven > 500 && stopped > 10, "{driven} {stopped}");
    assert!(
        early_is_worse > 10,
        "{early_is_worse} posts told early from late"
    );
}
