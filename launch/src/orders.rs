//! Goals that clients give while a stack runs: served in order of arrival, before the scenario's own.
//!
//! An order is one client's list of goals. It ends when its last goal is reached (then a repeated one
//! begins again), when one of its goals fails, when it is cancelled or replaced, or when its time is
//! over; the next order begins then. A goal that failed by an obstacle that may go is given again while
//! somebody still wants it: as long as the order repeats, or has a time limit that is not over.

use std::collections::VecDeque;
use zeronav_measure::result::Redirect;
use zeronav_msgs::task::{EndReason, Goal, TaskState};

/// Most orders that wait at a time.
const WAITING_MAX: usize = 64;

/// Orders that are remembered with their outcome; the oldest go first.
const KEPT_MAX: usize = 1000;

/// What a client asks for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Order {
    /// Where to, in order; not empty.
    pub goals: Vec<Goal>,
    /// True when the first goal follows the last one.
    pub repeats: bool,
    /// Run time after which it is given up. [ns]
    pub time_limit_ns: Option<u64>,
}

/// How the task of an order has ended.
#[derive(Debug, Clone)]
pub(crate) struct End {
    /// Its state.
    pub state: TaskState,
    /// Why.
    pub reason: EndReason,
    /// Why it failed, in words.
    pub why: Option<String>,
    /// It failed by an obstacle that may go.
    pub may_open: bool,
    /// Manoeuvres and waits of the recovery.
    pub recoveries: u32,
    /// Its goals that were not reached.
    pub left: Vec<Goal>,
}

/// An order that is being served.
#[derive(Debug, Clone)]
struct Current {
    id: u64,
    order: Order,
    began_run_ns: u64,
    /// How it will end, once it has been cancelled.
    ends_as: Option<&'static str>,
    /// Manoeuvres and waits of the recovery in its tasks that are over.
    recoveries: u32,
}

/// An order with what became of it.
#[derive(Debug, Clone)]
struct Kept {
    id: u64,
    /// Run time that it took, once it has ended. [ns]
    took_ns: u64,
    /// Why it failed, in words; empty when it has not.
    why: String,
    /// Manoeuvres and waits of the recovery, once it has ended.
    recoveries: u32,
    redirect: Redirect,
}

/// All orders of a run.
#[derive(Debug, Default)]
pub(crate) struct Orders {
    newest_id: u64,
    waiting: VecDeque<(u64, Order)>,
    current: Option<Current>,
    kept: VecDeque<Kept>,
    /// The goals of the scenario that were left when the first order began.
    aside: Option<Vec<Goal>>,
}

/// Outcome of an order that waits.
pub(crate) const QUEUED: &str = "queued";

/// Outcome of the order that is served.
pub(crate) const ACTIVE: &str = "active";

impl Orders {
    /// Takes in an order and returns its id.
    ///
    /// # Errors
    /// When too many wait.
    pub(crate) fn give(&mut self, time_s: f64, order: Order) -> Result<u64, String> {
        if self.waiting.len() == WAITING_MAX {
            return Err(format!(
                "{WAITING_MAX} goals wait already; cancel some (zeronav cancel)"
            ));
        }
        self.newest_id += 1;
        let id = self.newest_id;
        let pose = order.goals.last().map_or([0.0; 3], |goal| {
            [goal.pose.x_m, goal.pose.y_m, goal.pose.yaw_rad]
        });
        if self.kept.len() == KEPT_MAX {
            let is_over = |kept: &Kept| ![QUEUED, ACTIVE].contains(&kept.redirect.outcome.as_str());
            let oldest = self.kept.iter().position(is_over);
            self.kept.remove(oldest.unwrap_or(0));
        }
        self.kept.push_back(Kept {
            id,
            took_ns: 0,
            why: String::new(),
            recoveries: 0,
            redirect: Redirect {
                time_s,
                goal: pose,
                outcome: QUEUED.to_owned(),
            },
        });
        self.waiting.push_back((id, order));
        Ok(id)
    }

    /// Ends the current order and those that wait: another one takes their place.
    pub(crate) fn replace(&mut self, run_ns: u64) {
        self.settle("replaced", run_ns);
        self.drop_waiting("replaced");
    }

    /// The next order becomes the current one, unless there is one already; returns its goals. `left`
    /// are the scenario's goals that are current before the first order.
    pub(crate) fn begin(&mut self, run_ns: u64, left: Vec<Goal>) -> Option<Vec<Goal>> {
        if self.current.is_some() {
            return None;
        }
        let (id, order) = self.waiting.pop_front()?;
        self.aside.get_or_insert(left);
        let goals = order.goals.clone();
        self.note(id, ACTIVE);
        self.current = Some(Current {
            id,
            order,
            began_run_ns: run_ns,
            ends_as: None,
            recoveries: 0,
        });
        Some(goals)
    }

    /// The current order's task has ended. Returns the goals of the next one when it begins again, or
    /// goes on at the goal that failed.
    pub(crate) fn ended(&mut self, end: End, run_ns: u64) -> Option<Vec<Goal>> {
        let current = self.current.as_mut()?;
        current.recoveries = current.recoveries.saturating_add(end.recoveries);
        let (order, goes_on) = (&current.order, current.ends_as.is_none());
        if end.state == TaskState::Reached && order.repeats && goes_on {
            return Some(order.goals.clone());
        }
        // The time limit of an order that has one is seen to every tick.
        let is_wanted = order.repeats || order.time_limit_ns.is_some();
        let fails = end.state == TaskState::Failed;
        if fails && end.may_open && is_wanted && goes_on && !end.left.is_empty() {
            return Some(end.left);
        }
        let outcome = match (end.state, current.ends_as) {
            // What repeats is over by its cancellation alone, wherever that finds the robot.
            (TaskState::Reached, Some(outcome)) if order.repeats => outcome,
            (TaskState::Reached, _) => "reached",
            (_, Some(outcome)) => outcome,
            (TaskState::Cancelled, None) => "cancelled",
            (_, None) => end.reason.label(),
        };
        let failed = outcome == end.reason.label();
        let (id, recoveries) = (current.id, current.recoveries);
        self.settle(outcome, run_ns);
        if let Some(kept) = self.kept.iter_mut().find(|kept| kept.id == id) {
            kept.recoveries = recoveries;
            kept.why = end.why.filter(|_| failed).unwrap_or_default();
        }
        None
    }

    /// Cancels the order with this id, or all. True when the current task has to be cancelled for it.
    ///
    /// # Errors
    /// When there is no such order.
    pub(crate) fn cancel(&mut self, id: Option<u64>) -> Result<bool, String> {
        if let Some(id) = id
            && let Some(at) = self.waiting.iter().position(|(waiting, _)| *waiting == id)
        {
            self.waiting.remove(at);
            self.note(id, "cancelled");
            return Ok(false);
        }
        let current = self.current.as_mut();
        match (id, current) {
            (Some(id), Some(current)) if current.id == id => {
                current.ends_as = Some("cancelled");
                Ok(true)
            }
            (Some(id), _) => Err(format!("goal {id} neither waits nor is it being driven to")),
            (None, current) => {
                if let Some(current) = current {
                    current.ends_as = Some("cancelled");
                }
                self.drop_waiting("cancelled");
                Ok(true)
            }
        }
    }

    /// True once, when the time of the current order is over: its task has to be cancelled.
    pub(crate) fn is_over_time(&mut self, run_ns: u64) -> bool {
        let Some(current) = &mut self.current else {
            return false;
        };
        let over = current
            .order
            .time_limit_ns
            .is_some_and(|limit_ns| run_ns.saturating_sub(current.began_run_ns) > limit_ns);
        if over && current.ends_as.is_none() {
            current.ends_as = Some("time_limit");
            return true;
        }
        false
    }

    /// True while an order is served.
    pub(crate) const fn is_active(&self) -> bool {
        self.current.is_some()
    }

    /// Id of the order that is served, and the run time at which it began. [ns]
    pub(crate) fn current(&self) -> Option<(u64, u64)> {
        let current = self.current.as_ref()?;
        Some((current.id, current.began_run_ns))
    }

    /// How many wait.
    pub(crate) fn n_waiting(&self) -> usize {
        self.waiting.len()
    }

    /// What became of an order, and the run time that it took if it has ended [ns]; `None` when it is
    /// not remembered.
    pub(crate) fn outcome(&self, id: u64) -> Option<(&str, u64)> {
        let kept = self.kept.iter().find(|kept| kept.id == id)?;
        Some((&kept.redirect.outcome, kept.took_ns))
    }

    /// Why an order failed, in words; empty when it has not.
    pub(crate) fn why(&self, id: u64) -> &str {
        let kept = self.kept.iter().find(|kept| kept.id == id);
        kept.map_or("", |kept| &kept.why)
    }

    /// Manoeuvres and waits of the recovery for an order, once it has ended.
    pub(crate) fn recoveries(&self, id: u64) -> u32 {
        let kept = self.kept.iter().find(|kept| kept.id == id);
        kept.map_or(0, |kept| kept.recoveries)
    }

    /// How many orders are served before this one.
    pub(crate) fn n_before(&self, id: u64) -> usize {
        let at = self.waiting.iter().position(|(waiting, _)| *waiting == id);
        at.map_or(0, |at| at + usize::from(self.current.is_some()))
    }

    /// The goals of the scenario that the orders took the place of; they are current again.
    pub(crate) fn take_aside(&mut self) -> Option<Vec<Goal>> {
        self.aside.take()
    }

    /// True when no order was given.
    pub(crate) fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// The orders that are remembered, as in the result of a run.
    pub(crate) fn records(&self) -> Vec<Redirect> {
        let kept = self.kept.iter();
        kept.map(|kept| kept.redirect.clone()).collect()
    }

    fn settle(&mut self, outcome: &str, run_ns: u64) {
        let Some(Current {
            id, began_run_ns, ..
        }) = self.current.take()
        else {
            return;
        };
        self.note(id, outcome);
        if let Some(kept) = self.kept.iter_mut().find(|kept| kept.id == id) {
            kept.took_ns = run_ns.saturating_sub(began_run_ns);
        }
    }

    fn drop_waiting(&mut self, outcome: &str) {
        for (id, _) in core::mem::take(&mut self.waiting) {
            self.note(id, outcome);
        }
    }

    fn note(&mut self, id: u64, outcome: &str) {
        if let Some(kept) = self.kept.iter_mut().find(|kept| kept.id == id) {
            outcome.clone_into(&mut kept.redirect.outcome);
        }
    }
}

#[cfg(test)]
mod tests;
