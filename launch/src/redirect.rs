//! Goals given by hand while a run goes on (`zeronav goal`). They stand in the result, they do not
//! count for the scenario's own goals, and one that cannot be reached is given up for the task that
//! it took the place of.

use crate::result::Redirect;
use zeronav_msgs::task::{EndReason, Goal, TaskState};

/// The goals given by hand, and the task that waits behind the current one.
#[derive(Debug, Default)]
pub(crate) struct Redirects {
    given: Vec<Redirect>,
    /// The goals of the scenario that were left when the first was given.
    aside: Option<Vec<Goal>>,
}

impl Redirects {
    /// A goal takes the place of `left`, the current goals that are not reached yet.
    pub(crate) fn give(&mut self, time_s: f64, goal: &Goal, left: Vec<Goal>) {
        if self.aside.is_some() {
            self.settle("replaced");
        } else {
            self.aside = Some(left);
        }
        self.given.push(Redirect {
            time_s,
            goal: [goal.pose.x_m, goal.pose.y_m, goal.pose.yaw_rad],
            outcome: "active".to_owned(),
        });
    }

    /// The current task has ended: the goals with which the run goes on, if it was one given by
    /// hand and could not be reached.
    pub(crate) fn ended(&mut self, state: TaskState, reason: EndReason) -> Option<Vec<Goal>> {
        self.aside.as_ref()?;
        if state == TaskState::Reached {
            self.settle("reached");
            return None;
        }
        self.settle(reason.label());
        self.aside.take()
    }

    /// True while a goal given by hand is current, or ended the run.
    #[must_use]
    pub(crate) fn is_redirected(&self) -> bool {
        self.aside.is_some()
    }

    /// All of them.
    #[must_use]
    pub(crate) fn given(&self) -> &[Redirect] {
        &self.given
    }

    fn settle(&mut self, outcome: &str) {
        if let Some(last) = self.given.last_mut() {
            outcome.clone_into(&mut last.outcome);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::Pose;

    fn goal(id: u64) -> Goal {
        Goal {
            pose: Pose::new(1.0, 2.0, 0.5),
            tolerance_m: 0.25,
            yaw_tolerance_rad: 0.25,
            id,
        }
    }

    fn outcomes(redirects: &Redirects) -> Vec<&str> {
        let given = redirects.given().iter();
        given.map(|one| one.outcome.as_str()).collect()
    }

    #[test]
    fn a_goal_that_cannot_be_reached_gives_way_to_the_task_before_it() {
        let mut redirects = Redirects::default();
        assert_eq!(redirects.ended(TaskState::Failed, EndReason::Stuck), None);
        redirects.give(3.0, &goal(7), vec![goal(1), goal(2)]);
        redirects.give(4.0, &goal(8), vec![goal(7)]);
        assert!(redirects.is_redirected());
        let left = redirects.ended(TaskState::Failed, EndReason::GoalBlocked);
        assert_eq!(left, Some(vec![goal(1), goal(2)]));
        assert!(!redirects.is_redirected());
        assert_eq!(outcomes(&redirects), ["replaced", "goal_blocked"]);
    }

    #[test]
    fn a_goal_that_is_reached_ends_the_run_elsewhere() {
        let mut redirects = Redirects::default();
        redirects.give(3.0, &goal(7), vec![goal(1)]);
        assert_eq!(redirects.ended(TaskState::Reached, EndReason::None), None);
        assert!(redirects.is_redirected());
        assert_eq!(outcomes(&redirects), ["reached"]);
    }
}
