//! What is not following the path: arriving, turning on the spot, backing up.

use super::{Dwa, Mode, Wish};
use crate::controller::Situation;
use crate::progress::Place;
use crate::turn;
use zeronav_motion::{Twist, reachable, towards_rest};
use zeronav_msgs::command::Validity;
use zeronav_msgs::pose::wrap_angle;

/// [m/s] below which the robot may begin a turn on the spot.
const TURN_FROM_MPS: f64 = 0.15;

/// [m/s] fastest way backwards out of a dead end.
const BACK_UP_MPS: f64 = 0.15;

/// [m] within which something that moves is waited for before a turn on the spot, and [s] how long.
/// The way that it blocks is mostly free again by then.
const NEAR_M: f64 = 2.5;
const PATIENCE_S: f64 = 0.6;

/// Share of the goal's tolerances within which the robot is content.
const CONTENT: f64 = 0.7;

impl Dwa {
    /// Within the goal's tolerance: slow down to a stand, then turn to the goal's yaw.
    pub(super) fn arrive(
        &mut self,
        situation: &Situation<'_>,
        place: &Place,
        from: Twist,
    ) -> Option<Wish> {
        let goal = situation.goal;
        let distance_m = situation.map_from_base.distance_m(&goal.pose);
        let content = distance_m <= CONTENT * goal.tolerance_m
            || (distance_m <= goal.tolerance_m && place.remaining_m < 0.02);
        let arrived = content || (self.mode == Mode::Arrive && distance_m <= goal.tolerance_m);
        if !arrived {
            if self.mode == Mode::Arrive {
                self.mode = Mode::Follow;
            }
            return None;
        }
        let turning = self.mode == Mode::Arrive && from.w_radps.abs() > 0.02;
        self.mode = Mode::Arrive;
        self.steered_radps = 0.0;
        if from.v_mps.abs() >= 0.02 {
            // Towards rest in good order, on the arc of now.
            let slower = towards_rest(
                situation.robot,
                from,
                self.config.comfort_share * situation.period_s,
            );
            return Some(Wish::Towards(slower));
        }
        let error_rad = wrap_angle(goal.pose.yaw_rad - situation.map_from_base.yaw_rad);
        let any_yaw = goal.yaw_tolerance_rad >= core::f64::consts::PI;
        let enough = if turning { 0.3 } else { CONTENT } * goal.yaw_tolerance_rad;
        if any_yaw || error_rad.abs() <= enough {
            return Some(Wish::Rest(Validity::AtGoal));
        }
        let error_rad = turn::committed_rad(error_rad, sign(from.w_radps));
        Some(self.turn_by(situation, from, error_rad))
    }

    /// Align, then go: a slow robot that faces away from its local goal turns on the spot.
    pub(super) fn turn(
        &mut self,
        situation: &Situation<'_>,
        from: Twist,
        error_rad: f64,
        stuck: bool,
    ) -> Option<Wish> {
        let config = &self.config;
        let (direction, limit_rad) = match self.mode {
            Mode::Turn(direction) => (direction, config.turn_until_rad),
            _ if stuck => (0.0, config.turn_until_rad),
            _ if from.is_stopped() => (0.0, config.turn_above_standing_rad),
            _ if from.v_mps.abs() < TURN_FROM_MPS => (0.0, config.turn_above_rad),
            _ => return None,
        };
        if error_rad.abs() <= limit_rad {
            self.mode = Mode::Follow;
            self.astray_s = 0.0;
            return None;
        }
        self.astray_s += situation.period_s;
        if self.mode == Mode::Follow && self.moving.is_within(NEAR_M) && self.astray_s < PATIENCE_S
        {
            return Some(Wish::Towards(Twist::REST));
        }
        let error_rad = turn::committed_rad(error_rad, direction);
        self.mode = Mode::Turn(sign(error_rad));
        match self.turn_by(situation, from, error_rad) {
            Wish::Towards(twist) => Some(Wish::Towards(twist)),
            // Neither way round is free: perhaps driving on is.
            Wish::Rest(_) => {
                self.mode = Mode::Follow;
                None
            }
        }
    }

    /// A turn by `error_rad`, the other way round when that one is not free. A turn that is not
    /// free to its end is not begun, or the robot would rock between two walls.
    fn turn_by(&mut self, situation: &Situation<'_>, from: Twist, error_rad: f64) -> Wish {
        self.steered_radps = 0.0;
        let robot = situation.robot;
        let other_rad = error_rad - core::f64::consts::TAU.copysign(error_rad);
        for error_rad in [error_rad, other_rad] {
            let wanted = Twist::new(0.0, turn::rate_radps(robot, error_rad));
            let next = reachable(robot, from, wanted, situation.period_s);
            // Slowing down is free wherever the robot could get to.
            let slowing = next.w_radps.abs() < from.w_radps.abs();
            let free = self.surroundings.turn_is_free(error_rad)
                && (slowing || self.stop_arc_m(situation, next).is_some());
            if free {
                return Wish::Towards(wanted);
            }
        }
        Wish::Rest(Validity::Blocked)
    }

    /// Backwards in a straight line as far as it is free, once begun.
    pub(super) fn back_up(&mut self, situation: &Situation<'_>, from: Twist) -> Option<Wish> {
        let Mode::BackUp(left_m) = self.mode else {
            return None;
        };
        let left_m = left_m - from.v_mps.abs() * situation.period_s;
        let back_mps = situation.robot.v_mps_min.max(-BACK_UP_MPS);
        let wanted = Twist::new(back_mps, 0.0);
        let next = reachable(situation.robot, from, wanted, situation.period_s);
        if left_m <= 0.0 || self.stop_arc_m(situation, next).is_none() {
            self.mode = Mode::Follow;
            return None;
        }
        self.mode = Mode::BackUp(left_m);
        Some(Wish::Towards(wanted))
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
