//! A robot that something has shut in from behind does not back up into it.

use crate::support::whole::Whole;
use crate::support::{Loop, block, jackal, path};
use zeronav_local_planner::LocalPlannerConfig;
use zeronav_local_planner::recovery::Behaviour;
use zeronav_msgs::Pose;

/// Drives a Jackal into an aisle that ends, drops what `behind` says behind it, and waits: whether
/// it tried to back up, and how far back it came. [m]
fn at_the_end_of_an_aisle(behind: bool) -> (bool, f64) {
    let walls = [
        block(0.0, 0.0, 8.0, 0.6),
        block(0.0, 1.2, 8.0, 1.8),
        block(5.0, 0.6, 5.3, 1.2),
    ];
    let start = Pose::new(1.0, 0.9, 0.0);
    let corners = path(&[(1.0, 0.9), (7.0, 0.9)]);
    let mut run = Loop::new(jackal(), &walls, (8.0, 1.8), start, corners);
    let mut whole = Whole::new(&LocalPlannerConfig::default());
    let ends = |run: &Loop| run.twist.is_stopped() && run.pose.x_m > 4.0;
    for _ in 0..1000 {
        run.step(&mut whole);
        if ends(&run) {
            break;
        }
    }
    assert!(ends(&run), "it stands at {:?}", run.pose);
    assert!(whole.changes.iter().all(|it| it.to != Behaviour::BackUp));
    let end_m = run.pose.x_m;
    if behind {
        let back_m = end_m - 0.254 - 0.06;
        run.blocks.push(block(back_m - 0.1, 0.7, back_m, 1.1));
    }
    let mut least_m = end_m;
    for _ in 0..600 {
        run.step(&mut whole);
        least_m = least_m.min(run.pose.x_m);
    }
    assert!(run.least_m > 0.0, "touched something");
    let backed = whole.changes.iter().any(|it| it.to == Behaviour::BackUp);
    (backed, end_m - least_m)
}

#[test]
fn only_what_is_free_behind_is_backed_into() {
    let (backed, back_m) = at_the_end_of_an_aisle(false);
    assert!(backed && back_m > 0.2, "{backed} {back_m}");
    let (backed, back_m) = at_the_end_of_an_aisle(true);
    assert!(!backed && back_m < 0.06, "{backed} {back_m}");
}
