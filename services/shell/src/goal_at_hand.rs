//! Which goal of the task is at hand. The local planner carries a task out and says how far it has
//! come with it; everybody else reads both.

use crate::error::StartError;
use crate::peer::Peer;
use crate::reader::Latest;
use crate::roster::Roster;
use crate::tasks::Tasks;
use zeronav_msgs::header::Id;
use zeronav_msgs::task::{Goal, TaskKind, TaskState as State};
use zeronav_msgs::topics::TaskState;

/// Reads `task/goal` and `task/status`.
#[derive(Debug)]
pub struct GoalAtHand {
    tasks: Tasks,
    status: Latest<TaskState>,
    /// Task, goal at hand and state, as they were said last.
    said: Option<(u64, u64, u16)>,
}

impl GoalAtHand {
    /// Opens both topics.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            tasks: Tasks::open(peer)?,
            status: peer.latest()?,
            said: None,
        })
    }

    /// Takes in what has come; true when there is a new task, or another goal or state of it.
    pub fn poll(&mut self, roster: &Roster) -> bool {
        let new_task = self.tasks.poll(roster);
        self.status.poll(roster);
        let said = self
            .status
            .get()
            .map(|view| (view.meta.task, view.meta.goal, view.meta.state));
        let elsewhere = said != self.said;
        self.said = said;
        new_task || elsewhere
    }

    /// Lets the task hold that holds at `tick`.
    pub fn advance(&mut self, tick: u64) {
        self.tasks.at(tick);
    }

    /// Where to; `None` without a task, or when it is over.
    #[must_use]
    pub fn goal(&self) -> Option<Goal> {
        let task = self.tasks.current()?;
        let status = self
            .status
            .get()
            .map(|view| view.meta)
            .filter(|status| status.task == task.id.0);
        let over = status
            .is_some_and(|status| !matches!(status.state(), Some(State::Idle | State::Active)));
        if over || task.kind != TaskKind::Go {
            return None;
        }
        let at_hand = status.map_or(0, |status| status.goal);
        let named = task.goals.iter().find(|goal| goal.id == at_hand);
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

    /// Messages that were refused.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.tasks.refused() + self.status.refused()
    }
}
