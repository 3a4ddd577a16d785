use super::*;
use zeronav_ros_messages::{frame, view};

const MS: u64 = 1_000_000;
const S: u64 = 1_000 * MS;
const START: [f64; 3] = [5.0, 2.0, core::f64::consts::FRAC_PI_2];

fn expected(fixed_laser: Option<Pose>) -> Expected {
    let [x, y, yaw] = START;
    Expected {
        odom_frame: "odom".to_owned(),
        base_frame: "base_link".to_owned(),
        fixed_laser,
        start: Pose::new(x, y, yaw),
    }
}

/// The robot's clock is this host's.
fn inputs(fixed_laser: Option<Pose>) -> Inputs {
    Inputs::new(expected(fixed_laser), Stamps::new(false, 0), None)
}

fn odometry(ns: u64, pose: Pose) -> Box<ros::Odometry> {
    let odometry = zeronav_msgs::odometry::Odometry {
        pose,
        v_mps: 0.5,
        ..Default::default()
    };
    Box::new(view::odometry(ns, &odometry))
}

fn scan(ns: u64) -> ros::LaserScan {
    ros::LaserScan {
        header: view::header(ns, frame::LASER),
        angle_min: -1.0,
        angle_max: 1.0,
        angle_increment: 0.5,
        time_increment: 0.007_812_5,
        scan_time: 0.1,
        range_min: 0.1,
        range_max: 10.0,
        ranges: vec![1.0, f32::NAN, 0.0, f32::INFINITY, 20.0],
        intensities: Vec::new(),
    }
}

fn give(inputs: &mut Inputs, event: Event, came_ns: u64, from: u8) -> Vec<Measured> {
    inputs.take(Arrived {
        event,
        came_ns,
        publisher: [from; 16],
    });
    core::iter::from_fn(|| inputs.next_measured()).collect()
}

fn give_odometry(inputs: &mut Inputs, ns: u64, x_m: f64) -> Vec<Measured> {
    let pose = Pose::new(x_m, 0.0, 0.0);
    give(inputs, Event::Odometry(odometry(ns, pose)), ns + MS, 1)
}

fn pose_of(measured: &[Measured]) -> Pose {
    match measured {
        [Measured::Odometry { odometry, .. }] => odometry.pose,
        other => panic!("{other:?}"),
    }
}

#[test]
fn odometry_begins_where_the_robot_starts() {
    let mut inputs = inputs(None);
    // It was switched on somewhere else.
    let first = give_odometry(&mut inputs, S, 7.0);
    assert!(pose_of(&first).distance_m(&Pose::new(5.0, 2.0, 0.0)) < 1e-9);
    // A metre ahead is a metre to the north.
    let next = pose_of(&give_odometry(&mut inputs, 2 * S, 8.0));
    assert!(next.distance_m(&Pose::new(5.0, 3.0, 0.0)) < 1e-9);
    assert!((next.yaw_rad - START[2]).abs() < 1e-9);
}

#[test]
fn odometry_that_begins_anew_goes_on_from_where_it_was() {
    let mut inputs = inputs(None);
    give_odometry(&mut inputs, S, 7.0);
    let before = pose_of(&give_odometry(&mut inputs, S + 20 * MS, 7.01));
    let after = pose_of(&give_odometry(&mut inputs, S + 40 * MS, 0.0));
    assert!(after.distance_m(&before) < 1e-9, "{after:?} {before:?}");
    let next = pose_of(&give_odometry(&mut inputs, S + 60 * MS, 0.01));
    assert!((next.y_m - before.y_m - 0.01).abs() < 1e-9);
}

#[test]
fn a_successor_goes_on_with_the_anchor_of_the_process_before_it() {
    let mut first = inputs(None);
    give_odometry(&mut first, S, 7.0);
    let anchor = first.anchor();
    let mut second = Inputs::new(expected(None), Stamps::new(false, 0), anchor);
    let pose = pose_of(&give_odometry(&mut second, 5 * S, 9.0));
    assert!(pose.distance_m(&Pose::new(5.0, 4.0, 0.0)) < 1e-9);
}

#[test]
fn a_scan_has_its_moment_its_mount_and_clean_ranges() {
    let mut inputs = inputs(None);
    let mount = view::transform(0, "base_footprint", "mast", &Pose::new(0.1, 0.0, 0.0));
    give(&mut inputs, Event::Transforms(mount), S, 1);
    let laser = view::transform(0, "mast", frame::LASER, &Pose::new(0.1, 0.0, 0.0));
    give(&mut inputs, Event::Transforms(laser), S, 1);
    let measured = give(&mut inputs, Event::Scan(scan(S)), S + 50 * MS, 1);
    let [
        Measured::Scan {
            moment,
            ranges,
            base_from_laser,
            ..
        },
    ] = &measured[..]
    else {
        panic!("{measured:?}")
    };
    // The stamp is that of the first beam.
    assert_eq!(moment.at_ns, S + 31_250_000);
    assert!((base_from_laser.x_m - 0.2).abs() < 1e-12);
    assert!(ranges[1].is_nan() && ranges[2].is_nan());
    assert!(ranges[3].is_infinite() && ranges[4].is_infinite());
}

#[test]
fn scans_without_transforms_are_named_and_none_is_measured() {
    let mut inputs = inputs(None);
    assert!(give(&mut inputs, Event::Scan(scan(S)), S, 1).is_empty());
    assert!(inputs.holds(Trouble::Transform, S).is_some());
    assert!(inputs.holds(Trouble::Transform, 3 * S).is_none());
    let mut fixed = self::inputs(Some(Pose::default()));
    assert_eq!(
        give(&mut fixed, Event::Scan(scan(S)), S + 40 * MS, 1).len(),
        1
    );
    assert!(fixed.holds(Trouble::Transform, S).is_none());
}

type Spoil = fn(&mut ros::Odometry);

#[test]
fn nan_and_wrong_frames_are_rejected_and_counted() {
    let spoilt: [Spoil; 6] = [
        |it| it.pose.pose.position.x = f64::NAN,
        |it| it.pose.pose.orientation.z = f64::INFINITY,
        |it| it.twist.twist.linear.x = f64::NAN,
        |it| it.twist.twist.angular.z = 1.0e9,
        |it| it.header.frame_id = "map".into(),
        |it| it.child_frame_id = "wheel".into(),
    ];
    let mut inputs = inputs(Some(Pose::default()));
    for (n, spoil) in (1..).zip(spoilt) {
        let mut message = odometry(S, Pose::default());
        spoil(&mut message);
        assert!(give(&mut inputs, Event::Odometry(message), S, 1).is_empty());
        assert_eq!(inputs.rejected(), n);
    }
    let mut message = scan(S);
    message.angle_increment = f32::NAN;
    assert!(give(&mut inputs, Event::Scan(message), S, 1).is_empty());
    assert_eq!(inputs.rejected(), 7);
    // Covariances of drivers are anything, and no reason.
    let mut message = odometry(S, Pose::default());
    message.pose.covariance = [[f64::NAN; 6]; 6];
    assert_eq!(give(&mut inputs, Event::Odometry(message), S, 1).len(), 1);
}

#[test]
fn what_comes_late_or_twice_is_left_out() {
    let mut inputs = inputs(Some(Pose::default()));
    assert_eq!(give_odometry(&mut inputs, S, 0.0).len(), 1);
    assert!(give_odometry(&mut inputs, S, 0.0).is_empty());
    assert!(give_odometry(&mut inputs, S - 10 * MS, 0.0).is_empty());
    assert_eq!(give_odometry(&mut inputs, S + 10 * MS, 0.0).len(), 1);
    assert_eq!(inputs.rejected(), 0);
}

#[test]
fn a_clock_that_stands_or_was_set_is_named_and_nothing_is_measured_meanwhile() {
    let mut inputs = inputs(None);
    give_odometry(&mut inputs, S, 0.0);
    for n in 1..30 {
        let message = Event::Odometry(odometry(S, Pose::default()));
        give(&mut inputs, message, S + n * 20 * MS, 1);
    }
    assert!(inputs.holds(Trouble::Clock, S + 580 * MS).is_some());
    let mut inputs = self::inputs(None);
    give_odometry(&mut inputs, S, 0.0);
    let ahead = |ns| Event::Odometry(odometry(ns + 3_600 * S, Pose::default()));
    assert!(give(&mut inputs, ahead(S + 20 * MS), S + 21 * MS, 1).is_empty());
    assert!(inputs.holds(Trouble::Clock, S + 22 * MS).is_some());
    assert_eq!(give(&mut inputs, ahead(3 * S), 3 * S + MS, 1).len(), 1);
}

#[test]
fn two_publishers_are_named_and_nothing_is_measured_meanwhile() {
    let mut inputs = inputs(None);
    let mut measured = 0;
    for n in 0..10 {
        let message = Event::Odometry(odometry(S + n * 20 * MS, Pose::default()));
        let from = 1 + u8::try_from(n % 2).expect("0 or 1");
        measured += give(&mut inputs, message, S + n * 20 * MS, from).len();
    }
    assert!(measured <= 2, "{measured}");
    assert!(inputs.holds(Trouble::Publishers, S + 200 * MS).is_some());
}
