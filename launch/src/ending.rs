//! How a run ended.

use zeronav_msgs::role::Role;
use zeronav_msgs::task::{EndReason, TaskState};

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Ending {
    /// The task ended by itself.
    Task(TaskState, EndReason),
    /// The robot reached a goal that was given by hand, and not all of the scenario's.
    Redirected,
    /// The time limit of the scenario, or trials that came to no end.
    Timeout,
    /// All trials were made.
    TrialsOver,
    /// A service ended: who, how, the tail of its log, its exit code.
    Died {
        /// Its seat.
        role: Role,
        /// How it ended, in words.
        how: String,
        /// Its exit code, if it had one.
        code: Option<i32>,
        /// The last lines of its log.
        log: Vec<String>,
    },
    /// Services that could not answer in time.
    NotReady(Vec<Role>),
    /// A service that stopped answering.
    Silent(Role),
    /// No tick came within the wall time that a run may stand still, whatever the reason; what it waited
    /// for.
    Stalled(Role),
    /// The shared memory of the stack was deleted while it ran.
    Deleted,
    /// Launch was killed or has crashed.
    LaunchDied,
    /// Ctrl-C.
    Interrupted,
    /// A client asked for the end.
    Down,
}

impl Ending {
    /// The outcome of the run in one word, as in its result.
    #[must_use]
    pub(crate) const fn outcome(&self) -> &'static str {
        match self {
            Self::Task(TaskState::Reached, _) => "reached",
            Self::Task(TaskState::Cancelled, _) => "cancelled",
            Self::Task(_, EndReason::None) => "failed",
            Self::Task(_, reason) => reason.label(),
            Self::Redirected => "redirected",
            Self::Timeout => "timeout",
            Self::TrialsOver => "trials_over",
            Self::Died { .. } => "service_died",
            Self::NotReady(_) => "not_ready",
            Self::Silent(_) => "silent",
            Self::Stalled(_) => "stalled",
            Self::Deleted => "memory_deleted",
            Self::LaunchDied => "launch_died",
            Self::Interrupted => "interrupted",
            Self::Down => "down",
        }
    }
}

impl Ending {
    /// No process could be started for a seat.
    #[must_use]
    pub(crate) const fn not_started(role: Role, how: String) -> Self {
        Self::Died {
            role,
            how,
            code: None,
            log: Vec::new(),
        }
    }

    /// What has ended a run at a moment that the scenario does not know of.
    #[must_use]
    pub(crate) fn cut_short(&self) -> Option<String> {
        match self {
            // A death is named as the end of its service.
            Self::Task(..)
            | Self::Redirected
            | Self::Timeout
            | Self::TrialsOver
            | Self::Died { .. } => None,
            Self::NotReady(_)
            | Self::Silent(_)
            | Self::Stalled(_)
            | Self::Deleted
            | Self::LaunchDied => Some(format!("the run could not go on: {}", self.outcome())),
            Self::Interrupted | Self::Down => Some("the run was ended by hand".to_owned()),
        }
    }
}

/// Why a run that stood still was ended, in words.
#[must_use]
pub(crate) fn stalled(role: Role) -> String {
    format!(
        "no tick came for minutes, waiting for {role}: it stands still, or the machine does too much"
    )
}
