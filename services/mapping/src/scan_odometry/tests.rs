use super::*;
use zeronav_casts::Cast;

/// Ends of the beams, in `base`, in a hall of 6 m x 4 m with a pillar, seen from a pose.
fn hall(from: &Pose) -> Vec<Point2<f64>> {
    let into_base = from.isometry().inverse();
    let edge = |n: i32, from: [f64; 2], to: [f64; 2]| {
        (0..n).map(move |k| {
            let share = f64::from(k) / f64::from(n);
            Point2::new(
                from[0] + share * (to[0] - from[0]),
                from[1] + share * (to[1] - from[1]),
            )
        })
    };
    edge(200, [-3.0, -2.0], [3.0, -2.0])
        .chain(edge(140, [3.0, -2.0], [3.0, 2.0]))
        .chain(edge(200, [3.0, 2.0], [-3.0, 2.0]))
        .chain(edge(140, [-3.0, 2.0], [-3.0, -2.0]))
        .chain(edge(20, [1.0, 0.5], [1.0, 0.9]))
        .map(|point| into_base * point)
        .collect()
}

/// Ends of beams that were taken all at once.
fn at_once(at: &[Point2<f64>]) -> Ends<'_> {
    Ends {
        at,
        ago: &[],
        sweep_share: 0.0,
        are_most: true,
    }
}

fn noise(length_m: f64, turn_rad: f64) -> Matrix3<f64> {
    let place = 0.03_f64.powi(2) * length_m;
    let yaw = 0.04_f64.powi(2) * turn_rad + 0.02_f64.powi(2) * length_m;
    Matrix3::from_diagonal(&Vector3::new(place, place, yaw))
}

/// An arc of 3 m in steps of 4 cm, with odometry that reads lengths 4 % and turns 8 % too long.
fn arc(moves: bool, mut see: impl FnMut(f64, &Pose) -> Vec<Point2<f64>>) -> (Pose, Pose, Pose) {
    let (mut truth, mut odometry) = (Pose::new(-1.5, -1.0, 0.0), Pose::default());
    let mut judged = truth;
    let mut scans = ScanOdometry::default();
    scans.begin(&odometry, &see(0.0, &truth));
    let step = Pose::new(0.04, 0.0, 0.015);
    for n in 1..=75 {
        truth = truth.then(&step);
        odometry = odometry.then(&Pose::new(1.04 * 0.04, 0.0, 1.08 * 0.015));
        let seen = see(f64::from(n), &truth);
        let moved = scans.follow(&odometry, &noise(0.04, 0.015), &at_once(&seen), moves);
        judged = judged.then(&moved.last_from_base);
    }
    (truth, judged, Pose::new(-1.5, -1.0, 0.0).then(&odometry))
}

#[test]
fn two_scans_of_a_hall_know_better_than_odometry() {
    let (truth, judged, by_odometry) = arc(false, |_, from| hall(from));
    assert!(by_odometry.distance_m(&truth) > 0.15);
    assert!(judged.distance_m(&truth) < 0.02, "{judged:?} {truth:?}");
    assert!(wrap_angle(judged.yaw_rad - truth.yaw_rad).abs() < 0.01);
}

/// Without anything to see, and where all that is seen walks, the robot is where odometry says.
#[test]
fn nothing_and_those_who_walk_are_not_believed() {
    let (_, judged, by_odometry) = arc(true, |_, _| Vec::new());
    assert!(judged.distance_m(&by_odometry) < 1e-9);
    // 40 Hz, 1.2 m/s sideways.
    let (_, judged, by_odometry) = arc(true, |n, from| {
        let walked = Pose::new(from.x_m, from.y_m - 0.03 * n, from.yaw_rad);
        hall(&walked)
    });
    let off_m = judged.distance_m(&by_odometry);
    assert!(off_m < 0.25, "{off_m} of 2.25 m");
}

/// A drive in the hall with wheels of which this share of the way and of the turn is lost from the tenth
/// scan on; where the robot is in truth, by the scans and by odometry, and what the last step rests on.
fn slip(way: f64, turn: f64, moves: bool) -> (Pose, Pose, Pose, Basis) {
    let start = Pose::new(-1.5, -1.0, 0.0);
    let (mut truth, mut odometry, mut judged) = (start, start, start);
    let mut scans = ScanOdometry::default();
    let mut basis = Basis::Odometry;
    scans.begin(&odometry, &hall(&truth));
    for n in 0..40 {
        let lost = if n < 10 { (0.0, 0.0) } else { (way, turn) };
        let step = Pose::new(0.09, 0.0, 0.05);
        truth = truth.then(&Pose::new(
            (1.0 - lost.0) * step.x_m,
            0.0,
            (1.0 - lost.1) * step.yaw_rad,
        ));
        odometry = odometry.then(&step);
        let seen = hall(&truth);
        let moved = scans.follow(&odometry, &noise(0.09, 0.05), &at_once(&seen), moves);
        judged = judged.then(&moved.last_from_base);
        assert_ne!(moved.basis, Basis::Nothing);
        assert_eq!(moved.unknown(), None, "{way} {turn} {n}");
        basis = moved.basis;
    }
    (truth, judged, odometry, basis)
}

/// Wheels that slip, the way, the turn or both: the scans carry the robot, also where something moves.
#[test]
fn scans_carry_a_robot_whose_wheels_slip() {
    for moves in [false, true] {
        for (way, turn) in [
            (0.5, 0.5),
            (0.7, 0.0),
            (0.8, 0.8),
            (1.0, 0.0),
            (0.0, 1.0),
            (1.0, 1.0),
        ] {
            let (truth, judged, by_odometry, basis) = slip(way, turn, moves);
            assert!(by_odometry.distance_m(&truth) > 0.5, "{way} {turn}");
            let off_m = judged.distance_m(&truth);
            assert!(off_m < 0.06, "{way} {turn} {moves}: {off_m} m");
            let off_rad = wrap_angle(judged.yaw_rad - truth.yaw_rad).abs();
            assert!(off_rad < 0.03, "{way} {turn} {moves}: {off_rad} rad");
            assert!(basis == Basis::Scans || way < 0.75, "{way} {turn} {moves}");
        }
    }
}

/// A lidar that takes its beams one after the other on wheels that spin on the spot.
#[test]
fn beams_put_together_by_wheels_that_slip_are_put_together_anew() {
    let truth = Pose::new(-1.5, -1.0, 0.2);
    let mut odometry = truth;
    let mut scans = ScanOdometry::default();
    let seen = hall(&truth);
    scans.begin(&odometry, &seen);
    let ago: Vec<f64> = (0..seen.len())
        .map(|n| 1.0 - n.to_f64() / seen.len().to_f64())
        .collect();
    let mut judged = truth;
    for _ in 0..10 {
        odometry = odometry.then(&Pose::new(0.12, 0.0, 0.1));
        let put = |(end, ago): (&Point2<f64>, &f64)| {
            let at = Pose::new(0.12 * ago, 0.0, 0.1 * ago);
            at.isometry().inverse() * end
        };
        let at: Vec<Point2<f64>> = seen.iter().zip(&ago).map(put).collect();
        let ends = Ends {
            at: &at,
            ago: &ago,
            sweep_share: 1.0,
            are_most: true,
        };
        let moved = scans.follow(&odometry, &noise(0.12, 0.1), &ends, false);
        assert_eq!(moved.basis, Basis::Scans);
        judged = judged.then(&moved.last_from_base);
    }
    assert!(judged.distance_m(&truth) < 0.03, "{judged:?} {truth:?}");
}

/// Another place altogether: no motion explains it, and that is said.
#[test]
fn a_scan_that_nothing_explains_tells_that_the_motion_is_unknown() {
    let mut scans = ScanOdometry::default();
    scans.begin(&Pose::default(), &hall(&Pose::default()));
    let stood = hall(&Pose::default());
    let moved = scans.follow(&Pose::default(), &noise(0.0, 0.0), &at_once(&stood), false);
    assert_eq!(moved.unknown(), None);
    let elsewhere: Vec<Point2<f64>> = hall(&Pose::new(1.3, 0.9, 0.7));
    let odometry = Pose::new(0.3, 0.0, 0.0);
    let moved = scans.follow(&odometry, &noise(0.3, 0.0), &at_once(&elsewhere), false);
    assert_eq!(moved.basis, Basis::Nothing);
    let (place_m, _) = moved.unknown().expect("unknown");
    assert!(place_m >= 0.3, "{place_m}");
    // A robot that stands, and a scan with hardly a point, contradict nothing.
    for (odometry, seen) in [(odometry, &elsewhere[..]), (Pose::new(0.6, 0.0, 0.0), &[])] {
        let moved = scans.follow(&odometry, &noise(0.3, 0.0), &at_once(seen), false);
        assert_eq!(moved.unknown(), None);
    }
}

/// A key scan of a few returns explains no whole scan: that says nothing about odometry.
#[test]
fn a_key_scan_of_few_points_contradicts_nobody() {
    let few = &hall(&Pose::default())[..40];
    let elsewhere = hall(&Pose::new(1.3, 0.9, 0.7));
    let mut scans = ScanOdometry::default();
    scans.begin(&Pose::default(), few);
    let stood = scans.follow(&Pose::default(), &noise(0.0, 0.0), &at_once(few), false);
    assert!(stood.share > FOUND_SHARE.1, "{stood:?}");
    let odometry = Pose::new(0.3, 0.0, 0.0);
    let moved = scans.follow(&odometry, &noise(0.3, 0.0), &at_once(&elsewhere), false);
    assert_eq!(moved.basis, Basis::Odometry);
}

/// Odometry that jumps by more than a robot can drive in no time says nothing of its motion.
#[test]
fn after_a_jump_the_robot_goes_on_as_it_did() {
    let start = Pose::new(-1.5, -1.0, 0.0);
    let (mut truth, mut odometry, mut judged) = (start, start, start);
    let mut scans = ScanOdometry::default();
    scans.begin(&odometry, &hall(&truth));
    for n in 0..30 {
        let step = Pose::new(0.05, 0.0, 0.02);
        truth = truth.then(&step);
        odometry = odometry.then(&step);
        let mut noise = noise(0.05, 0.02);
        if n == 15 {
            odometry = odometry.then(&Pose::new(2.0, -1.0, 1.5));
            scans.jumped(&odometry);
            noise = Matrix3::from_diagonal(&Vector3::new(0.01, 0.01, 0.01));
        }
        let moved = scans.follow(&odometry, &noise, &at_once(&hall(&truth)), n > 10);
        judged = judged.then(&moved.last_from_base);
    }
    assert!(judged.distance_m(&truth) < 0.03, "{judged:?} {truth:?}");
}

#[test]
fn what_scans_tell_is_what_odometry_does_not_err_by() {
    let mut scans = ScanOdometry::default();
    scans.begin(&Pose::default(), &hall(&Pose::default()));
    let odometry = Pose::new(0.05, 0.0, 0.0);
    let moved = scans.follow(
        &odometry,
        &noise(0.05, 0.0),
        &at_once(&hall(&odometry)),
        true,
    );
    let left = moved.left.diagonal();
    assert!(left.iter().all(|left| (0.0..0.9).contains(left)), "{left}");
    let moved = scans.follow(&odometry, &noise(0.05, 0.0), &at_once(&[]), true);
    assert_eq!(moved.left, Matrix3::identity());
}

/// The basis of the motion to a scan that shows `share` of a hall from `truth` and else an arc that was not
/// there, of which `are_most` beams are left, while odometry has moved by `step`.
fn basis(truth: &Pose, share: f64, are_most: bool, step: &Pose) -> Basis {
    let mut scans = ScanOdometry::default();
    let mut seen = hall(&Pose::default());
    scans.begin(&Pose::default(), &seen);
    let still = scans.follow(&Pose::default(), &noise(0.0, 0.0), &at_once(&seen), false);
    assert!(still.share > 0.9, "{still:?}");
    seen = hall(truth);
    let n = f64::from(u16::try_from(seen.len()).expect("a few hundred ends"));
    for (end, k) in seen.iter_mut().zip(0_u16..) {
        let at = f64::from(k) / n;
        if at >= share {
            let angle = at * core::f64::consts::TAU;
            *end = Point2::new(0.7 * angle.cos(), 0.7 * angle.sin());
        }
    }
    let ends = Ends {
        are_most,
        ..at_once(&seen)
    };
    let noise = noise(step.x_m.hypot(step.y_m), step.yaw_rad.abs());
    scans.follow(step, &noise, &ends, false).basis
}

#[test]
fn what_is_left_where_most_may_move_does_not_speak_against_odometry() {
    let step = Pose::new(0.2, 0.0, 0.0);
    // The wheels have turned for nothing.
    let stands = Pose::default();
    assert_eq!(basis(&stands, 1.0, true, &step), Basis::Scans);
    assert_eq!(basis(&stands, 1.0, false, &step), Basis::Odometry);
    // Nothing explains an arc that was not there.
    assert_eq!(basis(&stands, 0.0, true, &step), Basis::Nothing);
    assert_eq!(basis(&stands, 0.0, false, &step), Basis::Odometry);
}

#[test]
fn a_motion_that_no_slip_explains_must_explain_most_of_the_scan() {
    let step = Pose::new(0.04, 0.0, 0.0);
    let sideways = Pose::new(0.0, 0.08, 0.0);
    assert_eq!(basis(&sideways, 1.0, true, &step), Basis::Scans);
    assert_eq!(basis(&sideways, 0.5, true, &step), Basis::Nothing);
}

/// A few ends are enough to go along with odometry that is right, scan after scan, and not to where wheels slip.
#[test]
fn a_few_ends_speak_against_wheels_that_slip_and_nothing_else() {
    let few_of = |from: &Pose| -> Vec<Point2<f64>> { hall(from).into_iter().step_by(12).collect() };
    let step = Pose::new(0.09, 0.0, 0.05);
    for (way, turn) in [
        (0.0, 0.0),
        (0.5, 0.5),
        (0.7, 0.0),
        (1.0, 0.0),
        (0.0, 1.0),
        (1.0, 1.0),
    ] {
        let start = Pose::new(-1.5, -1.0, 0.0);
        let (mut truth, mut odometry) = (start, start);
        let mut scans = ScanOdometry::default();
        scans.begin(&odometry, &hall(&truth));
        let mut goes_along = |lost: (f64, f64)| {
            truth = truth.then(&Pose::new(
                (1.0 - lost.0) * step.x_m,
                0.0,
                (1.0 - lost.1) * step.yaw_rad,
            ));
            odometry = odometry.then(&step);
            let goes_along = scans.goes_along(
                &odometry,
                &noise(0.09, 0.05),
                &at_once(&few_of(&truth)),
                false,
            );
            if goes_along && scans.is_key_due() {
                scans.next_key(&odometry, &hall(&truth));
            }
            goes_along
        };
        assert!((0..20).all(|_| goes_along((0.0, 0.0))));
        assert_eq!(goes_along((way, turn)), way + turn < 0.1, "{way} {turn}");
    }
}

/// Ends of beams along a bare wall at `far_m`, as far as a lidar sees that reaches 3.5 m and is wrong by `sigma_m`.
fn bare_wall(far_m: f64, sigma_m: f64, seed: &mut u32) -> Vec<Point2<f64>> {
    // About normal: twelve uniform numbers less six.
    let mut normal = || {
        let mut sum = -6.0;
        for _ in 0..12 {
            *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum += f64::from(*seed >> 8) / f64::from(1_u32 << 24);
        }
        sum
    };
    (0..360)
        .filter_map(|beam| {
            let (sin, cos) = f64::from(beam).to_radians().sin_cos();
            let range_m = far_m / sin + sigma_m * normal();
            (sin > 0.0 && range_m < 3.5).then(|| Point2::new(range_m * cos, range_m * sin))
        })
        .collect()
}

#[test]
fn what_comes_into_the_view_of_a_short_sighted_lidar_speaks_against_nobody() {
    let mut scans = ScanOdometry::default();
    let seen = bare_wall(3.3, 0.0, &mut 1);
    scans.begin(&Pose::default(), &seen);
    for n in 1..=7 {
        let odometry = Pose::new(0.04 * f64::from(n), 0.0, 0.0);
        let moved = scans.follow(&odometry, &noise(0.04, 0.0), &at_once(&seen), false);
        assert_eq!(moved.basis, Basis::Odometry);
        assert!(moved.share > 0.99, "{n}: {moved:?}");
    }
}

/// By chance another motion along the wall explains more of a noisy scan: no reason to leave odometry.
#[test]
fn along_a_bare_wall_that_a_noisy_lidar_sees_odometry_is_believed() {
    for far_m in [2.0, 2.8, 3.2, 3.4] {
        let mut seed = 7;
        let mut scans = ScanOdometry::default();
        scans.begin(&Pose::default(), &bare_wall(far_m, 0.05, &mut seed));
        let (mut slips, mut judged) = (0, Pose::default());
        for n in 1..=500 {
            let odometry = Pose::new(0.044 * f64::from(n), 0.0, 0.0);
            let seen = bare_wall(far_m, 0.05, &mut seed);
            let moved = scans.follow(&odometry, &noise(0.044, 0.0), &at_once(&seen), false);
            slips += u32::from(moved.basis == Basis::Scans);
            judged = judged.then(&moved.last_from_base);
        }
        eprintln!("{far_m} m: {slips} of 500, {judged:?}");
        assert!(slips <= 2, "{far_m} m: {slips}");
    }
}
