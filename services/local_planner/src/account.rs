//! What is told of a task besides its state: what the recovery did for it, and because of what it
//! failed.

use crate::obstruction::Obstruction;
use crate::recovery::{Behaviour, Cause};
use zeronav_msgs::task::{StuckCause, TaskStatus};

/// Of the newest task with goals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Account {
    /// Id of the task.
    task: u64,
    /// Manoeuvres and waits.
    attempts: u32,
    /// Why the robot got stuck.
    cause: StuckCause,
    /// What it did not get past.
    obstruction: Obstruction,
}

impl Account {
    /// Nothing yet.
    pub(crate) const fn of(task: u64) -> Self {
        Self {
            task,
            attempts: 0,
            cause: StuckCause::None,
            obstruction: Obstruction::NONE,
        }
    }

    /// Takes down what the recovery begins.
    pub(crate) fn note(&mut self, task: u64, behaviour: Behaviour) {
        self.turn_to(task);
        if behaviour.is_attempt() {
            self.attempts = self.attempts.saturating_add(1);
        }
        if let Behaviour::GiveUp(cause) = behaviour {
            self.cause = match cause {
                Cause::Blocked => StuckCause::Blocked,
                Cause::NoProgress => StuckCause::NoProgress,
                Cause::TooManyAttempts => StuckCause::TooManyAttempts,
            };
        }
    }

    /// Takes down because of what the task failed, or what it waits for.
    pub(crate) fn blocked(&mut self, task: u64, obstruction: Obstruction) {
        self.turn_to(task);
        self.obstruction = obstruction;
    }

    /// Goes on from what another local planner told of the task.
    pub(crate) fn follow(&mut self, task: u64, status: &TaskStatus) {
        *self = Self {
            task,
            attempts: status.recoveries,
            cause: status.cause().unwrap_or(StuckCause::None),
            obstruction: Obstruction::of(status),
        };
    }

    /// The status of `task` with what is told of it here.
    pub(crate) fn complete(&self, task: u64, status: TaskStatus) -> TaskStatus {
        if self.task != task {
            return status;
        }
        TaskStatus {
            recoveries: self.attempts,
            cause: self.cause.code(),
            block: self.obstruction.block.code(),
            block_m: self.obstruction.at_m,
            source: self.obstruction.source.code(),
            ..status
        }
    }

    fn turn_to(&mut self, task: u64) {
        if self.task != task {
            *self = Self::of(task);
        }
    }
}
