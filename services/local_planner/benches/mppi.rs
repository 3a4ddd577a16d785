//! One cycle of `mppi`: 2000 samples of 56 steps, disc and rectangle, without and with 20 tracked
//! obstacles. "ready" is a cycle between two scans, "new scan" one with noisy points and a map some
//! cells of which changed. The time contains the 800 rollouts of `dwa_t` that seed it.
//!
//! `cargo bench -p zeronav-local-planner --no-default-features --bench mppi`

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use zeronav_local_planner::config::{DwaConfig, DwaTConfig, MppiConfig};
use zeronav_local_planner::controller::{Controller, Situation};
use zeronav_local_planner::mppi::Mppi;
use zeronav_msgs::path::Waypoint;
use zeronav_msgs::task::Goal;
use zeronav_msgs::{MapView, Pose};

mod aisle;
use aisle::{GEOMETRY, cells, crowd, disc, jackal, noisy, scan};

fn cycle(criterion: &mut Criterion) {
    let cells = cells();
    let mut others = cells.clone();
    // 1.2 m ahead less space beside the wall, so that the cost-to-go is made anew.
    others[23 * 400 + 124].clearance_mm -= 100;
    others[23 * 400 + 125].clearance_mm -= 100;
    let waypoint = |x_m| Waypoint {
        x_m,
        y_m: 1.5,
        ..Waypoint::default()
    };
    let path = [waypoint(1.0), waypoint(19.0)];
    let goal = Goal {
        pose: Pose::new(19.0, 1.5, 0.0),
        tolerance_m: 0.15,
        yaw_tolerance_rad: 4.0,
        id: 1,
    };
    let crowd = crowd();
    for (name, (robot, corners), points, obstacles) in [
        ("disc", disc(), scan(360, false), &[][..]),
        ("disc, 20 tracked", disc(), scan(360, false), &crowd[..]),
        ("disc, unknown box ahead", disc(), scan(360, true), &[][..]),
        ("rectangle", jackal(), scan(360, false), &[][..]),
        (
            "rectangle, 20 tracked",
            jackal(),
            scan(360, false),
            &crowd[..],
        ),
    ] {
        let situation = Situation {
            map_from_base: Pose::new(5.0, 1.5, 0.0),
            v_mps: 0.6,
            w_radps: 0.1,
            robot: &robot,
            corners: &corners,
            path: &path,
            path_geometry: 1,
            map: Some(MapView {
                geometry: &GEOMETRY,
                cells: &cells,
            }),
            map_cells: 1,
            obstacles,
            obstacles_age_s: 0.0,
            scan_points_in_base: &points,
            goal: &goal,
            speed_factor: 1.0,
            period_s: 0.02,
        };
        let mut controller = Mppi::new(
            DwaConfig::default(),
            DwaTConfig::default(),
            MppiConfig::default(),
        );
        assert!(controller.decide(&situation).rollouts >= 2000);
        criterion.bench_function(&format!("mppi, {name}, ready"), |bencher| {
            bencher.iter(|| controller.decide(black_box(&situation)));
        });
        let rings = [noisy(&points, 1), noisy(&points, 2)];
        let mut scans = 1;
        criterion.bench_function(&format!("mppi, {name}, new scan"), |bencher| {
            bencher.iter(|| {
                scans += 1;
                let changed = scans % 2;
                let situation = Situation {
                    map: Some(MapView {
                        geometry: &GEOMETRY,
                        cells: if changed == 0 { &cells } else { &others },
                    }),
                    map_cells: scans,
                    scan_points_in_base: if changed == 0 { &rings[0] } else { &rings[1] },
                    ..situation
                };
                controller.decide(black_box(&situation))
            });
        });
    }
}

criterion_group!(benches, cycle);
criterion_main!(benches);
