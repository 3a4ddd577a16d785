//! The loop of [LWX] over interim goals, `LWX-OAPF` and `LWX-ITER` as printed: `I = ceil(L |R - T|)`
//! steps of the field for every interim goal, one goal after the other.

use super::ju_apf::JuApf;
use super::law::{Body, Ground, Law as _, LawInput, Push};
use super::lwx_oapf::{budget, has_passed};
use super::potential::Gains;
use super::route::turning_points;
use super::walk::{End, Trace, Walk, stride};
use nalgebra::{Point2, Vector2};
use zeronav_msgs::path::Waypoint;

/// Where the integration goes on when a turning point is passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Restart {
    /// At the turning point, as printed: the path jumps.
    Point,
    /// Where the robot is.
    Robot,
}

/// How the loop goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loop {
    /// Steps, and whether obstacles are points; its limit bounds all steps together.
    pub walk: Walk,
    /// Steps per unit of distance (`L`).
    pub per_unit: f64,
    /// An interim goal is left as soon as the turning point is passed; else all its steps are done.
    pub early_exit: bool,
    /// Where the integration goes on.
    pub restart: Restart,
    /// The nearer turning point is tried when an interim goal is not reached in its steps.
    pub falls_back: bool,
}

/// Walks from the first turning point of `path` to its last among `bodies`.
#[must_use]
pub fn run(gains: Gains, bodies: &[Body], path: &[Waypoint], how: &Loop) -> Trace {
    run_on(gains, (bodies, None), path, how)
}

/// The same on the ground of a robot where there is one: what repels is looked up at every step, all along
/// the walk, and a step is free when the ground says so. `bodies` are then those of the scan, which stand
/// for what is around where there is no map.
#[must_use]
pub fn run_on(
    gains: Gains,
    (bodies, ground): (&[Body], Option<&dyn Ground>),
    path: &[Waypoint],
    how: &Loop,
) -> Trace {
    let corners = turning_points(path);
    let (Some(start), Some(goal)) = (corners.first(), corners.last()) else {
        return Trace {
            points: Vec::new(),
            end: End::Stuck,
            steps: 0,
        };
    };
    let mut state = State {
        law: JuApf::new(gains),
        bodies,
        ground,
        reach: gains.reach,
        around: Vec::new(),
        how,
        trace: Trace {
            points: vec![*start],
            end: End::Limit,
            steps: 0,
        },
    };
    let (mut passed, mut ahead) = (0, 2);
    state.trace.end = loop {
        let target = corners[(passed + ahead).min(corners.len() - 1)];
        // The last interim goal is the goal.
        let leave = match corners[passed..] {
            [here, next, _, ..] => Some((here, next)),
            _ => None,
        };
        if let Err(end) = state.towards(target, leave) {
            break end;
        }
        let at = state.at();
        let is_passed = leave.is_some_and(|(here, next)| has_passed(at, here, next));
        if (at - goal).norm() < how.walk.tolerance {
            break End::Reached;
        }
        if is_passed {
            (passed, ahead) = (passed + 1, 2);
            if how.restart == Restart::Point {
                state.trace.points.push(corners[passed]);
            }
        } else if how.falls_back && ahead == 2 && leave.is_some() {
            ahead = 1;
        } else {
            break End::Stuck;
        }
    };
    state.trace
}

struct State<'a> {
    law: JuApf,
    bodies: &'a [Body],
    ground: Option<&'a dyn Ground>,
    /// Distance within which bodies repel.
    reach: f64,
    /// Bodies at a step, where the ground tells them.
    around: Vec<Body>,
    how: &'a Loop,
    trace: Trace,
}

impl State<'_> {
    fn at(&self) -> Point2<f64> {
        self.trace.points[self.trace.points.len() - 1]
    }

    /// The steps of one interim goal.
    fn towards(
        &mut self,
        target: Point2<f64>,
        leave: Option<(Point2<f64>, Point2<f64>)>,
    ) -> Result<(), End> {
        let mut left = budget(self.how.per_unit, self.at(), target);
        while left > 0.0 {
            let at = self.at();
            let there = (at - target).norm() < self.how.walk.tolerance;
            let done = leave.map_or(there, |(here, next)| has_passed(at, here, next));
            if done && self.how.early_exit {
                break;
            }
            if self.trace.steps == self.how.walk.limit {
                return Err(End::Limit);
            }
            left -= 1.0;
            self.trace.steps += 1;
            self.around.clear();
            let is_told =
                (self.ground).is_some_and(|ground| ground.bodies(at, self.reach, &mut self.around));
            let bodies = if is_told {
                &self.around[..]
            } else {
                self.bodies
            };
            let input = LawInput {
                at,
                velocity: Vector2::zeros(),
                goal: target,
                bodies,
                path: &[],
                geometry: 1,
                literal: self.how.walk.literal,
                steps: 1.0,
                ground: self.ground,
            };
            let Push::Along(force) = self.law.push(&input) else {
                return Err(End::Stuck);
            };
            // At the goal itself nothing pulls, and the loop goes on all the same.
            let Some(direction) = force.try_normalize(1.0e-9) else {
                continue;
            };
            let length = stride(&input, target, direction, &self.how.walk)?;
            self.trace.points.push(at + direction * length);
        }
        Ok(())
    }
}
