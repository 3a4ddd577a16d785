//! What a task waits for, for how long, and what counts as getting on.

use crate::tasks::{Bench, blocked, goal, planned};
use zeronav_local_planner::task::TaskConfig;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::task::{EndReason, TaskState};

/// What a task fails by, and after how long.
fn failure_after(bench: &mut Bench) -> (Option<EndReason>, f64) {
    let begun = bench.tick;
    bench.step();
    while bench.machine.state() == TaskState::Active && bench.tick < begun + 5000 {
        bench.step();
    }
    let periods = u32::try_from(bench.tick - begun).expect("few periods");
    (bench.machine.status().0.reason(), 0.02 * f64::from(periods))
}

/// Tracked, or seen by the lidar and not in the static map: it may go. A wall does not, nor does what
/// is not known.
#[test]
fn what_may_go_is_waited_for_and_a_wall_is_not() {
    use ObstacleSource::{Lidar, None, StaticMap, Tracked, Unknown};
    use PathStatus::{GoalBlocked, OutOfBudget, StartBlocked, Unreachable, UnreachableCorner};
    let TaskConfig {
        blocked_goal_s,
        failure_s,
        ..
    } = TaskConfig::default();
    for (status, reason) in [
        (Unreachable, EndReason::Unreachable),
        (UnreachableCorner, EndReason::Unreachable),
        (GoalBlocked, EndReason::GoalBlocked),
        (StartBlocked, EndReason::NoPath),
        (OutOfBudget, EndReason::NoPath),
    ] {
        for source in [Lidar, Tracked, StaticMap, Unknown, None] {
            let mut bench = Bench::with_goals(&[goal(1, 5.0)]);
            bench.path = Some(blocked(status, 1, source));
            let waits = matches!(source, Lidar | Tracked) && status != OutOfBudget;
            bench.steps(10);
            let (told, _) = bench.machine.status();
            assert_eq!(told.waits_s > 0, waits, "{status} {source}");
            let (ended, lasted_s) = failure_after(&mut bench);
            let expected_s = if waits { blocked_goal_s } else { failure_s };
            assert_eq!(ended, Some(reason), "{status} {source}");
            let off_s = lasted_s + 0.2 - expected_s;
            assert!(off_s.abs() < 0.1, "{status} {source}: {lasted_s}");
        }
    }
}

/// What came onto a way or a goal since may go as it came, whatever is said of it; so may what moves.
#[test]
fn a_way_that_was_open_is_waited_for() {
    for (status, reason) in [
        (PathStatus::GoalBlocked, EndReason::GoalBlocked),
        (PathStatus::Unreachable, EndReason::Unreachable),
    ] {
        for was_free in [true, false] {
            let mut bench = Bench::with_goals(&[goal(1, 5.0)]);
            if was_free {
                bench.path = planned(PathStatus::Found, 1);
                bench.steps(2);
            }
            bench.path = planned(status, 1);
            let (ended, lasted_s) = failure_after(&mut bench);
            assert_eq!(ended, Some(reason));
            assert_eq!(lasted_s > 29.0, was_free, "{status} {lasted_s}");
        }
    }
    let mut bench = Bench::with_goals(&[goal(1, 5.0)]);
    bench.moves_at_goal = true;
    bench.path = planned(PathStatus::GoalBlocked, 1);
    bench.steps(500);
    assert_eq!(bench.machine.state(), TaskState::Active);
    // It stays: the rest is that of a goal that was never free.
    bench.moves_at_goal = false;
    let (ended, lasted_s) = failure_after(&mut bench);
    assert!(lasted_s < 1.1, "{lasted_s}");
    assert_eq!(ended, Some(EndReason::GoalBlocked));
}

/// The wait is a sum that only coming closer ends; it is told, and no time without progress.
#[test]
fn a_wait_is_counted_down_until_the_robot_comes_closer() {
    let mut bench = Bench::with_goals(&[goal(1, 5.0)]);
    bench.remaining = Some((5.0, 1));
    bench.path = planned(PathStatus::Found, 1);
    bench.steps(2);
    let wait = |bench: &mut Bench, seconds: u32| {
        bench.remaining = None;
        bench.path = Some(blocked(PathStatus::Unreachable, 1, ObstacleSource::Lidar));
        bench.steps(50 * seconds);
        let (status, ends) = bench.machine.status();
        assert_eq!(status.check(ends), Ok(()));
        (status.state(), status.reason(), status.waits_s)
    };
    let open = |bench: &mut Bench, remaining_m: f64| {
        bench.remaining = Some((remaining_m, 1));
        bench.path = planned(PathStatus::Found, 1);
        let step = bench.step();
        assert_eq!(bench.machine.status().0.waits_s, 0);
        step
    };
    let waits = |left_s| {
        let reason = Some(EndReason::Unreachable);
        (Some(TaskState::Active), reason, left_s)
    };
    assert_eq!(wait(&mut bench, 12), waits(19));
    // A gap in which it does not get on.
    let step = open(&mut bench, 4.95);
    assert!(!step.no_progress && !step.stuck, "{step:?}");
    assert_eq!(wait(&mut bench, 12), waits(7));
    open(&mut bench, 4.95);
    open(&mut bench, 4.8);
    assert_eq!(wait(&mut bench, 12), waits(19));
    let (ended, lasted_s) = failure_after(&mut bench);
    assert_eq!(ended, Some(EndReason::Unreachable));
    assert!((17.5..18.5).contains(&lasted_s), "{lasted_s}");
    assert_eq!(bench.machine.status().0.waits_s, 0);
}

/// A turn of 180 degrees at 0.08 rad/s takes 40 s; one that never ends is no progress for ever.
#[test]
fn a_slow_turn_is_progress_and_turning_for_ever_is_not() {
    let mut bench = Bench::with_goals(&[goal(1, 5.0)]);
    bench.remaining = Some((5.0, 1));
    bench.turns = true;
    let mut turned_s = 0.0;
    bench.step();
    while bench.machine.state() == TaskState::Active && turned_s < 200.0 {
        let step = bench.step();
        turned_s += 0.02;
        bench.pose.yaw_rad = 0.08 * turned_s;
        assert!(turned_s > 78.0 || !step.no_progress, "{turned_s}");
    }
    // Once around takes 78.5 s, and then it has `stuck_s`.
    assert!((107.0..110.0).contains(&turned_s), "{turned_s}");
    let reason = bench.machine.status().0.reason();
    assert_eq!(reason, Some(EndReason::Stuck));
}

/// 20 s of `stuck_s` go by before it, 10 s after it.
#[test]
fn a_robot_that_looks_for_its_pose_is_not_stuck_by_that() {
    let mut bench = Bench::with_goals(&[goal(1, 5.0)]);
    bench.certainty = PoseCertainty::Unknown;
    bench.steps(20 * 50);
    bench.seeks_pose = true;
    assert_eq!(bench.steps(100 * 50), 0);
    bench.seeks_pose = false;
    assert_eq!(bench.steps(9 * 50), 0);
    assert_eq!(bench.steps(2 * 50), 1);
    assert_eq!(
        bench.machine.status().0.reason(),
        Some(EndReason::PoseUnknown)
    );
}
