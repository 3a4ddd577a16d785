//! A cycle of a controller allocates nothing once it has driven for a second.

mod support;

use support::{Loop, block, disc, jackal, path};
use zeronav_local_planner::beam;
use zeronav_local_planner::beam::options::BeamConfig;
use zeronav_local_planner::dwa::options::DwaConfig;
use zeronav_local_planner::dwa_t::options::DwaTConfig;
use zeronav_local_planner::mppi;
use zeronav_local_planner::mppi::options::MppiConfig;
use zeronav_local_planner::pilot::Pilot;
use zeronav_local_planner::{dwa, dwa_t};
use zeronav_msgs::Pose;
use zeronav_msgs::obstacles::Obstacle;

#[test]
fn a_cycle_allocates_nothing() {
    let hall = [block(0.0, 0.0, 14.0, 0.4), block(0.0, 3.0, 14.0, 3.4)];
    let corners = path(&[(1.0, 1.7), (12.0, 1.7)]);
    let dwa = DwaConfig::default;
    let timed = DwaTConfig::default;
    let controllers = || -> [(Pilot, u32); 4] {
        [
            (dwa::dwa(dwa()), 800),
            (dwa_t::dwa_t(dwa(), timed()), 800),
            (mppi::mppi(dwa(), timed(), MppiConfig::default()), 2000),
            (beam::beam(dwa(), timed(), BeamConfig::default()), 2000),
        ]
    };
    let robots = [disc(0.25, 0.8, 1.0, 1.8, 3.0), jackal()];
    for (robot, is_recorded) in robots
        .iter()
        .zip([false, true])
        .chain(robots.iter().zip([true, false]))
    {
        for (mut controller, least_rollouts) in controllers() {
            controller.record(is_recorded);
            let pose = Pose::new(1.0, 1.7, 0.0);
            let mut run = Loop::new(robot.clone(), &hall, (14.0, 3.4), pose, corners.clone());
            for _ in 0..50 {
                run.step(&mut controller);
            }
            run.obstacles = vec![Obstacle {
                track: 1,
                x_m: 6.0,
                y_m: 1.5,
                vx_mps: 0.5,
                radius_m: 0.3,
                ..Obstacle::default()
            }];
            let scan = run.scan();
            let mut situation = run.situation(&scan);
            controller.decide(&situation);
            // Ready cycles, and some with changed cells.
            for cycle in 0..20 {
                situation.map_cells = 1 + cycle / 5;
                let mut rollouts = 0;
                let allocated = allocation_counter::measure(|| {
                    rollouts = controller.decide(&situation).rollouts;
                });
                assert!(rollouts >= least_rollouts);
                assert_eq!(
                    allocated.count_total, 0,
                    "cycle {cycle} of {least_rollouts}"
                );
            }
        }
    }
}
