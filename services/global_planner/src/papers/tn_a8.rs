//! `tn_a8`: A* over eight neighbours, the baseline of \[TN\]; the estimate can be chosen.

use crate::papers::best_first::Recipe;
use crate::papers::on_map::OnMap;
use crate::papers::variants::Variant;
use crate::table::PlannerOptions;

/// The planner.
#[must_use]
pub fn tn_a8(options: &PlannerOptions) -> OnMap<Variant> {
    let recipe = Recipe::plain(options.papers.heuristic);
    OnMap::new(Variant::of(recipe), options, false)
}
