//! What a search drives through: how the robot moves, what is in its way, what that costs.

use super::node::{Blocked, Node, State};
use crate::beam::options::BeamConfig;
use crate::cost_to_go::CostToGo;
use crate::dynamic_obstacles::DynamicObstacles;
use crate::lanes::data::narrow;
use crate::surroundings::Surroundings;
use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::description::Description;
use zeronav_msgs::rollouts::RolloutOutcome;

/// Poses of a manoeuvre that are looked at.
pub(super) const LOOKS: usize = 4;

impl BeamConfig {
    /// [s] between two checked poses.
    pub(super) fn look_s(&self) -> f64 {
        self.manoeuvre_s / LOOKS.to_f64()
    }
}

/// Discs of which a node knows whether the robot has left them; the others count as left.
const INSIDE_MAX: usize = 64;

/// [m/s] of the outline below which being hit is not the robot's doing, and what each such look
/// costs. [s]
const STANDING_MPS: f32 = 0.05;

/// Cost of a predicted obstacle at the margin at 0.8 m/s, per second.
const WEIGHT_NEAR: f32 = 3.0;

/// [s] for which predictions are relied on; predicted collisions after it only cost.
const CERTAIN_S: f32 = 1.5;
const HIT_STANDING: f32 = 1.0;

/// How likely a predicted collision may be that only costs all the same.
const GRAZING: f32 = 0.1;

/// [m/s] and [rad/s] below which the robot stays where it is, free or not.
const RESTING: f32 = 0.01;

/// What driving into a prediction of the far future costs. [1]
const HIT_DRIVING: f32 = 40.0;

/// [m/s] towards a disc that the robot is in already; less is no motion.
const APPROACH_MPS: f32 = 0.02;

/// [m/s] at which a robot is expected to go on after the last manoeuvre.
const LATER_MPS: f32 = 1.5;

/// [m] ahead of the robot where the way to go tells whether it heads along it, and what heading
/// the other way costs. [s]
const AHEAD_M: f32 = 0.4;
const ASTRAY: f32 = 0.8;

/// Share of the goal's tolerance within which the robot arrives.
const ARRIVAL_SHARE: f32 = 0.8;

/// [s] for which a robot stands at its goal before that counts.
const NOTICED_S: f32 = 0.4;

/// [s] that each metre per second at the end is worth.
const MOMENTUM: f32 = 0.15;

/// Costs that keep manoeuvres calm: of a squared yaw rate for a second, of a change of speed.
const TURNING: f32 = 0.006;
const CHANGING: f32 = 0.01;

/// What does not change during a search.
#[derive(Debug)]
pub(super) struct Space<'a> {
    pub(super) config: BeamConfig,
    pub(super) robot: &'a Description,
    pub(super) surroundings: &'a Surroundings,
    /// Tabulated at the looks of all manoeuvres.
    pub(super) dynamic: &'a DynamicObstacles,
    /// Without one the way to go is the straight line.
    pub(super) cost_to_go: Option<&'a CostToGo>,
    /// `map_from_base` now.
    pub(super) here: Pose,
    /// Goal relative to the robot along the axes of the map, and how near counts. [m]
    pub(super) goal: (f32, f32),
    pub(super) tolerance: f32,
    /// [m/s] fastest speed.
    pub(super) fastest: f32,
    /// [m] of space to static obstacles from which on nearness costs nothing.
    pub(super) soft: f32,
}

impl Space<'_> {
    /// [s] from look to look.
    fn look_s(&self) -> f32 {
        narrow(self.config.look_s())
    }

    /// The node that a search begins with.
    pub(super) fn root(&self, v_mps: f64, w_radps: f64) -> Node {
        let (sin, cos) = self.here.yaw_rad.sin_cos();
        let delay = narrow(self.config.delay_s);
        let state = State {
            x: narrow(v_mps * cos) * delay,
            y: narrow(v_mps * sin) * delay,
            yaw: narrow(self.here.yaw_rad),
            cos: narrow(cos),
            sin: narrow(sin),
            v: narrow(v_mps),
            w: narrow(w_radps),
        };
        let margin = narrow(self.config.margin_m);
        let discs = self.dynamic.now().iter().take(INSIDE_MAX).enumerate();
        let inside = discs
            .filter(|(_, disc)| self.apart(&state, disc) < margin)
            .fold(0, |inside, (i, _)| inside | 1 << i);
        let mut root = Node {
            state,
            cost: 0.0,
            total: 0.0,
            to_go: self.goal.0.hypot(self.goal.1),
            parent: 0,
            asked: (state.v, state.w),
            arrived: false,
            inside,
        };
        self.value(&mut root);
        root
    }

    /// [m] between the outline and a disc; negative when they overlap.
    fn apart(&self, state: &State, disc: &[f32; 3]) -> f32 {
        let (dx, dy) = (disc[0] - state.x, disc[1] - state.y);
        let in_base = Point2::new(
            f64::from(state.cos * dx + state.sin * dy),
            f64::from(state.cos * dy - state.sin * dx),
        );
        narrow(self.surroundings.footprint.distance_m(in_base)) - disc[2]
    }

    /// [m] of the way to go from a position.
    fn to_go(&self, x: f32, y: f32) -> Option<f32> {
        let Some(cost_to_go) = self.cost_to_go else {
            return Some((self.goal.0 - x).hypot(self.goal.1 - y));
        };
        let here = self.here.point();
        cost_to_go.at(Point2::new(here.x + f64::from(x), here.y + f64::from(y)))
    }

    /// True where the robot is at its goal and slow enough to stop there.
    fn is_arrival(&self, state: &State) -> bool {
        let away = (self.goal.0 - state.x).hypot(self.goal.1 - state.y);
        let stop = state.v * state.v / (2.0 * narrow(self.robot.brake_mps2));
        away < ARRIVAL_SHARE * self.tolerance && stop < self.tolerance
    }

    /// True when nothing that moves comes to a robot that stops from this state, the one at a look, until
    /// its stop has been noticed.
    fn stays_free(&self, state: &State, look: usize) -> bool {
        let brake_mps2 = narrow(self.robot.brake_mps2);
        let stop_m = state.v * state.v / (2.0 * brake_mps2);
        let at = (state.x + stop_m * state.cos, state.y + stop_m * state.sin);
        let reach = narrow(self.surroundings.footprint.circumscribed_m + self.config.margin_m);
        let until_s = state.v / brake_mps2 + NOTICED_S;
        let mut elapsed_s = self.look_s();
        let mut later = look + 1;
        while elapsed_s < until_s {
            let discs = self.dynamic.at_step(later).iter();
            let mut near =
                discs.filter(|[x, y, radius]| (x - at.0).hypot(y - at.1) < radius + reach);
            if near.next().is_some() {
                return false;
            }
            elapsed_s += self.look_s();
            later += 1;
        }
        true
    }

    /// Adds what is still to come to a node that knows its parent's way to go, in seconds.
    fn value(&self, node: &mut Node) {
        if node.arrived {
            (node.to_go, node.total) = (0.0, node.cost - MOMENTUM * self.fastest);
            return;
        }
        let at = &node.state;
        node.to_go = self.to_go(at.x, at.y).unwrap_or(node.to_go);
        let ahead = self.to_go(at.x + AHEAD_M * at.cos, at.y + AHEAD_M * at.sin);
        let along = ahead.map_or(0.0, |ahead| {
            ((node.to_go - ahead) / AHEAD_M).clamp(-1.0, 1.0)
        });
        let astray = 0.5 * ASTRAY * (1.0 - along);
        node.total = node.cost + node.to_go / LATER_MPS + astray - MOMENTUM * at.v;
    }

    /// The state a look later, when this speed and yaw rate are asked for.
    fn step(&self, from: &State, asked: (f32, f32)) -> State {
        let (robot, step_s) = (self.robot, self.look_s());
        let up = narrow(robot.a_mps2_max) * step_s;
        let down = narrow(robot.brake_mps2) * step_s;
        let turn = narrow(robot.alpha_radps2_max) * step_s;
        let v = asked.0.clamp(from.v - down, from.v + up);
        let w = asked.1.clamp(from.w - turn, from.w + turn);
        let (mean_v, mean_w) = (0.5 * (v + from.v), 0.5 * (w + from.w));
        let half = rotation(0.5 * mean_w * step_s);
        let (mid_cos, mid_sin) = rotated((from.cos, from.sin), half);
        let (cos, sin) = rotated((mid_cos, mid_sin), half);
        State {
            x: from.x + mean_v * mid_cos * step_s,
            y: from.y + mean_v * mid_sin * step_s,
            yaw: from.yaw + mean_w * step_s,
            cos,
            sin,
            v,
            w,
        }
    }

    /// How likely it is that a predicted disc touches an outline that is so far inside of it, margin
    /// included [m]: surely, when what is there now would; less, the more of the overlap is what it has
    /// grown by. Beside somebody who comes along a corridor there is room, though not for all that he
    /// may do until then.
    fn likely(&self, disc: usize, predicted: &[f32; 3], apart: f32) -> f32 {
        let now = self
            .dynamic
            .now()
            .get(disc)
            .map_or(predicted[2], |now| now[2]);
        let grown = (predicted[2] - now).max(0.0) + narrow(self.config.margin_m);
        let share = (-apart / grown.max(1.0e-3)).min(1.0);
        share * share
    }

    /// The discs that a manoeuvre of this layer can meet when it begins at `node`.
    pub(super) fn gather(&self, node: &Node, layer: usize, near: &mut Vec<usize>) {
        near.clear();
        let first = self.dynamic.at_step(layer * LOOKS);
        let last = self.dynamic.at_step((layer + 1) * LOOKS - 1);
        let outer_m = self.surroundings.footprint.circumscribed_m;
        let driven = self.fastest * narrow(self.config.manoeuvre_s);
        let reach = driven + narrow(outer_m + self.config.margin_m + self.config.near_m);
        for (i, (from, to)) in first.iter().zip(last).enumerate() {
            let middle = (0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]));
            let half = 0.5 * (to[0] - from[0]).hypot(to[1] - from[1]);
            let away = (middle.0 - node.state.x).hypot(middle.1 - node.state.y);
            if away < reach + half + to[2] {
                near.push(i);
            }
        }
    }

    /// Where a manoeuvre from `node` leads, or what is in the way. `near` are the discs that it can
    /// meet.
    pub(super) fn drive(
        &self,
        node: &Node,
        asked: (f32, f32),
        layer: usize,
        near: &[usize],
    ) -> Result<Node, Blocked> {
        let step_s = self.look_s();
        let (margin, near_m) = (narrow(self.config.margin_m), narrow(self.config.near_m));
        let footprint = &self.surroundings.footprint;
        let (inner, outer) = (footprint.inscribed_m, footprint.circumscribed_m);
        // A disc turns within its own outline.
        let swing = if inner < outer { narrow(outer) } else { 0.0 };
        let outer = narrow(outer);
        let mut next = Node { asked, ..*node };
        if next.arrived {
            return Ok(next);
        }
        for look in layer * LOOKS..(layer + 1) * LOOKS {
            let state = self.step(&next.state, asked);
            next.state = state;
            let at = (state.x, state.y);
            let blocked = |by| Blocked { at, by };
            let stopped = state.v.abs() < RESTING && state.w.abs() < RESTING;
            let space = if stopped {
                self.soft
            } else {
                let space = self.surroundings.space(state.place(), self.soft);
                space.ok_or(blocked(RolloutOutcome::Collision))?
            };
            let elapsed_s = (look + 1).to_f32() * step_s;
            let discs = self.dynamic.at_step(look);
            let mut least = near_m;
            for &i in near {
                let disc = &discs[i];
                let (dx, dy) = (disc[0] - state.x, disc[1] - state.y);
                let reach = disc[2] + margin + near_m + outer;
                if dx * dx + dy * dy > reach * reach {
                    continue;
                }
                let apart = self.apart(&state, disc) - margin;
                if i < INSIDE_MAX && next.inside >> i & 1 == 1 {
                    // Who is in it must be able to leave it.
                    if apart > 0.0 {
                        next.inside &= !(1 << i);
                    } else if (dx * state.cos + dy * state.sin) * state.v > APPROACH_MPS {
                        return Err(blocked(RolloutOutcome::MovingCollision));
                    } else {
                        next.cost += HIT_STANDING * f32::from(u8::from(apart < -margin));
                        continue;
                    }
                }
                if apart < 0.0 {
                    let likely = self.likely(i, disc, apart);
                    if state.v.abs() + state.w.abs() * swing <= STANDING_MPS {
                        next.cost += HIT_STANDING * likely;
                    } else if elapsed_s <= CERTAIN_S && likely > GRAZING {
                        return Err(blocked(RolloutOutcome::MovingCollision));
                    } else {
                        next.cost += HIT_DRIVING * step_s * faded(elapsed_s) * likely;
                    }
                }
                least = least.min(apart);
            }
            let beside = (near_m - least.max(0.0)) / near_m;
            let tight = (self.soft - space) / self.soft;
            let nearness = WEIGHT_NEAR * faded(elapsed_s) * beside * beside + tight * tight;
            next.cost += step_s;
            if self.is_arrival(&state) && self.stays_free(&state, look) {
                next.arrived = true;
                break;
            }
            next.cost += step_s * ((0.2 + state.v.abs()) * nearness + TURNING * asked.1 * asked.1);
        }
        next.cost += CHANGING * (asked.0 - node.asked.0).abs();
        self.value(&mut next);
        Ok(next)
    }
}

/// How much of a cost is left for what is so far in the future.
fn faded(elapsed_s: f32) -> f32 {
    (1.0 - 0.13 * elapsed_s).max(0.25)
}

/// Cosine and sine of a small angle, below half a radian right to 1e-5; the same on all machines.
fn rotation(angle: f32) -> (f32, f32) {
    let square = angle * angle;
    (
        1.0 - 0.5 * square * (1.0 - square / 12.0),
        angle * (1.0 - square / 6.0 * (1.0 - square / 20.0)),
    )
}

/// A direction turned by an angle, both as cosine and sine.
fn rotated((cos, sin): (f32, f32), (by_cos, by_sin): (f32, f32)) -> (f32, f32) {
    (cos * by_cos - sin * by_sin, sin * by_cos + cos * by_sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surroundings::Reach;
    use crate::test_robot::robot;

    #[test]
    fn small_angles_are_turned_by_exactly() {
        for hundredth in -50_i16..=50 {
            let angle = 0.01 * f32::from(hundredth);
            let (cos, sin) = rotation(angle);
            assert!((cos - angle.cos()).abs() < 3e-5, "{angle}");
            assert!((sin - angle.sin()).abs() < 3e-6, "{angle}");
        }
    }

    /// What a robot with the goal so far ahead finds of a manoeuvre on an open ground, from 0.4 m/s with
    /// 0.4 m/s asked for: 0.16 m in 0.4 s.
    fn towards(goal_m: f32, tolerance_m: f32) -> Node {
        let (robot, here) = (robot(), Pose::new(3.0, -2.0, 0.0));
        let mut surroundings = Surroundings::default();
        surroundings.describe(&robot, &[]);
        let reach = Reach {
            field_m: 2.0,
            stop_m: 1.0,
            soft_m: 0.2,
            margin_m: 0.03,
        };
        surroundings.look(None, &here, (&[], &[]), &[], reach);
        let dynamic = DynamicObstacles::default();
        let space = Space {
            config: BeamConfig {
                delay_s: 0.0,
                ..BeamConfig::default()
            },
            robot: &robot,
            surroundings: &surroundings,
            dynamic: &dynamic,
            cost_to_go: None,
            here,
            goal: (goal_m, 0.0),
            tolerance: tolerance_m,
            fastest: 1.0,
            soft: 0.2,
        };
        let root = space.root(0.4, 0.0);
        let next = space.drive(&root, (0.4, 0.0), 0, &[]).expect("free");
        let after = space.drive(&next, (0.4, 0.0), 1, &[]).expect("free");
        if next.arrived {
            assert!(after.arrived && after.state.x.to_bits() == next.state.x.to_bits());
            assert!(
                (after.total - next.total).abs() < 1e-9,
                "it waits for nothing"
            );
        }
        next
    }

    #[test]
    fn a_robot_within_reach_of_its_goal_arrives_and_stays() {
        // The first look after 0.04 m is 0.11 m before the goal, the second 0.07 m.
        let there = towards(0.15, 0.1);
        assert!(there.arrived);
        assert!((there.state.x - 0.08).abs() < 1e-6, "{}", there.state.x);
        assert!((there.cost - 0.2).abs() < 1e-6, "{}", there.cost);
        assert!(there.to_go.abs() < 1e-9);
        // 0.14 m before the goal at the end of it.
        let before = towards(0.3, 0.1);
        assert!(!before.arrived && (before.to_go - 0.14).abs() < 1e-5);
        // It would take 0.04 m to stop.
        assert!(!towards(0.15, 0.03).arrived);
        // To arrive is worth more than to be about to.
        assert!(there.total < before.total);
    }
}
