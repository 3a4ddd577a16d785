//! The end of a run: the robot comes to rest, and clients hear what became of their goals.

use super::session::{LEASE_TICKS, Session};
use std::time::{Duration, Instant};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_supervise::own_time::Patience;
use zeronav_supervise::stack::Stack;

/// Own time that the robot and its guard may take until the robot stands.
const STAND_LIMIT: Duration = Duration::from_secs(4);

/// The same on a machine that has no time for them, by the clock; `zeronav down` waits for longer.
const STARVED_LIMIT: Duration = Duration::from_secs(10);

/// How long clients that gave goals can still ask what became of them: `--wait` asks ten times a
/// second.
const ANSWER_TIME: Duration = Duration::from_millis(300);

/// Speed below which the robot is stopped. [m/s]
const STANDING_MPS: f64 = 0.01;

impl Session<'_> {
    /// Lets the robot come to rest and answers the last questions of clients.
    pub(super) fn stop(&mut self, stack: &mut Stack) {
        let started = Instant::now();
        let answer_time = if self.orders.is_empty() {
            Duration::ZERO
        } else {
            ANSWER_TIME
        };
        stack.pause(false);
        stack.stop_robot();
        let mut waits: Vec<Patience> = (stack.children.iter())
            .filter(|child| matches!(child.role, Role::Robot | Role::CollisionGuard))
            .map(|child| Patience::with(child.pid()))
            .collect();
        // Of processes that others have started only the clock is known.
        let limit = if waits.is_empty() {
            STAND_LIMIT
        } else {
            STARVED_LIMIT
        };
        loop {
            self.listen(stack);
            self.serve(stack);
            let over = waits.iter_mut().map(|wait| wait.is_over(STAND_LIMIT));
            let n_over = over.filter(|is_over| *is_over).count();
            let are_over = n_over > 0 && n_over == waits.len();
            let too_long = are_over || started.elapsed() >= limit;
            let is_over = too_long || self.is_stopped(stack);
            if is_over && started.elapsed() >= answer_time {
                tracing::info!(at_rest = self.is_at_rest(), "the robot was stopped");
                return;
            }
            if self.prepared.mode == RunMode::Lockstep && !is_over {
                stack.extend_lease(self.collector.robot_tick() + LEASE_TICKS);
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// True when the robot stands, as far as is known.
    fn is_at_rest(&self) -> bool {
        // Only a simulated robot tells the truth, which does not slip.
        let (v_mps, w_radps) = match (&self.collector.truth, &self.collector.odometry) {
            (Some(truth), _) => (truth.v_mps, truth.w_radps),
            (None, Some(odometry)) => (odometry.v_mps, odometry.w_radps),
            (None, None) => return true,
        };
        v_mps.abs() < STANDING_MPS && w_radps.abs() < STANDING_MPS
    }

    /// True when the robot is stopped, or nothing can stop it any more.
    fn is_stopped(&self, stack: &mut Stack) -> bool {
        // Without these two the robot is not stopped.
        self.is_at_rest()
            || stack.children.iter_mut().any(|child| {
                matches!(child.role, Role::Robot | Role::CollisionGuard)
                    && child.ended().is_some()
                    && (self.prepared.mode == RunMode::Lockstep || child.role == Role::Robot)
            })
    }
}
