//! What is said of a task that waits, and of one that is over.

use super::tests::{path, says, standing};
use super::*;
use zeronav_measure::result::moment::Blocked;
use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::path::PathBlock;
use zeronav_msgs::task::{EndReason, StuckCause};

/// A task that is over.
pub(super) fn over(state: TaskState, reason: EndReason, stuck: StuckCause) -> Task {
    Task {
        state,
        reason,
        stuck,
        blocked: None,
        waits_s: 0,
    }
}

#[test]
fn a_wait_is_told_with_its_reason_and_what_is_left_of_it() {
    let mut moment = standing(Validity::NoPath, RequestCause::None);
    moment.path = Some(path(PathStatus::Unreachable));
    let waits = Task {
        blocked: Some(Blocked {
            block: PathBlock::Closed,
            at_m: [7.0, 4.0],
            source: ObstacleSource::Lidar,
        }),
        waits_s: 24,
        ..over(TaskState::Active, EndReason::Unreachable, StuckCause::None)
    };
    for (past_s, left) in [(0.0, "24 s more"), (9.7, "15 s more"), (60.0, "1 s more")] {
        moment.task = Some(waits.after(past_s));
        let words = [
            "The robot waits for what is in its way to go, and takes any way that opens; ",
            left,
            "no way leads to the goal; the nearest way that could open is closed at (7.00, 4.00) by an \
             obstacle that the lidar saw",
        ];
        says(&moment, &Around::default(), &words);
    }
    assert!(waits.may_open());
    // One that has waited does so no more.
    moment.task = Some(Task {
        waits_s: 0,
        ..waits
    });
    says(&moment, &Around::default(), &["has no path to follow"]);
    let wall = Blocked {
        block: PathBlock::Closed,
        at_m: [7.0, 4.0],
        source: ObstacleSource::StaticMap,
    };
    let shut = Task {
        blocked: Some(wall),
        ..waits
    };
    assert!(!shut.may_open());
}

/// Whatever the local planner asks for meanwhile.
#[test]
fn a_goal_that_waits_for_its_robot_to_know_where_it_is_says_so() {
    for validity in [Validity::AtGoal, Validity::NoPath, Validity::Blocked] {
        let mut moment = standing(validity, RequestCause::None);
        moment.path = Some(path(PathStatus::StartBlocked));
        moment.task = Some(Task {
            waits_s: 7,
            ..over(TaskState::Active, EndReason::PoseUnknown, StuckCause::None)
        });
        let words = [
            "nothing that it sees has confirmed where it was told to be; 7 s more, then the goal fails",
        ];
        says(&moment, &Around::default(), &words);
    }
}

#[test]
fn the_end_of_a_task_is_told_with_its_reason() {
    let mut moment = standing(Validity::NoPath, RequestCause::None);
    // The planner forgets its plan with the goal; the outcome stays.
    moment.path = Some(path(PathStatus::NoGoal));
    let failed = |reason| over(TaskState::Failed, reason, StuckCause::None);
    let stuck = |cause| over(TaskState::Failed, EndReason::Stuck, cause);
    let cases = [
        (
            failed(EndReason::Unreachable),
            "The task has failed: the global planner has proved that no way leads to the goal. \
             Another",
        ),
        (
            failed(EndReason::GoalBlocked),
            "the goal's cell is in an obstacle",
        ),
        (
            failed(EndReason::GoalOutsideMap),
            "the goal is not on the map",
        ),
        (failed(EndReason::NoPath), "had no path for too long."),
        (
            failed(EndReason::PoseUnknown),
            "`zeronav pose` says where it is. Another",
        ),
        (
            stuck(StuckCause::Blocked),
            "got stuck, because no motion was admissible.",
        ),
        (stuck(StuckCause::NoProgress), "came no closer to its goal."),
        (
            over(TaskState::Cancelled, EndReason::None, StuckCause::None),
            "The task was cancelled.",
        ),
        (
            over(TaskState::Reached, EndReason::None, StuckCause::None),
            "The robot has arrived",
        ),
    ];
    for (task, words) in cases {
        moment.task = Some(task);
        says(&moment, &Around::default(), &[words]);
    }
    let arrived = standing(Validity::AtGoal, RequestCause::None);
    says(
        &arrived,
        &Around::default(),
        &["The robot has arrived: it is within the goal's tolerance."],
    );
}
