//! `lwx_fusion` [LWX]: the turning points of the global path walked by the potential field, the walk
//! fitted by least squares, the fit followed by a carrot. Where no fit is free the walk itself is followed,
//! and where it does not arrive, or is not free any longer, `lwx_oapf` drives: a drive without the fit says
//! so ([`Law::remark`]).
//!
//! The walk is planned at once for the whole path, with the obstacles of the map along it; those of a scan
//! reach three metres. The paper's path is that of its greedy A*: choose the planner `lwx_oa` with this
//! controller for its combination.

use super::fit::free_fit;
use super::law::{Law, LawInput, Push};
use super::lwx_loop::{Loop, Restart, run_on};
use super::lwx_lsq::Curve;
use super::lwx_oapf::LwxOapf;
use super::options::LwxFusionConfig;
use super::potential::{all_repulsions, attraction};
use super::walk::{End, Trace, Walk};
use nalgebra::Point2;
use zeronav_msgs::command::RequestCause;

/// OAPF, then LSQ.
#[derive(Debug, Clone)]
pub struct LwxFusion {
    config: LwxFusionConfig,
    walk: Walk,
    geometry: u64,
    /// The fit, or the walk where there is none, while it is free.
    curve: Option<Curve>,
    /// The curve is the fit.
    fitted: bool,
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
            fitted: false,
            walker: LwxOapf::new(config.gains(), config.steps_per_m, false),
        }
    }

    /// True while the fitted curve is driven.
    #[must_use]
    pub const fn is_fitted(&self) -> bool {
        self.fitted && self.curve.is_some()
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
        let around = (input.bodies, input.ground);
        let trace = run_on(self.config.gains(), around, input.path, &how);
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
            let (trace, fit) = self.plan(input);
            self.fitted = fit.is_some();
            let walked = (trace.end == End::Reached).then_some(trace.points);
            self.curve = fit.or(walked).map(Curve::new);
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

    fn remark(&self) -> Option<RequestCause> {
        (!self.is_fitted()).then_some(RequestCause::NoFit)
    }
}
