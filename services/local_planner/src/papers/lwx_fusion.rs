//! `lwx_fusion` [LWX]: the path of the greedy A* walked by `lwx_oapf`, the walk fitted by least
//! squares, the fit followed by a carrot; where the walk does not arrive, `lwx_oapf` itself.

use super::fit::free_fit;
use super::law::{Law, LawInput, Push};
use super::lwx_lsq::Curve;
use super::lwx_oapf::LwxOapf;
use super::potential::{Gains, all_repulsions, attraction};
use super::walk::{End, Trace, Walk, is_free, walk};
use nalgebra::Point2;

/// Steps per unit of distance (`L`).
pub const PER_UNIT: f64 = 10.0;

/// OAPF, then LSQ.
#[derive(Debug, Clone)]
pub struct LwxFusion {
    gains: Gains,
    how: Walk,
    geometry: u64,
    curve: Option<Curve>,
    walker: LwxOapf,
}

impl LwxFusion {
    /// The field with these gains, walked like this.
    #[must_use]
    pub const fn new(gains: Gains, how: Walk) -> Self {
        Self {
            gains,
            how,
            geometry: 0,
            curve: None,
            walker: LwxOapf::new(gains, PER_UNIT, false),
        }
    }

    /// The whole plan: the walk, and the fitted curve when the walk arrives and a fit is free.
    #[must_use]
    pub fn plan(&self, input: &LawInput<'_>) -> (Trace, Option<Vec<Point2<f64>>>) {
        let mut law = LwxOapf::new(self.gains, PER_UNIT, false);
        let trace = walk(
            &mut law,
            input.at,
            input.goal,
            input.bodies,
            input.path,
            &self.how,
        );
        let curve = (trace.end == End::Reached)
            .then(|| free_fit(&trace.points, |from, to| is_free(input.bodies, from, to)))
            .flatten();
        (trace, curve)
    }
}

impl Law for LwxFusion {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        if self.geometry != input.geometry {
            self.geometry = input.geometry;
            let (trace, curve) = self.plan(input);
            let walked = (trace.end == End::Reached).then_some(trace.points);
            self.curve = curve.or(walked).map(Curve::new);
        }
        let Some(carrot) = self.curve.as_mut().and_then(|curve| curve.carrot(input.at)) else {
            return self.walker.push(input);
        };
        let pull = attraction(self.gains.attract, input.at, carrot);
        Push::Along(pull + all_repulsions(&self.gains, input))
    }
}
