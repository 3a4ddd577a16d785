//! What the newest path says of the current goal.

use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::path::{Path, PathStatus};
use zeronav_msgs::task::EndReason;

/// What the newest path message says, as far as the task is judged by it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Planned {
    /// The outcome.
    pub status: PathStatus,
    /// [`zeronav_msgs::task::Goal::id`] that it is for.
    pub goal: u64,
    /// Where the obstacle comes from because of which there is no path.
    pub source: ObstacleSource,
}

impl Planned {
    /// What a message says; `None` for unknown codes.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        Some(Self {
            status: path.status()?,
            goal: path.goal,
            source: path.source()?,
        })
    }

    /// True when there may be a path soon though nothing is done: what is in the way is not in the
    /// static map, came after a path had led to the goal (it `was_free`), or moves.
    pub(crate) const fn may_open(self, was_free: bool, moves_at_goal: bool) -> bool {
        let may_go = matches!(self.source, ObstacleSource::Lidar | ObstacleSource::Tracked);
        match self.status {
            PathStatus::StartBlocked => may_go,
            PathStatus::GoalBlocked => may_go || was_free || moves_at_goal,
            PathStatus::Unreachable | PathStatus::UnreachableCorner => may_go || was_free,
            _ => false,
        }
    }

    /// The end that its status leads to when it lasts.
    pub(crate) const fn end(self) -> Option<EndReason> {
        match self.status {
            PathStatus::NoGoal | PathStatus::Found => None,
            PathStatus::Unreachable | PathStatus::UnreachableCorner => Some(EndReason::Unreachable),
            PathStatus::GoalBlocked => Some(EndReason::GoalBlocked),
            PathStatus::GoalOutsideMap => Some(EndReason::GoalOutsideMap),
            PathStatus::StartOutsideMap
            | PathStatus::StartBlocked
            | PathStatus::DeadEnd
            | PathStatus::OutOfBudget
            | PathStatus::TooLong => Some(EndReason::NoPath),
        }
    }
}
