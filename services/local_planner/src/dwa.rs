//! `dwa`: a dynamic window that follows a path.
//!
//! Source: Fox, Burgard, Thrun, "The Dynamic Window Approach to Collision Avoidance", IEEE
//! Robotics and Automation Magazine 4(1), 1997: sample the twists that the accelerations allow,
//! drop those from which the robot could not stop, take the best of the rest. The differences:
//!
//! - **Guidance is the path, not the goal's direction**: progress along it, distance from it and
//!   heading against it, all at places of the rollout. A robot that faces away from the path turns
//!   on the spot first; the speed is bounded ahead of corners and the goal.
//! - **The window is longer than a control period.** At 50 Hz one period allows a change of some
//!   2 cm/s, within which nothing can be told apart. The window spans
//!   [`DwaConfig::window_s`]; rollouts ramp to their target as the robot would; the published
//!   twist is the part of the way that this period allows.
//! - **What is published is checked itself**: hold the twist for the reaction time, then ramp to
//!   rest, on poses 3 cm apart, against the map and every point of the scan with the true outline.
//!   If that is not free the robot slows down, along the stop that was checked the period before.
//!   So a verified stop exists at every moment, and the rollouts only decide what is wise.
//!
//! A robot that stands inside the safety margin (noise, a new obstacle) may move as long as it
//! does not come nearer.

mod guidance;
mod manoeuvre;
pub mod options;
pub(crate) mod row;
mod timed;

use crate::controller::{Controller, Decision, Situation};
use crate::dwa::options::DwaConfig;
use crate::dwa_t::options::DwaTConfig;
use crate::funnel::Funnel;
use crate::local_path::LocalPath;
use crate::moving::Moving;
use crate::progress::{PathTracker, Place};
use crate::refine::{Refine, Sight};
use crate::rollout::Rollouts;
use crate::shaping::Shaper;
use crate::shaping::ShapingConfig;
use crate::standing::StandingMap;
use crate::surroundings::{Reach, Surroundings};
use timed::Timed;
use zeronav_motion::{Twist, stop_distance_m, towards_rest};
use zeronav_msgs::command::Validity;

/// [s] of standing with somewhere to go after which the robot counts as stuck.
const STUCK_S: f64 = 0.1;

/// [s] of driving at full speed that the sampled stretch of the path spans at most.
const PATH_HORIZON_S: f64 = 1.5;

/// Twists that are tried at most, best first, when the best one is not free.
const RESERVE: usize = 6;

/// What the robot is about.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    /// Driving along the path.
    Follow,
    /// Turning on the spot towards the path; +1 = left.
    Turn(f64),
    /// Within the goal's tolerance: stop, then turn to its yaw.
    Arrive,
    /// Backing out of a dead end, so many metres still.
    BackUp(f64),
}

/// The target of a period.
enum Wish {
    /// Go on towards this twist.
    Towards(Twist),
    /// Ramp to rest, and why.
    Rest(Validity),
}

/// The controllers `dwa` and `dwa_t`.
#[derive(Debug, Clone)]
pub struct Dwa {
    config: DwaConfig,
    tracker: PathTracker,
    path: LocalPath,
    surroundings: Surroundings,
    rollouts: Rollouts,
    mode: Mode,
    goal: u64,
    /// Published last.
    last: Twist,
    /// Yaw rate steered for last. [rad/s]
    steered_radps: f64,
    /// Standing without an admissible motion for so long. [s]
    blocked_s: f64,
    /// Facing away from the path, slow or standing, for so long. [s]
    astray_s: f64,
    looked_at: u32,
    moving: Moving,
    shaper: Shaper,
    /// What `dwa_t` adds.
    timed: Option<Timed>,
    /// [m] that must be known around the robot, and the map without what moves; `None` = what moves
    /// is avoided where it was seen, too.
    standing: Option<(f64, StandingMap)>,
}

impl Dwa {
    /// A controller at rest. The numbers must be those that
    /// [`crate::config::LocalPlannerConfig::check`] accepts.
    #[must_use]
    pub fn new(config: DwaConfig) -> Self {
        Self {
            config,
            tracker: PathTracker::new(),
            path: LocalPath::default(),
            surroundings: Surroundings::default(),
            rollouts: Rollouts::default(),
            mode: Mode::Follow,
            goal: 0,
            last: Twist::REST,
            steered_radps: 0.0,
            blocked_s: 0.0,
            astray_s: 0.0,
            looked_at: 0,
            moving: Moving::default(),
            shaper: Shaper::new(ShapingConfig::OFF),
            timed: None,
            standing: None,
        }
    }

    /// The time-indexed dynamic window, at rest.
    #[must_use]
    pub fn timed(config: DwaConfig, timed: DwaTConfig) -> Self {
        let config = DwaConfig {
            horizon_s: timed.horizon_s,
            step_s: timed.horizon_s / f64::from(timed.steps),
            ..config
        };
        Self {
            timed: Some(Timed::new(timed)),
            ..Self::new(config)
        }
    }

    /// The same that takes what moves for an obstacle where it will be alone, and knows its
    /// surroundings as far as `sight_m`.
    #[must_use]
    pub(crate) fn among_what_moves(self, sight_m: f64) -> Self {
        Self {
            standing: Some((sight_m, StandingMap::default())),
            ..self
        }
    }

    /// The same with commands whose accelerations change no faster than this.
    #[must_use]
    pub fn shaped(self, config: ShapingConfig) -> Self {
        Self {
            shaper: Shaper::new(config),
            ..self
        }
    }

    /// The twist that this period's command starts from: the last command, as far as the
    /// measured twist can have followed it.
    fn start(&self, situation: &Situation<'_>) -> Twist {
        let measured = Twist::new(situation.v_mps, situation.w_radps);
        self.last
            .near(situation.robot, measured, self.config.command_lead_s)
    }

    /// [s] length of a rollout: at least the time of a stop from full speed.
    fn horizon_s(&self, situation: &Situation<'_>) -> f64 {
        let robot = situation.robot;
        let stop_m = stop_distance_m(robot, robot.v_mps_max, self.config.reaction_s)
            + self.config.stop_margin_m;
        self.config.horizon_s.max(stop_m / robot.v_mps_max)
    }

    /// Samples the path and looks around.
    fn look(&mut self, situation: &Situation<'_>, place: &Place) {
        let robot = situation.robot;
        self.surroundings.describe(robot, situation.corners);
        let mut sight_m = robot.v_mps_max * self.horizon_s(situation) + 0.5;
        let position = situation.map_from_base.point();
        // Sampled as densely as the weights of the evaluation are meant for.
        let path_m = robot.v_mps_max * self.horizon_s(situation).min(PATH_HORIZON_S) + 0.5;
        self.path
            .sample(&self.tracker, situation.path, place, position, path_m);
        // Taken out for as long as the map is looked at through it.
        let mut standing = self.standing.take();
        let mut map = situation.map.map(|map| (map, situation.map_cells));
        if let (Some((known_m, standing)), Some((whole, cells))) = (&mut standing, map)
            && !situation.obstacles.is_empty()
        {
            sight_m = sight_m.max(*known_m);
            map = Some(standing.view(whole, cells, position, Funnel::half_m(sight_m)));
        }
        let reach = Reach {
            field_m: sight_m,
            stop_m: stop_distance_m(robot, robot.v_mps_max, self.config.reaction_s),
            soft_m: self.config.soft_clearance_m,
            margin_m: self.config.safety_margin_m,
        };
        let points = situation.scan_points_in_base;
        let stamped = self.timed.as_mut().map_or(points, |timed| {
            timed.standing_points(situation, &mut self.moving)
        });
        self.surroundings
            .look(map, &situation.map_from_base, points, stamped, reach);
        self.guide(situation, map, place, sight_m);
        self.standing = standing;
    }

    fn wish(
        &mut self,
        situation: &Situation<'_>,
        place: &Place,
        from: Twist,
        mut refiner: Option<&mut dyn Refine>,
    ) -> Wish {
        if let Some(wish) = self.arrive(situation, place, from) {
            return wish;
        }
        if let Some(wish) = self.back_up(situation, from) {
            return wish;
        }
        let fastest = situation.robot.v_mps_max * situation.speed_factor.clamp(0.0, 1.0);
        let led = refiner
            .as_mut()
            .and_then(|refiner| refiner.lead(self.sight(situation, place, from, fastest, None)));
        if let Some(twist) = led {
            self.mode = Mode::Follow;
            self.astray_s = 0.0;
            self.steered_radps = twist.w_radps;
            return Wish::Towards(twist);
        }
        let to_goal = self.to_local_goal(situation, place, from);
        let error_rad = to_goal.y.atan2(to_goal.x);
        // Too near a point to have a direction.
        let meaningful = to_goal.norm() > 0.05;
        let stuck = self.blocked_s > STUCK_S;
        if meaningful && let Some(wish) = self.turn(situation, from, error_rad, stuck) {
            return wish;
        }
        if stuck && situation.robot.v_mps_min < 0.0 && self.blocked_s >= self.config.back_up_after_s
        {
            self.blocked_s = 0.0;
            self.mode = Mode::BackUp(self.config.back_up_m);
        }
        let astray = meaningful && error_rad.abs() > self.config.turn_above_rad;
        let fastest = self.fastest_mps(situation, place, astray);
        let best = self.best(situation, place, from, fastest, to_goal);
        let refined = refiner
            .and_then(|refiner| refiner.refine(self.sight(situation, place, from, fastest, best)));
        if let Some(twist) = refined {
            self.steered_radps = twist.w_radps;
        }
        refined
            .or(best)
            .map_or(Wish::Rest(Validity::Blocked), Wish::Towards)
    }

    /// What an optimiser in place of the window gets to see.
    fn sight<'a>(
        &'a mut self,
        situation: &'a Situation<'a>,
        place: &Place,
        from: Twist,
        fastest_mps: f64,
        best: Option<Twist>,
    ) -> Sight<'a> {
        Sight {
            situation,
            config: &self.config,
            tracker: &self.tracker,
            place: *place,
            from,
            fastest_mps,
            surroundings: &self.surroundings,
            moving: &mut self.moving,
            funnel: self
                .timed
                .as_ref()
                .filter(|_| situation.map.is_some())
                .map(Timed::funnel),
            best,
        }
    }

    /// [m] along the path to the first obstacle in sight.
    fn blocked_arc_m(&self) -> Option<f64> {
        self.path.blocked_m(
            &self.surroundings.field,
            self.surroundings.footprint.inscribed_m,
        )
    }

    fn stop_arc_m(&self, situation: &Situation<'_>, twist: Twist) -> Option<f64> {
        self.surroundings
            .stop_arc_m(situation.robot, twist, self.config.reaction_s, &self.moving)
    }

    /// The first step towards the wish from which a stop is free; else the first step of a stop.
    fn publish(&mut self, situation: &Situation<'_>, from: Twist, wish: &Wish) -> Decision {
        let (robot, period_s) = (situation.robot, situation.period_s);
        let rest = towards_rest(robot, from, period_s);
        let braking_m = stop_distance_m(robot, rest.v_mps, 0.0);
        let (twist, validity, braking_arc_m) = match wish {
            Wish::Rest(validity) => (rest, *validity, braking_m),
            Wish::Towards(wanted) => {
                let slowed = Twist::new(0.0, wanted.w_radps);
                let reserve = self.timed.iter().flat_map(|timed| &timed.reserve);
                let others = reserve
                    .map(|(_, twist)| *twist)
                    .take(RESERVE)
                    .filter(|twist| twist != wanted);
                core::iter::once(*wanted)
                    .chain(others)
                    .chain(core::iter::once(slowed))
                    .find_map(|wanted| {
                        let next = self.shaper.next(robot, from, wanted, period_s);
                        let arc_m = self.stop_arc_m(situation, next)?;
                        Some((next, Validity::Drive, arc_m))
                    })
                    .unwrap_or((rest, Validity::Blocked, braking_m))
            }
        };
        // Standing although something was wished is being blocked, whoever is to blame.
        let resting = matches!(wish, Wish::Rest(Validity::AtGoal | Validity::NoPath));
        let idle = from.is_stopped()
            && twist.v_mps.abs() < 0.5 * robot.a_mps2_max * period_s
            && twist.w_radps.abs() < 0.5 * robot.alpha_radps2_max * period_s;
        self.blocked_s = if resting || !idle {
            0.0
        } else {
            self.blocked_s + period_s
        };
        let validity = match validity {
            Validity::Drive if self.blocked_s > STUCK_S => Validity::Blocked,
            other => other,
        };
        self.last = twist;
        if twist == rest {
            self.shaper.interrupted();
        } else {
            self.shaper.published(from, twist, period_s);
        }
        Decision {
            v_mps: twist.v_mps,
            w_radps: twist.w_radps,
            validity,
            braking_arc_m,
            rollouts: self.looked_at,
            blocked_arc_m: None,
        }
    }
}

impl Controller for Dwa {
    fn decide(&mut self, situation: &Situation<'_>) -> Decision {
        self.decide_with(situation, None)
    }

    fn overruled(&mut self, published: Twist) {
        self.shaper.interrupted();
        self.last = published;
    }
}

impl Dwa {
    /// [`Controller::decide`] with another optimiser for the twist that follows the path.
    pub(crate) fn decide_with(
        &mut self,
        situation: &Situation<'_>,
        refiner: Option<&mut dyn Refine>,
    ) -> Decision {
        self.looked_at = 0;
        if let Some(timed) = &mut self.timed {
            timed.reserve.clear();
        }
        if situation.goal.id != self.goal {
            self.goal = situation.goal.id;
            self.mode = Mode::Follow;
        }
        let from = self.start(situation);
        let place = self.tracker.advance(
            situation.path_geometry,
            situation.path,
            situation.map_from_base.point(),
        );
        let Some(place) = place else {
            self.mode = Mode::Follow;
            return self.publish(situation, from, &Wish::Rest(Validity::NoPath));
        };
        self.look(situation, &place);
        let wish = self.wish(situation, &place, from, refiner);
        let blocked_arc_m = self.blocked_arc_m();
        Decision {
            blocked_arc_m,
            ..self.publish(situation, from, &wish)
        }
    }
}
