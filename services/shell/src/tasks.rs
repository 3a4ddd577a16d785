//! The current task. In lockstep a task holds from a named tick, so that it takes effect at the
//! same moment in every run, whenever its message came in.

use crate::error::StartError;
use crate::input::Input;
use crate::peer::Peer;
use crate::reader::Latest;
use crate::roster::Roster;
use zeronav_msgs::header::Id;
use zeronav_msgs::task::{Goal, TaskKind};
use zeronav_msgs::topics::TaskGoal;

/// A task, copied out of shared memory.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldTask {
    /// Id on `task/goal`.
    pub id: Id,
    /// What is asked.
    pub kind: TaskKind,
    /// First tick at which it holds; 0 = at once.
    pub from_tick: u64,
    /// Where to, in order.
    pub goals: Vec<Goal>,
}

/// Reads `task/goal`.
#[derive(Debug)]
pub struct Tasks {
    reader: Latest<TaskGoal>,
    current: Option<HeldTask>,
    next: Option<HeldTask>,
}

impl Tasks {
    /// Opens the topic.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            reader: peer.latest()?,
            current: None,
            next: None,
        })
    }

    /// Takes in what has come; true when there is a new task.
    pub fn poll(&mut self, roster: &Roster) -> bool {
        if !self.reader.poll(roster) {
            return false;
        }
        self.next = self.reader.get().and_then(|view| {
            Some(HeldTask {
                id: view.header.id(),
                kind: view.meta.kind()?,
                from_tick: view.meta.from_tick,
                goals: view.items.to_vec(),
            })
        });
        true
    }

    /// True when something has come that [`Self::poll`] has not taken in yet.
    #[must_use]
    pub fn waits(&self) -> bool {
        self.reader.waits()
    }

    /// The task that holds at `tick`.
    pub fn at(&mut self, tick: u64) -> Option<&HeldTask> {
        if self
            .next
            .as_ref()
            .is_some_and(|next| next.from_tick <= tick)
        {
            self.current = self.next.take();
        }
        self.current.as_ref()
    }

    /// The task that held when [`Self::at`] was last asked.
    #[must_use]
    pub fn current(&self) -> Option<&HeldTask> {
        self.current.as_ref()
    }
}

impl Input for Tasks {
    fn refused(&self) -> u64 {
        self.reader.refused()
    }
}
