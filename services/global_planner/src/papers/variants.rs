//! The planners that are one best-first search under another recipe.

use crate::papers::best_first::{BestFirst, PastCorner, Recipe, SoFar};
use crate::papers::field::{Field, Meter};
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::{NO_WAY, Solver};
use crate::papers::options::PaperOptions;
use crate::papers::sight::pull;
use crate::papers::spline::Spline;
use crate::papers::weight::{EtaOptions, WEIGHT_MAX, Weight};
use crate::planner::{CornerRule, PlanError};
use zeronav_msgs::Cell;

/// `c_los`: the shortest way over the grid, pulled taut along lines of sight: the any-angle
/// baseline of PAPERS 0.6.
pub(crate) fn c_los() -> Variant {
    Variant {
        pull: true,
        ..Variant::of(Recipe::plain(Heuristic::Octile))
    }
}

/// `tn_a8`: A* over eight neighbours, the baseline of \[TN\].
pub(crate) fn tn_a8(heuristic: Heuristic) -> Variant {
    Variant::of(Recipe::plain(heuristic))
}

/// `ju_astar`: A* with the straight distance, the global part of \[JU\].
///
/// The printed pseudo-code leaves out that obstacles are skipped, the g of a new node, its
/// insertion into the open list and its g on improvement; this is the algorithm it means.
pub(crate) fn ju_astar() -> Variant {
    Variant::of(Recipe::plain(Heuristic::Euclid))
}

/// `zm_tra`: `TRA_A*` of \[ZM\], A* with the straight distance. Its `Searched_Node` is
/// [`crate::planner::PlanStats::expanded`], its `Path_Node` the number of cells of the path.
pub(crate) fn zm_tra() -> Variant {
    Variant::of(Recipe::plain(Heuristic::Euclid))
}

/// `zm_hw`: `H_W_A*` of \[ZM\], `f = g + w h` with a fixed weight w, 1 to [`WEIGHT_MAX`]. The path
/// costs at most w times the optimum.
pub(crate) fn zm_hw(weight: f64) -> Variant {
    Variant::of(Recipe {
        weight: Weight::Fixed(weight.clamp(1.0, WEIGHT_MAX)),
        ..Recipe::plain(Heuristic::Euclid)
    })
}

/// `zm_im`: `IM_APF_A*` of \[ZM\], `f = g + exp(eta) h` with eta by the distance to the nearest
/// obstacle, eq. (5).
///
/// Nodes near obstacles get a higher f, so that the search prefers open space. The gains are not
/// printed. The heuristic is not consistent, so closed nodes are reopened; the path costs at most
/// `exp(eta_max)` times the optimum.
pub(crate) fn zm_im(eta: EtaOptions) -> Variant {
    Variant::of(Recipe {
        weight: Weight::Eta(eta),
        ..Recipe::plain(Heuristic::Euclid)
    })
}

/// `lwx_ta`: the traditional A* of \[LWX\], with the straight distance.
///
/// Eq. (2) of the paper takes the straight distance from the start for g, with which the search is
/// not A* and its path not the cheapest; literal mode reproduces that.
pub(crate) fn lwx_ta(literal: bool) -> Variant {
    let so_far = if literal {
        SoFar::StraightLine
    } else {
        SoFar::Path
    };
    Variant {
        literal,
        ..Variant::of(Recipe {
            so_far,
            ..Recipe::plain(Heuristic::Euclid)
        })
    }
}

/// `bao_taa`: the traditional A* of \[BAO\], with the Manhattan heuristic.
///
/// The heuristic is too large where diagonal steps are allowed, so the path is not the cheapest.
/// It cuts corners as in the paper, whatever rule the query has, and
/// [`crate::remarks::Remarks::corner_cuts`] counts them; on the robot the corners are those of the
/// inflation, and the local planner checks the outline against the map all the same. Literal mode never reopens a closed node, as printed.
pub(crate) fn bao_taa(options: &PaperOptions) -> Variant {
    let reopen = options.reopen && !options.literal;
    Variant {
        corner_rule: Some(CornerRule::Allow),
        literal: !reopen,
        ..Variant::of(Recipe {
            reopen,
            ..Recipe::plain(Heuristic::Manhattan)
        })
    }
}

/// `bao_aao`: virtual obstacles and the Manhattan heuristic, which is not admissible; not smoothed.
pub(crate) fn bao_aao(options: &PaperOptions) -> Variant {
    with_virtual_obstacles(Heuristic::Manhattan, Spline::OFF, options)
}

/// `bao_iaa`: virtual obstacles and the octile heuristic, eq. (8); smoothed.
pub(crate) fn bao_iaa(options: &PaperOptions) -> Variant {
    with_virtual_obstacles(Heuristic::Octile, options.curve(), options)
}

/// `bao_dij`: virtual obstacles without a heuristic (Dijkstra's algorithm); smoothed.
pub(crate) fn bao_dij(options: &PaperOptions) -> Variant {
    with_virtual_obstacles(Heuristic::Zero, options.curve(), options)
}

/// A* with the virtual obstacles of \[BAO\].
///
/// A cell past a corner is virtual for the cell it is seen from: no corner is ever cut, whatever
/// rule the query has. A persistent one ([`PastCorner::Persistent`]) is closed for every other
/// cell, too; what the search then finds depends on the order of expansion, and it may fail where
/// there is a way. Literal mode is that, and never reopens a closed node.
fn with_virtual_obstacles(heuristic: Heuristic, spline: Spline, options: &PaperOptions) -> Variant {
    let past_corner = if options.literal {
        PastCorner::Persistent
    } else {
        options.past_corner
    };
    let reopen = options.reopen && !options.literal;
    Variant {
        corner_rule: Some(CornerRule::ForbidAny),
        spline,
        literal: past_corner == PastCorner::Persistent || !reopen,
        ..Variant::of(Recipe {
            reopen,
            past_corner,
            ..Recipe::plain(heuristic)
        })
    }
}

/// A best-first search and what comes after it.
#[derive(Debug)]
pub(crate) struct Variant {
    recipe: Recipe,
    /// Corner rule of the paper.
    corner_rule: Option<CornerRule>,
    /// Whether the path is pulled taut.
    pull: bool,
    /// How the path is rounded.
    spline: Spline,
    /// Whether a fault that is printed in the paper is switched on.
    literal: bool,
    memory: BestFirst,
}

impl Variant {
    /// The search alone.
    fn of(recipe: Recipe) -> Self {
        Self {
            recipe,
            corner_rule: None,
            pull: false,
            spline: Spline::OFF,
            literal: false,
            memory: BestFirst::default(),
        }
    }
}

impl Solver for Variant {
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        let found = self
            .memory
            .search(field, &self.recipe, start, goal, meter)?;
        if !found {
            // A recipe that closes cells for good proves nothing.
            let proof = self.recipe.past_corner == PastCorner::Edge;
            return Err(if proof { NO_WAY } else { PlanError::DeadEnd });
        }
        let first = cells.len();
        self.memory.trace(field, goal, cells);
        if self.pull {
            pull(field, cells, first, meter)?;
        }
        Ok(())
    }

    fn corner_rule(&self) -> Option<CornerRule> {
        self.corner_rule
    }

    fn is_literal(&self) -> bool {
        self.literal
    }

    fn spline(&self) -> Spline {
        self.spline
    }
}
