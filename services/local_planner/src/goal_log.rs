//! What the local planner logs of a task: goals that were accepted and goals that ended.

use zeronav_msgs::task::{EndReason, GoalEnd, TaskState, TaskStatus};

/// What was logged last.
#[derive(Debug, Default)]
pub(crate) struct GoalLog {
    /// Task and current goal.
    goal: (u64, u64),
    /// Ends of goals of that task.
    n_ended: usize,
}

impl GoalLog {
    /// Logs what is new in a status.
    pub(crate) fn log(&mut self, tick: u64, status: &TaskStatus, ended: &[GoalEnd]) {
        let (task, goal) = (status.task, status.goal);
        if (task, goal) != self.goal && goal != 0 {
            tracing::info!(tick, task, goal, "goal accepted");
        }
        if task != self.goal.0 {
            self.n_ended = 0;
        }
        for end in ended.iter().skip(self.n_ended) {
            let state = TaskState::from_code(end.state).map_or("unknown", TaskState::label);
            let reason = EndReason::from_code(end.reason).map_or("unknown", EndReason::label);
            let (tick, goal) = (end.tick, end.goal);
            tracing::info!(tick, goal, state, reason, "goal ended");
        }
        self.goal = (task, goal);
        self.n_ended = ended.len();
    }
}
