//! The run, its tasks, and what the simulator says.

use crate::{PLACE, SPEED, lengths, ranges};
use zeronav_msgs::Role;
use zeronav_msgs::health::Health;
use zeronav_msgs::message::Refusal;
use zeronav_msgs::run::{RunClock, RunControl, Seat, TopicFault};
use zeronav_msgs::task::{Goal, GoalEnd, PoseEstimate, Task, TaskKind, TaskStatus};
use zeronav_msgs::truth::{Placement, Placements, Truth, TruthObstacle};

fn goal() -> Goal {
    Goal {
        tolerance_m: 0.2,
        yaw_tolerance_rad: 0.2,
        id: 1,
        ..Goal::default()
    }
}

fn task(kind: TaskKind, n_goals: u32) -> Task {
    Task {
        kind: kind.code(),
        n_goals,
        ..Task::default()
    }
}

#[test]
fn tasks() {
    ranges(
        goal(),
        |goal| task(TaskKind::Go, 1).check(&[*goal]),
        &[
            ("pose", |it, value| it.pose.x_m = value, PLACE),
            (
                "tolerance_m",
                |it, value| it.tolerance_m = value,
                [1.0e-3, 1.0e3],
            ),
            (
                "yaw_tolerance_rad",
                |it, value| it.yaw_tolerance_rad = value,
                [1.0e-3, 1.0e3],
            ),
        ],
    );
    lengths(("goals", 1, 64), goal(), |n, goals| {
        task(TaskKind::Go, n).check(goals)
    });
    for kind in [TaskKind::None, TaskKind::Cancel] {
        assert_eq!(task(kind, 0).check(&[]), Ok(()), "{kind}");
        let with_a_goal = task(kind, 1).check(&[goal()]);
        assert_eq!(with_a_goal, Err(Refusal::Length("goals")), "{kind}");
    }
    let unknown = Task {
        kind: 3,
        ..Task::default()
    };
    assert_eq!(unknown.check(&[]), Err(Refusal::Code("kind")));
    let nameless = Goal { id: 0, ..goal() };
    assert_eq!(
        task(TaskKind::Go, 1).check(&[nameless]),
        Err(Refusal::OutOfRange("id"))
    );
    ranges(
        PoseEstimate::default(),
        PoseEstimate::check,
        &[
            (
                "map_from_base",
                |it, value| it.map_from_base.y_m = value,
                PLACE,
            ),
            (
                "odom_from_base",
                |it, value| it.odom_from_base.y_m = value,
                PLACE,
            ),
        ],
    );
    let certain = |certainty| {
        PoseEstimate {
            certainty,
            ..PoseEstimate::default()
        }
        .check()
    };
    let unknown = Err(Refusal::Code("certainty"));
    assert_eq!([2, 3].map(certain), [Ok(()), unknown]);
}

#[test]
fn states_of_tasks() {
    let status = TaskStatus {
        n_ended: 1,
        ..TaskStatus::default()
    };
    ranges(
        status,
        |status| status.check(&[GoalEnd::default()]),
        &[(
            "remaining_m",
            |it, value| it.remaining_m = value,
            [0.0, 1.0e9],
        )],
    );
    lengths(("ends", 0, 64), GoalEnd::default(), |n_ended, ended| {
        TaskStatus {
            n_ended,
            ..TaskStatus::default()
        }
        .check(ended)
    });
    let end = GoalEnd::default();
    for (field, status, end) in [
        ("state", TaskStatus { state: 5, ..status }, end),
        (
            "reason",
            TaskStatus {
                reason: 8,
                ..status
            },
            end,
        ),
        ("cause", TaskStatus { cause: 4, ..status }, end),
        ("end.state", status, GoalEnd { state: 5, ..end }),
        ("end.reason", status, GoalEnd { reason: 8, ..end }),
    ] {
        assert_eq!(status.check(&[end]), Err(Refusal::Code(field)));
    }
    let health = |state| {
        Health {
            state,
            ..Health::default()
        }
        .check()
    };
    assert_eq!([3, 4].map(health), [Ok(()), Err(Refusal::Code("state"))]);
}

#[test]
fn clocks() {
    let right = RunClock {
        mode: 1,
        tick_ns: 20_000_000,
        ..RunClock::default()
    };
    let ticks = |tick_ns| RunClock { tick_ns, ..right }.check();
    let wrong = Err(Refusal::OutOfRange("tick_ns"));
    assert_eq!(
        [999_999, 1_000_000, 1_000_000_000, 1_000_000_001].map(ticks),
        [wrong, Ok(()), Ok(()), wrong]
    );
    let told = |foresight| RunClock { foresight, ..right }.check();
    assert_eq!([0, 1, 2, 3].map(told), [Ok(()); 4]);
    assert_eq!(told(4), Err(Refusal::Code("foresight")));
    let unknown = RunClock { mode: 3, ..right };
    assert_eq!(unknown.check(), Err(Refusal::Code("mode")));
}

fn seat() -> Seat {
    Seat {
        role: Role::Robot.code(),
        ..Seat::default()
    }
}

#[test]
fn rosters() {
    lengths(("seats", 0, 16), seat(), |n_seats, seats| {
        RunControl {
            n_seats,
            ..RunControl::default()
        }
        .check(seats)
    });
    let of = |change: fn(&mut Seat)| {
        let mut seat = seat();
        change(&mut seat);
        RunControl {
            n_seats: 1,
            ..RunControl::default()
        }
        .check(&[seat])
    };
    let out = |field| Err(Refusal::OutOfRange(field));
    assert_eq!(of(|it| it.role = 99), Err(Refusal::Code("seat.role")));
    assert_eq!(of(|it| (it.off_tick, it.on_tick) = (4, 4)), Ok(()));
    assert_eq!(of(|it| (it.off_tick, it.on_tick) = (4, 5)), Ok(()));
    assert_eq!(
        of(|it| (it.off_tick, it.on_tick) = (5, 4)),
        out("seat.on_tick")
    );
    assert_eq!(of(|it| it.clock_offset_ms = -10_000), Ok(()));
    assert_eq!(
        of(|it| it.clock_offset_ms = 10_001),
        out("seat.clock_offset_ms")
    );
    assert_eq!(
        of(|it| it.clock_offset_ms = i32::MIN),
        out("seat.clock_offset_ms")
    );
    let flags = |paused, stopping| {
        RunControl {
            paused,
            stopping,
            ..RunControl::default()
        }
        .check(&[])
    };
    assert_eq!(flags(1, 1), Ok(()));
    assert_eq!(flags(2, 0), Err(Refusal::Code("paused")));
    assert_eq!(flags(0, 2), Err(Refusal::Code("stopping")));
    let fault = |fault: TopicFault| {
        let mut control = RunControl::default();
        control.topic_faults[3] = fault;
        control.check(&[])
    };
    let right = TopicFault {
        kind: 3,
        share: 1_000_000,
        delay_us: 10_000_000,
        ..TopicFault::default()
    };
    assert_eq!(fault(right), Ok(()));
    let kind = TopicFault { kind: 4, ..right };
    assert_eq!(fault(kind), Err(Refusal::Code("topic_fault.kind")));
    let share = TopicFault {
        share: 1_000_001,
        ..right
    };
    assert_eq!(fault(share), out("topic_fault.share"));
    let late = TopicFault {
        delay_us: 10_000_001,
        ..right
    };
    assert_eq!(fault(late), out("topic_fault.delay_us"));
}

#[test]
// long: one line for each field
fn what_the_simulator_says() {
    let truth = Truth {
        n_obstacles: 1,
        ..Truth::default()
    };
    ranges(
        (truth, TruthObstacle::default()),
        |(truth, obstacle)| truth.check(&[*obstacle]),
        &[
            ("pose", |it, value| it.0.pose.x_m = value, PLACE),
            ("v_mps", |it, value| it.0.v_mps = value, SPEED),
            ("w_radps", |it, value| it.0.w_radps = value, SPEED),
            (
                "clearance_m",
                |it, value| it.0.clearance_m = value,
                [0.0, 1.0e3],
            ),
            ("driven_m", |it, value| it.0.driven_m = value, [0.0, 1.0e6]),
            ("obstacle.pose", |it, value| it.1.pose.x_m = value, PLACE),
        ],
    );
    lengths(
        ("obstacles", 0, 256),
        TruthObstacle::default(),
        |n_obstacles, obstacles| {
            Truth {
                n_obstacles,
                ..Truth::default()
            }
            .check(obstacles)
        },
    );
    let contact = |in_contact| {
        Truth {
            in_contact,
            ..Truth::default()
        }
        .check(&[])
    };
    assert_eq!(
        [1, 2].map(contact),
        [Ok(()), Err(Refusal::Code("in_contact"))]
    );
    let index = |index| {
        truth.check(&[TruthObstacle {
            index,
            ..TruthObstacle::default()
        }])
    };
    assert_eq!(
        [255, 256].map(index),
        [Ok(()), Err(Refusal::OutOfRange("index"))]
    );
    ranges(
        Placement::default(),
        |placement| Placements { n_placements: 1 }.check(&[*placement]),
        &[
            ("pose", |it, value| it.pose.x_m = value, PLACE),
            ("size_x_m", |it, value| it.size_x_m = value, [0.0, 1.0e3]),
            ("size_y_m", |it, value| it.size_y_m = value, [0.0, 1.0e3]),
        ],
    );
    lengths(
        ("placements", 0, 256),
        Placement::default(),
        |n, placements| {
            Placements {
                n_placements: u64::from(n),
            }
            .check(placements)
        },
    );
    let index = |index| {
        let placement = Placement {
            index,
            ..Placement::default()
        };
        Placements { n_placements: 1 }.check(&[placement])
    };
    assert_eq!(
        [255, 256].map(index),
        [Ok(()), Err(Refusal::OutOfRange("index"))]
    );
}
