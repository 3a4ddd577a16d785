//! What a lidar makes of exact ranges: noise, quantisation, lost, short and mixed returns, in this
//! order. Motion distortion comes before all of them, in the geometry ([`crate::lidar`]).
//!
//! It is the beam model of Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), section 6.3, with
//! mixed pixels for its uniform part (Tuley, Vandapel, Hebert, "Analysis and Removal of Artifacts
//! in 3-D LADAR Data", ICRA 2005).

use crate::noise::{Draws, Stream};
use zeronav_robot_description::Dropout;
use zeronav_robot_description::LidarSpec;

/// Difference of the ranges of two neighbouring beams from which there is an edge between them.
/// [m]
pub const EDGE_M: f64 = 0.1;

/// The noise of one lidar.
#[derive(Debug, Clone)]
pub struct Returns {
    seed: u64,
    spec: LidarSpec,
    /// What a lost return looks like.
    lost: f64,
}

/// A range and whether it is that of the thing that the beam met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Return {
    /// [m] NaN = invalid, +inf = nothing within reach.
    pub range_m: f64,
    /// True when the beam was on the thing that ended it.
    pub genuine: bool,
}

impl Returns {
    /// The noise of `spec`, which [`LidarSpec::check`] accepts.
    #[must_use]
    pub fn new(spec: &LidarSpec, seed: u64) -> Self {
        Self {
            seed,
            lost: match spec.dropout_as {
                Dropout::NoReturn => f64::INFINITY,
                Dropout::Invalid => f64::NAN,
            },
            spec: spec.clone(),
        }
    }

    /// What scan `scan_index` makes of the exact ranges `true_m`, infinite where a beam meets
    /// nothing, one `found` for each. `all_around` when the last beam is the first's neighbour.
    ///
    /// A range is NaN closer than the sensor's limit and +inf when nothing is within its reach. A
    /// lidar inside something solid sees nothing but NaN.
    pub fn of_scan(&self, scan_index: u64, true_m: &[f64], all_around: bool, found: &mut [Return]) {
        let draws = |stream| Draws::new(self.seed, stream, scan_index);
        let spec = &self.spec;
        let noisy = spec.sigma_m > 0.0 || spec.sigma_ratio > 0.0;
        let mut errors = draws(Stream::Range);
        for (found, true_m) in found.iter_mut().zip(true_m) {
            let sigma_m = spec
                .sigma_m
                .max(spec.sigma_ratio * true_m.min(spec.range_m_max));
            let error_m = if noisy {
                sigma_m * errors.normal()
            } else {
                0.0
            };
            let seen_m = quantised(true_m + error_m, spec.quantum_m);
            let range_m = if *true_m == 0.0 {
                f64::NAN
            } else {
                self.within_reach(*true_m, seen_m)
            };
            *found = Return {
                range_m,
                genuine: range_m.is_finite(),
            };
        }
        if spec.dropout_ratio > 0.0 {
            let mut draws = draws(Stream::Dropout);
            for found in &mut *found {
                if draws.uniform() < spec.dropout_ratio && found.genuine {
                    *found = made_up(self.lost);
                }
            }
        }
        if spec.short_ratio > 0.0 {
            let mut draws = draws(Stream::Short);
            for (found, true_m) in found.iter_mut().zip(true_m) {
                let (chance, where_to) = (draws.uniform(), draws.uniform());
                if chance < spec.short_ratio && found.genuine {
                    let short_m = exponential_below(where_to, spec.short_mean_m, *true_m);
                    *found = made_up(self.within_reach(short_m, short_m));
                }
            }
        }
        if spec.edge_ratio > 0.0 {
            self.mix_edges(true_m, all_around, draws(Stream::Edge), found);
        }
    }

    /// A beam behind an edge has a part on the thing before it and gives a range between.
    fn mix_edges(&self, true_m: &[f64], all_around: bool, mut draws: Draws, found: &mut [Return]) {
        let n_beams = true_m.len();
        let neighbour = |beam: usize, step: usize| match beam + step {
            at if at >= 1 && at <= n_beams => Some(at - 1),
            at if all_around => Some((at + n_beams - 1) % n_beams),
            _ => None,
        };
        for beam in 0..n_beams {
            let (chance, share) = (draws.uniform(), draws.uniform());
            if chance >= self.spec.edge_ratio || !found[beam].genuine {
                continue;
            }
            let nearest_m = [neighbour(beam, 0), neighbour(beam, 2)]
                .into_iter()
                .flatten()
                .map(|at| true_m[at])
                .fold(f64::INFINITY, f64::min);
            let own_m = true_m[beam];
            if own_m - nearest_m > EDGE_M {
                let mixed_m = nearest_m + share * (own_m - nearest_m);
                found[beam] = made_up(self.within_reach(mixed_m, mixed_m));
            }
        }
    }

    fn within_reach(&self, true_m: f64, seen_m: f64) -> f64 {
        if true_m > self.spec.range_m_max || seen_m > self.spec.range_m_max {
            f64::INFINITY
        } else if seen_m < self.spec.range_m_min {
            f64::NAN
        } else {
            seen_m
        }
    }
}

impl Return {
    /// Before the scan.
    pub const NONE: Self = made_up(f64::INFINITY);
}

const fn made_up(range_m: f64) -> Return {
    Return {
        range_m,
        genuine: false,
    }
}

fn quantised(range_m: f64, quantum_m: f64) -> f64 {
    if quantum_m > 0.0 {
        (range_m / quantum_m).round() * quantum_m
    } else {
        range_m
    }
}

/// The inverse of the exponential distribution with `mean`, cut at `limit`.
fn exponential_below(uniform: f64, mean: f64, limit: f64) -> f64 {
    let below = -libm::expm1(-limit / mean);
    -mean * libm::log1p(-uniform * below)
}

#[cfg(test)]
mod tests;
