//! The evaluation of rollouts, one or a row of them at a time.

#![allow(
    clippy::inline_always,
    reason = "compiled once more with AVX2 only where it is inlined"
)]

use crate::dwa::options::DwaWeights;
use crate::dwa_t::options::DwaTConfig;
use crate::lanes::data::{LANES_MAX, Lanes, Projections};
use crate::lanes::{Kernel, run_wide};

/// A rollout in the terms of the evaluation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outcome {
    /// [m] along the path.
    pub(crate) progress_m: f64,
    /// [m] beside the path, mean of [`cost_beside`] half way and at the end.
    pub(crate) beside_m: f64,
    /// 1 - cos of the angle between the end's heading and the path.
    pub(crate) heading: f64,
    /// [m] least space around the outline, at most the soft clearance.
    pub(crate) margin_m: f64,
}

/// Quadratic up to 30 cm, so that millimetres beside the path do not make the robot weave.
#[inline]
pub(crate) fn cost_beside(beside: f32) -> f32 {
    const BEND: f32 = 0.3;
    if beside < BEND {
        beside * beside / (2.0 * BEND)
    } else {
        (beside - 0.5 * BEND).min(1.0)
    }
}

/// What a rollout is worth, term by term, in metres of progress.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Terms {
    pub(crate) progress: f64,
    pub(crate) speed: f64,
    pub(crate) cross_track: f64,
    pub(crate) heading: f64,
    pub(crate) clearance: f64,
    pub(crate) turn_change: f64,
    /// Of two that are equal the straighter one.
    pub(crate) straightness: f64,
    /// Faster than the clearance allows.
    pub(crate) calm: f64,
    pub(crate) dynamic_obstacles: f64,
}

impl Terms {
    /// Their sum.
    #[inline(always)]
    pub(crate) fn worth(&self) -> f64 {
        self.progress
            + self.speed
            + self.cross_track
            + self.heading
            + self.clearance
            + self.turn_change
            + self.straightness
            + self.calm
            + self.dynamic_obstacles
    }
}

/// An evaluation of rollouts of one speed.
pub(crate) trait Evaluate: Copy {
    /// The terms of a rollout's worth. `collision_cost` is the cost of a predicted collision, from 0
    /// to 1.
    fn terms(&self, w_radps: f64, outcome: &Outcome, collision_cost: f64) -> Terms;

    /// What a rollout is worth, in metres of progress.
    #[inline(always)]
    fn of(&self, w_radps: f64, outcome: &Outcome, collision_cost: f64) -> f64 {
        self.terms(w_radps, outcome, collision_cost).worth()
    }
}

/// What decides, besides where they lead, how much the rollouts of a speed are worth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RolloutScore {
    pub(super) weights: DwaWeights,
    /// Share of the highest speed.
    pub(super) speed: f64,
    /// [rad/s] steered in the period before.
    pub(super) steered_radps: f64,
    pub(super) w_radps_max: f64,
    /// [m] of space from which on nearness costs nothing, and at which it costs most.
    pub(super) soft_m: f64,
    pub(super) hard_m: f64,
}

impl Evaluate for RolloutScore {
    #[inline(always)]
    fn terms(&self, w_radps: f64, outcome: &Outcome, _: f64) -> Terms {
        let weights = &self.weights;
        let turn_change = (w_radps - self.steered_radps).abs() / self.w_radps_max;
        let near = ((self.soft_m - outcome.margin_m) / (self.soft_m - self.hard_m)).clamp(0.0, 1.0);
        Terms {
            progress: weights.progress * outcome.progress_m,
            speed: weights.speed * self.speed,
            cross_track: -(weights.cross_track * outcome.beside_m),
            heading: -(weights.heading * outcome.heading),
            clearance: -(weights.clearance * near * near * (0.3 + 0.7 * self.speed)),
            turn_change: -(weights.turn_change * turn_change),
            straightness: -(1.0e-6 * w_radps.abs()),
            ..Terms::default()
        }
    }
}

/// [`RolloutScore`] with what `dwa_t` adds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TimedRolloutScore {
    pub(super) worth: RolloutScore,
    pub(super) v_mps: f64,
    pub(super) config: DwaTConfig,
}

impl Evaluate for TimedRolloutScore {
    #[inline(always)]
    fn terms(&self, w_radps: f64, outcome: &Outcome, collision_cost: f64) -> Terms {
        let config = &self.config;
        let calm_mps = config.speed_base_mps + config.speed_gain_hz * outcome.margin_m;
        Terms {
            calm: -(config.weight_speed * (self.v_mps - calm_mps).max(0.0)),
            dynamic_obstacles: -(config.weight_moving * collision_cost),
            ..self.worth.terms(w_radps, outcome, collision_cost)
        }
    }
}

/// The rollouts of one speed, side by side, in the terms of the evaluation.
#[derive(Debug, Clone)]
pub(crate) struct ScoredRollouts {
    /// Where they end and where they are half way, relative to the robot along the map's axes. [m]
    pub(super) x: Lanes,
    pub(super) y: Lanes,
    pub(super) half_x: Lanes,
    pub(super) half_y: Lanes,
    /// Headings at their ends.
    pub(super) cos: Lanes,
    pub(super) sin: Lanes,
    /// The least space around the outline, at most the soft clearance. [m]
    pub(super) space: Lanes,
    /// How bad it is what they touch that moves.
    pub(super) collision_cost: [f64; LANES_MAX],
    /// Where they end on the path, and where they are half way.
    pub(super) then: Projections,
    pub(super) half: Projections,
    /// Bit by bit: the robot can stop on it.
    pub(super) admissible: u64,
    /// What they are worth, admissible or not.
    pub(super) worth: [f64; LANES_MAX],
}

impl Default for ScoredRollouts {
    fn default() -> Self {
        let (lanes, numbers) = ([0.0; LANES_MAX], [0.0; LANES_MAX]);
        Self {
            x: lanes,
            y: lanes,
            half_x: lanes,
            half_y: lanes,
            cos: lanes,
            sin: lanes,
            space: lanes,
            collision_cost: numbers,
            then: Projections::default(),
            half: Projections::default(),
            admissible: 0,
            worth: numbers,
        }
    }
}

impl ScoredRollouts {
    /// One of them in the terms of the evaluation.
    #[inline(always)]
    pub(super) fn outcome(&self, lane: usize) -> Outcome {
        let (along_x, along_y) = (self.then.direction_x[lane], self.then.direction_y[lane]);
        let cos = self.cos[lane] * along_x + self.sin[lane] * along_y;
        let pathless = (along_x, along_y) == (0.0, 0.0);
        let beside = [self.then.beside[lane], self.half.beside[lane]].map(cost_beside);
        Outcome {
            progress_m: f64::from(self.then.along[lane]),
            beside_m: 0.5 * f64::from(beside[0] + beside[1]),
            heading: if pathless { 0.0 } else { 1.0 - f64::from(cos) },
            margin_m: f64::from(self.space[lane]),
        }
    }

    /// Rates rollouts with these yaw rates.
    pub(crate) fn rate(&mut self, terms: &impl Evaluate, yaw_rates: &[f64]) {
        run_wide(Rate {
            rated: self,
            terms,
            yaw_rates,
        });
    }

    /// True when the robot can stop on it.
    pub(super) const fn is_admissible(&self, lane: usize) -> bool {
        self.admissible >> lane & 1 == 1
    }

    /// The admissible one that is worth most, the first of those.
    pub(super) fn most_promising(&self, lanes: usize) -> Option<usize> {
        let mut best = None;
        let mut most = f64::NEG_INFINITY;
        for (lane, worth) in self.worth[..lanes].iter().enumerate() {
            if *worth > most && self.is_admissible(lane) {
                (best, most) = (Some(lane), *worth);
            }
        }
        best
    }
}

/// [`ScoredRollouts::rate`] for wide vectors.
struct Rate<'a, T> {
    rated: &'a mut ScoredRollouts,
    terms: &'a T,
    yaw_rates: &'a [f64],
}

impl<T: Evaluate> Kernel for Rate<'_, T> {
    #[inline(always)]
    fn run(self) {
        let rated = self.rated;
        for (lane, w_radps) in self.yaw_rates.iter().enumerate().take(LANES_MAX) {
            rated.worth[lane] =
                self.terms
                    .of(*w_radps, &rated.outcome(lane), rated.collision_cost[lane]);
        }
    }
}
