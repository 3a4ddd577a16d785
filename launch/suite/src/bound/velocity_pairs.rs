//! What the robot can do: manoeuvres from pair to pair.
//!
//! A pair is a forward speed and a yaw rate, out of a few of each. In a manoeuvre both change as fast
//! as the robot can from one pair to another and are held then. Manoeuvres begin and end in pairs, so
//! all of them are integrated once and then only placed.

use super::super::oracle::robot::{Abilities, State};
use zeronav_casts::Cast;

/// How long a manoeuvre lasts. [s]
pub(super) const MANOEUVRE_S: f64 = 0.4;

/// Moments of a manoeuvre at which the search looks for contacts: every 20 ms, as often as the robot
/// gets a command.
pub(super) const MOMENTS: usize = 20;

/// Steps of the integration from moment to moment, and how long one lasts. [s]
pub(super) const STEPS: usize = 4;
const STEP_S: f64 = 0.005;

/// Speeds are apart by this share of what a manoeuvre can change, at most.
const SPEED_SHARE: f64 = 1.0 / 3.0;

/// Fewest and most speeds of one direction.
const SPEEDS: [f64; 2] = [4.0, 60.0];

/// Yaw rates in shares of the largest: fine ones to hold a direction, coarse ones to turn.
const RATES: [f64; 5] = [0.075, 0.2, 0.4, 0.7, 1.0];

/// A forward speed and a yaw rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct VelocityPair {
    /// [m/s]
    pub(super) v_mps: f64,
    /// [rad/s]
    pub(super) w_radps: f64,
}

/// The robot at a moment of a manoeuvre, seen from `base` at its beginning.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Moment {
    /// Its centre. [m]
    pub(super) at_m: [f64; 2],
    /// Cosine and sine of the angle turned.
    pub(super) turned: [f64; 2],
    /// No point of the outline has moved farther since the moment before. [m]
    pub(super) moved_m: f64,
}

/// A manoeuvre.
#[derive(Debug, Clone)]
pub(super) struct Manoeuvre {
    /// Index of the pair in which it ends.
    pub(super) to: usize,
    /// Angle turned. [rad]
    pub(super) turned_rad: f64,
    /// One after the other; the beginning is none of them.
    pub(super) moments: [Moment; MOMENTS],
}

impl Manoeuvre {
    /// The robot at its end.
    pub(super) const fn end(&self) -> &Moment {
        &self.moments[MOMENTS - 1]
    }
}

/// All pairs, and the manoeuvres between them.
#[derive(Debug)]
pub(super) struct VelocityPairs {
    all: Vec<VelocityPair>,
    /// The manoeuvres that begin in each pair.
    manoeuvres: Vec<Vec<Manoeuvre>>,
    /// Index of the pair of a robot that stands.
    pub(super) rest: usize,
}

impl VelocityPairs {
    /// Those of a robot.
    pub(super) fn new(abilities: &Abilities) -> Self {
        let speeds = speeds(abilities);
        let rates = rates(abilities);
        let pairs = speeds
            .iter()
            .flat_map(|v| rates.iter().map(move |w| (*v, *w)));
        let pairs: Vec<VelocityPair> = pairs
            .map(|(v_mps, w_radps)| VelocityPair { v_mps, w_radps })
            .collect();
        let from = |pair: &VelocityPair| {
            let to = pairs.iter().enumerate();
            to.filter_map(|(index, to)| manoeuvre(*pair, (index, *to), abilities))
                .collect()
        };
        let manoeuvres = pairs.iter().map(from).collect();
        let rest = VelocityPair {
            v_mps: 0.0,
            w_radps: 0.0,
        };
        Self {
            rest: pairs.iter().position(|pair| *pair == rest).unwrap_or(0),
            all: pairs,
            manoeuvres,
        }
    }

    /// A pair.
    pub(super) fn pair(&self, index: usize) -> VelocityPair {
        self.all[index]
    }

    /// The manoeuvres that begin in a pair.
    pub(super) fn from(&self, index: usize) -> &[Manoeuvre] {
        &self.manoeuvres[index]
    }
}

/// One step of the integration, towards a pair.
pub(super) fn step(now: &State, towards: VelocityPair, abilities: &Abilities) -> State {
    let up = abilities.speed_up_mps2 * STEP_S;
    let down = abilities.a_mps2_max * STEP_S;
    let turn = abilities.alpha_radps2_max * STEP_S;
    let v_mps = nearer(now.v_mps, towards.v_mps, up, down);
    let w_radps = nearer(now.w_radps, towards.w_radps, turn, turn);
    let along_m = 0.5 * (now.v_mps + v_mps) * STEP_S;
    let turned_rad = 0.5 * (now.w_radps + w_radps) * STEP_S;
    // The chord of a short arc points along half its angle.
    let (sin, cos) = (now.yaw_rad + 0.5 * turned_rad).sin_cos();
    State {
        t_s: now.t_s + STEP_S,
        at_m: [now.at_m[0] + along_m * cos, now.at_m[1] + along_m * sin],
        yaw_rad: now.yaw_rad + turned_rad,
        v_mps,
        w_radps,
    }
}

/// Run time after some steps. [s]
pub(super) fn step_s(steps: usize) -> f64 {
    steps.to_f64() * STEP_S
}

/// `value` after it has changed towards `target`, by at most `up` away from zero and `down` towards
/// it.
fn nearer(value: f64, target: f64, up: f64, down: f64) -> f64 {
    /// What steps that add up to a change exactly may miss of it.
    const ROUNDING: f64 = 1.0e-6;
    let slows = (target - value) * value < 0.0;
    let (end, most) = match (slows, value * target < 0.0) {
        (true, true) => (0.0, down),
        (true, false) => (target, down),
        (false, _) => (target, up),
    };
    let way = end - value;
    if way.abs() <= most * (1.0 + ROUNDING) {
        end
    } else {
        value + most.copysign(way)
    }
}

/// The manoeuvre between two pairs; `None` when they are too far apart for one.
fn manoeuvre(
    from: VelocityPair,
    (index, to): (usize, VelocityPair),
    abilities: &Abilities,
) -> Option<Manoeuvre> {
    let too_far = |change: f64, per_s2: f64| change.abs() > per_s2 * (MANOEUVRE_S + STEP_S);
    let fastest = abilities.a_mps2_max.max(abilities.speed_up_mps2);
    if too_far(to.v_mps - from.v_mps, fastest)
        || too_far(to.w_radps - from.w_radps, abilities.alpha_radps2_max)
    {
        return None;
    }
    let mut now = State {
        t_s: 0.0,
        at_m: [0.0; 2],
        yaw_rad: 0.0,
        v_mps: from.v_mps,
        w_radps: from.w_radps,
    };
    let mut moments = [Moment::default(); MOMENTS];
    for moment in &mut moments {
        for _ in 0..STEPS {
            let next = step(&now, to, abilities);
            // Of the mean speeds; the corners swing around the centre.
            let along_m = 0.5 * (now.v_mps + next.v_mps).abs() * STEP_S;
            let swing_m = (next.yaw_rad - now.yaw_rad).abs() * abilities.reach_m;
            moment.moved_m += along_m + swing_m;
            now = next;
        }
        let (sin, cos) = now.yaw_rad.sin_cos();
        moment.at_m = now.at_m;
        moment.turned = [cos, sin];
    }
    let is_there = VelocityPair {
        v_mps: now.v_mps,
        w_radps: now.w_radps,
    } == to;
    is_there.then_some(Manoeuvre {
        to: index,
        turned_rad: now.yaw_rad,
        moments,
    })
}

/// Forward speeds, 0 among them, with the fastest of each direction. [m/s]
fn speeds(abilities: &Abilities) -> Vec<f64> {
    let apart_mps = SPEED_SHARE * abilities.speed_up_mps2 * MANOEUVRE_S;
    let [slowest, fastest] = abilities.v_mps;
    let mut all = vec![0.0];
    for end in [slowest, fastest] {
        if end.abs() > 0.0 {
            let parts = (end.abs() / apart_mps - 1.0e-9).ceil();
            all.extend(shares(parts.clamp(SPEEDS[0], SPEEDS[1])).map(|share| share * end));
        }
    }
    all
}

/// Yaw rates, 0 among them, to both sides. [rad/s] None is farther from the next than a manoeuvre
/// can change it.
fn rates(abilities: &Abilities) -> Vec<f64> {
    let apart_radps = abilities.alpha_radps2_max * MANOEUVRE_S;
    let mut all = vec![0.0];
    let mut last = 0.0;
    for rate in RATES.map(|share| share * abilities.w_radps_max) {
        let parts = ((rate - last) / apart_radps - 1.0e-9).ceil();
        for share in shares(parts.clamp(1.0, SPEEDS[1])) {
            let between = last + share * (rate - last);
            all.extend([between, -between]);
        }
        last = rate;
    }
    all
}

/// `1 / parts`, `2 / parts` and so on up to 1.
fn shares(parts: f64) -> impl Iterator<Item = f64> {
    (1..=parts.to_u32()).map(move |part| f64::from(part) / parts)
}
