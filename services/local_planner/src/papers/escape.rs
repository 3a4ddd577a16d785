//! Escape from local minima, [ZM]'s flow chart as far as it is known.
//!
//! The printed escape force (eq. 9) is the repulsion that is already balanced, which cannot break the
//! balance. Here it is turned by a right angle to the side with more room, on top of the attraction,
//! `F_esp = R(+-90 deg) F_rep + F_att`, for a way that grows from try to try.

use super::law::{LawInput, Push};
use nalgebra::{Point2, Vector2};

/// Length of a step of the paper, on the robot, too. [m]
const STEP_M: f64 = 0.1;

/// Steps over which the displacement is looked at, and the least that it must be.
const WINDOW: usize = 20;
const MOVED_M: f64 = 3.0 * STEP_M;

/// How much nearer to the goal than at the last minimum another minimum is a new one. [m]
const NEARER_M: f64 = 1.0;

/// A robot that does not get on may take so many times the steps of an escape's way.
const PATIENCE: f64 = 4.0;

/// The state of the escapes towards one goal.
#[derive(Debug, Clone)]
pub(super) struct Escape {
    first_m: f64,
    tries_max: u32,
    goal: Point2<f64>,
    geometry: u64,
    /// One position a step.
    recent: Vec<Point2<f64>>,
    /// Steps since the last of them.
    since: f64,
    running: Option<Running>,
    tries: u32,
    side: f64,
    /// Distance of the last minimum from the goal. [m]
    minimum_m: f64,
    escapes: u32,
}

/// An escape on its way.
#[derive(Debug, Clone, Copy)]
struct Running {
    left_m: f64,
    left_steps: f64,
    at: Point2<f64>,
}

impl Escape {
    /// None yet; the first one is `first_m` long [m].
    pub(super) fn new(first_m: f64, tries_max: u32) -> Self {
        Self {
            first_m,
            tries_max,
            goal: Point2::origin(),
            geometry: 0,
            recent: Vec::with_capacity(WINDOW + 1),
            since: 1.0,
            running: None,
            tries: 0,
            side: 1.0,
            minimum_m: f64::INFINITY,
            escapes: 0,
        }
    }

    /// Escapes begun towards this goal.
    pub(super) const fn escapes(&self) -> u32 {
        self.escapes
    }

    /// True while one is under way.
    pub(super) const fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// The force of the field, or that of an escape from where the field's forces cancel: below
    /// `least` together.
    pub(super) fn push(
        &mut self,
        input: &LawInput<'_>,
        (pull, repel): (Vector2<f64>, Vector2<f64>),
        least: f64,
    ) -> Push {
        if self.geometry != input.geometry || (self.goal - input.goal).norm() > 1.0e-9 {
            *self = Self {
                goal: input.goal,
                geometry: input.geometry,
                ..Self::new(self.first_m, self.tries_max)
            };
        }
        if let Some(running) = &mut self.running {
            running.left_m -= (input.at - running.at).norm();
            running.left_steps -= input.steps;
            running.at = input.at;
            if running.left_m > 0.0 && running.left_steps > 0.0 {
                return Push::Along(self.force(input, (pull, repel)));
            }
            self.running = None;
            self.recent.clear();
        }
        let force = pull + repel;
        if !self.is_caught(input) && force.norm() >= least {
            return Push::Along(force);
        }
        let distance_m = (input.goal - input.at).norm();
        if distance_m < self.minimum_m - NEARER_M {
            self.tries = 0;
            self.minimum_m = distance_m;
            self.side = roomier_side(input);
        } else {
            self.side = -self.side;
        }
        if self.tries >= self.tries_max {
            return Push::Stuck;
        }
        let left_m = self.first_m * 1.5_f64.powi(self.tries.cast_signed());
        self.tries += 1;
        self.escapes += 1;
        self.running = Some(Running {
            left_m,
            left_steps: PATIENCE * left_m / STEP_M,
            at: input.at,
        });
        Push::Along(self.force(input, (pull, repel)))
    }

    /// `F_esp`. The turned repulsion never points away from an obstacle, so that within a step of one
    /// the repulsion itself acts as well.
    fn force(
        &self,
        input: &LawInput<'_>,
        (pull, repel): (Vector2<f64>, Vector2<f64>),
    ) -> Vector2<f64> {
        let turned = Vector2::new(repel.y, -repel.x) * self.side;
        let near = (input.bodies.iter()).any(|body| body.distance_m(input.at) < STEP_M);
        turned + pull + if near { repel } else { Vector2::zeros() }
    }

    /// True when the robot has hardly moved for some steps.
    fn is_caught(&mut self, input: &LawInput<'_>) -> bool {
        self.since += input.steps;
        if self.since >= 1.0 {
            self.since = 0.0;
            self.recent.push(input.at);
            if self.recent.len() > WINDOW {
                self.recent.remove(0);
            }
        }
        self.recent.len() == WINDOW && (input.at - self.recent[0]).norm() < MOVED_M
    }
}

/// +1 when there is more room to the left of the way to the goal, or as much.
fn roomier_side(input: &LawInput<'_>) -> f64 {
    let to_goal = (input.goal - input.at)
        .try_normalize(1.0e-9)
        .unwrap_or_else(Vector2::x);
    let left = Vector2::new(-to_goal.y, to_goal.x);
    let room = |side: f64| {
        (1..=8)
            .map(|i| {
                let at = input.at + left * (side * 0.25 * f64::from(i)) + to_goal * 0.25;
                let bodies = input.bodies.iter().map(|body| body.distance_m(at));
                bodies.fold(2.0, f64::min)
            })
            .sum::<f64>()
    };
    if room(1.0) >= room(-1.0) { 1.0 } else { -1.0 }
}
