//! One control cycle of the dynamic windows: disc and rectangle, known and unknown surroundings,
//! and of `dwa_t` with 20 tracked obstacles. "ready" is a cycle between two scans, in which map and
//! points lie where they lay; "new scan" one with noisy points and a map some cells of which changed.
//!
//! `cargo bench -p zeronav-local-planner --no-default-features`

use criterion::{Criterion, criterion_group, criterion_main};
use zeronav_local_planner::dwa::options::DwaConfig;
use zeronav_local_planner::dwa_t::options::DwaTConfig;
use zeronav_local_planner::{dwa, dwa_t};

mod aisle;
use aisle::{Aisle, crowd, disc, jackal, scan};

fn cycle(criterion: &mut Criterion) {
    let aisle = Aisle::new();
    let crowd = crowd();
    for (name, robot, points) in [
        ("disc, known aisle, 360 beams", disc(), scan(360, false)),
        (
            "disc, unknown box ahead, 360 beams",
            disc(),
            scan(360, true),
        ),
        ("disc, known aisle, 1080 beams", disc(), scan(1080, false)),
        (
            "rectangle, known aisle, 360 beams",
            jackal(),
            scan(360, false),
        ),
    ] {
        let alone = aisle.situation(&robot, &points, &[]);
        let crowded = aisle.situation(&robot, &points, &crowd);
        let mut dwa = dwa::dwa(DwaConfig::default());
        aisle.time(criterion, &format!("dwa, {name}"), &mut dwa, &alone, 800);
        let mut dwa_t = dwa_t::dwa_t(DwaConfig::default(), DwaTConfig::default());
        for (with, situation) in [("", alone), (", 20 tracked", crowded)] {
            let name = format!("dwa_t, {name}{with}");
            aisle.time(criterion, &name, &mut dwa_t, &situation, 800);
        }
    }
}

criterion_group!(benches, cycle);
criterion_main!(benches);
