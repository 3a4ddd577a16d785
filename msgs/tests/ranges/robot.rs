//! What the robot is, measures and is told to do.

use crate::{PLACE, SPEED, lengths, ranges, short, wire};
use zeronav_msgs::Pose;
use zeronav_msgs::command::{RequestCause, VelocityCommand, VelocityRequest};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::message::Refusal;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::request::PlanRequest;
use zeronav_msgs::scan::Scan;

#[test]
fn commands() {
    ranges(
        VelocityRequest::default(),
        VelocityRequest::check,
        &[
            ("v_mps", |it, value| it.v_mps = value, SPEED),
            ("w_radps", |it, value| it.w_radps = value, SPEED),
            (
                "braking_arc_m",
                |it, value| it.braking_arc_m = value,
                [0.0, 1.0e6],
            ),
            ("limit_mps", |it, value| it.limit_mps = value, [0.0, 1.0e3]),
            (
                "blocked_arc_m",
                |it, value| it.blocked_arc_m = value,
                [0.0, 1.0e6],
            ),
        ],
    );
    let point = [-1.0e3, 1.0e3];
    ranges(
        VelocityCommand::default(),
        VelocityCommand::check,
        &[
            ("v_mps", |it, value| it.v_mps = value, SPEED),
            ("w_radps", |it, value| it.w_radps = value, SPEED),
            ("point_m", |it, value| it.point_m[0] = value, point),
            ("point_m", |it, value| it.point_m[1] = value, point),
            (
                "point_clearance_m",
                |it, value| it.point_clearance_m = value,
                point,
            ),
        ],
    );
    let beam = |beam| {
        VelocityCommand {
            beam,
            ..VelocityCommand::default()
        }
        .check()
    };
    assert_eq!(beam(4096), Ok(()));
    assert_eq!(beam(4097), Err(Refusal::OutOfRange("beam")));
    let [validity, intervention] = [7, 11].map(|code| {
        let command = VelocityCommand::default();
        (
            VelocityCommand {
                validity: code,
                ..command
            },
            VelocityCommand {
                intervention: code,
                ..command
            },
        )
    });
    assert_eq!(validity.0.check(), Err(Refusal::Code("validity")));
    assert_eq!(intervention.1.check(), Err(Refusal::Code("intervention")));
    ranges(
        PlanRequest::default(),
        PlanRequest::check,
        &[(
            "blocked_arc_m",
            |it, value| it.blocked_arc_m = value,
            [0.0, 1.0e6],
        )],
    );
    let reason = PlanRequest {
        reason: 4,
        ..PlanRequest::default()
    };
    assert_eq!(reason.check(), Err(Refusal::Code("reason")));
}

/// A description with everything that it needs.
fn description() -> Description {
    Description {
        inscribed_radius_m: 0.2,
        circumscribed_radius_m: 0.3,
        v_mps_max: 1.0,
        w_radps_max: 1.0,
        a_mps2_max: 1.0,
        brake_mps2: 1.0,
        alpha_radps2_max: 1.0,
        range_m_min: 0.1,
        range_m_max: 10.0,
        scan_period_ns: 1,
        n_beams: 1,
        n_corners: 3,
        ..Description::default()
    }
}

#[test]
fn descriptions() {
    let corner = [-100.0, 100.0];
    let positive = [f64::MIN_POSITIVE, 1.0e3];
    ranges(
        (description(), Corner::default()),
        |(meta, corner)| meta.check(&[*corner; 3]),
        &[
            ("corner", |it, value| it.1.x_m = value, corner),
            ("corner", |it, value| it.1.y_m = value, corner),
            (
                "inscribed_radius_m",
                |it, value| {
                    it.0.inscribed_radius_m = value;
                    it.0.circumscribed_radius_m = 120.0;
                },
                [1.0e-3, 100.0],
            ),
            (
                "circumscribed_radius_m",
                |it, value| it.0.circumscribed_radius_m = value,
                [0.2, 150.0],
            ),
            ("v_mps_max", |it, value| it.0.v_mps_max = value, positive),
            (
                "v_mps_min",
                |it, value| it.0.v_mps_min = value,
                [-1.0e3, 0.0],
            ),
            (
                "w_radps_max",
                |it, value| it.0.w_radps_max = value,
                positive,
            ),
            ("a_mps2_max", |it, value| it.0.a_mps2_max = value, positive),
            ("brake_mps2", |it, value| it.0.brake_mps2 = value, positive),
            (
                "alpha_radps2_max",
                |it, value| it.0.alpha_radps2_max = value,
                positive,
            ),
            (
                "base_from_laser",
                |it, value| it.0.base_from_laser.x_m = value,
                PLACE,
            ),
            (
                "angle_min_rad",
                |it, value| it.0.angle_min_rad = value,
                [-12.6, 12.6],
            ),
            (
                "angle_increment_rad",
                |it, value| it.0.angle_increment_rad = value,
                [-1.6, 1.6],
            ),
            (
                "range_m_min",
                |it, value| {
                    it.0.range_m_min = value;
                    it.0.range_m_max = 1.0e3;
                },
                [0.0, 1.0e3],
            ),
            (
                "range_m_max",
                |it, value| it.0.range_m_max = value,
                [0.1, 1.0e3],
            ),
        ],
    );
}

#[test]
fn corners_beams_and_stops_of_a_description() {
    let corners = |n_corners, corners: &[Corner]| {
        Description {
            n_corners,
            ..description()
        }
        .check(corners)
    };
    let wrong = Err(Refusal::Length("corners"));
    for (n, expected) in [
        (0, Ok(())),
        (1, wrong),
        (2, wrong),
        (3, Ok(())),
        (32, Ok(())),
        (33, wrong),
    ] {
        let told = u32::try_from(n).expect("a few");
        assert_eq!(
            corners(told, &vec![Corner::default(); n]),
            expected,
            "{n} corners"
        );
        assert_eq!(
            corners(told + 1, &vec![Corner::default(); n]),
            wrong,
            "{n} corners"
        );
    }
    let beams = |n_beams| {
        Description {
            n_beams,
            ..description()
        }
        .check(&[Corner::default(); 3])
    };
    let wrong = Err(Refusal::OutOfRange("n_beams"));
    assert_eq!(
        [0, 1, 4096, 4097].map(beams),
        [wrong, Ok(()), Ok(()), wrong]
    );
    let still = Description {
        scan_period_ns: 0,
        ..description()
    };
    assert_eq!(
        still.check(&[Corner::default(); 3]),
        Err(Refusal::OutOfRange("scan_period_ns"))
    );
    let late = |actuation_delay_ns| {
        Description {
            actuation_delay_ns,
            ..description()
        }
        .check(&[Corner::default(); 3])
    };
    assert_eq!(late(2_000_000_000), Ok(()));
    assert_eq!(
        late(2_000_000_001),
        Err(Refusal::OutOfRange("actuation_delay_ns"))
    );
    let stop_m = Description {
        brake_mps2: 1.5,
        ..description()
    }
    .braking_distance_m(-3.0);
    assert!((stop_m - 3.0).abs() < 1e-12, "{stop_m}");
}

/// A scan with everything that it needs.
fn scan() -> Scan {
    Scan {
        n_beams: 1,
        angle_increment_rad: 0.1,
        range_m_min: 0.1,
        range_m_max: 10.0,
        ..Scan::default()
    }
}

#[test]
fn scans() {
    ranges(
        scan(),
        |scan| scan.check(&[1.0]),
        &[
            (
                "angle_min_rad",
                |it, value| it.angle_min_rad = short(value),
                [-12.6, 12.6].map(wire),
            ),
            (
                "angle_increment_rad",
                |it, value| it.angle_increment_rad = short(value),
                [-1.6, 1.6].map(wire),
            ),
            (
                "time_increment_s",
                |it, value| it.time_increment_s = short(value),
                [0.0, 1.0],
            ),
            (
                "range_m_min",
                |it, value| {
                    it.range_m_min = short(value);
                    it.range_m_max = 1.0e3;
                },
                [0.0, 1.0e3],
            ),
            (
                "range_m_max",
                |it, value| it.range_m_max = short(value),
                [f64::from(0.1_f32), 1.0e3],
            ),
        ],
    );
}

#[test]
fn beams_and_hits_of_a_scan() {
    let step = |angle_increment_rad| {
        Scan {
            angle_increment_rad,
            ..scan()
        }
        .check(&[1.0])
    };
    let wrong = Err(Refusal::OutOfRange("angle_increment_rad"));
    assert_eq!(
        [-1.1e-6, -0.9e-6, 0.0, 1.0e-6, 1.1e-6].map(step),
        [Ok(()), wrong, wrong, wrong, Ok(())]
    );
    let ranges_of = |range_m: f32| scan().check(&[range_m]);
    let wrong = Err(Refusal::OutOfRange("ranges"));
    assert_eq!(
        [-1.0e-6, -0.0, 0.0, f32::NAN].map(ranges_of),
        [wrong, Ok(()), Ok(()), Ok(())]
    );
    let hits =
        [0.099, 0.1, 10.0, 10.001, f32::NAN, f32::INFINITY].map(|range_m| scan().is_hit(range_m));
    assert_eq!(hits, [false, true, true, false, false, false]);
    let angle_rad = Scan {
        angle_min_rad: -1.0,
        angle_increment_rad: 0.25,
        ..scan()
    }
    .angle_of(6);
    assert!((angle_rad - 0.5).abs() < 1e-12, "{angle_rad}");
    lengths(("beams", 0, 4096), 1.0, |n_beams, ranges| {
        let scan = Scan {
            n_beams,
            angle_increment_rad: 0.1,
            ..Scan::default()
        };
        scan.check(ranges)
    });
}

#[test]
fn odometry_and_poses() {
    ranges(
        Odometry::default(),
        Odometry::check,
        &[
            ("pose", |it, value| it.pose.y_m = value, PLACE),
            ("v_mps", |it, value| it.v_mps = value, SPEED),
            ("w_radps", |it, value| it.w_radps = value, SPEED),
            (
                "variance",
                |it, value| it.variance[2] = value,
                [0.0, 1.0e12],
            ),
        ],
    );
    let due = |scan_due| Odometry {
        scan_due,
        ..Odometry::default()
    };
    assert_eq!([0, 1].map(|flag| due(flag).check()), [Ok(()); 2]);
    assert_eq!(due(2).check(), Err(Refusal::Code("scan_due")));
    assert_eq!(
        [0, 1, 2].map(|flag| due(flag).scan_due()),
        [false, true, false]
    );
    ranges(
        Pose::default(),
        |pose| pose.check("pose"),
        &[
            ("pose", |it, value| it.x_m = value, PLACE),
            ("pose", |it, value| it.y_m = value, PLACE),
            ("pose", |it, value| it.yaw_rad = value, [-62.9, 62.9]),
        ],
    );
}

#[test]
fn behaviours_of_the_recovery_are_the_six_in_its_list() {
    let recovery = RequestCause::ALL.iter().filter(|cause| cause.is_recovery());
    let labels: Vec<_> = recovery.map(|cause| cause.label()).collect();
    assert_eq!(
        labels,
        [
            "ask_for_path",
            "back_up",
            "rotate",
            "wait",
            "give_up",
            "manoeuvre"
        ]
    );
}
