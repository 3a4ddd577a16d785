//! `lwx_fusion` [LWX]: the turning points of the global path walked by the potential field, the walk
//! fitted by least squares, the fit followed by a carrot; where the walk does not arrive or is not
//! free, `lwx_oapf` itself.
//!
//! The paper's path is that of its greedy A*: choose the planner `lwx_oa` with this controller for its
//! combination.

use super::fit::free_fit;
use super::law::{Law, LawInput, Push};
use super::lwx_loop::{Loop, Restart, run};
use super::lwx_lsq::Curve;
use super::lwx_oapf::LwxOapf;
use super::options::LwxFusionConfig;
use super::potential::{all_repulsions, attraction};
use super::walk::{End, Trace, Walk};
use nalgebra::Point2;

/// OAPF, then LSQ.
#[derive(Debug, Clone)]
pub struct LwxFusion {
    config: LwxFusionConfig,
    walk: Walk,
    geometry: u64,
    curve: Option<Curve>,
    walker: LwxOapf,
}

impl LwxFusion {
    /// The field with these gains, rolled out like this.
    #[must_use]
    pub const fn new(config: &LwxFusionConfig, walk: Walk) -> Self {
        Self {
            config: *config,
            walk,
            geometry: 0,
            curve: None,
            walker: LwxOapf::new(config.gains(), config.steps_per_m, false),
        }
    }

    /// The whole plan: the walk, and the fitted curve when the walk arrives and a fit is free.
    #[must_use]
    pub fn plan(&self, input: &LawInput<'_>) -> (Trace, Option<Vec<Point2<f64>>>) {
        let how = Loop {
            walk: self.walk,
            per_unit: self.config.steps_per_m,
            early_exit: true,
            restart: Restart::Robot,
            falls_back: true,
        };
        let trace = run(self.config.gains(), input.bodies, input.path, &how);
        let curve = (trace.end == End::Reached)
            .then(|| free_fit(&trace.points, |from, to| input.is_free(from, to)))
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
        // What was free when it was fitted may not be any longer.
        self.curve.take_if(|curve| !curve.is_free(input));
        let lookahead = self.config.lookahead_m;
        let carrot = self
            .curve
            .as_mut()
            .and_then(|curve| curve.carrot(input.at, lookahead));
        let Some(carrot) = carrot else {
            return self.walker.push(input);
        };
        let gains = self.config.gains();
        let pull = attraction(gains.attract, input.at, carrot);
        Push::Along(pull + all_repulsions(&gains, input))
    }
}
