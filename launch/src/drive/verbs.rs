//! What clients make a stack do while it runs.

use super::pace::{Pace, SPEEDS};
use super::session::Session;
use crate::ending::Ending;
use crate::orders::Order;
use crate::placed_obstacles::shape_of;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::task::PoseEstimate;
use zeronav_msgs::time::seconds;
use zeronav_msgs::truth::Placement;
use zeronav_observe::control::ObstacleChange;
use zeronav_supervise::stack::Stack;
use zeronav_world::Shape;

/// Most ticks of one step.
const STEP_TICKS_MAX: u64 = 1_000_000;

/// In real time, ticks after the newest one known whose scan is surely made after a message is out: a
/// map of that scan rests on it.
const BEGUN_TICKS: u64 = 2;

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
        let time_s = seconds(
            self.collector
                .run_ns
                .saturating_sub(self.begin.goals_run_ns),
        );
        if now {
            self.orders.replace(self.collector.run_ns);
        }
        let id = self.orders.give(time_s, order)?;
        if self.phase.is_ready() {
            self.begin_order(stack);
        }
        Ok(id)
    }

    /// Begins the order whose turn it is; false when there is none.
    pub(super) fn begin_order(&mut self, stack: &mut Stack) -> bool {
        let left = self.left();
        let Some(goals) = self.orders.begin(self.collector.run_ns, left) else {
            return false;
        };
        self.send_now(stack, goals);
        true
    }

    /// Gives up the current order when its time is over, and sends again what there was no memory
    /// for.
    pub(super) fn update_order(&mut self, stack: &mut Stack) {
        if self.orders.is_over_time(self.collector.run_ns) {
            self.cancel_task(stack);
        } else if self.task.is_unsent() {
            if self.task.is_cancelling {
                self.cancel_task(stack);
            } else {
                let goals = core::mem::take(&mut self.task.goals);
                self.send_now(stack, goals);
            }
        }
    }

    /// Cancels an order, or all and the task.
    ///
    /// # Errors
    /// When there is nothing to cancel.
    pub(super) fn cancel(&mut self, stack: &mut Stack, id: Option<u64>) -> Result<(), String> {
        if self.trial_runner.is_some() {
            return Err("the run makes trials; end it with `zeronav down`".to_owned());
        }
        if id.is_none() && self.has_no_goal() {
            return Err("there is no goal to cancel".to_owned());
        }
        if self.orders.cancel(id)? && !self.task.goals.is_empty() {
            self.cancel_task(stack);
        }
        Ok(())
    }

    /// Asks the local planner to end its task; how it ended comes with its status.
    fn cancel_task(&mut self, stack: &mut Stack) {
        let from_tick = self.next_tick(stack);
        self.task.is_cancelling = true;
        self.task.id = stack.send_goals(&[], from_tick);
        tracing::info!(task = self.task.id, "cancelled");
    }

    /// No task from now on. It is said to the local planner, too: a successor would begin the last
    /// one that it was given again.
    pub(super) fn rest(&mut self, stack: &mut Stack) {
        let from_tick = self.next_tick(stack);
        stack.send_goals(&[], from_tick);
        self.task.clear();
    }

    /// Holds run time: in real time the robot stops where it is, in lockstep it does the ticks that
    /// it may have begun.
    ///
    /// # Errors
    /// In trials.
    pub(super) fn pause(&mut self, stack: &mut Stack) -> Result<(), String> {
        if self.trial_runner.is_some() {
            return Err("the run measures latencies and cannot be paused".to_owned());
        }
        self.run_time.is_paused = true;
        self.run_time.hold_tick = stack.roster.control.lease;
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
        if !self.run_time.is_paused {
            return Err("the stack is not paused".to_owned());
        }
        self.run_time.is_paused = false;
        let robot_tick = self.collector.robot_tick();
        self.run_time.speed.restart(robot_tick, Instant::now());
        stack.pause(false);
        Ok(())
    }

    /// Lets the robot do so many ticks more, and no others.
    ///
    /// # Errors
    /// In real time, while it is not paused, and for counts that no step can be.
    pub(super) fn step(&mut self, ticks: u64) -> Result<(), String> {
        if self.prepared.mode != RunMode::Lockstep {
            return Err("only a lockstep stack can step (zeronav up --lockstep)".to_owned());
        }
        if !self.run_time.is_paused {
            return Err("the stack is not paused (zeronav pause)".to_owned());
        }
        if !(1..=STEP_TICKS_MAX).contains(&ticks) {
            return Err(format!("1 to {STEP_TICKS_MAX} ticks, not {ticks}"));
        }
        self.run_time.hold_tick = self.run_time.hold_tick.saturating_add(ticks);
        Ok(())
    }

    /// Lets a lockstep stack go `factor` times as fast as real time; `None` = as fast as it can.
    ///
    /// # Errors
    /// In real time, and for speeds that cannot be.
    pub(super) fn set_speed(&mut self, stack: &Stack, factor: Option<f64>) -> Result<(), String> {
        if self.prepared.mode != RunMode::Lockstep {
            return Err("only a lockstep stack has a speed (zeronav up --lockstep)".to_owned());
        }
        let [least, most] = SPEEDS;
        if let Some(wrong) = factor.filter(|factor| !(least..=most).contains(factor)) {
            return Err(format!(
                "a speed is from {least} to {most} times real time, not {wrong}"
            ));
        }
        let tick = Duration::from_nanos(stack.roster.clock.tick_ns);
        let robot_tick = self.collector.robot_tick();
        let pace = factor.map(|factor| Pace::new(factor, tick, robot_tick, Instant::now()));
        self.run_time.speed.ask(pace);
        Ok(())
    }

    /// The tick at which a lockstep robot that has reached `tick` has to wait, for whatever reason.
    pub(super) fn held_at(&mut self, tick: u64) -> u64 {
        let limit = self.swap_limit().min(self.fault_limit());
        if self.run_time.is_paused {
            return limit.min(self.run_time.hold_tick);
        }
        let is_idle = self.prepared.stays && self.has_no_goal();
        let length = Duration::from_nanos(self.prepared.scenario.run.tick_ns());
        let granted = (self.run_time.speed).granted(is_idle, length, tick, Instant::now());
        limit.min(granted)
    }

    fn has_no_goal(&self) -> bool {
        self.task.goals.is_empty() && self.orders.n_waiting() == 0
    }

    /// Tells mapping that the robot is at `pose`, x [m], y [m] and yaw [rad] in the map frame, now: when
    /// its newest odometry was measured.
    ///
    /// # Errors
    /// When the robot cannot be there, or no odometry has come yet.
    pub(super) fn relocate(&mut self, stack: &mut Stack, pose: [f64; 3]) -> Result<(), String> {
        if self.trial_runner.is_some() {
            return Err("the run measures latencies; a jump would change them".to_owned());
        }
        let map_from_base = Pose::new(pose[0], pose[1], pose[2]);
        self.check_pose(&map_from_base)?;
        let odometry = (self.collector.odometry).ok_or("the robot has sent no odometry yet")?;
        let from_tick = if self.lockstep() {
            self.next_tick(stack)
        } else {
            self.collector.robot_tick() + BEGUN_TICKS
        };
        let estimate = PoseEstimate {
            map_from_base,
            odom_from_base: odometry.pose,
            from_tick,
            certainty: PoseCertainty::Unconfirmed.code(),
            ..PoseEstimate::default()
        };
        if !stack.estimate_pose(estimate) {
            return Err("no memory for the message; try again".to_owned());
        }
        self.given_pose = Some(estimate);
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
        if self.trial_runner.is_some() {
            return Err("the run makes trials with obstacles of its own".to_owned());
        }
        let tick_ns = self.prepared.scenario.run.tick_ns();
        let run_ns = match self.prepared.mode {
            RunMode::Lockstep => self.next_tick(stack) * tick_ns,
            _ => self.collector.run_ns + tick_ns,
        };
        let placement = self.placed.plan(name, change, run_ns)?;
        if placement.until_run_ns == 0 {
            self.check_room(&placement)?;
        }
        if stack.place(self.placed.take(name, placement)) {
            Ok(())
        } else {
            Err("no memory for the message; it is sent with the next change".to_owned())
        }
    }

    /// Rejects an obstacle that would be put onto the robot.
    fn check_room(&self, placement: &Placement) -> Result<(), String> {
        let scripted = self.prepared.world.obstacles();
        let shape = match shape_of(placement) {
            Some(spec) => Shape::new(&spec).ok(),
            None => (scripted.get(placement.index as usize)).map(|it| it.shape.clone()),
        };
        let Some(covered) = shape.map(|shape| shape.placed_at(&placement.pose)) else {
            return Ok(());
        };
        let start = self.prepared.scenario.start;
        let robot = self.collector.truth.map_or(start, |truth| truth.pose);
        let robot = self.prepared.footprint.placed(&robot);
        if robot.distance_m(&covered) <= 0.0 {
            return Err("the robot is there".to_owned());
        }
        Ok(())
    }

    /// How the run ends because a client, a signal or the loss of its memory wants it to.
    pub(super) fn asked_to_end(&self, stack: &Stack) -> Option<Ending> {
        if stack.is_deleted() {
            return Some(Ending::Deleted);
        }
        if self.interrupted.load(Ordering::Relaxed) {
            return Some(Ending::Interrupted);
        }
        self.clients.asked_for_end.then_some(Ending::Down)
    }
}
