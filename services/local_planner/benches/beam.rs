//! One cycle of `beam`, disc and rectangle, among 20 tracked obstacles: one that searches, and the
//! mean of ten of which one does, as on the robot (`replan_s`). "ready" is a cycle between two
//! scans, "new scan" one with noisy points and a map some cells of which changed.
//!
//! `cargo bench -p zeronav-local-planner --no-default-features --bench beam`

use criterion::{Criterion, criterion_group, criterion_main};
use zeronav_local_planner::beam;
use zeronav_local_planner::beam::options::BeamConfig;
use zeronav_local_planner::dwa::options::DwaConfig;
use zeronav_local_planner::dwa_t::options::DwaTConfig;

mod aisle;
use aisle::{Aisle, crowd, disc, jackal, scan};

fn cycle(criterion: &mut Criterion) {
    let aisle = Aisle::new();
    let crowd = crowd();
    for (name, robot) in [("disc", disc()), ("rectangle", jackal())] {
        let default = BeamConfig::default();
        let always = BeamConfig {
            replan_s: 0.0,
            ..default
        };
        for (often, config) in [("search", always), ("mean of ten", default)] {
            let points = scan(360, false);
            let situation = aisle.situation(&robot, &points, &crowd);
            let mut beam = beam::beam(DwaConfig::default(), DwaTConfig::default(), config);
            let name = format!("beam, {name}, 20 tracked, {often}");
            aisle.time(criterion, &name, &mut beam, &situation, 0);
        }
    }
}

criterion_group!(benches, cycle);
criterion_main!(benches);
