//! One cycle of `mppi`: 2000 samples of 56 steps, disc and rectangle, without and with 20 tracked
//! obstacles. "ready" is a cycle between two scans, "new scan" one with noisy points and a map some
//! cells of which changed. The time contains the 800 rollouts of `dwa_t` that seed it.
//!
//! `cargo bench -p zeronav-local-planner --no-default-features --bench mppi`

use criterion::{Criterion, criterion_group, criterion_main};
use zeronav_local_planner::dwa::options::DwaConfig;
use zeronav_local_planner::dwa_t::options::DwaTConfig;
use zeronav_local_planner::mppi;
use zeronav_local_planner::mppi::options::MppiConfig;

mod aisle;
use aisle::{Aisle, crowd, disc, jackal, scan};

fn cycle(criterion: &mut Criterion) {
    let aisle = Aisle::new();
    let crowd = crowd();
    for (name, robot, points, obstacles) in [
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
        let situation = aisle.situation(&robot, &points, obstacles);
        let mut mppi = mppi::mppi(
            DwaConfig::default(),
            DwaTConfig::default(),
            MppiConfig::default(),
        );
        aisle.time(
            criterion,
            &format!("mppi, {name}"),
            &mut mppi,
            &situation,
            2000,
        );
    }
}

criterion_group!(benches, cycle);
criterion_main!(benches);
