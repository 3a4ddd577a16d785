//! What may be set about the planners of the papers. PAPERS, Appendix B, tells where the defaults
//! come from.

use crate::config::{ConfigError, within};
use crate::papers::heuristic::Heuristic;
use serde::{Deserialize, Serialize};

/// Options of all of them; each reads its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PaperOptions {
    /// Reproduces the faults as printed where a planner has some; the result says so. The search
    /// may then fail where there is a way, or find worse ones.
    pub literal: bool,
    /// `tn_a8`: which estimate.
    pub heuristic: Heuristic,
    /// `zm_hw`: fixed weight of the heuristic, 1 to [`WEIGHT_MAX`].
    pub weight: f64,
    /// `zm_im`: the weight by the distance to obstacles.
    pub eta: EtaOptions,
    /// `tn_3n`, `tn_hyb`: the walk and what is around it.
    pub walk: WalkOptions,
    /// `lwx_oa`: the greedy search.
    pub greedy: GreedyOptions,
    /// `lwx_aco`: the ants.
    pub ants: AntOptions,
    /// `lwx_rrt`: the random tree.
    pub tree: TreeOptions,
    /// `bao_full`: which cells around an obstacle are virtual obstacles.
    pub ring: Neighbours,
    /// `bao_iaa`, `bao_dij`: the curve along the path.
    pub spline: SplineEnds,
    /// Seed of `lwx_aco` and `lwx_rrt`.
    pub seed: u64,
}

impl Default for PaperOptions {
    fn default() -> Self {
        Self {
            literal: false,
            heuristic: Heuristic::default(),
            weight: 1.5,
            eta: EtaOptions::default(),
            walk: WalkOptions::default(),
            greedy: GreedyOptions::default(),
            ants: AntOptions::default(),
            tree: TreeOptions::default(),
            ring: Neighbours::default(),
            spline: SplineEnds::default(),
            seed: 1,
        }
    }
}

/// Largest [`PaperOptions::weight`].
pub const WEIGHT_MAX: f64 = 10.0;

/// Largest [`EtaOptions::p0_cells`].
pub const P0_CELLS_MAX: f64 = 12.0;

/// Largest [`WalkOptions::switch_margin_cells`].
pub const SWITCH_MARGIN_MAX: u32 = 16;

/// ZM-IM. See [`EtaOptions::eta`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EtaOptions {
    /// Gain of the emergency zone, 0 to 5.
    pub alpha: f64,
    /// \[1/cell\] slope of the mild zone, 0 to 5. Continuous with the emergency zone when it is
    /// `alpha^2 exp(-P0 (1 - 1/alpha)) / P0`.
    pub beta: f64,
    /// \[cells\] distance beyond which obstacles do not count, 0.1 to [`P0_CELLS_MAX`].
    pub p0_cells: f64,
    /// In place of eq. (5) `alpha (1 - x / P0)^2`, which decreases and is continuous.
    pub monotone: bool,
}

impl Default for EtaOptions {
    fn default() -> Self {
        Self {
            alpha: 2.0,
            beta: 0.2975,
            p0_cells: 3.0,
            monotone: false,
        }
    }
}

/// TN-3N, TN-SW, TN-REG, TN-HYB.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WalkOptions {
    /// To which side the pose vector turns when the three cells are blocked.
    pub rotate: Rotate,
    /// Keeps a turned vector until the direction of the target is free.
    pub keep_heading: bool,
    /// \[cells\] Chebyshev distance of an obstacle within which the walk takes over, 1 to
    /// [`SWITCH_MARGIN_MAX`].
    pub switch_margin_cells: u32,
    /// Which cells belong to one obstacle.
    pub components: Neighbours,
    /// Part of the map that a rectangle may cover, 0 to 1.
    pub rectangle_share_max: f64,
    /// Whether others step in when the method fails.
    pub ladder: bool,
    /// Whether the path is pulled taut afterwards.
    pub pull: bool,
}

impl Default for WalkOptions {
    fn default() -> Self {
        Self {
            rotate: Rotate::default(),
            keep_heading: false,
            switch_margin_cells: 1,
            components: Neighbours::default(),
            rectangle_share_max: 0.25,
            ladder: true,
            pull: false,
        }
    }
}

/// To which side the walk turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rotate {
    /// Counter-clockwise, as printed.
    #[default]
    Ccw,
    /// Clockwise.
    Cw,
    /// To the side whose best cell is cheaper; counter-clockwise of two equal ones.
    Shorter,
}

/// Which cells are neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Neighbours {
    /// Those that share an edge or a corner.
    #[default]
    Eight,
    /// Those that share an edge.
    Four,
}

impl Neighbours {
    /// True when step `n` of [`crate::moves::STEPS`] leads to one.
    #[must_use]
    pub const fn has(self, n: usize) -> bool {
        matches!(self, Self::Eight) || n.is_multiple_of(2)
    }
}

/// LWX-OA.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GreedyOptions {
    /// What happens where no neighbour is left.
    pub dead_end: DeadEndPolicy,
    /// By what the best neighbour is chosen.
    pub child_cost: ChildCost,
}

/// What the greedy search does where no neighbour is left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeadEndPolicy {
    /// Gives up.
    Fail,
    /// Goes back to the last cell that has one: depth-first search, complete.
    #[default]
    Backtrack,
    /// A* from the start.
    FallbackAstar,
}

/// By what the greedy search chooses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ChildCost {
    /// Distance to the goal.
    #[default]
    Distance,
    /// Distance to the goal and cost of the step.
    DistanceAndStep,
}

/// LWX-ACO, PAPERS Appendix D.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AntOptions {
    /// Ants in every iteration, 1 to 1000.
    pub ants: u32,
    /// Most iterations, 1 to 10000.
    pub iterations: u32,
    /// Iterations without a better path after which the search ends, at least 1.
    pub patience: u32,
    /// Exponent of the pheromone, 0 to 20.
    pub alpha: f64,
    /// Exponent of 1 / distance to the goal, 0 to 20.
    pub beta: f64,
    /// Part of the pheromone that is lost in an iteration, 0 to 1.
    pub evaporation: f64,
    /// \[cells\] Pheromone of an ant times the length of its path, > 0.
    pub deposit: f64,
    /// Steps of all ants together, at least 1: what bounds the search on large maps.
    pub steps_max: u32,
}

impl Default for AntOptions {
    fn default() -> Self {
        Self {
            ants: 50,
            iterations: 100,
            patience: 30,
            alpha: 1.0,
            beta: 7.0,
            evaporation: 0.3,
            deposit: 1.0,
            steps_max: 2_000_000,
        }
    }
}

/// LWX-RRT.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TreeOptions {
    /// \[cells\] Length of a branch, >= 1. Without, a twentieth of the map's longer side: one cell
    /// on the maps of the paper.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_cells: Option<f64>,
    /// Part of the samples that is the goal, 0 to 1.
    pub goal_bias: f64,
    /// Most samples, 1 to 10 million.
    pub samples: u32,
    /// \[cells\] How near to the goal the tree must come, >= 0.
    pub region_cells: f64,
}

impl Default for TreeOptions {
    fn default() -> Self {
        Self {
            step_cells: None,
            goal_bias: 0.05,
            samples: 20_000,
            region_cells: 1.0,
        }
    }
}

/// BAO-SPL: how the cubic B-spline meets its first and last control point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SplineEnds {
    /// A mirrored point beyond each end: exact ends, along the path.
    #[default]
    Phantom,
    /// The end points three times: exact ends, straight first piece.
    Triple,
    /// No curve: the cells' centres are the path.
    Off,
}

impl PaperOptions {
    /// Checks every number.
    ///
    /// # Errors
    /// The first that is outside its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let (eta, walk, ants, tree) = (&self.eta, &self.walk, &self.ants, &self.tree);
        let count = f64::from(u32::MAX);
        let margin = f64::from(walk.switch_margin_cells);
        let share = walk.rectangle_share_max;
        for (field, value, min, max) in [
            ("options.papers.weight", self.weight, 1.0, WEIGHT_MAX),
            ("options.papers.eta.alpha", eta.alpha, 0.0, 5.0),
            ("options.papers.eta.beta", eta.beta, 0.0, 5.0),
            (
                "options.papers.eta.p0_cells",
                eta.p0_cells,
                0.1,
                P0_CELLS_MAX,
            ),
            (
                "options.papers.walk.switch_margin_cells",
                margin,
                1.0,
                f64::from(SWITCH_MARGIN_MAX),
            ),
            ("options.papers.walk.rectangle_share_max", share, 0.0, 1.0),
            ("options.papers.ants.ants", f64::from(ants.ants), 1.0, 1.0e3),
            (
                "options.papers.ants.iterations",
                f64::from(ants.iterations),
                1.0,
                1.0e4,
            ),
            (
                "options.papers.ants.patience",
                f64::from(ants.patience),
                1.0,
                count,
            ),
            ("options.papers.ants.alpha", ants.alpha, 0.0, 20.0),
            ("options.papers.ants.beta", ants.beta, 0.0, 20.0),
            (
                "options.papers.ants.evaporation",
                ants.evaporation,
                0.0,
                1.0,
            ),
            ("options.papers.ants.deposit", ants.deposit, 1.0e-6, 1.0e6),
            (
                "options.papers.ants.steps_max",
                f64::from(ants.steps_max),
                1.0,
                count,
            ),
            (
                "options.papers.tree.step_cells",
                tree.step_cells.unwrap_or(1.0),
                1.0,
                1.0e4,
            ),
            ("options.papers.tree.goal_bias", tree.goal_bias, 0.0, 1.0),
            (
                "options.papers.tree.samples",
                f64::from(tree.samples),
                1.0,
                1.0e7,
            ),
            (
                "options.papers.tree.region_cells",
                tree.region_cells,
                0.0,
                1.0e4,
            ),
        ] {
            within(field, value, min, max)?;
        }
        Ok(())
    }
}
