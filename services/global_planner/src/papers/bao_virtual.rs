//! `bao_aao`, `bao_iaa`, `bao_dij`: A* with the virtual obstacles of \[BAO\], under three
//! estimates.
//!
//! A cell past a corner is virtual for the cell it is seen from: no corner is ever cut, whatever
//! rule the query has. Literal mode closes it for every other cell, too; what the search then
//! finds depends on the order of expansion, and it may fail where there is a way. Literal mode
//! never opens a closed node again either.

use crate::papers::best_first::{PastCorner, Recipe};
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::OnMap;
use crate::papers::options::SplineEnds;
use crate::papers::variants::Variant;
use crate::planner::CornerRule;
use crate::table::PlannerOptions;

/// With the Manhattan estimate, which is not admissible; not smoothed.
#[must_use]
pub fn bao_aao(options: &PlannerOptions) -> OnMap<Variant> {
    with(Heuristic::Manhattan, SplineEnds::Off, options)
}

/// With the octile estimate, eq. (8); smoothed.
#[must_use]
pub fn bao_iaa(options: &PlannerOptions) -> OnMap<Variant> {
    with(Heuristic::Octile, options.papers.spline, options)
}

/// Without an estimate: Dijkstra's algorithm; smoothed.
#[must_use]
pub fn bao_dij(options: &PlannerOptions) -> OnMap<Variant> {
    with(Heuristic::Zero, options.papers.spline, options)
}

fn with(heuristic: Heuristic, spline: SplineEnds, options: &PlannerOptions) -> OnMap<Variant> {
    let literal = options.papers.literal;
    let recipe = Recipe {
        reopen: !literal,
        past_corner: if literal {
            PastCorner::Persistent
        } else {
            PastCorner::Edge
        },
        ..Recipe::plain(heuristic)
    };
    let mut variant = Variant::of(recipe);
    variant.corner_rule = Some(CornerRule::ForbidAny);
    variant.spline = spline;
    OnMap::new(variant, options, literal)
}
