//! The current goal, as the task and what the local planner says of it make it.

use super::support::House;
use zeronav_msgs::header::Id;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunMode, Seat};
use zeronav_msgs::task::{Goal, Task, TaskKind, TaskState as State, TaskStatus};
use zeronav_msgs::topics::{TaskGoal, TaskState};
use zeronav_shell::{CurrentGoal, Draft, Input, Roster, Writer};

/// A reader of the goal, and those who write it.
struct Bench {
    tasks: Writer<TaskGoal>,
    statuses: Writer<TaskState>,
    goal: CurrentGoal,
    roster: Roster,
}

impl Bench {
    fn new(house: &House, mode: RunMode) -> Self {
        let tasks = house.join(Role::Launch, 2).writer(8).expect("a writer");
        let statuses = house.join(Role::LocalPlanner, 1).writer(8);
        let seat = Seat {
            role: Role::LocalPlanner.code(),
            epoch: 1,
            ..Seat::default()
        };
        let planner = house.join(Role::GlobalPlanner, 1);
        Self {
            tasks,
            statuses: statuses.expect("a writer"),
            goal: CurrentGoal::open(&planner).expect("a reader"),
            roster: Roster {
                clock: RunClock {
                    mode: mode.code(),
                    ..RunClock::default()
                },
                seats: vec![seat],
                ..Roster::default()
            },
        }
    }

    /// Sends a task with these goals from this tick on.
    fn task(&mut self, kind: TaskKind, from_tick: u64, ids: &[u64]) -> u64 {
        let goals: Vec<Goal> = ids
            .iter()
            .map(|id| Goal {
                tolerance_m: 0.1,
                yaw_tolerance_rad: 0.1,
                id: *id,
                ..Goal::default()
            })
            .collect();
        let task = Task {
            kind: kind.code(),
            n_goals: u32::try_from(ids.len()).expect("a few"),
            from_tick,
            ..Task::default()
        };
        let sent = self.tasks.publish(&Draft::default(), task, &goals);
        sent.expect("sent").id.0
    }

    /// The local planner says at `tick` how far it has come.
    fn status(&mut self, tick: u64, task: u64, goal: u64, state: State) {
        let draft = Draft {
            tick,
            ..Draft::default()
        };
        let status = TaskStatus {
            state: state.code(),
            task,
            goal,
            ..TaskStatus::default()
        };
        self.statuses.publish(&draft, status, &[]).expect("sent");
    }

    fn poll(&mut self) -> bool {
        self.goal.poll(&self.roster)
    }

    /// The goal's id at `tick`.
    fn at(&mut self, tick: u64) -> Option<u64> {
        self.goal.advance(&self.roster, tick);
        self.goal.goal().map(|goal| goal.id)
    }
}

#[test]
fn the_goal_is_the_first_until_the_local_planner_names_another_or_ends_the_task() {
    let house = House::new();
    let mut bench = Bench::new(&house, RunMode::RealTime);
    assert!(!bench.poll() && bench.at(1).is_none());
    assert_eq!(bench.goal.task(), Id::NONE);
    let task = bench.task(TaskKind::Go, 0, &[11, 12]);
    assert!(bench.goal.waits());
    assert!(bench.poll() && !bench.goal.waits());
    assert_eq!(bench.at(0), None, "the idle output has no task");
    assert_eq!(bench.at(1), Some(11));
    assert_eq!(bench.goal.task(), Id(task));
    bench.status(1, task, 12, State::Active);
    assert!(bench.poll());
    assert_eq!(bench.at(2), Some(12));
    // The same again is no news, another state is.
    bench.status(2, task, 12, State::Active);
    assert!(!bench.poll());
    bench.status(3, task, 12, State::Reached);
    assert!(bench.poll());
    assert_eq!(bench.at(3), None, "over");
    // What was said of another task does not end this one.
    let next = bench.task(TaskKind::Go, 0, &[21]);
    assert!(bench.poll());
    assert_eq!(bench.at(4), Some(21));
    bench.status(4, next, 99, State::Idle);
    assert!(bench.poll());
    assert_eq!(bench.at(5), Some(21), "a goal that the task does not have");
    bench.task(TaskKind::Cancel, 0, &[]);
    assert!(bench.poll());
    assert_eq!(bench.at(6), None);
    assert_eq!(bench.goal.refused(), 0);
}

#[test]
fn in_lockstep_a_status_counts_from_the_tick_after_its_own() {
    for (mode, at_once) in [(RunMode::Lockstep, 11), (RunMode::RealTime, 12)] {
        let house = House::new();
        let mut bench = Bench::new(&house, mode);
        let task = bench.task(TaskKind::Go, 3, &[11, 12]);
        assert!(bench.poll());
        assert_eq!(bench.at(2), None, "it holds from tick 3 on");
        assert_eq!(bench.at(3), Some(11));
        bench.status(4, task, 12, State::Active);
        assert!(bench.poll());
        assert_eq!(bench.at(4), Some(at_once));
        assert_eq!(bench.at(5), Some(12));
    }
}

#[test]
fn messages_that_are_refused_are_counted() {
    let house = House::new();
    let mut bench = Bench::new(&house, RunMode::RealTime);
    let task = bench.task(TaskKind::Go, 0, &[0]);
    bench.status(1, task, 1, State::Active);
    bench.statuses.publish(
        &Draft::default(),
        TaskStatus {
            state: 99,
            ..TaskStatus::default()
        },
        &[],
    );
    bench.poll();
    assert_eq!(bench.goal.refused(), 2);
    let none: Option<CurrentGoal> = None;
    assert_eq!((none.refused(), none.superseded()), (0, 0));
    let some = Some(bench.goal);
    assert_eq!((some.refused(), some.superseded()), (2, 0));
}
