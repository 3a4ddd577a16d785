//! What moves, during one manoeuvre.

use super::super::future::Mover;
use super::velocity_pairs::{MOMENTS, STEPS, step_s};

/// A disc during one manoeuvre.
#[allow(clippy::struct_field_names, reason = "the postfix is the unit")]
pub(super) struct Passage {
    /// Its radius. [m]
    pub(super) radius_m: f64,
    /// Its centre at each moment, `None` while it is nowhere. [m]
    pub(super) at_m: [Option<[f64; 2]>; MOMENTS],
    /// The box of its centre. [m]
    lower_m: [f64; 2],
    upper_m: [f64; 2],
}

impl Passage {
    /// Least distance of its edge from a point, at most by what its box leaves open. [m]
    pub(super) fn apart_m(&self, point_m: [f64; 2]) -> f64 {
        let beside = |axis: usize| {
            (self.lower_m[axis] - point_m[axis])
                .max(point_m[axis] - self.upper_m[axis])
                .max(0.0)
        };
        beside(0).hypot(beside(1)) - self.radius_m
    }
}

/// Who is there during a manoeuvre, the first being manoeuvre 0.
pub(super) fn during(movers: &[Mover], manoeuvre: usize) -> Vec<Passage> {
    let passage = |mover: &Mover| {
        let mut at_m = [None; MOMENTS];
        let (mut lower_m, mut upper_m) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (n, at_m) in at_m.iter_mut().enumerate() {
            let disc = mover.at(step_s((manoeuvre * MOMENTS + n + 1) * STEPS));
            *at_m = disc.map(|(centre_m, _)| centre_m);
            for (axis, value) in at_m.iter().flatten().enumerate() {
                lower_m[axis] = lower_m[axis].min(*value);
                upper_m[axis] = upper_m[axis].max(*value);
            }
        }
        Passage {
            radius_m: mover.radius_m,
            at_m,
            lower_m,
            upper_m,
        }
    };
    let all = movers.iter().map(passage);
    all.filter(|passage| passage.at_m.iter().any(Option::is_some))
        .collect()
}
