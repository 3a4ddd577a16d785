//! `c_los`: the shortest way over the grid, pulled taut: the honest any-angle baseline of PAPERS
//! 0.6.

use crate::papers::best_first::Recipe;
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::OnMap;
use crate::papers::variants::Variant;
use crate::table::PlannerOptions;

/// The planner.
#[must_use]
pub fn c_los(options: &PlannerOptions) -> OnMap<Variant> {
    let mut variant = Variant::of(Recipe::plain(Heuristic::Octile));
    variant.pull = true;
    OnMap::new(variant, options, false)
}
