//! `lwx_ta`: the traditional A* of \[LWX\], with the straight distance.
//!
//! Eq. (2) of the paper takes the straight distance from the start for g, with which the search is
//! not A* and its path not the cheapest; literal mode reproduces that.

use crate::papers::best_first::{Recipe, SoFar};
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::OnMap;
use crate::papers::variants::Variant;
use crate::table::PlannerOptions;

/// The planner.
#[must_use]
pub fn lwx_ta(options: &PlannerOptions) -> OnMap<Variant> {
    let literal = options.papers.literal;
    let recipe = Recipe {
        so_far: if literal {
            SoFar::StraightLine
        } else {
            SoFar::Path
        },
        ..Recipe::plain(Heuristic::Euclid)
    };
    OnMap::new(Variant::of(recipe), options, literal)
}
