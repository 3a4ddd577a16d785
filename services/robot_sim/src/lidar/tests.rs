use super::*;
use core::f64::consts::{FRAC_PI_2, PI};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use zeronav_casts::Cast;
use zeronav_msgs::GridGeometry;
use zeronav_world::{Occupancy, Shape, ShapeSpec, StaticMap};

const SEED: u64 = 42;

fn spec(n_beams: u32) -> LidarSpec {
    LidarSpec::exact(n_beams, 10.0, 0.1..10.0)
}

fn shape(spec: &ShapeSpec) -> Convex {
    Shape::new(spec).expect("a shape").placed().clone()
}

fn disc(x: f64, y: f64, radius_m: f64) -> Convex {
    shape(&ShapeSpec::Disc {
        centre_m: [x, y],
        radius_m,
    })
}

fn a_box(centre_m: [f64; 2], size_m: [f64; 2], yaw_rad: f64) -> Convex {
    shape(&ShapeSpec::Box {
        centre_m,
        size_m,
        yaw_rad,
    })
}

/// Ranges of one scan and the beams on tags 0 and 1.
fn take(spec: &LidarSpec, at: Pose, forms: &[(&Convex, Option<u32>)]) -> (Vec<f32>, [u32; 2]) {
    let mut lidar = Lidar::new(spec, SEED);
    let mut ranges = vec![0.0; spec.n_beams as usize];
    let mut beams_on = [0; 2];
    let mut exposure = lidar.expose(&at);
    for (form, tag) in forms {
        exposure.add_shape(form, *tag);
    }
    let scan = exposure.finish(1, &mut ranges, &mut beams_on);
    assert_eq!(scan.check(&ranges), Ok(()));
    (ranges, beams_on)
}

#[track_caller]
fn check(range: f32, expected: f64) {
    assert!(
        (f64::from(range) - expected).abs() < 1e-5,
        "{range}, not {expected}"
    );
}

#[test]
fn beams_go_all_around_and_the_last_is_one_step_before_the_first() {
    let header = Lidar::new(&spec(720), SEED).header();
    assert!((header.angle_of(0) + PI).abs() < 1e-6);
    let gap_rad = header.angle_of(0) + TAU - header.angle_of(719);
    assert!((gap_rad - TAU / 720.0).abs() < 1e-5, "{gap_rad}");
    let mut half = spec(181);
    half.fov_rad = PI;
    let header = Lidar::new(&half, SEED).header();
    assert!((header.angle_of(0) + FRAC_PI_2).abs() < 1e-6);
    assert!((header.angle_of(180) - FRAC_PI_2).abs() < 1e-5);
}

#[test]
fn ranges_from_a_laser_that_is_mounted_turned_and_beside_the_middle() {
    // Robot at (1, 1) looking along +y; the laser 0.2 m ahead, 0.1 m to the left, turned by
    // half a turn: it sits at (0.9, 1.2) and its beam 0 (-pi) points along +y of the map.
    let mut four = spec(4);
    four.pose = [0.2, 0.1, PI];
    let at = Pose::new(1.0, 1.0, FRAC_PI_2);
    let ahead = a_box([0.9, 4.7], [2.0, 1.0], 0.0);
    let left = disc(-2.1, 1.2, 0.5);
    let right = disc(3.9, 1.5, 0.5);
    let (ranges, beams_on) = take(
        &four,
        at,
        &[(&ahead, None), (&left, Some(0)), (&right, Some(1))],
    );
    check(ranges[0], 3.0);
    check(ranges[1], 2.5);
    assert!(ranges[2].is_infinite() && ranges[2] > 0.0);
    // 0.3 beside the middle of a disc of 0.5: half the chord is 0.4.
    check(ranges[3], 2.6);
    assert_eq!(beams_on, [1, 1]);
}

#[test]
fn the_nearest_thing_counts_and_hides_the_rest() {
    let near = disc(2.0, 0.0, 0.5);
    let far = a_box([4.0, 0.0], [0.2, 1.0], 0.0);
    for forms in [
        [(&near, Some(0)), (&far, Some(1))],
        [(&far, Some(1)), (&near, Some(0))],
    ] {
        let (ranges, beams_on) = take(&spec(4), Pose::default(), &forms);
        check(ranges[2], 1.5);
        assert_eq!(beams_on, [1, 0]);
    }
}

#[test]
fn every_beam_agrees_with_casting_every_beam() {
    let seed = 9;
    eprintln!("seed {seed}");
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    for case in 0..300 {
        let mut spec = spec(rng.random_range(2..400));
        if case % 2 == 0 {
            spec.fov_rad = rng.random_range(0.1..TAU);
        }
        if spec.directions_rad().1 > 1.6 {
            continue;
        }
        let mut within = |m: f64| rng.random_range(-m..m);
        spec.pose = [within(0.5), within(0.5), within(PI)];
        let at = Pose::new(within(2.0), within(2.0), within(PI));
        let forms: Vec<Convex> = (0..12)
            .map(|i| {
                let centre_m = [within(8.0), within(8.0)];
                if i % 2 == 0 {
                    disc(centre_m[0], centre_m[1], within(0.6).abs() + 0.01)
                } else {
                    let size_m = [within(3.0).abs() + 0.01, within(3.0).abs() + 0.01];
                    a_box(centre_m, size_m, within(PI))
                }
            })
            .collect();
        let tagged: Vec<(&Convex, Option<u32>)> = forms.iter().map(|form| (form, None)).collect();
        let (ranges, _) = take(&spec, at, &tagged);
        let laser = at.then(&Pose::new(spec.pose[0], spec.pose[1], spec.pose[2]));
        let header = Lidar::new(&spec, SEED).header();
        for (beam, range) in ranges.iter().enumerate() {
            let (sin, cos) = (laser.yaw_rad + header.angle_of(beam)).sin_cos();
            let nearest = forms
                .iter()
                .filter_map(|form| ray::cast(form, laser.point(), Vector2::new(cos, sin)))
                .fold(f64::INFINITY, f64::min);
            if nearest < spec.range_m_min {
                assert!(
                    range.is_nan(),
                    "case {case} beam {beam}: {range} at {nearest}"
                );
            } else if nearest > spec.range_m_max {
                assert!(range.is_infinite(), "case {case} beam {beam}: {range}");
            } else {
                check(*range, nearest);
            }
        }
    }
}

#[test]
fn too_close_is_nan_too_far_is_infinite_and_inside_is_blind() {
    let at = |x: f64| take(&spec(4), Pose::default(), &[(&disc(x, 0.0, 1.0), Some(0))]);
    let (ranges, beams_on) = at(1.099);
    assert!(ranges[2].is_nan());
    assert_eq!(beams_on, [0, 0]);
    check(at(1.101).0[2], 0.101);
    check(at(10.999).0[2], 9.999);
    assert_eq!(
        at(11.001).0[2].total_cmp(&f32::INFINITY),
        core::cmp::Ordering::Equal
    );
    assert!(at(0.5).0.iter().all(|range| range.is_nan()));
    // Also when the sensor has no closest range.
    let mut blind = spec(4);
    blind.range_m_min = 0.0;
    let around = a_box([0.0, 0.0], [1.0, 1.0], 0.3);
    let (ranges, _) = take(&blind, Pose::default(), &[(&around, None)]);
    assert!(ranges.iter().all(|range| range.is_nan()));
}

#[test]
fn cells_of_a_map_and_shapes_hide_each_other() {
    let geometry = GridGeometry {
        origin_x_m: -5.0,
        origin_y_m: -5.0,
        resolution_m: 0.5,
        width: 20,
        height: 20,
    };
    let mut map = StaticMap::free(geometry);
    // x 3.0..3.5, y 0.0..0.5 and its neighbour below.
    map.cells[10 * 20 + 16] = Occupancy::Occupied;
    map.cells[9 * 20 + 16] = Occupancy::Occupied;
    map.cells[10 * 20 + 12] = Occupancy::Unknown;
    let grid = SolidGrid::new(&map);
    let mut lidar = Lidar::new(&spec(4), SEED);
    let mut scan = |form: &Convex| {
        let mut ranges = [0.0; 4];
        let mut beams_on = [0; 1];
        let mut exposure = lidar.expose(&Pose::new(0.1, 0.1, 0.0));
        exposure.add_shape(form, Some(0));
        exposure.add_grid(&grid);
        exposure.finish(1, &mut ranges, &mut beams_on);
        (ranges[2], beams_on[0])
    };
    let (range, beams) = scan(&disc(4.0, 0.1, 0.2));
    check(range, 2.9);
    assert_eq!(beams, 0);
    let (range, beams) = scan(&disc(2.0, 0.1, 0.2));
    check(range, 1.7);
    assert_eq!(beams, 1);
}

#[test]
fn noise_never_makes_a_range_negative() {
    let mut noisy = spec(720);
    noisy.sigma_m = 1.0;
    noisy.range_m_min = 0.0;
    let (ranges, _) = take(
        &noisy,
        Pose::default(),
        &[(&disc(0.3, 0.0, 0.2), None), (&disc(-9.9, 0.0, 0.5), None)],
    );
    assert!(ranges.iter().any(|range| range.is_nan()));
    assert!(ranges.iter().any(|range| range.is_finite()));
    assert!(
        !ranges
            .iter()
            .any(|range| *range < 0.0 || *range > 10.0 && range.is_finite())
    );
}

#[test]
fn noise_depends_on_seed_and_scan_and_nothing_else() {
    let mut noisy = spec(360);
    noisy.sigma_m = 0.05;
    let wall = a_box([0.0, 5.0], [20.0, 2.0], 0.0);
    let bits = |lidar: &mut Lidar, index: u64| -> Vec<u32> {
        let mut ranges = vec![0.0; 360];
        let mut exposure = lidar.expose(&Pose::default());
        exposure.add_shape(&wall, None);
        exposure.finish(index, &mut ranges, &mut []);
        ranges.iter().map(|range| range.to_bits()).collect()
    };
    let mut first = Lidar::new(&noisy, SEED);
    let (one, two) = (bits(&mut first, 1), bits(&mut first, 2));
    assert_ne!(one, two);
    assert_eq!(bits(&mut first, 1), one);
    assert_eq!(bits(&mut Lidar::new(&noisy, SEED), 2), two);
    assert_ne!(bits(&mut Lidar::new(&noisy, SEED + 1), 1), one);
}

/// A scan of a lidar that turns, beam by beam from `at(age)`, by casting every beam at every form.
fn swept_by_hand(
    spec: &LidarSpec,
    at: impl Fn(u64) -> Pose,
    forms_at: impl Fn(u64) -> Vec<Convex>,
) -> Vec<f64> {
    let header = Lidar::new(spec, SEED).header();
    (0..spec.n_beams as usize)
        .map(|beam| {
            let later = f64::from(spec.n_beams) - 1.0 - f64::from(u32::try_from(beam).unwrap());
            let age_s = later * f64::from(header.time_increment_s);
            let age_ns = (age_s * 1.0e9).round().to_u64();
            let laser = at(age_ns).then(&Pose::new(spec.pose[0], spec.pose[1], spec.pose[2]));
            let (sin, cos) = (laser.yaw_rad + header.angle_of(beam)).sin_cos();
            forms_at(age_ns)
                .iter()
                .filter_map(|form| ray::cast(form, laser.point(), Vector2::new(cos, sin)))
                .fold(f64::INFINITY, f64::min)
        })
        .collect()
}

/// Ten of them; `within(m)` draws from -m to m.
fn discs_and_boxes(within: &mut impl FnMut(f64) -> f64) -> Vec<Convex> {
    let form = |i: usize| {
        let centre_m = [within(7.0), within(7.0)];
        if i.is_multiple_of(2) {
            disc(centre_m[0], centre_m[1], within(0.5).abs() + 0.01)
        } else {
            let size_m = [within(3.0).abs() + 0.01, within(3.0).abs() + 0.01];
            a_box(centre_m, size_m, within(PI))
        }
    };
    (0..10).map(form).collect()
}

#[test]
fn a_turning_lidar_sees_every_beam_from_where_it_was_then() {
    let seed = 21;
    eprintln!("seed {seed}");
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let (mut hits, mut on_moving) = (0, 0);
    for case in 0..120 {
        let mut within = |m: f64| rng.random_range(-m..m);
        let mut spec = spec(if case % 3 == 0 { 90 } else { 360 });
        spec.motion_distortion = true;
        spec.range_m_min = 0.0;
        if case % 4 == 0 {
            spec.fov_rad = 4.7;
        }
        spec.pose = [within(0.3), within(0.3), within(PI)];
        let (start, v_mps) = (Pose::new(within(1.0), within(1.0), within(PI)), within(3.0));
        // The last cases turn faster than the mirror, against it and with it.
        let w_radps = within(if case < 100 { 4.0 } else { 90.0 });
        let at = |age_ns: u64| {
            let t_s = 0.1 - age_ns.to_f64() * 1.0e-9;
            let yaw_rad = wrap_angle(start.yaw_rad + w_radps * t_s);
            let (x, y) = (start.x_m + v_mps * t_s, start.y_m - 0.5 * v_mps * t_s);
            Pose::new(x, y, yaw_rad)
        };
        let still = discs_and_boxes(&mut within);
        let (from, velocity) = ([within(4.0), within(4.0)], [within(5.0), within(5.0)]);
        let walker = |age_ns: u64| {
            let t_s = 0.1 - age_ns.to_f64() * 1.0e-9;
            // There during the second half only.
            (t_s > 0.05).then(|| {
                disc(
                    from[0] + velocity[0] * t_s,
                    from[1] + velocity[1] * t_s,
                    0.4,
                )
            })
        };
        let expected = swept_by_hand(&spec, at, |age_ns| {
            still.iter().cloned().chain(walker(age_ns)).collect()
        });
        let mut lidar = Lidar::new(&spec, SEED);
        let middle_ns = lidar.sweep_ns() / 2;
        let mut ranges = vec![0.0; spec.n_beams as usize];
        let mut beams_on = [0];
        let mut exposure = lidar.sweep(at);
        for form in &still {
            exposure.add_shape(form, None);
        }
        let middle_s = 0.1 - middle_ns.to_f64() * 1.0e-9;
        let middle = disc(
            from[0] + velocity[0] * middle_s,
            from[1] + velocity[1] * middle_s,
            0.4,
        );
        let reach_m = f64::hypot(velocity[0], velocity[1]) * 0.0501;
        exposure.add_moving(&middle, reach_m, 0, walker);
        let scan = exposure.finish(1, &mut ranges, &mut beams_on);
        assert_eq!(scan.check(&ranges), Ok(()));
        for (beam, (range, expected)) in ranges.iter().zip(expected).enumerate() {
            if expected > spec.range_m_max {
                assert!(range.is_infinite(), "case {case} beam {beam}: {range}");
            } else if expected == 0.0 {
                assert!(range.is_nan(), "case {case} beam {beam}: {range}");
            } else {
                hits += 1;
                check(*range, expected);
            }
        }
        on_moving += beams_on[0];
    }
    assert!(hits > 10_000 && on_moving > 100, "{hits} {on_moving}");
}

#[test]
fn a_turning_lidar_says_how_long_it_takes() {
    let mut spec = spec(360);
    spec.motion_distortion = true;
    let lidar = Lidar::new(&spec, SEED);
    assert!((f64::from(lidar.header().time_increment_s) - 0.1 / 360.0).abs() < 1e-9);
    assert!(lidar.sweep_ns().abs_diff(99_722_222) < 100);
    assert_eq!(Lidar::new(&super::tests::spec(360), SEED).sweep_ns(), 0);
}
