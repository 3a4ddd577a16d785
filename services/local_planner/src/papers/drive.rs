//! From the direction of a law to a wish of the pilot.
//!
//! As the paper notes define it: `v = v_max max(0, cos err)`, `w = clamp(2 err)`. `yield`: the speed
//! is scaled by `min(1, TTC / 2 s)`. The pilot brings the robot to the goal's pose, keeps to the
//! accelerations and publishes no twist from which it cannot stop before contact.

use super::law::{Body, Extent, Law, LawInput, Push};
use crate::dwa::options::DwaConfig;
use crate::dynamic_obstacles::DynamicObstacles;
use crate::pilot::Pilot;
use crate::pilot::limit::Limit;
use crate::pilot::perception::Tracks;
use crate::pilot::scene::{COMFORT_SHARE, Choose, Scene, Wish};
use crate::situation::Situation;
use nalgebra::{Point2, Vector2};
use zeronav_motion::Twist;
use zeronav_msgs::command::{RequestCause, Validity};
use zeronav_msgs::pose::wrap_angle;

/// [1/s] yaw rate per radian of heading error.
const TURN_GAIN_HZ: f64 = 2.0;

/// [s] time to contact below which the robot yields.
const YIELD_S: f64 = 2.0;

/// [m] between neighbouring hits of the scan that belong to two obstacles.
const GAP_M: f64 = 0.3;

/// [m] from the robot within which obstacles are looked at.
const RANGE_M: f64 = 3.0;

/// Shares of a wish's speed that are tried when it is not free.
const SLOWER: [f64; 2] = [0.5, 0.2];

/// A controller that goes where `law` says. `literal` = obstacles are points.
#[must_use]
pub fn along(law: Box<dyn Law>, config: DwaConfig, literal: bool) -> Pilot {
    let chooser = Along {
        law,
        literal,
        bodies: Vec::new(),
    };
    Pilot::new(config, Tracks::Checked, Box::new(chooser))
}

/// Steers along the direction of a law.
#[derive(Debug)]
struct Along {
    law: Box<dyn Law>,
    literal: bool,
    bodies: Vec<Body>,
}

impl Choose for Along {
    fn choose(&mut self, scene: &mut Scene<'_>) -> Wish {
        let situation = scene.situation;
        let (robot, pose) = (situation.robot, situation.map_from_base);
        let footprint = &scene.seen.surroundings.footprint;
        let (inscribed_m, circumscribed_m) = (footprint.inscribed_m, footprint.circumscribed_m);
        self.gather(situation, inscribed_m, &scene.seen.dynamic);
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let velocity = Vector2::new(cos, sin) * situation.v_mps;
        let push = self.law.push(&LawInput {
            at: pose.point(),
            velocity,
            goal: situation.goal.pose.point(),
            bodies: &self.bodies,
            path: situation.path,
            geometry: situation.path_geometry,
            literal: self.literal,
        });
        let Push::Along(force) = push else {
            return Wish::Rest(Validity::Blocked);
        };
        if force.norm() < 1.0e-9 {
            return Wish::Rest(Validity::Blocked);
        }
        let error_rad = wrap_angle(force.y.atan2(force.x) - pose.yaw_rad);
        let velocity = (velocity.x, velocity.y);
        let contact_s = scene.seen.dynamic.contact_s(velocity, circumscribed_m);
        let (facing, yielding) = (error_rad.cos().max(0.0), (contact_s / YIELD_S).min(1.0));
        let v_mps = scene.top_speed_mps() * facing * yielding;
        let w_radps = (TURN_GAIN_HZ * error_rad).clamp(-robot.w_radps_max, robot.w_radps_max);
        let slower = if yielding < facing {
            RequestCause::Yield
        } else {
            RequestCause::PotentialField
        };
        wish_or_slower(scene, Twist::new(v_mps, w_radps), slower)
    }
}

/// The wish for a twist no faster than a stop at the goal allows; the same more slowly when it is
/// not free. `slower` explains a twist that is slower than the robot may be.
pub(super) fn wish_or_slower(scene: &mut Scene<'_>, twist: Twist, slower: RequestCause) -> Wish {
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
    /// One body per obstacle in the scan: neighbouring hits without a gap between them. Areas are
    /// represented by their nearest hit, points by the middle of their hits; both as far around
    /// them as the robot's inscribed disc reaches.
    fn gather(&mut self, situation: &Situation<'_>, inscribed_m: f64, dynamic: &DynamicObstacles) {
        self.bodies.clear();
        let pose = situation.map_from_base;
        let extent = Extent::Disc(if self.literal { 0.0 } else { inscribed_m });
        let mut group: Option<(Point2<f64>, Vector2<f64>, f64)> = None;
        let mut last: Option<Point2<f64>> = None;
        let literal = self.literal;
        let bodies = &mut self.bodies;
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
                    velocity: dynamic.velocity_at(nearest),
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
}
