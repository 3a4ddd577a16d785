//! One decision of the guard in a narrow aisle: disc and rectangle, free, slowed and stopped, with
//! and without a new scan.
//!
//! `cargo bench -p zeronav-collision-guard --no-default-features`

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::command::{Intervention, Validity, VelocityRequest};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;

/// [m] half the width of the aisle.
const HALF_M: f32 = 0.45;

/// Ranges of `n` beams all around between two walls, one of them with a face across the aisle at
/// `ahead_m`.
fn ranges(n: u16, ahead_m: f32) -> Vec<f32> {
    (0..n)
        .map(|i| {
            let angle = std::f32::consts::TAU * f32::from(i) / f32::from(n);
            let wall = HALF_M / angle.sin().abs().max(1e-3);
            let face = if angle.cos() > 0.0 {
                ahead_m / angle.cos()
            } else {
                f32::INFINITY
            };
            wall.min(face).min(25.0)
        })
        .collect()
}

fn robot(n_beams: u16, step_rad: f32, corners: &[Corner]) -> Description {
    Description {
        inscribed_radius_m: 0.21,
        circumscribed_radius_m: if corners.is_empty() { 0.25 } else { 0.333 },
        v_mps_max: 1.5,
        w_radps_max: 2.0,
        a_mps2_max: 1.0,
        brake_mps2: 1.0,
        alpha_radps2_max: 4.0,
        angle_increment_rad: f64::from(step_rad),
        range_m_min: 0.05,
        range_m_max: 20.0,
        scan_period_ns: 100_000_000,
        n_beams: u32::from(n_beams),
        n_corners: u32::try_from(corners.len()).unwrap_or(0),
        ..Description::default()
    }
}

fn cycle(criterion: &mut Criterion) {
    let corner = |(x_m, y_m)| Corner { x_m, y_m };
    let rectangle = [
        (0.254, 0.215),
        (-0.254, 0.215),
        (-0.254, -0.215),
        (0.254, -0.215),
    ]
    .map(corner);
    for (shape, corners) in [("disc", &[][..]), ("rectangle", &rectangle[..])] {
        for (scene, n, ahead_m, expected) in [
            ("free, 720 beams", 720, 8.0, Intervention::None),
            ("slowed, 720 beams", 720, 0.81, Intervention::Slowed),
            ("free, 1080 beams", 1080, 8.0, Intervention::None),
            ("slowed, 1080 beams", 1080, 0.81, Intervention::Slowed),
            ("stopped, 1080 beams", 1080, 0.6, Intervention::StoppedShort),
        ] {
            let step_rad = std::f32::consts::TAU / f32::from(n);
            let robot = robot(n, step_rad, corners);
            let scan = Scan {
                n_beams: u32::from(n),
                angle_increment_rad: step_rad,
                range_m_min: 0.05,
                range_m_max: 20.0,
                ..Scan::default()
            };
            let ranges = ranges(n, ahead_m);
            let odometry = Odometry {
                v_mps: 1.0,
                w_radps: 0.05,
                ..Odometry::default()
            };
            let request = VelocityRequest {
                v_mps: 1.0,
                w_radps: 0.05,
                validity: Validity::Drive.code(),
                ..VelocityRequest::default()
            };
            let mut guard = Guard::new(GuardConfig::default());
            let mut decide = |count: u64| {
                guard.decide(&GuardInputs {
                    robot: Some((&robot, corners)),
                    request: Some((request, 1_000_000)),
                    scan: Some(ScanInput {
                        scan: &scan,
                        ranges: &ranges,
                        id: count,
                        run_ns: count,
                        age_ns: 10_000_000,
                        odom_from_base: Some(odometry.pose),
                    }),
                    odometry: Some(OdometryInput {
                        odometry: &odometry,
                        id: 1,
                        run_ns: 1,
                        age_ns: 1_000_000,
                    }),
                    period_ns: 20_000_000,
                    stopping: false,
                })
            };
            decide(1);
            assert_eq!(decide(2).intervention(), Some(expected), "{shape}, {scene}");
            criterion.bench_function(&format!("{shape}, {scene}"), |bencher| {
                bencher.iter(|| decide(black_box(2)));
            });
            let mut count = 2;
            criterion.bench_function(&format!("{shape}, {scene}, new scan"), |bencher| {
                bencher.iter(|| {
                    count += 1;
                    decide(black_box(count))
                });
            });
        }
    }
}

criterion_group!(benches, cycle);
criterion_main!(benches);
