//! The seam between the pilot and its choosers: from a scene to an output.

use super::limit::Limit;
use super::perception::{Perception, horizon_s};
use crate::dwa::options::{DwaConfig, DwaWeights};
use crate::dwa::window::{Range, Window};
use crate::lanes::data::LANES_MAX;
use crate::progress::Place;
use crate::record::Record;
use crate::rollout_scores::RolloutScore;
use crate::situation::Situation;
use core::fmt;
use nalgebra::{Point2, Vector2};
use zeronav_motion::Twist;
use zeronav_msgs::command::{RequestCause, Validity};

/// [m/s] slowest speed wanted at a corner, and speed at which a robot that must turn steers.
pub(crate) const CREEP_MPS: f64 = 0.12;

/// [m] by which a corner of the path may be cut or overrun, which bounds the speed there: less
/// than the soft clearance, so that a corner around an obstacle may be cut.
const CORNER_DEVIATION_M: f64 = 0.15;

/// Share of the robot's `brake_mps2` that slows it down when nothing is urgent; the rest is for what
/// comes unexpectedly.
pub(crate) const COMFORT_SHARE: f64 = 0.7;

/// [s] stopped with somewhere to go after which the robot counts as blocked.
pub(super) const BLOCKED_S: f64 = 0.1;

/// [m] of path that are left when rotation room no longer matters.
const FINAL_M: f64 = 0.5;

/// Chooses where to go next.
pub(crate) trait Choose: fmt::Debug {
    /// The output of this period. Not called while the robot arrives or has no path.
    fn choose(&mut self, scene: &mut Scene<'_>) -> ControlOutput;

    /// The robot did something else than the last choice: plans that build on it are void.
    fn forget(&mut self) {}
}

/// The target of a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ControlOutput {
    /// Go on towards this twist.
    Towards(Twist),
    /// Ramp to rest, and why.
    Rest(Validity),
}

/// The phase of the drive that the pilot is in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mode {
    /// Driving along the path.
    Follow,
    /// Turning on the spot towards the path; +1 = left.
    Turn(f64),
    /// Within the goal's tolerance: stop, then turn to its yaw.
    Arrive,
}

/// What the pilot keeps from period to period.
#[derive(Debug)]
pub(crate) struct Memory {
    pub(crate) mode: Mode,
    goal: u64,
    /// Published last.
    pub(crate) last: Twist,
    /// Yaw rate steered for last. [rad/s]
    pub(crate) steered_radps: f64,
    /// Stopped without an admissible motion for so long. [s]
    pub(crate) blocked_s: f64,
    /// Facing away from the path, slow or stopped, for so long. [s]
    pub(crate) astray_s: f64,
    /// Of this period: the best twist of each speed with its worth, best first.
    pub(crate) reserve: Vec<(f64, Twist)>,
    /// Of this period: the output begins a sequence that a search in time has found free of what moves.
    pub(crate) searched: bool,
    /// Of this period: motions looked at.
    pub(crate) rollouts: u32,
    /// Of this period: the output is a turn on the spot.
    pub(crate) turns: bool,
    /// Of this period: what limits the speed, to explain it.
    pub(crate) limit: Limit,
    /// Of this period: where an obstacle keeps the robot from going straight to its goal, `map` frame.
    /// [m] For choosers that do not follow the path, to explain it.
    pub(crate) against: Option<Point2<f64>>,
    /// Of this period: what was looked at, while somebody wants to know.
    pub(crate) record: Option<Box<Record>>,
}

impl Default for Memory {
    fn default() -> Self {
        Self {
            mode: Mode::Follow,
            goal: 0,
            last: Twist::REST,
            steered_radps: 0.0,
            blocked_s: 0.0,
            astray_s: 0.0,
            reserve: Vec::with_capacity(LANES_MAX),
            searched: false,
            rollouts: 0,
            turns: false,
            limit: Limit::NONE,
            against: None,
            record: None,
        }
    }
}

impl Memory {
    /// A period begins.
    pub(crate) fn begin(&mut self, goal: u64) {
        self.rollouts = 0;
        self.searched = false;
        self.turns = false;
        self.limit = Limit::NONE;
        self.against = None;
        self.reserve.clear();
        if goal != self.goal {
            self.goal = goal;
            self.mode = Mode::Follow;
        }
    }
}

/// One control period as a chooser sees it.
#[derive(Debug)]
pub(crate) struct Scene<'a> {
    pub(crate) situation: &'a Situation<'a>,
    pub(crate) config: &'a DwaConfig,
    pub(crate) place: Place,
    /// Twist that the motions start from.
    pub(crate) from: Twist,
    pub(crate) seen: &'a mut Perception,
    pub(crate) memory: &'a mut Memory,
}

/// Where the path leads from here.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Heading {
    /// Local goal in `base`. [m]
    pub(crate) to_goal: Vector2<f64>,
    /// [m/s] fastest speed that the goal, the corners ahead and the age of the inputs allow.
    pub(crate) fastest_mps: f64,
}

impl<'a> Scene<'a> {
    /// Makes the cost-to-go current for a chooser that asks for it; see
    /// [`Perception::find_cost_to_go`].
    pub(crate) fn find_cost_to_go(&mut self, puts_off: bool) {
        self.seen
            .find_cost_to_go(self.config, self.situation, &self.place, puts_off);
    }

    /// Where the path leads, or the output to turn towards it on the spot first.
    pub(crate) fn heading(&mut self) -> Result<Heading, ControlOutput> {
        let to_goal = self.to_local_goal();
        let error_rad = to_goal.y.atan2(to_goal.x);
        // Too near a point to have a direction.
        let meaningful = to_goal.norm() > 0.05;
        let stuck = self.memory.blocked_s > BLOCKED_S;
        if meaningful && let Some(output) = self.turn(error_rad, stuck) {
            return Err(output);
        }
        let astray = meaningful && error_rad.abs() > self.config.turn_above_rad;
        self.memory.limit = self.fastest(astray);
        Ok(Heading {
            to_goal,
            fastest_mps: self.memory.limit.v_mps,
        })
    }

    /// [m/s] fastest speed that the age of the inputs and zones allow.
    pub(crate) fn top_speed_mps(&self) -> f64 {
        self.aged_mps().min(self.situation.zone_mps)
    }

    /// [m/s] the same without zones.
    fn aged_mps(&self) -> f64 {
        self.situation.robot.v_mps_max * self.situation.speed_factor.clamp(0.0, 1.0)
    }

    /// What the fastest speed depends on, and that. [m/s]
    pub(crate) fn top(&self) -> (RequestCause, f64) {
        let cause = if self.situation.zone_mps < self.aged_mps() {
            RequestCause::SpeedZone
        } else if self.situation.speed_factor < 1.0 {
            RequestCause::Ageing
        } else {
            RequestCause::Free
        };
        (cause, self.top_speed_mps())
    }

    /// The limit of a search in time, which may ask for every speed.
    pub(crate) fn searched(&self) -> Limit {
        let (cause, v_mps) = self.top();
        Limit {
            slower: RequestCause::TimedSearch,
            ..Limit::at(cause, v_mps)
        }
    }

    /// The output to go on towards a chosen twist.
    pub(crate) fn steer(&mut self, twist: Twist) -> ControlOutput {
        self.memory.steered_radps = twist.w_radps;
        ControlOutput::Towards(twist)
    }

    /// The same for a choice; without one, a ramp to rest.
    pub(crate) fn steer_or_rest(&mut self, choice: Option<Twist>) -> ControlOutput {
        choice.map_or(ControlOutput::Rest(Validity::Blocked), |twist| {
            self.steer(twist)
        })
    }

    /// The local goal in `base`. [m]
    fn to_local_goal(&self) -> Vector2<f64> {
        // Beside the path it is approached at an angle, and a corner cut on the inside is left
        // forwards.
        let lookahead_m = self
            .config
            .lookahead_m_min
            .max(self.config.lookahead_s * self.from.v_mps.abs())
            + 1.5 * self.place.cross_track_m;
        let surroundings = &self.seen.surroundings;
        let inscribed_m = surroundings.footprint.inscribed_m;
        let in_map = self
            .seen
            .path
            .local_goal(&surroundings.field, inscribed_m, lookahead_m);
        let (sin, cos) = self.situation.map_from_base.yaw_rad.sin_cos();
        Vector2::new(
            cos * in_map.x + sin * in_map.y,
            cos * in_map.y - sin * in_map.x,
        )
    }

    /// The fastest speed that the goal, the corners ahead and the age of the inputs allow.
    fn fastest(&self, astray: bool) -> Limit {
        let robot = self.situation.robot;
        let decel_mps2 = COMFORT_SHARE * robot.brake_mps2;
        let beside_m = (self.place.cross_track_m - self.situation.goal.tolerance_m).max(0.0);
        let goal_mps = (2.0 * decel_mps2 * (self.place.remaining_m + beside_m)).sqrt();
        let corner_mps = self.seen.path.corner_speed_mps(
            CORNER_DEVIATION_M,
            0.8 * robot.w_radps_max,
            decel_mps2,
            CREEP_MPS.min(robot.v_mps_max),
        );
        let astray_mps = if astray { CREEP_MPS } else { f64::INFINITY };
        Limit::lowest(&[
            self.top(),
            (RequestCause::Goal, goal_mps.max(0.03)),
            (RequestCause::Corner, corner_mps),
            (RequestCause::Heading, astray_mps),
        ])
    }

    /// The dynamic window (Fox, Burgard, Thrun 1997, Eq. 14) as wide as `window_s` allows.
    pub(crate) fn window(&self, heading: &Heading) -> Window<'a> {
        let (config, robot, from) = (self.config, self.situation.robot, self.from);
        let footprint = &self.seen.surroundings.footprint;
        let blocked = self.seen.blocked_arc_m().is_some();
        let low = (from.v_mps - robot.brake_mps2 * config.window_s).max(0.0);
        let high = (from.v_mps + robot.a_mps2_max * config.window_s).min(heading.fastest_mps);
        let about = robot.alpha_radps2_max * config.window_s;
        // Pure pursuit: the arc through the local goal has the curvature 2 y / l^2.
        let to_goal = heading.to_goal;
        let curvature = 2.0 * to_goal.y / to_goal.norm_squared().max(0.01);
        // Before an obstacle across the path there must be room to turn away from it.
        let rotation_room_m = if blocked && self.place.remaining_m > FINAL_M {
            footprint.circumscribed_m - footprint.inscribed_m
        } else {
            0.0
        };
        Window {
            robot,
            from,
            speeds: Range {
                low,
                high: high.max(low),
            },
            yaw_rates: Range {
                low: (from.w_radps - about).max(-robot.w_radps_max),
                high: (from.w_radps + about).min(robot.w_radps_max),
            },
            preferred_radps: curvature * heading.fastest_mps.clamp(low, high.max(low)),
            yaw_rad: self.situation.map_from_base.yaw_rad,
            step_s: config.step_s,
            horizon_s: horizon_s(config, robot),
            reaction_s: config.reaction_s,
            stop_margin_m: config.stop_margin_m + rotation_room_m,
            soft_m: config.soft_clearance_m,
        }
    }

    /// What a rollout at a speed is worth besides what it leads to.
    pub(crate) fn worth_at(&self, v_mps: f64) -> RolloutScore {
        let (config, robot) = (self.config, self.situation.robot);
        // A goal beside a wall must be reached: nearness costs less and less on the last metre.
        let clearance = config.weights.clearance * self.place.remaining_m.min(1.0);
        RolloutScore {
            weights: DwaWeights {
                clearance,
                ..config.weights
            },
            speed: v_mps / robot.v_mps_max,
            steered_radps: self.memory.steered_radps,
            w_radps_max: robot.w_radps_max,
            soft_m: config.soft_clearance_m,
            hard_m: config.safety_margin_m.min(0.9 * config.soft_clearance_m),
        }
    }
}
