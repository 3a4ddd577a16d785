//! Parameters of the planners of the papers. PAPERS, Appendix B, tells where the defaults come
//! from.

use crate::moves::Neighbours;
use crate::papers::best_first::PastCorner;
use crate::papers::heuristic::Heuristic;
use crate::papers::lwx_aco::AntOptions;
use crate::papers::lwx_oa::GreedyOptions;
use crate::papers::lwx_rrt::TreeOptions;
use crate::papers::spline::{SAMPLES_MAX, Spline, SplineEnds};
use crate::papers::tn_3n::WalkOptions;
use crate::papers::weight::{EtaOptions, WEIGHT_MAX};
use zeronav_params::parameters;

parameters! {
    /// Options of all of them; each reads its own.
    #[derive(Copy)]
    pub struct PaperOptions {
        /// Reproduces the faults as printed where a planner has some; the result says so. The
        /// search may then fail where there is a way, or find worse ones.
        literal: bool = false;
        /// `tn_a8`: which estimate.
        heuristic: Heuristic = Heuristic::default();
        /// `zm_hw`: fixed weight of the heuristic.
        weight: f64 = 1.5, [1.0, WEIGHT_MAX];
        /// `zm_im`: the weight by the distance to obstacles.
        eta: EtaOptions;
        /// `tn_3n`, `tn_hyb`: the walk and what is around it.
        walk: WalkOptions;
        /// `lwx_oa`: the greedy search.
        greedy: GreedyOptions;
        /// `lwx_aco`: the ants.
        ants: AntOptions;
        /// `lwx_rrt`: the random tree.
        tree: TreeOptions;
        /// `bao_full`: which cells around an obstacle are virtual obstacles.
        ring: Neighbours = Neighbours::default();
        /// `bao_aao`, `bao_iaa`, `bao_dij`: for whom a cell past a corner is an obstacle.
        past_corner: PastCorner = PastCorner::default();
        /// `bao_taa`, `bao_aao`, `bao_iaa`, `bao_dij`: whether a closed node is opened again when a
        /// cheaper way to it turns up.
        reopen: bool = true;
        /// `bao_iaa`, `bao_dij`: the curve along the path.
        spline: SplineEnds = SplineEnds::default();
        /// `bao_iaa`, `bao_dij`: samples of the curve from cell to cell.
        spline_samples: u32 = 20, [1, SAMPLES_MAX];
        /// Seed of `lwx_aco` and `lwx_rrt`.
        seed: u64 = 1, [0, u64::MAX];
    }
}

impl PaperOptions {
    /// How `bao_iaa` and `bao_dij` round their paths.
    pub(crate) const fn curve(&self) -> Spline {
        Spline {
            ends: self.spline,
            samples: self.spline_samples,
        }
    }
}
