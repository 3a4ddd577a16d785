//! From the direction of a law to an output of the pilot.
//!
//! As the paper notes define it: `v = v_max max(0, cos err)`, `w = clamp(2 err)`. `yield`: the speed
//! is scaled by `min(1, TTC / 2 s)`. The pilot brings the robot to the goal's pose, keeps to the
//! accelerations and publishes no twist from which it cannot stop before contact.

use super::law::{Body, Extent, Ground, Law, LawInput, Push};
use super::pieces::{convex_pieces, middle, nearest};
use crate::dwa::options::DwaConfig;
use crate::dynamic_obstacles::DynamicObstacles;
use crate::pilot::Pilot;
use crate::pilot::limit::Limit;
use crate::pilot::perception::Tracks;
use crate::pilot::scene::{COMFORT_SHARE, Choose, ControlOutput, Scene};
use crate::situation::Situation;
use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::command::{RequestCause, Validity};
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::{Cell, MapCell, MapView};

/// [1/s] yaw rate per radian of heading error.
const TURN_GAIN_HZ: f64 = 2.0;

/// [s] time to contact below which the robot yields.
const YIELD_S: f64 = 2.0;

/// Length of a step of the papers on the robot. [m]
const STEP_M: f64 = 0.1;

/// [m] from the robot within which obstacles are looked at.
const RANGE_M: f64 = 3.0;

/// How far from the robot a body is that keeps it from its goal, at most. [m]
const AGAINST_M: f64 = 1.5;

/// Shares of an output's speed that are tried when it is not free.
const SLOWER: [f64; 2] = [0.5, 0.2];

/// A controller that goes where `law` says. `literal` = obstacles are points.
#[must_use]
pub fn along(law: Box<dyn Law>, config: DwaConfig, literal: bool) -> Pilot {
    let chooser = Along {
        law,
        literal,
        bodies: Vec::new(),
        hull: Vec::new(),
        hits: Vec::new(),
    };
    Pilot::new(config, Tracks::Checked, Box::new(chooser))
}

/// Steers along the direction of a law.
#[derive(Debug)]
struct Along {
    law: Box<dyn Law>,
    literal: bool,
    bodies: Vec<Body>,
    hull: Vec<usize>,
    /// Hits of the scan, `map` frame. [m]
    hits: Vec<Point2<f64>>,
}

/// What map and scan say about where the robot's centre may be.
#[derive(Debug)]
struct Obstacles<'a> {
    map: Option<MapView<'a>>,
    hits: &'a [Point2<f64>],
    inscribed_m: f64,
}

/// Side of the squares in each of which the nearest blocked cell of the map is one obstacle: a cell of
/// [LWX] on the robot. A finer grid would multiply the repulsion by the cells of a wall. [m]
const OBSTACLE_M: f64 = 0.5;

/// Appends the blocked cell of the map that is nearest to `at` in every square of [`OBSTACLE_M`] within
/// `reach`, at most [`RANGE_M`]. The map is widened by the robot's inscribed radius already. [m]
fn bodies_on(map: &MapView<'_>, at: Point2<f64>, reach: f64, bodies: &mut Vec<Body>) {
    let reach = reach.min(RANGE_M);
    let half_m = 0.5 * map.geometry.resolution_m;
    let square = |along: f64| (along / OBSTACLE_M).floor();
    let first = bodies.len();
    let low = map
        .geometry
        .unbounded_cell_at(at.map(|along| along - reach));
    let high = map
        .geometry
        .unbounded_cell_at(at.map(|along| along + reach));
    let cells = (low.y..=high.y).flat_map(|y| (low.x..=high.x).map(move |x| Cell::new(x, y)));
    for cell in cells.filter(|cell| map.get(*cell).is_some_and(MapCell::blocks_centre)) {
        let body = Body::standing(map.geometry.centre_of(cell), Extent::Square(half_m));
        if body.distance_m(at) > reach {
            continue;
        }
        let is_beside = |other: &&mut Body| {
            let along = |axis: usize| (square(other.at[axis]), square(body.at[axis]));
            (0..2)
                .map(along)
                .all(|(of_other, own)| of_other.total_cmp(&own).is_eq())
        };
        match bodies[first..].iter_mut().find(is_beside) {
            Some(other) if body.distance_m(at) < other.distance_m(at) => *other = body,
            Some(_) => {}
            None => bodies.push(body),
        }
    }
}

impl Ground for Obstacles<'_> {
    fn is_free(&self, from: Point2<f64>, to: Point2<f64>) -> bool {
        let along = to - from;
        let near = |hit: &Point2<f64>| {
            let share = (hit - from).dot(&along) / along.norm_squared().max(1.0e-12);
            (from + along * share.clamp(0.0, 1.0) - hit).norm() < self.inscribed_m
        };
        !self.hits.iter().any(near)
            && self
                .map
                .as_ref()
                .is_none_or(|map| is_free_on(map, from, to))
    }

    fn bodies(&self, at: Point2<f64>, reach: f64, bodies: &mut Vec<Body>) -> bool {
        if let Some(map) = &self.map {
            bodies_on(map, at, reach, bodies);
        }
        self.map.is_some()
    }
}

/// Looked at every half cell: a shorter cut through a blocked cell's corner is within what its
/// inflation was rounded up by.
fn is_free_on(map: &MapView<'_>, from: Point2<f64>, to: Point2<f64>) -> bool {
    let steps = (2.0 * (to - from).norm() / map.geometry.resolution_m).ceil();
    (0..=steps.to_u32()).all(|i| {
        let at = from + (to - from) * (f64::from(i) / steps.max(1.0));
        let cell = map.geometry.cell_at(at).and_then(|cell| map.get(cell));
        !cell.is_some_and(MapCell::blocks_centre)
    })
}

impl Choose for Along {
    fn choose(&mut self, scene: &mut Scene<'_>) -> ControlOutput {
        let situation = scene.situation;
        let (robot, pose) = (situation.robot, situation.map_from_base);
        let footprint = &scene.seen.surroundings.footprint;
        let (inscribed_m, circumscribed_m) = (footprint.inscribed_m, footprint.circumscribed_m);
        self.gather(situation, inscribed_m, &scene.seen.dynamic);
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let velocity = Vector2::new(cos, sin) * situation.v_mps;
        self.hits.clear();
        let hits = situation.scan_points_in_base.iter();
        self.hits.extend(hits.map(|hit| pose.transform(*hit)));
        let ground = Obstacles {
            map: situation.map,
            hits: &self.hits,
            inscribed_m,
        };
        scene.memory.against = self.against(pose.point(), situation.goal.pose.point());
        let push = self.law.push(&LawInput {
            at: pose.point(),
            velocity,
            goal: situation.goal.pose.point(),
            bodies: &self.bodies,
            path: situation.path,
            geometry: situation.path_geometry,
            literal: self.literal,
            steps: robot.v_mps_max * situation.period_s / STEP_M,
            ground: Some(&ground),
        });
        let Push::Along(force) = push else {
            return ControlOutput::Rest(Validity::Blocked);
        };
        if force.norm() < 1.0e-9 {
            return ControlOutput::Rest(Validity::Blocked);
        }
        let error_rad = wrap_angle(force.y.atan2(force.x) - pose.yaw_rad);
        let velocity = (velocity.x, velocity.y);
        let contact_s = scene.seen.dynamic.contact_s(velocity, circumscribed_m);
        let output = steered(scene, error_rad, (contact_s / YIELD_S).min(1.0));
        if let Some(remark) = self.law.remark() {
            scene.memory.limit = remarked(scene.memory.limit, remark);
        }
        output
    }
}

/// The limit of a law that does without a part of its method: it is said where nothing else than the law
/// limits the speed.
fn remarked(limit: Limit, remark: RequestCause) -> Limit {
    let said = |cause| match cause {
        RequestCause::Free | RequestCause::PotentialField => remark,
        other => other,
    };
    Limit {
        cause: said(limit.cause),
        slower: said(limit.slower),
        ..limit
    }
}

/// The output for a direction `error_rad` to the left of the robot's, at this share of the speed that
/// it allows.
pub(super) fn steered(scene: &mut Scene<'_>, error_rad: f64, yielding: f64) -> ControlOutput {
    let facing = error_rad.cos().max(0.0);
    let v_mps = scene.top_speed_mps() * facing * yielding;
    let w_radps_max = scene.situation.robot.w_radps_max;
    let w_radps = (TURN_GAIN_HZ * error_rad).clamp(-w_radps_max, w_radps_max);
    let slower = if yielding < facing {
        RequestCause::Yield
    } else {
        RequestCause::PotentialField
    };
    output_or_slower(scene, Twist::new(v_mps, w_radps), slower)
}

/// The output for a twist no faster than a stop at the goal allows; the same more slowly when it is
/// not free. `slower` explains a twist that is slower than the robot may be.
pub(super) fn output_or_slower(
    scene: &mut Scene<'_>,
    twist: Twist,
    slower: RequestCause,
) -> ControlOutput {
    let situation = scene.situation;
    let distance_m = situation.map_from_base.distance_m(&situation.goal.pose);
    let decel_mps2 = COMFORT_SHARE * situation.robot.brake_mps2;
    let goal_mps = (2.0 * decel_mps2 * scene.place.remaining_m.max(distance_m)).sqrt();
    scene.memory.limit = Limit {
        slower,
        ..Limit::lowest(&[scene.top(), (RequestCause::Goal, goal_mps)])
    };
    let twist = Twist::new(twist.v_mps.min(goal_mps), twist.w_radps);
    let slower = SLOWER.map(|share| (share, Twist::new(twist.v_mps * share, twist.w_radps)));
    scene.memory.reserve.extend(slower);
    scene.memory.rollouts = scene.memory.rollouts.max(1);
    scene.steer(twist)
}

impl Along {
    /// The nearest point of the bodies near the robot on the goal's side of it. [m]
    fn against(&self, at: Point2<f64>, goal: Point2<f64>) -> Option<Point2<f64>> {
        let to_goal = goal - at;
        let ahead = self.bodies.iter().map(|body| body.at);
        ahead
            .filter(|body| (body - at).dot(&to_goal) > 0.0 && (body - at).norm() < AGAINST_M)
            .min_by(|one, other| (one - at).norm().total_cmp(&(other - at).norm()))
    }

    /// One body for each convex piece in the scan. Areas are represented by their nearest point,
    /// points by the middle of their hits; both as far around them as the robot's inscribed disc
    /// reaches.
    fn gather(&mut self, situation: &Situation<'_>, inscribed_m: f64, dynamic: &DynamicObstacles) {
        self.bodies.clear();
        let pose = situation.map_from_base;
        let (extent, literal) = (
            Extent::Disc(if self.literal { 0.0 } else { inscribed_m }),
            self.literal,
        );
        let bodies = &mut self.bodies;
        let hits = situation.scan_points_in_base;
        convex_pieces(hits, &mut self.hull, &mut |piece| {
            let near = nearest(piece);
            if near.coords.norm() > RANGE_M {
                return;
            }
            let in_base = if literal { middle(piece) } else { near };
            bodies.push(Body {
                at: pose.transform(in_base),
                extent,
                velocity: dynamic.velocity_at(near),
            });
        });
    }
}
