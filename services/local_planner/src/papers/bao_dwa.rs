//! `bao_dwa` [BAO]: the dynamic window of Fox, Burgard and Thrun with normalised terms.
//!
//! `V_r = V_m ∩ V_d ∩ V_a` (eq. 14 to 16, the second root of eq. 16 with the angle that is swept
//! instead of a length), `G = sigma (alpha head + beta dist + gamma vel + delta path)` (eq. 17 and a
//! term for the path, which `delta = 0` leaves out), every term scaled over the admissible set, exact
//! arcs, a local goal at a look-ahead along the path. `sigma` smooths the scores over neighbouring
//! twists, as in the original method; as a positive constant it would change nothing.

use super::options::{BaoDwaConfig, Normalise, Smooth};
use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::command::RequestCause;
use zeronav_msgs::description::Description;

/// [m/s] between sampled speeds.
const V_STEP_MPS: f64 = 0.05;

/// [rad/s] between sampled yaw rates.
const W_STEP_RADPS: f64 = 0.1;

/// Most samples of either.
pub const SAMPLES_MAX: usize = 64;

/// A closed range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Lowest value.
    pub low: f64,
    /// Highest value.
    pub high: f64,
}

/// `V_m ∩ V_d`: what limits and accelerations allow within `period_s`, for v and w.
#[must_use]
pub fn window(robot: &Description, from: Twist, period_s: f64) -> (Span, Span) {
    let v = Span {
        low: (from.v_mps - robot.brake_mps2 * period_s).max(0.0),
        high: (from.v_mps + robot.a_mps2_max * period_s).min(robot.v_mps_max),
    };
    let about = robot.alpha_radps2_max * period_s;
    let w = Span {
        low: (from.w_radps - about).max(-robot.w_radps_max),
        high: (from.w_radps + about).min(robot.w_radps_max),
    };
    (
        Span {
            high: v.high.max(v.low),
            ..v
        },
        w,
    )
}

/// `V_a` (eq. 16): the robot can stop within the free arc, forward and about.
#[must_use]
pub fn is_admissible(robot: &Description, twist: Twist, free_arc_m: f64) -> bool {
    let v = twist.v_mps.abs();
    let swept_rad = free_arc_m * twist.w_radps.abs() / v.max(1.0e-6);
    v <= (2.0 * free_arc_m * robot.brake_mps2).sqrt()
        && (v < 1.0e-6
            || twist.w_radps.abs() <= (2.0 * swept_rad * robot.alpha_radps2_max).sqrt()
            || twist.w_radps.abs() < 1.0e-9)
}

/// A sample with its terms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The twist.
    pub twist: Twist,
    /// Its place in the sampled window: speeds, then yaw rates.
    pub place: [u8; 2],
    /// `pi - |angle to the local goal - heading at the end|`. [rad]
    pub head: f64,
    /// Distance to the nearest obstacle on the arc, capped. [m]
    pub dist: f64,
    /// How much less than the cap the end is away from the path. [m]
    pub path: f64,
}

/// Terms of the evaluation: heading, distance, speed, nearness to the path.
const TERMS: usize = 4;

/// The terms of a sample, each scaled over `samples` and with its weight.
fn terms(samples: &[Sample], config: &BaoDwaConfig) -> impl Fn(&Sample) -> [f64; TERMS] {
    let of: [fn(&Sample) -> f64; TERMS] = [
        |sample| sample.head,
        |sample| sample.dist,
        |sample| sample.twist.v_mps.abs(),
        |sample| sample.path,
    ];
    let weights = [config.head, config.dist, config.vel, config.path];
    // What is subtracted, and what the rest is divided by.
    let scales = of.map(|term| {
        let values = || samples.iter().map(term);
        match config.normalise {
            Normalise::Sum => (0.0, values().sum::<f64>()),
            Normalise::MinMax => {
                let least = values().fold(f64::INFINITY, f64::min);
                (least, values().fold(f64::NEG_INFINITY, f64::max) - least)
            }
        }
    });
    move |sample| {
        core::array::from_fn(|i| {
            let (offset, divisor) = scales[i];
            if divisor > 0.0 {
                weights[i] * (of[i](sample) - offset) / divisor
            } else {
                0.0
            }
        })
    }
}

/// The mean of the scores of a sample and of those beside it in the window that are admissible.
fn smoothed(samples: &[Sample], scores: &[f64], of: &Sample) -> f64 {
    let beside = |sample: &Sample| {
        let apart = |axis: usize| sample.place[axis].abs_diff(of.place[axis]);
        apart(0) <= 1 && apart(1) <= 1
    };
    let near = samples
        .iter()
        .zip(scores)
        .filter(|(sample, _)| beside(sample));
    let (sum, n) = near.fold((0.0, 0.0), |(sum, n), (_, score)| (sum + score, n + 1.0));
    sum / n
}

/// The sample with the largest `G`; ties go to the smaller `|w|`. `scores` is memory.
fn best<'a>(
    samples: &'a [Sample],
    config: &BaoDwaConfig,
    scores: &mut Vec<f64>,
) -> Option<&'a Sample> {
    const TIE: f64 = 1.0e-12;
    let terms = terms(samples, config);
    scores.clear();
    scores.extend(
        samples
            .iter()
            .map(|sample| terms(sample).iter().sum::<f64>()),
    );
    let mut best: Option<(f64, &Sample)> = None;
    for (sample, score) in samples.iter().zip(&*scores) {
        let here = match config.smooth {
            Smooth::Identity => *score,
            Smooth::Box => smoothed(samples, scores, sample),
        };
        let better = best.is_none_or(|(most, known)| {
            here > most + TIE
                || (here > most - TIE && sample.twist.w_radps.abs() < known.twist.w_radps.abs())
        });
        if better {
            best = Some((here, sample));
        }
    }
    best.map(|(_, sample)| sample)
}

/// The twist with the largest `G`; ties go to the smaller `|w|`. `scores` is memory, reused.
#[must_use]
pub fn choose(samples: &[Sample], config: &BaoDwaConfig, scores: &mut Vec<f64>) -> Option<Twist> {
    best(samples, config, scores).map(|sample| sample.twist)
}

/// The term that speaks most for the best sample and against the fastest, to explain the choice.
#[must_use]
pub fn decisive(samples: &[Sample], config: &BaoDwaConfig, scores: &mut Vec<f64>) -> RequestCause {
    let speed = |sample: &&Sample| sample.twist.v_mps;
    let fastest = samples.iter().max_by(|a, b| speed(a).total_cmp(&speed(b)));
    let Some((best, fastest)) = best(samples, config, scores).zip(fastest) else {
        return RequestCause::Critics;
    };
    if best.twist.v_mps >= fastest.twist.v_mps {
        return RequestCause::StoppingDistance;
    }
    let terms = terms(samples, config);
    let (chosen, faster) = (terms(best), terms(fastest));
    let gain = |term: usize| chosen[term] - faster[term];
    if gain(0).max(gain(3)) > gain(1) {
        RequestCause::PathCritic
    } else {
        RequestCause::ClearanceCritic
    }
}

/// Fills `values` with an evenly spread span, at most `step` apart, zero moved onto the nearest.
pub fn sample(values: &mut Vec<f64>, span: Span, step: f64) {
    let n = ((span.high - span.low) / step)
        .ceil()
        .to_usize()
        .clamp(1, SAMPLES_MAX - 1);
    let at = |i: usize| span.low + (span.high - span.low) * (i.to_f64() / n.to_f64());
    values.clear();
    values.extend((0..=n).map(at));
    if span.low < 0.0
        && span.high > 0.0
        && let Some(nearest) = values.iter_mut().min_by(|a, b| a.abs().total_cmp(&b.abs()))
    {
        *nearest = 0.0;
    }
}

/// Step widths of the sampled window: speeds [m/s] and yaw rates [rad/s].
#[must_use]
pub const fn steps() -> (f64, f64) {
    (V_STEP_MPS, W_STEP_RADPS)
}
