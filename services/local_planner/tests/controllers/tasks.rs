//! The task machine: what becomes of goals.

use zeronav_local_planner::task::{Planned, TaskConfig, TaskInputs, TaskMachine, TaskStep};
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::task::{EndReason, Goal, GoalEnd, Task, TaskKind, TaskState, TaskStatus};

const PERIOD_NS: u64 = 20_000_000;

/// A message about the path to a goal, of which nobody says what is in the way.
#[allow(clippy::unnecessary_wraps, reason = "as the inputs take it")]
pub(crate) fn planned(status: PathStatus, goal: u64) -> Option<Planned> {
    Some(blocked(status, goal, ObstacleSource::None))
}

pub(crate) fn blocked(status: PathStatus, goal: u64, source: ObstacleSource) -> Planned {
    Planned {
        status,
        goal,
        source,
    }
}

pub(crate) fn goal(id: u64, x_m: f64) -> Goal {
    Goal {
        pose: Pose::new(x_m, 0.0, 1.0),
        tolerance_m: 0.2,
        yaw_tolerance_rad: 4.0,
        id,
    }
}

fn task(kind: TaskKind, n_goals: u32, from_tick: u64) -> Task {
    Task {
        kind: kind.code(),
        spare: 0,
        n_goals,
        from_tick,
    }
}

/// A machine and its time.
#[derive(Clone)]
#[allow(clippy::struct_excessive_bools, reason = "independent observations")]
pub(crate) struct Bench {
    pub(crate) machine: TaskMachine,
    pub(crate) tick: u64,
    pub(crate) pose: Pose,
    pub(crate) twist: Twist,
    pub(crate) path: Option<Planned>,
    pub(crate) remaining: Option<(f64, u64)>,
    pub(crate) moves_at_goal: bool,
    pub(crate) turns: bool,
    pub(crate) given_up: bool,
    pub(crate) seeks_pose: bool,
    pub(crate) certainty: PoseCertainty,
}

impl Bench {
    pub(crate) fn with_goals(goals: &[Goal]) -> Self {
        let mut machine = TaskMachine::new(TaskConfig::default());
        let n = u32::try_from(goals.len()).expect("few goals");
        machine.accept(7, &task(TaskKind::Go, n, 0), goals);
        Self {
            machine,
            tick: 0,
            pose: Pose::default(),
            twist: Twist::REST,
            path: None,
            remaining: None,
            moves_at_goal: false,
            turns: false,
            given_up: false,
            seeks_pose: false,
            certainty: PoseCertainty::Confirmed,
        }
    }

    pub(crate) fn step(&mut self) -> TaskStep {
        self.tick += 1;
        let inputs = TaskInputs {
            tick: self.tick,
            run_ns: self.tick * PERIOD_NS,
            robot: Some((self.pose, self.twist)),
            path: self.path,
            remaining: self.remaining,
            turns: self.turns,
            certainty: self.certainty,
            given_up: self.given_up,
            seeks_pose: self.seeks_pose,
            moves_at_goal: self.moves_at_goal,
        };
        self.machine.step(&inputs)
    }

    /// Steps for a while; how often the status changed.
    pub(crate) fn steps(&mut self, n: u32) -> u32 {
        (0..n).map(|_| u32::from(self.step().changed)).sum()
    }

    #[track_caller]
    fn check(&self, state: TaskState, reason: EndReason, ended: &[(u64, TaskState)]) {
        let (status, ends) = self.machine.status();
        assert_eq!(status.check(ends), Ok(()));
        assert_eq!(status.state(), Some(state));
        assert_eq!(status.reason(), Some(reason));
        let found: Vec<(u64, u16)> = ends.iter().map(|end| (end.goal, end.state)).collect();
        let expected: Vec<(u64, u16)> = ended.iter().map(|(g, s)| (*g, s.code())).collect();
        assert_eq!(found, expected);
    }
}

#[test]
fn goals_are_taken_in_order_and_the_last_one_standing() {
    let mut bench = Bench::with_goals(&[goal(1, 1.0), goal(2, 2.0)]);
    assert!(bench.step().changed);
    bench.check(TaskState::Active, EndReason::None, &[]);
    bench.twist = Twist::new(0.8, 0.0);
    bench.pose = Pose::new(0.85, 0.0, 0.0);
    assert!(bench.step().changed, "passing is enough on the way");
    bench.check(
        TaskState::Active,
        EndReason::None,
        &[(1, TaskState::Reached)],
    );
    bench.pose = Pose::new(1.9, 0.0, 0.0);
    assert!(!bench.step().changed, "still driving");
    bench.twist = Twist::new(0.01, 0.0);
    assert!(bench.step().changed);
    let ends = [(1, TaskState::Reached), (2, TaskState::Reached)];
    bench.check(TaskState::Reached, EndReason::None, &ends);
    assert_eq!(bench.machine.status().0.goal, 0);
    assert_eq!(bench.steps(500), 0, "the end is the end");
}

/// A robot that does not know where it is has not arrived, whatever its pose says, and is not shut in;
/// it waits as long as it does for progress.
#[test]
fn a_robot_that_does_not_know_where_it_is_has_not_arrived() {
    for path in [PathStatus::Found, PathStatus::Unreachable] {
        let mut bench = Bench::with_goals(&[goal(1, 0.0)]);
        bench.certainty = PoseCertainty::Unknown;
        bench.path = planned(path, 1);
        bench.steps(29 * 50);
        bench.check(TaskState::Active, EndReason::None, &[]);
        let mut found_again = Bench {
            machine: bench.machine.clone(),
            certainty: PoseCertainty::Confirmed,
            ..Bench::with_goals(&[goal(1, 0.0)])
        };
        found_again.tick = bench.tick;
        found_again.step();
        let reached = [(1, TaskState::Reached)];
        found_again.check(TaskState::Reached, EndReason::None, &reached);
        bench.steps(2 * 50);
        let failed = [(1, TaskState::Failed)];
        bench.check(TaskState::Failed, EndReason::PoseUnknown, &failed);
    }
}

/// It drives to look around, and its meaningless pose comes closer all the time.
#[test]
fn a_pose_that_means_nothing_is_no_progress() {
    let mut bench = Bench::with_goals(&[goal(1, 100.0)]);
    bench.certainty = PoseCertainty::Unknown;
    let step = |bench: &mut Bench| {
        bench.pose.x_m += 0.01;
        bench.step();
    };
    let drive = |bench: &mut Bench, n: u32| (0..n).for_each(|_| step(bench));
    drive(&mut bench, 29 * 50);
    bench.check(TaskState::Active, EndReason::None, &[]);
    // Who has found itself has all its time again.
    let mut found = bench.clone();
    found.certainty = PoseCertainty::Confirmed;
    found.path = planned(PathStatus::Found, 1);
    found.remaining = Some((120.0, 3));
    found.steps(29 * 50);
    found.check(TaskState::Active, EndReason::None, &[]);
    drive(&mut bench, 2 * 50);
    let failed = [(1, TaskState::Failed)];
    bench.check(TaskState::Failed, EndReason::PoseUnknown, &failed);
}

/// Nothing that the robot sees has confirmed where it was told to be: no goal ends by that pose, but none waits for ever.
#[test]
fn a_goal_waits_while_nothing_confirms_where_the_robot_is() {
    let cases = [
        (
            PathStatus::Found,
            0.0,
            false,
            TaskState::Reached,
            EndReason::None,
        ),
        (
            PathStatus::StartBlocked,
            5.0,
            false,
            TaskState::Failed,
            EndReason::NoPath,
        ),
        (
            PathStatus::Unreachable,
            5.0,
            false,
            TaskState::Failed,
            EndReason::Unreachable,
        ),
        (
            PathStatus::Found,
            5.0,
            true,
            TaskState::Failed,
            EndReason::Stuck,
        ),
    ];
    for (path, at_m, given_up, state, reason) in cases {
        let mut bench = Bench::with_goals(&[goal(1, at_m)]);
        bench.certainty = PoseCertainty::Unconfirmed;
        bench.path = planned(path, 1);
        bench.given_up = given_up;
        bench.steps(9 * 50);
        bench.check(TaskState::Active, EndReason::PoseUnknown, &[]);
        let left_s = bench.machine.status().0.waits_s;
        assert!((1..=3).contains(&left_s), "{path:?}: {left_s} s");
        let mut confirmed = bench.clone();
        confirmed.certainty = PoseCertainty::Confirmed;
        confirmed.step();
        confirmed.check(state, reason, &[(1, state)]);
        // It is noticed that the robot is elsewhere.
        let mut lost = bench.clone();
        lost.certainty = PoseCertainty::Unknown;
        lost.steps(15 * 50);
        lost.check(TaskState::Active, EndReason::None, &[]);
        bench.steps(3 * 50);
        let failed = [(1, TaskState::Failed)];
        bench.check(TaskState::Failed, EndReason::PoseUnknown, &failed);
    }
}

#[test]
fn a_yaw_counts_where_it_is_asked_for() {
    let aligned = Goal {
        yaw_tolerance_rad: 0.1,
        ..goal(1, 0.0)
    };
    let mut bench = Bench::with_goals(&[aligned]);
    bench.steps(10);
    bench.check(TaskState::Active, EndReason::None, &[]);
    bench.pose = Pose::new(0.0, 0.1, 1.05 - core::f64::consts::TAU);
    bench.step();
    bench.check(
        TaskState::Reached,
        EndReason::None,
        &[(1, TaskState::Reached)],
    );
}

#[test]
fn a_failure_must_last_while_the_robot_stands() {
    for (status, reason) in [
        (PathStatus::Unreachable, EndReason::Unreachable),
        (PathStatus::UnreachableCorner, EndReason::Unreachable),
        (PathStatus::GoalBlocked, EndReason::GoalBlocked),
        (PathStatus::GoalOutsideMap, EndReason::GoalOutsideMap),
        (PathStatus::StartBlocked, EndReason::NoPath),
        (PathStatus::OutOfBudget, EndReason::NoPath),
    ] {
        let mut bench = Bench::with_goals(&[goal(1, 5.0)]);
        bench.path = planned(status, 1);
        bench.twist = Twist::new(0.5, 0.0);
        bench.steps(100);
        bench.check(TaskState::Active, EndReason::None, &[]);
        bench.twist = Twist::REST;
        bench.steps(45);
        bench.path = planned(PathStatus::NoGoal, 1);
        bench.step();
        bench.path = planned(status, 1);
        bench.steps(45);
        bench.check(TaskState::Active, EndReason::None, &[]);
        bench.steps(6);
        bench.check(TaskState::Failed, reason, &[(1, TaskState::Failed)]);
    }
}

#[test]
fn a_failure_for_another_goal_is_not_ours() {
    let mut bench = Bench::with_goals(&[goal(1, 5.0)]);
    bench.path = planned(PathStatus::Unreachable, 99);
    bench.steps(200);
    bench.check(TaskState::Active, EndReason::None, &[]);
}

#[test]
fn no_progress_asks_first_and_fails_later() {
    let mut bench = Bench::with_goals(&[goal(1, 5.0), goal(2, 9.0)]);
    bench.remaining = Some((5.0, 1));
    let asked = (0..1400).position(|_| bench.step().no_progress);
    assert!(
        asked.is_some_and(|at| (500..=502).contains(&at)),
        "{asked:?}"
    );
    bench.check(TaskState::Active, EndReason::None, &[]);
    bench.remaining = Some((4.8, 1));
    assert!(!bench.step().no_progress);
    bench.steps(1600);
    bench.check(
        TaskState::Failed,
        EndReason::Stuck,
        &[(1, TaskState::Failed)],
    );
}

#[test]
fn a_task_waits_for_its_tick_and_replaces_the_one_before() {
    let mut bench = Bench::with_goals(&[goal(1, 5.0)]);
    bench.step();
    let next = task(TaskKind::Go, 1, 10);
    bench.machine.accept(8, &next, &[goal(2, 6.0)]);
    bench.machine.accept(8, &next, &[goal(3, 6.0)]);
    bench.machine.accept(6, &next, &[goal(4, 6.0)]);
    bench.steps(8);
    assert_eq!(bench.machine.goal().map(|goal| goal.id), Some(1));
    assert!(bench.step().changed);
    bench.check(
        TaskState::Cancelled,
        EndReason::Replaced,
        &[(1, TaskState::Cancelled)],
    );
    assert!(bench.step().changed);
    bench.check(TaskState::Active, EndReason::None, &[]);
    let (status, _) = bench.machine.status();
    assert_eq!((status.task, status.goal), (8, 2));
    assert_eq!(bench.steps(10), 0);
}

#[test]
fn a_cancel_ends_the_goal_at_hand() {
    let mut bench = Bench::with_goals(&[goal(1, 5.0), goal(2, 6.0)]);
    bench.step();
    bench.machine.accept(8, &task(TaskKind::Cancel, 0, 0), &[]);
    assert!(bench.step().changed);
    bench.check(
        TaskState::Cancelled,
        EndReason::None,
        &[(1, TaskState::Cancelled)],
    );
    assert_eq!(bench.machine.goal(), None);
    assert_eq!(bench.machine.status().0.task, 8);
    assert_eq!(bench.steps(10), 0);
    bench
        .machine
        .accept(9, &task(TaskKind::Go, 1, 0), &[goal(3, 1.0)]);
    assert!(bench.step().changed);
    bench.check(TaskState::Active, EndReason::None, &[]);
}

#[test]
fn an_outcome_stays_until_the_next_goal() {
    let mut bench = Bench::with_goals(&[goal(1, 5.0)]);
    bench.step();
    bench.remaining = None;
    bench.path = planned(PathStatus::Unreachable, 1);
    bench.steps(100);
    let ends = [(1, TaskState::Failed)];
    bench.check(TaskState::Failed, EndReason::Unreachable, &ends);
    // launch cancels after every end; that is no outcome.
    bench.machine.accept(8, &task(TaskKind::Cancel, 0, 0), &[]);
    assert!(bench.step().changed);
    bench.check(TaskState::Failed, EndReason::Unreachable, &ends);
    assert_eq!(bench.machine.subject(), 7);
    let (status, told) = bench.machine.status();
    assert_eq!(status.task, 8);
    let told = told.to_vec();
    // A newcomer that has heard of the cancel alone takes the outcome over from its predecessor.
    let machine = TaskMachine::new(TaskConfig::default());
    let mut newcomer = Bench { machine, ..bench };
    newcomer
        .machine
        .accept(8, &task(TaskKind::Cancel, 0, 0), &[]);
    newcomer.step();
    newcomer.machine.follow(&status, &told);
    newcomer.check(TaskState::Failed, EndReason::Unreachable, &ends);
}

#[test]
fn without_a_pose_nothing_is_judged() {
    let mut machine = TaskMachine::new(TaskConfig::default());
    machine.accept(1, &task(TaskKind::Go, 1, 0), &[goal(1, 0.0)]);
    for tick in 1..3000 {
        machine.step(&TaskInputs {
            tick,
            run_ns: tick * PERIOD_NS,
            robot: None,
            path: planned(PathStatus::Unreachable, 1),
            remaining: None,
            turns: false,
            certainty: PoseCertainty::Confirmed,
            given_up: false,
            seeks_pose: false,
            moves_at_goal: false,
        });
    }
    assert_eq!(machine.state(), TaskState::Active);
}

#[test]
fn a_task_that_was_given_up_fails_as_stuck() {
    let mut bench = Bench::with_goals(&[goal(1, 5.0)]);
    (bench.path, bench.remaining) = (planned(PathStatus::Found, 1), Some((5.0, 1)));
    assert_eq!(bench.steps(2), 1);
    assert_eq!(bench.machine.state(), TaskState::Active);
    bench.given_up = true;
    let step = bench.step();
    assert!(step.changed && step.stuck);
    assert_eq!(bench.machine.status().0.reason(), Some(EndReason::Stuck));
}

#[test]
fn a_task_goes_on_from_where_the_obeyed_planner_has_come_to() {
    let mut bench = Bench::with_goals(&[goal(1, 5.0), goal(2, 9.0)]);
    bench.step();
    let end = |goal| GoalEnd {
        goal,
        tick: 3,
        state: TaskState::Reached.code(),
        ..GoalEnd::default()
    };
    let status = |task, goal, n_ended| TaskStatus {
        state: TaskState::Active.code(),
        task,
        goal,
        n_ended,
        ..TaskStatus::default()
    };
    // Another task, goals out of order, more ends than goals: nothing changes.
    let many: Vec<GoalEnd> = (0..64).map(|_| end(1)).collect();
    bench.machine.follow(&status(8, 2, 1), &[end(1)]);
    bench.machine.follow(&status(7, 2, 1), &[end(2)]);
    bench.machine.follow(&status(7, 2, 64), &many);
    bench.machine.follow(&status(7, 1, 1), &[end(1)]);
    assert_eq!(bench.machine.goal().map(|goal| goal.id), Some(1));
    assert!(bench.machine.status().1.is_empty());
    let waiting = TaskStatus {
        reason: EndReason::Unreachable.code(),
        waits_s: 12,
        ..status(7, 2, 1)
    };
    bench.machine.follow(&waiting, &[end(1)]);
    assert_eq!(bench.machine.goal().map(|goal| goal.id), Some(2));
    let reason = bench.machine.status().0.reason();
    assert_eq!(reason, Some(EndReason::None), "its own wait is another");
    let (own, ends) = bench.machine.status();
    assert_eq!((own.n_ended, ends), (1, &[end(1)][..]));
    assert!(own.check(ends).is_ok());
}

/// It takes the seat over after half a minute, in which it has seen nothing of the goal.
#[test]
fn what_a_process_did_not_see_counts_neither_as_no_progress_nor_as_stuck() {
    let mut bench = Bench::with_goals(&[goal(1, 5.0), goal(2, 9.0)]);
    bench.tick = 2000;
    bench.remaining = Some((4.0, 1));
    bench.step();
    let status = TaskStatus {
        state: TaskState::Active.code(),
        task: 7,
        goal: 2,
        n_ended: 1,
        ..TaskStatus::default()
    };
    let end = GoalEnd {
        goal: 1,
        tick: 3,
        state: TaskState::Reached.code(),
        ..GoalEnd::default()
    };
    bench.machine.follow(&status, &[end]);
    let step = bench.step();
    assert!(!step.no_progress && !step.stuck, "{step:?}");
    assert_eq!(bench.machine.state(), TaskState::Active);
    // From then on it counts.
    let periods = (1..=600)
        .map(|_| bench.step())
        .filter(|step| step.no_progress);
    assert!((80..=110).contains(&periods.count()), "12 s less 10 s");
}
