use super::task_tests::over;
use super::*;
use crate::why::around::Missing;
use zeronav_measure::result::moment::{Blocked, Obstacle};
use zeronav_msgs::command::{PlannerInput, RecoveryReason};
use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::path::{PathBlock, PathCause};
use zeronav_msgs::task::{EndReason, StuckCause};

fn request(validity: Validity, cause: RequestCause) -> Request {
    Request {
        v_mps: 0.8,
        w_radps: 0.0,
        validity,
        cause,
        input: PlannerInput::None,
        recovery: RecoveryReason::None,
        limit_mps: 0.5,
        blocked_arc_m: 0.0,
        ages_ms: [2, 45, 60, 80],
        obstacle: None,
    }
}

fn command(v_mps: f64, intervention: Intervention) -> Command {
    Command {
        v_mps,
        w_radps: 0.0,
        validity: Validity::Drive,
        intervention,
        point: None,
    }
}

pub(super) fn path(status: PathStatus) -> Path {
    Path {
        planner: "mpgaa".to_owned(),
        status,
        cause: PathCause::Goal,
        time_s: Some(0.1),
        length_m: 25.4,
        beside_goal_m: 0.0,
        block: PathBlock::None,
        block_m: [0.0; 2],
        source: ObstacleSource::None,
    }
}

fn driving() -> Moment {
    Moment {
        time_s: 12.3,
        request: Some(request(Validity::Drive, RequestCause::Free)),
        command: Some(command(0.8, Intervention::None)),
        path: Some(path(PathStatus::Found)),
        task: None,
        zone: None,
    }
}

/// The same with another word of the local planner, standing.
pub(super) fn standing(validity: Validity, cause: RequestCause) -> Moment {
    Moment {
        request: Some(request(validity, cause)),
        command: Some(command(0.0, Intervention::None)),
        ..driving()
    }
}

#[track_caller]
pub(super) fn says(moment: &Moment, around: &Around, words: &[&str]) {
    let text = why(moment, around);
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
    assert!(!text.contains("  ") && !text.contains('\n'), "{text}");
}

#[test]
fn a_free_drive_says_which_way_and_how_old_the_inputs_are() {
    let expected = "At 12.30 s the robot drives at 0.80 m/s. Nothing limits it but its own limits. \
                    It follows a path of 25.4 m by mpgaa, made at 0.10 s because the goal was \
                    given. Ages of the inputs: odometry 2 ms, scan 45 ms, map 60 ms, path 80 ms.";
    assert_eq!(why(&driving(), &Around::default()), expected);
    let mut slow = driving();
    slow.command = Some(command(0.0, Intervention::None));
    slow.request.as_mut().expect("a request").limit_mps = 0.9;
    says(
        &slow,
        &Around::default(),
        &["stands. It speeds up to 0.90 m/s: nothing else limits it."],
    );
}

#[test]
fn a_way_around_names_the_cell_that_cut_the_one_before() {
    let mut moment = driving();
    moment.path = Some(Path {
        cause: PathCause::Obstacle,
        block: PathBlock::PathBefore,
        block_m: [9.05, 6.45],
        ..path(PathStatus::Found)
    });
    says(
        &moment,
        &Around::default(),
        &["because an obstacle at (9.05, 6.45) cut the one before"],
    );
    moment.path.as_mut().expect("a path").source = ObstacleSource::Tracked;
    says(
        &moment,
        &Around::default(),
        &["because an obstacle at (9.05, 6.45) that is tracked cut the one before"],
    );
    moment.path = Some(Path {
        beside_goal_m: 0.2,
        ..path(PathStatus::Found)
    });
    says(
        &moment,
        &Around::default(),
        &["it ends 0.20 m beside the goal"],
    );
    let path = moment.path.as_mut().expect("a path");
    (path.block, path.source) = (PathBlock::Closed, ObstacleSource::Lidar);
    (path.block_m, path.beside_goal_m) = ([9.05, 6.45], 4.0);
    says(
        &moment,
        &Around::default(),
        &[
            "it leads to where the robot sees from near whether an obstacle at (9.05, 6.45) that the lidar saw",
        ],
    );
}

#[test]
fn the_guard_names_the_point_that_slowed_or_stopped_the_robot() {
    let mut moment = driving();
    let point = Some(Point {
        beam: 181,
        at_m: [0.62, -0.1],
        clearance_m: 0.03,
    });
    moment.command = Some(Command {
        point,
        ..command(0.2, Intervention::Slowed)
    });
    let around = Around::default();
    let words = [
        "drives at 0.20 m/s.",
        "The collision guard slows down the request of 0.80 m/s and 0.00 rad/s.",
        "Beam 181 decided: its point is 0.62 m ahead and 0.10 m to the right, 0.03 m from the \
         outline on the way asked for.",
        "faster when that is farther from the way.",
    ];
    says(&moment, &around, &words);
    moment.command = Some(Command {
        point,
        ..command(0.0, Intervention::StoppedShort)
    });
    says(
        &moment,
        &around,
        &[
            "the robot stands.",
            "stops the robot",
            "Beam 181",
            "another arc",
        ],
    );
    // A guard that tells no point is none the less understood.
    moment.command = Some(command(0.0, Intervention::StoppedShort));
    says(
        &moment,
        &around,
        &["Which point of the scan decided is not told."],
    );
}

#[test]
fn an_old_input_is_named_with_its_age_and_who_must_send_it() {
    let mut moment = standing(Validity::Stale, RequestCause::Stale);
    let said = moment.request.as_mut().expect("a request");
    said.input = PlannerInput::Scan;
    said.ages_ms = [2, 360, 400, AGE_MS_MAX];
    let words = [
        "brakes because the scan is 360 ms old: the robot must send it again.",
        "path missing.",
    ];
    says(&moment, &Around::default(), &words);
    moment.command = Some(command(0.0, Intervention::ScanStale));
    says(
        &moment,
        &Around::default(),
        &["The collision guard brakes because the scan is too old"],
    );
    let mut slow = driving();
    let said = slow.request.as_mut().expect("a request");
    (said.cause, said.input) = (RequestCause::Ageing, PlannerInput::Map);
    says(
        &slow,
        &Around::default(),
        &["slows down to 0.50 m/s because the map is getting old."],
    );
}

#[test]
fn no_path_says_what_closed_it_and_what_would_have_to_open() {
    let mut moment = standing(Validity::NoPath, RequestCause::None);
    moment.path = Some(Path {
        block: PathBlock::PathBefore,
        block_m: [3.0, 4.0],
        ..path(PathStatus::Unreachable)
    });
    let words = [
        "has no path to follow and brakes: the global planner has proved that no way leads to the goal; the \
         last path was cut at (3.00, 4.00) by an obstacle, which would have to go (unreachable).",
        "The task fails when that lasts.",
    ];
    says(&moment, &Around::default(), &words);
    let statuses = [
        (
            PathStatus::StartBlocked,
            "the robot's own cell at (3.00, 4.00) is in an obstacle",
        ),
        (
            PathStatus::GoalBlocked,
            "the goal's cell at (3.00, 4.00) is in an obstacle",
        ),
        (
            PathStatus::GoalOutsideMap,
            "the goal at (3.00, 4.00) is not on the map",
        ),
        (
            PathStatus::StartOutsideMap,
            "`zeronav pose` says where it is",
        ),
        (PathStatus::OutOfBudget, "mpgaa spent its budget"),
        (PathStatus::NoGoal, "There is no goal"),
    ];
    for (status, words) in statuses {
        let said = moment.path.as_mut().expect("a path");
        (said.status, said.block) = (status, PathBlock::Goal);
        says(&moment, &Around::default(), &[words]);
    }
}

#[test]
fn the_end_of_a_task_names_the_cell_and_where_its_obstacle_comes_from() {
    let mut moment = standing(Validity::NoPath, RequestCause::None);
    let cases = [
        (
            (EndReason::Unreachable, PathBlock::Closed),
            ObstacleSource::StaticMap,
            "no way leads to the goal; the nearest way that could open is closed at (3.00, 4.00) by \
             an obstacle of the static map.",
        ),
        (
            (EndReason::Unreachable, PathBlock::PathBefore),
            ObstacleSource::Lidar,
            "the last path was cut at (3.00, 4.00) by an obstacle that the lidar saw and the static \
             map does not have, which would have to go.",
        ),
        (
            (EndReason::GoalBlocked, PathBlock::Goal),
            ObstacleSource::Tracked,
            "the goal's cell at (3.00, 4.00) is in an obstacle that is tracked, or too close to",
        ),
        (
            (EndReason::Stuck, PathBlock::Obstacle),
            ObstacleSource::Lidar,
            "no motion was admissible; in its way is an obstacle at (3.00, 4.00) that the lidar saw",
        ),
        (
            (EndReason::NoPath, PathBlock::Robot),
            ObstacleSource::None,
            "the robot's own cell at (3.00, 4.00) is in an obstacle and no free cell is near.",
        ),
        (
            (EndReason::Unreachable, PathBlock::Closed),
            ObstacleSource::Unknown,
            "closed at (3.00, 4.00) by an obstacle of cells of which nothing is known.",
        ),
    ];
    for ((reason, block), source, words) in cases {
        moment.task = Some(over(TaskState::Failed, reason, StuckCause::Blocked));
        let task = moment.task.as_mut().expect("a task");
        let at_m = [3.0, 4.0];
        task.blocked = Some(Blocked {
            block,
            at_m,
            source,
        });
        // What the end of a goal says of itself is in the sentence about the robot.
        let alone = crate::why::failure(task).expect("it has failed");
        assert!(why(&moment, &Around::default()).contains(&alone), "{alone}");
        says(&moment, &Around::default(), &[words]);
    }
}

#[test]
fn the_recovery_says_what_it_does_and_why() {
    let obstacle = Some(Obstacle {
        track: 12,
        at_m: [5.0, 3.0],
        speed_mps: 0.9,
    });
    let mut moment = standing(Validity::Blocked, RequestCause::Wait);
    let said = moment.request.as_mut().expect("a request");
    (said.recovery, said.obstacle) = (RecoveryReason::DynamicObstacle, obstacle);
    let words = [
        "waits for the way to become free because a moving obstacle is in the way.",
        "Tracked obstacle 12 is near, at (5.00, 3.00), with 0.90 m/s.",
    ];
    says(&moment, &Around::default(), &words);
    let cases = [
        (
            RequestCause::BackUp,
            RecoveryReason::Blocked,
            "drives back along the track that the robot came by because no motion was admissible.",
        ),
        (
            RequestCause::Rotate,
            RecoveryReason::TimedOut,
            "turns on the spot to look around because",
        ),
        (
            RequestCause::Manoeuvre,
            RecoveryReason::Blocked,
            "stops, searches for a manoeuvre with the true outline and drives it because no motion",
        ),
        (
            RequestCause::AskForPath,
            RecoveryReason::NoProgress,
            "has asked for another path and waits for it because the robot came no closer",
        ),
        (
            RequestCause::GiveUp,
            RecoveryReason::OutOfAttempts,
            "has nothing left to try because no attempt is left.",
        ),
    ];
    for (cause, reason, words) in cases {
        let said = moment.request.as_mut().expect("a request");
        (said.cause, said.recovery) = (cause, reason);
        says(&moment, &Around::default(), &[words]);
    }
    let mut blocked = standing(Validity::Blocked, RequestCause::Blocked);
    blocked.request.as_mut().expect("a request").blocked_arc_m = 0.7;
    says(
        &blocked,
        &Around::default(),
        &["no admissible motion", "on the path, 0.70 m ahead."],
    );
}

#[test]
fn turning_slowing_down_and_critics_are_told_apart() {
    let mut turning = standing(Validity::Drive, RequestCause::Turn);
    turning.command.as_mut().expect("a command").w_radps = -0.9;
    says(
        &turning,
        &Around::default(),
        &[
            "turns on the spot to the right at 0.90 rad/s.",
            "towards the path",
        ],
    );
    let cases = [
        (
            RequestCause::Corner,
            "for a corner of the path, to 0.50 m/s.",
        ),
        (RequestCause::Goal, "for the end of the path, to 0.50 m/s."),
        (RequestCause::Critics, "at 0.50 m/s it keeps more clearance"),
        (
            RequestCause::ClearanceCritic,
            "The clearance critic of the local planner decided: at 0.50 m/s it keeps more",
        ),
        (RequestCause::PathCritic, "The path critic"),
        (RequestCause::ProgressCritic, "The progress critic"),
        (
            RequestCause::DynamicObstacleCritic,
            "at 0.50 m/s it stays out of the way of what moves",
        ),
        (
            RequestCause::SmoothnessCritic,
            "it changes its yaw rate less.",
        ),
        (
            RequestCause::StoppingDistance,
            "at 0.50 m/s: from no faster motion could it stop in time",
        ),
        (
            RequestCause::TimedSearch,
            "among moving obstacles: going towards 0.50 m/s now costs the least",
        ),
        (
            RequestCause::Heading,
            "slows down to 0.50 m/s until it faces it.",
        ),
        (
            RequestCause::PotentialField,
            "away from where the potential field leads it: the local planner slows down to 0.50 m/s",
        ),
        (
            RequestCause::NoFit,
            "No curve that was fitted to the way is free of obstacles: the local planner goes without \
             one, at 0.50 m/s at most.",
        ),
        (
            RequestCause::Yield,
            "yields, at 0.50 m/s: a faster motion would soon touch",
        ),
        (
            RequestCause::TurnWait,
            "waits for a moving obstacle to pass",
        ),
        (
            RequestCause::SeekPose,
            "does not know where it is: it looks around",
        ),
        (RequestCause::Arrive, "slows down to a stop."),
        (RequestCause::GoalYaw, "to the goal's yaw."),
        (RequestCause::None, "it tells no more."),
    ];
    for (cause, words) in cases {
        let mut moment = driving();
        moment.request.as_mut().expect("a request").cause = cause;
        says(&moment, &Around::default(), &[words]);
    }
}

#[test]
fn pause_end_and_a_missing_service_come_before_what_the_stages_said() {
    let moment = driving();
    let paused = Around {
        paused: true,
        ..Around::default()
    };
    says(&moment, &paused, &["Run time is paused: `zeronav resume`"]);
    let stopping = Around {
        stopping: true,
        ..Around::default()
    };
    says(&moment, &stopping, &["The run is ending"]);
    let missing = Around {
        missing: vec![Missing {
            role: "local_planner".to_owned(),
            how: "was killed by signal 9 at 3.00 s and is started again".to_owned(),
        }],
        faults: vec!["kill local_planner".to_owned()],
        ..Around::default()
    };
    let mut moment = moment;
    moment.command = Some(command(0.1, Intervention::RequestStale));
    let words = [
        "The local planner was killed by signal 9 at 3.00 s and is started again.",
        "made on purpose: kill local_planner.",
        "brakes because the velocity request is too old or missing",
    ];
    says(&moment, &missing, &words);
    says(
        &Moment::default(),
        &Around::default(),
        &["has not answered yet", "asked for nothing yet"],
    );
}
