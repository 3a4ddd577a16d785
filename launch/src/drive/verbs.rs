//! What clients make a stack do while it runs.

use super::session::Session;
use crate::arguments::service_role;
use crate::control::request::{FaultKind, ObstacleChange};
use crate::ending::Ending;
use crate::orders::Order;
use crate::placed::shape_of;
use crate::prepare::check_delay;
use crate::supervise::stack::Stack;
use rustix::process::Signal;
use std::sync::atomic::Ordering;
use zeronav_msgs::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::time::seconds;
use zeronav_msgs::truth::Placement;
use zeronav_world::Shape;

/// Most ticks of one step.
const STEP_TICKS_MAX: u64 = 1_000_000;

impl Session<'_> {
    /// Takes in an order, and begins it when it is its turn. Returns its id.
    ///
    /// # Errors
    /// When too many wait.
    pub(super) fn take_order(
        &mut self,
        stack: &mut Stack,
        order: Order,
        now: bool,
    ) -> Result<u64, String> {
        let time_s = seconds(self.collector.run_ns.saturating_sub(self.goals_run_ns));
        let left = self.left();
        if now {
            self.orders.replace(self.collector.run_ns);
        }
        let id = self.orders.give(time_s, order, || left)?;
        if self.is_ready {
            self.begin_order(stack);
        }
        Ok(id)
    }

    /// Begins the order whose turn it is; false when there is none.
    pub(super) fn begin_order(&mut self, stack: &mut Stack) -> bool {
        let Some(goals) = self.orders.begin(self.collector.run_ns) else {
            return false;
        };
        self.send_now(stack, goals);
        true
    }

    /// Gives up the current order when its time is over.
    pub(super) fn give_up_late_order(&mut self, stack: &mut Stack) {
        if self.orders.is_over_time(self.collector.run_ns) {
            self.cancel_task(stack);
        }
    }

    /// Cancels an order, or all and the task.
    ///
    /// # Errors
    /// When there is nothing to cancel.
    pub(super) fn cancel(&mut self, stack: &mut Stack, id: Option<u64>) -> Result<(), String> {
        if self.shuttle.is_some() {
            return Err("the run makes trials; end it with `zeronav down`".to_owned());
        }
        let idle = self.task_id == 0 && self.orders.n_waiting() == 0;
        if id.is_none() && idle {
            return Err("there is no goal to cancel".to_owned());
        }
        if self.orders.cancel(id)? && self.task_id != 0 {
            self.cancel_task(stack);
        }
        Ok(())
    }

    /// Asks the local planner to end its task; how it ended comes with its status.
    fn cancel_task(&mut self, stack: &mut Stack) {
        let from_tick = self.next_tick(stack);
        self.task_id = stack.send_goals(&[], from_tick);
        tracing::info!(task = self.task_id, "cancelled");
    }

    /// No task from now on. It is said to the local planner, too: a successor would begin the last
    /// one that it was given again.
    pub(super) fn rest(&mut self, stack: &mut Stack) {
        let from_tick = self.next_tick(stack);
        stack.send_goals(&[], from_tick);
        self.task_id = 0;
        self.task.clear();
        self.collector.reached.clear();
    }

    /// Holds run time: in real time the robot stops where it is, in lockstep it does the ticks that
    /// it may have begun.
    ///
    /// # Errors
    /// In trials.
    pub(super) fn pause(&mut self, stack: &mut Stack) -> Result<(), String> {
        if self.shuttle.is_some() {
            return Err("the run measures latencies and cannot be paused".to_owned());
        }
        self.is_paused = true;
        if self.prepared.mode == RunMode::RealTime {
            stack.pause(true);
        }
        Ok(())
    }

    /// Lets run time go on.
    ///
    /// # Errors
    /// When it is not held.
    pub(super) fn resume(&mut self, stack: &mut Stack) -> Result<(), String> {
        if !self.is_paused {
            return Err("the stack is not paused".to_owned());
        }
        self.is_paused = false;
        stack.pause(false);
        Ok(())
    }

    /// Lets the robot do so many ticks more, and no others.
    ///
    /// # Errors
    /// In real time, while it is not paused, and for counts that no step can be.
    pub(super) fn step(&mut self, stack: &mut Stack, ticks: u64) -> Result<(), String> {
        if self.prepared.mode != RunMode::Lockstep {
            return Err("only a lockstep stack can step (zeronav up --lockstep)".to_owned());
        }
        if !self.is_paused {
            return Err("the stack is not paused (zeronav pause)".to_owned());
        }
        if !(1..=STEP_TICKS_MAX).contains(&ticks) {
            return Err(format!("1 to {STEP_TICKS_MAX} ticks, not {ticks}"));
        }
        stack.extend_lease(stack.roster.control.lease + ticks);
        Ok(())
    }

    /// Breaks the service in a seat.
    ///
    /// # Errors
    /// When it cannot be broken, such as the robot, which nothing restarts.
    pub(super) fn break_service(
        &mut self,
        stack: &mut Stack,
        role: &str,
        kind: FaultKind,
    ) -> Result<(), String> {
        let role = service_role(role)?;
        if role == Role::Robot {
            return Err("the robot is not restarted; `zeronav down` ends the stack".to_owned());
        }
        let signal = match kind {
            FaultKind::Kill => Signal::KILL,
            FaultKind::Stop => Signal::STOP,
            FaultKind::Slow { .. } if self.prepared.mode == RunMode::Lockstep => {
                return Err("in lockstep a delay changes nothing".to_owned());
            }
            FaultKind::Slow { steps } => {
                check_delay(role, steps, &self.prepared.scenario)?;
                stack.delay(role, steps);
                return Ok(());
            }
        };
        if !stack.signal(role, signal) {
            return Err(format!("no process of this stack is in the seat of {role}"));
        }
        Ok(())
    }

    /// Changes an obstacle of the simulated world, from the first tick on that the robot may not have
    /// begun.
    ///
    /// # Errors
    /// Why it cannot be, such as that the robot is there.
    pub(super) fn place(
        &mut self,
        stack: &mut Stack,
        name: &str,
        change: &ObstacleChange,
    ) -> Result<(), String> {
        if self.shuttle.is_some() {
            return Err("the run makes trials with obstacles of its own".to_owned());
        }
        if let ObstacleChange::Add { pose, size_m } = change {
            self.check_room(*pose, *size_m)?;
        }
        let tick_ns = self.prepared.scenario.run.tick_ns();
        let run_ns = match self.prepared.mode {
            RunMode::Lockstep => self.next_tick(stack) * tick_ns,
            _ => self.collector.run_ns + tick_ns,
        };
        let placements = self.placed.change(name, change, run_ns)?;
        stack.place(placements);
        Ok(())
    }

    /// Rejects an obstacle that would be put onto the robot.
    fn check_room(&self, [x_m, y_m, yaw_rad]: [f64; 3], size_m: [f64; 2]) -> Result<(), String> {
        let placement = Placement {
            pose: Pose::new(x_m, y_m, yaw_rad),
            size_x_m: size_m[0],
            size_y_m: size_m[1],
            ..Placement::default()
        };
        let shape = shape_of(&placement).and_then(|spec| Shape::new(&spec).ok());
        let Some(shape) = shape else {
            return Ok(());
        };
        let start = self.prepared.scenario.start;
        let robot = self.collector.truth.map_or(start, |truth| truth.pose);
        let robot = self.prepared.footprint.placed(&robot);
        if robot.distance_m(shape.placed()) <= 0.0 {
            return Err("the robot is there".to_owned());
        }
        Ok(())
    }

    /// How the run ends because somebody wants it to.
    pub(super) fn asked_to_end(&self) -> Option<Ending> {
        if self.interrupted.load(Ordering::Relaxed) {
            return Some(Ending::Interrupted);
        }
        self.is_down.then_some(Ending::Down)
    }
}
