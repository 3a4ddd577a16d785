//! `zm_esc` [ZM]: leaves local minima of the plain field.
//!
//! The printed escape force is the repulsion that is already balanced, which cannot break the
//! balance. Here the repulsion is turned by a right angle to the side with more room, for a number
//! of steps that grows from try to try.

use super::law::{Law, LawInput, Push};
use super::potential::{Gains, all_repulsions, attraction};
use nalgebra::{Point2, Vector2};

/// Steps of the first escape; each further one takes half as many more.
const ESCAPE_STEPS: f64 = 30.0;

/// Escapes from one place before the law gives up.
const TRIES: u32 = 3;

/// Steps over which the displacement is looked at.
const WINDOW: usize = 20;

/// [m] that a robot must move away from a minimum before its tries are forgotten.
const AWAY_M: f64 = 1.0;

/// The plain field with escapes.
#[derive(Debug, Clone)]
pub struct ZmEsc {
    gains: Gains,
    /// Length of a step, against which displacements are measured. [m]
    step: f64,
    recent: Vec<Point2<f64>>,
    /// Steps left of an escape, and its side: +1 = left.
    escape: Option<(u32, f64)>,
    tries: u32,
    side: f64,
    minimum: Point2<f64>,
    escapes: u32,
}

impl ZmEsc {
    /// The field with these gains, for steps of this length.
    #[must_use]
    pub fn new(gains: Gains, step: f64) -> Self {
        Self {
            gains,
            step,
            recent: Vec::with_capacity(WINDOW + 1),
            escape: None,
            tries: 0,
            side: 1.0,
            minimum: Point2::new(f64::INFINITY, f64::INFINITY),
            escapes: 0,
        }
    }

    /// Escapes begun so far.
    #[must_use]
    pub const fn escapes(&self) -> u32 {
        self.escapes
    }

    /// True when the robot goes nowhere: no force, or hardly any displacement.
    fn is_caught(&mut self, input: &LawInput<'_>, force: Vector2<f64>) -> bool {
        self.recent.push(input.at);
        if self.recent.len() > WINDOW {
            self.recent.remove(0);
        }
        let full = self.recent.len() == WINDOW;
        let moved = (input.at - self.recent[0]).norm();
        force.norm() < 1.0e-3 * self.gains.attract || (full && moved < 3.0 * self.step)
    }

    /// +1 when there is more room to the left of the way to the goal.
    fn roomier_side(input: &LawInput<'_>) -> f64 {
        let to_goal = (input.goal - input.at)
            .try_normalize(1.0e-9)
            .unwrap_or_else(Vector2::x);
        let left = Vector2::new(-to_goal.y, to_goal.x);
        let room = |side: f64| {
            (1..=8)
                .map(|i| {
                    let at = input.at + left * (side * 0.25 * f64::from(i)) + to_goal * 0.25;
                    input
                        .bodies
                        .iter()
                        .map(|body| body.distance_m(at))
                        .fold(2.0, f64::min)
                })
                .sum::<f64>()
        };
        if room(1.0) >= room(-1.0) { 1.0 } else { -1.0 }
    }
}

impl Law for ZmEsc {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let pull = attraction(self.gains.attract, input.at, input.goal);
        let repel = all_repulsions(&self.gains, input);
        let force = pull + repel;
        if let Some((left, side)) = self.escape {
            self.escape = left.checked_sub(1).map(|left| (left, side));
            let turned = Vector2::new(-repel.y, repel.x) * -side;
            // As strong as the pull at least, or the robot would slide back at once.
            let strong = turned
                .try_normalize(1.0e-9)
                .map_or_else(|| pull, |unit| unit * repel.norm().max(1.5 * pull.norm()));
            return Push::Along(strong + pull);
        }
        if !self.is_caught(input, force) {
            return Push::Along(force);
        }
        if (input.at - self.minimum).norm() > AWAY_M {
            self.tries = 0;
            self.minimum = input.at;
            self.side = Self::roomier_side(input);
        } else {
            self.side = -self.side;
        }
        if self.tries >= TRIES {
            return Push::Stuck;
        }
        let steps = ESCAPE_STEPS * 1.5_f64.powi(self.tries.cast_signed());
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most a hundred steps"
        )]
        let steps = steps as u32;
        self.tries += 1;
        self.escapes += 1;
        self.escape = Some((steps, self.side));
        self.recent.clear();
        self.push(input)
    }
}
