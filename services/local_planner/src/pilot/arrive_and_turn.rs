//! Manoeuvres of the pilot's own: arriving at the goal and turning on the spot.

use super::limit::Limit;
use super::scene::{COMFORT_SHARE, ControlOutput, Mode, Scene};
use crate::dynamic_obstacles::NEAR_M;
use crate::turn;
use zeronav_motion::{Twist, reachable, towards_rest};
use zeronav_msgs::command::{RequestCause, Validity};
use zeronav_msgs::pose::wrap_angle;

/// [m/s] below which the robot may begin a turn on the spot.
const TURN_FROM_MPS: f64 = 0.15;

/// [s] that the robot waits for a dynamic obstacle nearby before a turn on the spot. The way that it
/// blocks is mostly free again by then.
const PATIENCE_S: f64 = 0.6;

/// Share of `turn_above_rad` above which a stopped robot turns on the spot: it loses no speed by it.
const STOPPED_SHARE: f64 = 0.5;

/// [rad] heading error below which a turn on the spot ends; far below every error at which one
/// begins, so that the robot does not rock between turning and driving.
const TURN_UNTIL_RAD: f64 = 0.15;

/// Share of the goal's tolerances that the robot aims for.
const AIM: f64 = 0.7;

impl Scene<'_> {
    /// Within the goal's tolerance: slow down to a stop, then turn to the goal's yaw.
    pub(super) fn arrive(&mut self) -> Option<ControlOutput> {
        let (situation, from) = (self.situation, self.from);
        let goal = situation.goal;
        let distance_m = situation.map_from_base.distance_m(&goal.pose);
        let content = distance_m <= AIM * goal.tolerance_m
            || (distance_m <= goal.tolerance_m && self.place.remaining_m < 0.02);
        let arrived =
            content || (self.memory.mode == Mode::Arrive && distance_m <= goal.tolerance_m);
        if !arrived {
            if self.memory.mode == Mode::Arrive {
                self.memory.mode = Mode::Follow;
            }
            return None;
        }
        let turning = self.memory.mode == Mode::Arrive && from.w_radps.abs() > 0.02;
        self.memory.mode = Mode::Arrive;
        self.memory.steered_radps = 0.0;
        self.memory.limit = Limit::of(RequestCause::Arrive);
        if from.v_mps.abs() >= 0.02 {
            // Towards rest in good order, on the arc of now.
            let slower = towards_rest(situation.robot, from, COMFORT_SHARE * situation.period_s);
            return Some(ControlOutput::Towards(slower));
        }
        let error_rad = wrap_angle(goal.pose.yaw_rad - situation.map_from_base.yaw_rad);
        let any_yaw = goal.yaw_tolerance_rad >= core::f64::consts::PI;
        let enough = if turning { 0.3 } else { AIM } * goal.yaw_tolerance_rad;
        if any_yaw || error_rad.abs() <= enough {
            return Some(ControlOutput::Rest(Validity::AtGoal));
        }
        let error_rad = turn::committed_rad(error_rad, sign(from.w_radps));
        self.memory.limit = Limit::of(RequestCause::GoalYaw);
        Some(self.turn_by(error_rad))
    }

    /// Align, then go: a slow robot that faces away from its local goal turns on the spot.
    pub(super) fn turn(&mut self, error_rad: f64, stuck: bool) -> Option<ControlOutput> {
        let (config, from) = (self.config, self.from);
        let (direction, limit_rad) = match self.memory.mode {
            Mode::Turn(direction) => (direction, TURN_UNTIL_RAD),
            _ if stuck => (0.0, TURN_UNTIL_RAD),
            _ if from.is_stopped() => (0.0, STOPPED_SHARE * config.turn_above_rad),
            _ if from.v_mps.abs() < TURN_FROM_MPS => (0.0, config.turn_above_rad),
            _ => return None,
        };
        if error_rad.abs() <= limit_rad {
            self.memory.mode = Mode::Follow;
            self.memory.astray_s = 0.0;
            return None;
        }
        self.memory.astray_s += self.situation.period_s;
        if self.memory.mode == Mode::Follow
            && self.seen.dynamic.is_within(NEAR_M)
            && self.memory.astray_s < PATIENCE_S
        {
            self.memory.limit = Limit::of(RequestCause::TurnWait);
            return Some(ControlOutput::Towards(Twist::REST));
        }
        let error_rad = turn::committed_rad(error_rad, direction);
        self.memory.limit = Limit::of(RequestCause::Turn);
        self.memory.mode = Mode::Turn(sign(error_rad));
        match self.turn_by(error_rad) {
            ControlOutput::Towards(twist) => Some(ControlOutput::Towards(twist)),
            // Neither way round is free: perhaps driving on is.
            ControlOutput::Rest(_) => {
                self.memory.mode = Mode::Follow;
                None
            }
        }
    }

    /// A turn by `error_rad`, the other way round when that one is not free. A turn that is not
    /// free to its end is not begun, or the robot would rock between two walls.
    fn turn_by(&mut self, error_rad: f64) -> ControlOutput {
        let (situation, from) = (self.situation, self.from);
        self.memory.steered_radps = 0.0;
        let robot = situation.robot;
        let other_rad = error_rad - core::f64::consts::TAU.copysign(error_rad);
        for error_rad in [error_rad, other_rad] {
            let wanted = Twist::new(0.0, turn::rate_radps(robot, error_rad));
            let next = reachable(robot, from, wanted, situation.period_s);
            // Slowing down is free wherever the robot could get to.
            let slowing = next.w_radps.abs() < from.w_radps.abs();
            let free = self.seen.surroundings.turn_is_free(error_rad)
                && (slowing || self.seen.stop_arc_m(self.config, robot, next).is_some());
            if free {
                self.memory.turns = true;
                return ControlOutput::Towards(wanted);
            }
        }
        ControlOutput::Rest(Validity::Blocked)
    }
}

fn sign(value: f64) -> f64 {
    if value > 0.0 {
        1.0
    } else if value < 0.0 {
        -1.0
    } else {
        0.0
    }
}
