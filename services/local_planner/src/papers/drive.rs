//! From the direction of a law to a twist, and the checks that no controller goes without.
//!
//! Direction to twist as the paper notes define it: `v = v_max max(0, cos err)`,
//! `w = clamp(2 err)`, within the accelerations. `yield`: the speed is scaled by
//! `min(1, TTC / 2 s)`. What is published must be a twist from which the robot can stop before
//! contact; otherwise the robot turns towards the direction on the spot, or stops.

use super::bao_dwa::{self, BaoWeights};
use super::scene::{Body, Extent, Law, Push, Scene};
use crate::controller::{Controller, Decision, Situation};
use crate::dwa::options::DwaConfig;
use crate::dynamic_obstacles::{DynamicObstacles, Growth};
use crate::lanes::data::narrow;
use crate::local_path::LocalPath;
use crate::pilot::verify::first_with_free_stop;
use crate::progress::PathTracker;
use crate::shaping::Shaper;
use crate::shaping::ShapingConfig;
use crate::surroundings::{LocalPose, Reach, Surroundings};
use crate::turn;
use nalgebra::{Point2, Vector2};
use zeronav_motion::{Twist, stop_distance_m, towards_rest};
use zeronav_msgs::command::Validity;
use zeronav_msgs::pose::wrap_angle;

/// [1/s] yaw rate per radian of heading error.
const TURN_GAIN_HZ: f64 = 2.0;

/// [s] time to contact below which the robot yields.
const YIELD_S: f64 = 2.0;

/// [m] between neighbouring hits of the scan that belong to two obstacles.
const GAP_M: f64 = 0.3;

/// [m] from the robot within which obstacles are looked at.
const RANGE_M: f64 = 3.0;

/// [m] look-ahead of `bao_dwa` along the path.
const LOOKAHEAD_M: f64 = 1.0;

/// Share of the goal's tolerance within which the robot stops.
const CONTENT: f64 = 0.7;

/// [m/s] below which the robot stands.
const STANDING_MPS: f64 = 0.02;

/// What says where to go.
enum Steer {
    /// A direction.
    Law(Box<dyn Law>),
    /// A twist of the dynamic window.
    Window(BaoWeights),
}

/// A law at the wheels.
pub struct Driver {
    steer: Steer,
    config: DwaConfig,
    literal: bool,
    tracker: PathTracker,
    path: LocalPath,
    surroundings: Surroundings,
    moving: DynamicObstacles,
    bodies: Vec<Body>,
    last: Twist,
    blocked_s: f64,
    /// Of this period: the wish is a turn on the spot.
    turns: bool,
    shaper: Shaper,
}

impl Driver {
    /// A controller that goes where `law` says; `literal` = obstacles are points.
    #[must_use]
    pub fn new(law: Box<dyn Law>, config: DwaConfig, literal: bool) -> Self {
        Self::steered(Steer::Law(law), config, literal)
    }

    /// A controller that takes the twists of `bao_dwa`.
    #[must_use]
    pub fn window(weights: BaoWeights, config: DwaConfig) -> Self {
        Self::steered(Steer::Window(weights), config, false)
    }

    fn steered(steer: Steer, config: DwaConfig, literal: bool) -> Self {
        Self {
            steer,
            config,
            literal,
            tracker: PathTracker::new(),
            path: LocalPath::default(),
            surroundings: Surroundings::default(),
            moving: DynamicObstacles::default(),
            bodies: Vec::new(),
            last: Twist::REST,
            blocked_s: 0.0,
            turns: false,
            shaper: Shaper::new(ShapingConfig::OFF),
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

    /// One body per obstacle in the scan: neighbouring hits without a gap between them. Areas are
    /// represented by their nearest hit, points by the middle of their hits; both as far around
    /// them as the robot's inscribed disc reaches.
    fn gather(&mut self, situation: &Situation<'_>) {
        self.bodies.clear();
        let pose = situation.map_from_base;
        let extent = Extent::Disc(if self.literal {
            0.0
        } else {
            self.surroundings.footprint.inscribed_m
        });
        let mut group: Option<(Point2<f64>, Vector2<f64>, f64)> = None;
        let mut last: Option<Point2<f64>> = None;
        let literal = self.literal;
        let bodies = &mut self.bodies;
        let moving = &self.moving;
        let mut finish = |group: Option<(Point2<f64>, Vector2<f64>, f64)>| {
            if let Some((nearest, sum, n)) = group {
                let in_base = if literal {
                    Point2::from(sum / n)
                } else {
                    nearest
                };
                bodies.push(Body {
                    at: pose.transform(in_base),
                    extent,
                    velocity: moving.velocity_at(nearest),
                });
            }
        };
        for point in situation.scan_points_in_base {
            if point.coords.norm() > RANGE_M {
                continue;
            }
            let joined = last.is_some_and(|last| (point - last).norm() < GAP_M);
            last = Some(*point);
            group = match group {
                Some((nearest, sum, n)) if joined => {
                    let nearer = point.coords.norm() < nearest.coords.norm();
                    let nearest = if nearer { *point } else { nearest };
                    Some((nearest, sum + point.coords, n + 1.0))
                }
                before => {
                    finish(before);
                    Some((*point, point.coords, 1.0))
                }
            };
        }
        finish(group);
    }

    /// The twist that the law wants, or why none is.
    fn wish(&mut self, situation: &Situation<'_>, remaining_m: f64) -> Result<Twist, Validity> {
        let (robot, pose) = (situation.robot, situation.map_from_base);
        let goal = situation.goal;
        let distance_m = pose.distance_m(&goal.pose);
        if distance_m <= CONTENT * goal.tolerance_m {
            let error_rad = wrap_angle(goal.pose.yaw_rad - pose.yaw_rad);
            let any_yaw = goal.yaw_tolerance_rad >= core::f64::consts::PI;
            let aligned = any_yaw || error_rad.abs() <= CONTENT * goal.yaw_tolerance_rad;
            if aligned || self.last.v_mps.abs() > STANDING_MPS {
                return Err(Validity::AtGoal);
            }
            self.turns = true;
            return Ok(Twist::new(0.0, turn::rate_radps(robot, error_rad)));
        }
        let decel_mps2 = self.config.comfort_share * robot.brake_mps2;
        let goal_mps = (2.0 * decel_mps2 * remaining_m.max(distance_m)).sqrt();
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let velocity = Vector2::new(cos, sin) * situation.v_mps;
        let law = match &mut self.steer {
            Steer::Law(law) => law,
            Steer::Window(weights) => {
                let weights = *weights;
                let twist = self.window_wish(situation, &weights, distance_m)?;
                return Ok(Twist::new(twist.v_mps.min(goal_mps), twist.w_radps));
            }
        };
        let scene = Scene {
            at: pose.point(),
            velocity,
            goal: goal.pose.point(),
            bodies: &self.bodies,
            path: situation.path,
            geometry: situation.path_geometry,
            literal: self.literal,
        };
        let Push::Along(force) = law.push(&scene) else {
            return Err(Validity::Blocked);
        };
        if force.norm() < 1.0e-9 {
            return Err(Validity::Blocked);
        }
        let error_rad = wrap_angle(force.y.atan2(force.x) - pose.yaw_rad);
        let radius_m = self.surroundings.footprint.circumscribed_m;
        let contact_s = self.moving.contact_s((velocity.x, velocity.y), radius_m);
        let calm = (contact_s / YIELD_S).min(1.0) * situation.speed_factor.clamp(0.0, 1.0);
        let v_mps = robot.v_mps_max * error_rad.cos().max(0.0) * calm;
        let w_radps = (TURN_GAIN_HZ * error_rad).clamp(-robot.w_radps_max, robot.w_radps_max);
        Ok(Twist::new(v_mps.min(goal_mps), w_radps))
    }

    /// The best admissible twist of `bao_dwa`; without one the robot stops, then turns towards
    /// its local goal.
    fn window_wish(
        &mut self,
        situation: &Situation<'_>,
        weights: &BaoWeights,
        distance_m: f64,
    ) -> Result<Twist, Validity> {
        let (robot, pose) = (situation.robot, situation.map_from_base);
        let from = Twist::new(situation.v_mps.max(0.0), situation.w_radps);
        let inscribed_m = self.surroundings.footprint.inscribed_m;
        let field = &self.surroundings.field;
        let local = self.path.local_goal(field, inscribed_m, LOOKAHEAD_M);
        let goal_in_base = pose.isometry().rotation.inverse() * local;
        let (vs, ws) = bao_dwa::window(robot, from, weights.period_s);
        let (v_step, w_step) = bao_dwa::steps();
        let fastest_mps = robot.v_mps_max * situation.speed_factor.clamp(0.0, 1.0);
        let mut admissible = Vec::new();
        for v in bao_dwa::samples(vs, v_step) {
            for &w in &bao_dwa::samples(ws, w_step) {
                let twist = Twist::new(v.min(fastest_mps.max(vs.low)), w);
                let (free_m, near_m) = self.arc(situation, twist, weights);
                if !bao_dwa::is_admissible(robot, twist, free_m) {
                    continue;
                }
                let end = twist.arc(weights.horizon_s.min(distance_m / v.max(0.1)));
                let to_goal = goal_in_base - Vector2::new(end.x_m, end.y_m);
                let error_rad = wrap_angle(to_goal.y.atan2(to_goal.x) - end.yaw_rad);
                admissible.push(bao_dwa::Sample {
                    twist,
                    head: core::f64::consts::PI - error_rad.abs(),
                    dist: near_m.min(distance_m).max(0.0),
                });
            }
        }
        let best = bao_dwa::choose(&admissible, weights);
        let turning = Twist::new(
            0.0,
            turn::rate_radps(robot, goal_in_base.y.atan2(goal_in_base.x)),
        );
        match best {
            Some(twist) if twist.v_mps > STANDING_MPS || !from.is_stopped() => Ok(twist),
            _ if from.v_mps < STANDING_MPS => {
                self.turns = true;
                Ok(turning)
            }
            _ => Err(Validity::Blocked),
        }
    }

    /// [m] free along an exact arc, and least space around the outline on the free part.
    fn arc(&self, situation: &Situation<'_>, twist: Twist, weights: &BaoWeights) -> (f64, f64) {
        const STEPS: u8 = 30;
        let yaw_rad = situation.map_from_base.yaw_rad;
        let (sin, cos) = yaw_rad.sin_cos();
        let soft = narrow(weights.dist_m_max);
        let mut least_m = weights.dist_m_max;
        for i in 1..=STEPS {
            let elapsed_s = weights.horizon_s * f64::from(i) / f64::from(STEPS);
            let at = twist.arc(elapsed_s);
            let (turned_sin, turned_cos) = (yaw_rad + at.yaw_rad).sin_cos();
            let local = LocalPose {
                x: narrow(cos * at.x_m - sin * at.y_m),
                y: narrow(sin * at.x_m + cos * at.y_m),
                cos: narrow(turned_cos),
                sin: narrow(turned_sin),
            };
            let outline_m = |point| self.surroundings.footprint.distance_m(point);
            let struck = self.moving.margin_m(&at, elapsed_s, outline_m) < 0.0;
            let space = self.surroundings.space(local, soft);
            let Some(space) = space.filter(|_| !struck) else {
                let before_s = elapsed_s - weights.horizon_s / f64::from(STEPS);
                return (twist.v_mps.abs() * before_s, least_m);
            };
            least_m = least_m.min(f64::from(space));
        }
        // Free as far as the arc goes: nothing in sight of a slow one bounds it.
        let stop_m = stop_distance_m(situation.robot, twist.v_mps, 0.0);
        ((twist.v_mps.abs() * weights.horizon_s).max(stop_m), least_m)
    }

    /// The first step towards the wish from which a stop is free: as wished, slower, on the spot;
    /// else the first step of a stop.
    fn publish(
        &mut self,
        situation: &Situation<'_>,
        from: Twist,
        wish: Result<Twist, Validity>,
    ) -> (Twist, Validity, f64) {
        let (robot, period_s) = (situation.robot, situation.period_s);
        let rest = towards_rest(robot, from, period_s);
        let stopped = stop_distance_m(robot, rest.v_mps, 0.0);
        let wanted = match wish {
            Ok(wanted) => wanted,
            Err(validity) => return (rest, validity, stopped),
        };
        let slower = [1.0, 0.5, 0.2, 0.0].into_iter().map(|share| {
            let slower = Twist::new(wanted.v_mps * share, wanted.w_radps);
            self.shaper.next(robot, from, slower, period_s)
        });
        let reaction_s = self.config.reaction_s;
        first_with_free_stop(slower, |twist| {
            self.surroundings
                .stop_arc_m(robot, twist, reaction_s, &self.moving)
        })
        .map_or((rest, Validity::Blocked, stopped), |(twist, arc_m)| {
            (twist, Validity::Drive, arc_m)
        })
    }
}

impl Controller for Driver {
    fn decide(&mut self, situation: &Situation<'_>) -> Decision {
        let robot = situation.robot;
        let measured = Twist::new(situation.v_mps, situation.w_radps);
        let from = self.last.near(robot, measured, self.config.command_lead_s);
        let position = situation.map_from_base.point();
        let place = self
            .tracker
            .advance(situation.path_geometry, situation.path, position);
        let mut blocked_arc_m = None;
        self.turns = false;
        let wish = if let Some(place) = place {
            self.surroundings.describe(robot, situation.corners);
            let stop_m = stop_distance_m(robot, robot.v_mps_max, self.config.reaction_s);
            let sight_m = robot.v_mps_max * self.config.horizon_s + 0.5;
            self.path
                .sample(&self.tracker, situation.path, &place, position, sight_m);
            self.surroundings.look(
                situation.map.map(|map| (map, situation.map_cells)),
                &situation.map_from_base,
                situation.scan_points_in_base,
                situation.scan_points_in_base,
                Reach {
                    field_m: sight_m.max(stop_m),
                    stop_m,
                    soft_m: self.config.soft_clearance_m,
                    margin_m: self.config.safety_margin_m,
                },
            );
            self.moving.take(
                situation.obstacles,
                situation.obstacles_age_s,
                &situation.map_from_base,
                Growth::default(),
            );
            let inscribed_m = self.surroundings.footprint.inscribed_m;
            blocked_arc_m = self.path.blocked_m(&self.surroundings.field, inscribed_m);
            self.gather(situation);
            self.wish(situation, place.remaining_m)
        } else {
            Err(Validity::NoPath)
        };
        let (twist, validity, braking_arc_m) = self.publish(situation, from, wish);
        let idle = twist.is_stopped() && validity == Validity::Drive;
        self.blocked_s = if idle {
            self.blocked_s + situation.period_s
        } else {
            0.0
        };
        self.last = twist;
        if validity == Validity::Drive {
            self.shaper.published(from, twist, situation.period_s);
        } else {
            self.shaper.interrupted();
        }
        Decision {
            v_mps: twist.v_mps,
            w_radps: twist.w_radps,
            validity: if self.blocked_s > 0.2 {
                Validity::Blocked
            } else {
                validity
            },
            braking_arc_m,
            turns: self.turns && validity == Validity::Drive,
            rollouts: 1,
            blocked_arc_m,
        }
    }

    fn overruled(&mut self, published: Twist) {
        self.shaper.interrupted();
        self.last = published;
    }
}
