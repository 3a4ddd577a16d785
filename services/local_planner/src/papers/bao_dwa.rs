//! `bao_dwa` [BAO]: the dynamic window of Fox, Burgard and Thrun with normalised terms.
//!
//! `V_r = V_m ∩ V_d ∩ V_a` (eq. 14 to 16, the second root of eq. 16 with the angle that is swept
//! instead of a length), `G = sigma (alpha head + beta dist + gamma vel)` (eq. 17, every term
//! divided by its sum over the admissible set, sigma the identity), exact arcs, a local goal at a
//! look-ahead along the path.

use zeronav_motion::Twist;
use zeronav_msgs::command::RequestCause;
use zeronav_msgs::description::Description;

/// [m/s] between sampled speeds.
const V_STEP_MPS: f64 = 0.05;

/// [rad/s] between sampled yaw rates.
const W_STEP_RADPS: f64 = 0.1;

/// Most samples of either.
pub const SAMPLES_MAX: usize = 64;

/// Weights and sizes of the evaluation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaoWeights {
    /// Of heading (`alpha`).
    pub head: f64,
    /// Of distance (`beta`).
    pub dist: f64,
    /// Of speed (`gamma`).
    pub vel: f64,
    /// Factor of everything (`sigma`); without effect on the choice when positive.
    pub sigma: f64,
    /// [m] beyond which distance counts no more.
    pub dist_m_max: f64,
    /// [s] length of a predicted arc.
    pub horizon_s: f64,
    /// [s] control period of the window.
    pub period_s: f64,
}

impl Default for BaoWeights {
    fn default() -> Self {
        Self {
            head: 0.15,
            dist: 0.2,
            vel: 0.1,
            sigma: 1.0,
            dist_m_max: 2.0,
            horizon_s: 3.0,
            period_s: 0.1,
        }
    }
}

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
    /// `pi - |angle to the local goal - heading at the end|`. [rad]
    pub head: f64,
    /// Distance to the nearest obstacle on the arc, capped. [m]
    pub dist: f64,
}

/// The terms of `G` for a sample: heading, distance and speed, each with its weight and divided by
/// its sum over `samples`.
fn terms(samples: &[Sample], weights: &BaoWeights) -> impl Fn(&Sample) -> [f64; 3] {
    let of: [fn(&Sample) -> f64; 3] = [|s| s.head, |s| s.dist, |s| s.twist.v_mps.abs()];
    let sums = of.map(|term| samples.iter().map(term).sum::<f64>());
    let factors = [weights.head, weights.dist, weights.vel].map(|weight| weights.sigma * weight);
    move |sample| {
        core::array::from_fn(|i| {
            let sum = sums[i];
            if sum > 0.0 {
                factors[i] * of[i](sample) / sum
            } else {
                0.0
            }
        })
    }
}

/// The sample with the largest `G`; ties go to the smaller `|w|`.
fn best<'a>(samples: &'a [Sample], weights: &BaoWeights) -> Option<&'a Sample> {
    let terms = terms(samples, weights);
    let tie = 1.0e-12 * weights.sigma;
    let mut best: Option<(f64, &Sample)> = None;
    for sample in samples {
        let here = terms(sample).iter().sum::<f64>();
        let better = best.is_none_or(|(most, known)| {
            here > most + tie
                || (here > most - tie && sample.twist.w_radps.abs() < known.twist.w_radps.abs())
        });
        if better {
            best = Some((here, sample));
        }
    }
    best.map(|(_, sample)| sample)
}

/// The twist with the largest `G`; ties go to the smaller `|w|`.
#[must_use]
pub fn choose(samples: &[Sample], weights: &BaoWeights) -> Option<Twist> {
    best(samples, weights).map(|sample| sample.twist)
}

/// The term that speaks most for the best sample and against the fastest, to explain the choice.
#[must_use]
pub fn decisive(samples: &[Sample], weights: &BaoWeights) -> RequestCause {
    let speed = |sample: &&Sample| sample.twist.v_mps;
    let fastest = samples.iter().max_by(|a, b| speed(a).total_cmp(&speed(b)));
    let Some((best, fastest)) = best(samples, weights).zip(fastest) else {
        return RequestCause::Critics;
    };
    if best.twist.v_mps >= fastest.twist.v_mps {
        return RequestCause::StoppingDistance;
    }
    let terms = terms(samples, weights);
    let (chosen, faster) = (terms(best), terms(fastest));
    if chosen[0] - faster[0] > chosen[1] - faster[1] {
        RequestCause::PathCritic
    } else {
        RequestCause::ClearanceCritic
    }
}

/// Fills `values` with an evenly spread span, at most `step` apart, zero moved onto the nearest.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    reason = "at most 64 samples"
)]
pub fn sample(values: &mut Vec<f64>, span: Span, step: f64) {
    let n = (((span.high - span.low) / step).ceil() as usize).clamp(1, SAMPLES_MAX - 1);
    let at = |i: usize| span.low + (span.high - span.low) * (i as f64 / n as f64);
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
