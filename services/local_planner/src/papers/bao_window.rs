//! `bao_dwa` on the robot: the window's samples against map and scan, towards a local goal.

use super::bao_dwa::{self, SAMPLES_MAX, Sample};
use super::drive::{output_or_slower, steered};
use super::options::{BaoDwaConfig, Switch};
use crate::dwa::options::DwaConfig;
use crate::lanes::data::narrow;
use crate::pilot::Pilot;
use crate::pilot::perception::Tracks;
use crate::pilot::scene::{Choose, ControlOutput, Scene};
use crate::record::{DrawnRollout, Record};
use crate::surroundings::LocalPose;
use crate::turn;
use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;
use zeronav_motion::{Twist, stop_distance_m};
use zeronav_msgs::Cell;
use zeronav_msgs::command::Validity;
use zeronav_msgs::map::FLAG_STATIC;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::rollouts::RolloutOutcome;

/// Distance from the way within which an obstacle that no map shows calls for the window. [m]
const DETECT_M: f64 = 1.5;

/// Cells around a hit in which the static map may show what was hit.
const KNOWN_CELLS: i32 = 2;

/// [m/s] below which the robot is stopped.
const STOPPED_MPS: f64 = 0.02;

/// Poses of an arc that are checked.
const STEPS: u8 = 30;

/// The controller `bao_dwa` at rest.
#[must_use]
pub fn bao_dwa(own: &BaoDwaConfig, config: DwaConfig) -> Pilot {
    let chooser = BaoWindow {
        own: *own,
        scores: Vec::with_capacity(SAMPLES_MAX * SAMPLES_MAX),
        speeds: Vec::with_capacity(SAMPLES_MAX),
        yaw_rates: Vec::with_capacity(SAMPLES_MAX),
        admissible: Vec::with_capacity(SAMPLES_MAX * SAMPLES_MAX),
    };
    Pilot::new(config, Tracks::Checked, Box::new(chooser))
}

/// The best admissible twist; without one the robot stops, then turns towards its local goal.
#[derive(Debug)]
struct BaoWindow {
    own: BaoDwaConfig,
    scores: Vec<f64>,
    /// Of this period: sampled speeds [m/s] and yaw rates [rad/s], and the admissible twists.
    speeds: Vec<f64>,
    yaw_rates: Vec<f64>,
    admissible: Vec<Sample>,
}

impl Choose for BaoWindow {
    fn choose(&mut self, scene: &mut Scene<'_>) -> ControlOutput {
        let (situation, weights) = (scene.situation, self.own);
        let (robot, pose) = (situation.robot, situation.map_from_base);
        let distance_m = pose.distance_m(&situation.goal.pose);
        let from = Twist::new(situation.v_mps.max(0.0), situation.w_radps);
        let surroundings = &scene.seen.surroundings;
        let (field, footprint) = (&surroundings.field, &surroundings.footprint);
        let local = (scene.seen.path).local_goal(field, footprint.inscribed_m, weights.lookahead_m);
        let goal_in_base = pose.isometry().rotation.inverse() * local;
        if weights.switch == Switch::OnDetect && !detects(scene, &weights) {
            let error_rad = goal_in_base.y.atan2(goal_in_base.x);
            return steered(scene, error_rad, 1.0);
        }
        let (vs, ws) = bao_dwa::window(robot, from, weights.period_s);
        let (v_step, w_step) = bao_dwa::steps();
        let fastest_mps = scene.top_speed_mps();
        bao_dwa::sample(&mut self.speeds, vs, v_step);
        bao_dwa::sample(&mut self.yaw_rates, ws, w_step);
        self.admissible.clear();
        let mut record = scene.memory.record.take();
        let (sin, cos) = pose.yaw_rad.sin_cos();
        for (i, &v) in (0..).zip(&self.speeds) {
            for (j, &w) in (0..).zip(&self.yaw_rates) {
                let twist = Twist::new(v.min(fastest_mps.max(vs.low)), w);
                let ahead = look(&weights, scene, twist);
                let is_admissible = bao_dwa::is_admissible(robot, twist, ahead.free_m);
                if let Some(record) = &mut record {
                    tell(
                        record,
                        &weights,
                        pose.yaw_rad,
                        (twist, &ahead, is_admissible),
                    );
                }
                if !is_admissible {
                    continue;
                }
                let end = twist.arc(weights.horizon_s.min(distance_m / v.max(0.1)));
                let to_goal = goal_in_base - Vector2::new(end.x_m, end.y_m);
                let error_rad = wrap_angle(to_goal.y.atan2(to_goal.x) - end.yaw_rad);
                let in_map =
                    Vector2::new(cos * end.x_m - sin * end.y_m, sin * end.x_m + cos * end.y_m);
                let aside_m = scene.seen.path.distance_m(in_map);
                self.admissible.push(Sample {
                    twist,
                    place: [i, j],
                    path: (weights.dist_m_max - aside_m).max(0.0),
                    head: core::f64::consts::PI - error_rad.abs(),
                    dist: ahead.near_m.min(distance_m).max(0.0),
                });
            }
        }
        scene.memory.record = record;
        scene.memory.rollouts = u32::try_from(self.admissible.len()).unwrap_or(u32::MAX);
        match bao_dwa::choose(&self.admissible, &weights, &mut self.scores) {
            Some(twist) if twist.v_mps > STOPPED_MPS || !from.is_stopped() => {
                let slower = bao_dwa::decisive(&self.admissible, &weights, &mut self.scores);
                output_or_slower(scene, twist, slower)
            }
            _ if from.v_mps < STOPPED_MPS => {
                scene.memory.turns = true;
                let error_rad = goal_in_base.y.atan2(goal_in_base.x);
                scene.steer(Twist::new(0.0, turn::rate_radps(robot, error_rad)))
            }
            _ => ControlOutput::Rest(Validity::Blocked),
        }
    }
}

/// True while something that moves is within the range of the distance term, or a hit near the way
/// ahead is on nothing that the static map shows.
fn detects(scene: &Scene<'_>, config: &BaoDwaConfig) -> bool {
    let situation = scene.situation;
    let (sin, cos) = situation.map_from_base.yaw_rad.sin_cos();
    let is_known = |hit: Point2<f64>| {
        let Some(map) = situation.map else {
            return false;
        };
        let Some(cell) = map.geometry.cell_at(situation.map_from_base.transform(hit)) else {
            return false;
        };
        let around = -KNOWN_CELLS..=KNOWN_CELLS;
        around.clone().any(|dy| {
            around.clone().any(|dx| {
                let beside = map.get(Cell::new(cell.x + dx, cell.y + dy));
                beside.is_some_and(|cell| cell.flags & FLAG_STATIC != 0)
            })
        })
    };
    let is_near = |hit: &Point2<f64>| {
        let in_map = Vector2::new(cos * hit.x - sin * hit.y, sin * hit.x + cos * hit.y);
        scene.seen.path.distance_m(in_map) < DETECT_M
    };
    scene.seen.dynamic.is_within(config.dist_m_max)
        || (situation.scan_points_in_base.iter()).any(|hit| is_near(hit) && !is_known(*hit))
}

/// What is along an exact arc.
struct Ahead {
    /// [m] free along it.
    free_m: f64,
    /// [m] least space around the outline on the free part.
    near_m: f64,
    /// What it leads into, and the pose that is not free, counted from 1.
    blocked: Option<(RolloutOutcome, u8)>,
}

/// Tells the record of an arc, which is not rated by itself.
fn tell(
    record: &mut Record,
    weights: &BaoDwaConfig,
    yaw_rad: f64,
    (twist, ahead, is_admissible): (Twist, &Ahead, bool),
) {
    let (outcome, steps) = ahead.blocked.unwrap_or((RolloutOutcome::Costlier, STEPS));
    let seen = DrawnRollout {
        twist: (narrow(twist.v_mps), narrow(twist.w_radps)),
        cost: 0.0,
        outcome: if is_admissible {
            outcome
        } else {
            RolloutOutcome::NoStop
        },
        steps: usize::from(steps),
    };
    let (sin, cos) = yaw_rad.sin_cos();
    record.offer(&seen, |step| {
        let share = (step + 1).to_f64() / f64::from(STEPS);
        let at = twist.arc(weights.horizon_s * share);
        (
            narrow(cos * at.x_m - sin * at.y_m),
            narrow(sin * at.x_m + cos * at.y_m),
        )
    });
}

fn look(weights: &BaoDwaConfig, scene: &Scene<'_>, twist: Twist) -> Ahead {
    let surroundings = &scene.seen.surroundings;
    let yaw_rad = scene.situation.map_from_base.yaw_rad;
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
        let outline_m = |point| surroundings.footprint.distance_m(point);
        let struck = scene.seen.dynamic.margin_m(&at, elapsed_s, outline_m) < 0.0;
        let space = surroundings.space(local, soft);
        let Some(space) = space.filter(|_| !struck) else {
            let before_s = elapsed_s - weights.horizon_s / f64::from(STEPS);
            let by = if struck {
                RolloutOutcome::MovingCollision
            } else {
                RolloutOutcome::Collision
            };
            return Ahead {
                free_m: twist.v_mps.abs() * before_s,
                near_m: least_m,
                blocked: Some((by, i)),
            };
        };
        least_m = least_m.min(f64::from(space));
    }
    // Free as far as the arc goes: nothing in sight of a slow one bounds it.
    let stop_m = stop_distance_m(scene.situation.robot, twist.v_mps, 0.0);
    Ahead {
        free_m: (twist.v_mps.abs() * weights.horizon_s).max(stop_m),
        near_m: least_m,
        blocked: None,
    }
}
