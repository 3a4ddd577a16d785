//! One cycle of `beam` in which it searches, disc and rectangle, among 20 tracked obstacles. On the
//! robot every tenth cycle does (`replan_s`); the others cost a check of what is published. "ready"
//! is a cycle between two scans, "new scan" one with noisy points and a map some cells of which
//! changed.
//!
//! `cargo bench -p zeronav-local-planner --no-default-features --bench beam`

use criterion::{Criterion, criterion_group, criterion_main};
use zeronav_local_planner::beam::Beam;
use zeronav_local_planner::config::{BeamConfig, DwaConfig, DwaTConfig};

mod aisle;
use aisle::{Aisle, crowd, disc, jackal, scan};

fn cycle(criterion: &mut Criterion) {
    let aisle = Aisle::new();
    let crowd = crowd();
    for (name, robot) in [("disc", disc()), ("rectangle", jackal())] {
        for (often, replan_s) in [("search", 0.0), ("no search", 0.4)] {
            let points = scan(360, false);
            let situation = aisle.situation(&robot, &points, &crowd);
            let config = BeamConfig {
                replan_s,
                ..BeamConfig::default()
            };
            let mut beam = Beam::new(DwaConfig::default(), DwaTConfig::default(), config);
            let name = format!("beam, {name}, 20 tracked, {often}");
            aisle.time(criterion, &name, &mut beam, &situation, 0);
        }
    }
}

criterion_group!(benches, cycle);
criterion_main!(benches);
