//! The current goal. The local planner carries a task out and publishes how far it has come with
//! it; the others read both.

use crate::error::StartError;
use crate::input::Input;
use crate::peer::Peer;
use crate::reader::Stream;
use crate::roster::Roster;
use crate::tasks::Tasks;
use zeronav_msgs::header::Id;
use zeronav_msgs::task::{Goal, TaskKind, TaskState as State};
use zeronav_msgs::topics::TaskState;

/// Reads `task/goal` and `task/status`.
#[derive(Debug)]
pub struct CurrentGoal {
    tasks: Tasks,
    status: Stream<TaskState>,
    /// The last two, the newer one last.
    statuses: [Status; 2],
    /// Statuses of earlier ticks than this count.
    before_tick: u64,
}

/// What counts of a message of `task/status`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Status {
    tick: u64,
    task: u64,
    goal: u64,
    state: u16,
}

impl CurrentGoal {
    /// Opens both topics.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            tasks: Tasks::open(peer)?,
            status: peer.stream()?,
            statuses: [Status::default(); 2],
            before_tick: u64::MAX,
        })
    }

    /// Takes in what has come; true when there is a new task, or another goal or state of it.
    pub fn poll(&mut self, roster: &Roster) -> bool {
        let mut news = self.tasks.poll(roster);
        let statuses = &mut self.statuses;
        self.status.drain(roster, |view| {
            let (before, meta) = (statuses[1], view.meta);
            let newest = Status {
                tick: view.header.tick,
                task: meta.task,
                goal: meta.goal,
                state: meta.state,
            };
            let changed = Status {
                tick: before.tick,
                ..newest
            };
            news |= changed != before;
            *statuses = [before, newest];
        });
        news
    }

    /// Takes the task that holds at `tick`; none holds at the idle output, tick 0. In lockstep a
    /// status counts from the tick after its own on, so that it does not matter which of the two
    /// processes is faster.
    pub fn advance(&mut self, roster: &Roster, tick: u64) {
        if tick == 0 {
            return;
        }
        self.tasks.at(tick);
        self.before_tick = if roster.lockstep() { tick } else { u64::MAX };
    }

    /// The goal; `None` without a task, or when it is over.
    #[must_use]
    pub fn goal(&self) -> Option<Goal> {
        let task = self.tasks.current()?;
        let counts = |status: &&Status| status.task == task.id.0 && status.tick < self.before_tick;
        let status = self.statuses.iter().rev().find(counts);
        let over = status.is_some_and(|status| {
            !matches!(
                State::from_code(status.state),
                Some(State::Idle | State::Active)
            )
        });
        if over || task.kind != TaskKind::Go {
            return None;
        }
        let current = status.map_or(0, |status| status.goal);
        let named = task.goals.iter().find(|goal| goal.id == current);
        named.or(task.goals.first()).copied()
    }

    /// Identity of the task that holds; [`Id::NONE`] before the first.
    #[must_use]
    pub fn task(&self) -> Id {
        self.tasks.current().map_or(Id::NONE, |task| task.id)
    }

    /// True when a task has come that [`Self::poll`] has not taken in yet.
    #[must_use]
    pub fn waits(&self) -> bool {
        self.tasks.waits()
    }
}

impl Input for CurrentGoal {
    fn refused(&self) -> u64 {
        self.tasks.refused() + self.status.refused()
    }
}
