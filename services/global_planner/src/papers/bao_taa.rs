//! `bao_taa`: the traditional A* of \[BAO\], with the Manhattan estimate.
//!
//! The estimate is too large where diagonal steps are allowed, so the path is not the cheapest.
//! The paper lets it cut corners (`corner_rule = "allow"`); in the stack the rule of the query
//! holds, and [`crate::papers::Remarks::corner_cuts`] counts. Literal mode never opens a closed
//! node again, as printed.

use crate::papers::best_first::Recipe;
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::OnMap;
use crate::papers::variants::Variant;
use crate::table::PlannerOptions;

/// The planner.
#[must_use]
pub fn bao_taa(options: &PlannerOptions) -> OnMap<Variant> {
    let literal = options.papers.literal;
    let recipe = Recipe {
        reopen: !literal,
        ..Recipe::plain(Heuristic::Manhattan)
    };
    OnMap::new(Variant::of(recipe), options, literal)
}
