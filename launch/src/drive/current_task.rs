//! The task that the robot has.

use std::collections::BTreeSet;
use zeronav_measure::run_totals::TaskReport;
use zeronav_msgs::task::Goal;

/// The goals that were sent last, and under which number.
#[derive(Debug, Default)]
pub(super) struct CurrentTask {
    pub(super) goals: Vec<Goal>,
    /// 0 = none was sent: without one, or because there was no memory for the message.
    pub(super) id: u64,
    /// True while it is being cancelled.
    pub(super) is_cancelling: bool,
    /// Number of the newest goal of this run.
    newest_goal: u64,
}

impl CurrentTask {
    /// Numbers goals in the order of the run.
    pub(super) fn number(&mut self, goals: &mut [Goal]) {
        for goal in goals {
            self.newest_goal += 1;
            goal.id = self.newest_goal;
        }
    }

    /// The goals that are not among those `reached`.
    pub(super) fn left(&self, reached: &BTreeSet<u64>) -> Vec<Goal> {
        let left = self.goals.iter().filter(|goal| !reached.contains(&goal.id));
        left.copied().collect()
    }

    /// True when this is said about it.
    pub(super) fn is_of(&self, report: &TaskReport) -> bool {
        self.id != 0 && report.task == self.id
    }

    /// True when there was no memory to send it.
    pub(super) fn is_unsent(&self) -> bool {
        self.id == 0 && !self.goals.is_empty()
    }

    /// No task from now on.
    pub(super) fn clear(&mut self) {
        self.id = 0;
        self.goals.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_numbered_through_the_run_and_left_until_reached() {
        let mut task = CurrentTask::default();
        for ids in [[1, 2], [3, 4]] {
            let mut goals = vec![Goal::default(); 2];
            task.number(&mut goals);
            assert_eq!(goals.iter().map(|goal| goal.id).collect::<Vec<_>>(), ids);
            task.goals = goals;
        }
        assert!(task.is_unsent());
        let left = task.left(&BTreeSet::from([1, 3]));
        assert_eq!(left.iter().map(|goal| goal.id).collect::<Vec<_>>(), [4]);
        task.clear();
        assert!(task.left(&BTreeSet::new()).is_empty() && !task.is_unsent());
    }
}
