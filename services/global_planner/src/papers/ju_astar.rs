//! `ju_astar`: A* with the straight distance, the global part of \[JU\].
//!
//! The printed pseudo-code leaves out that obstacles are skipped, the g of a new node, its
//! insertion into the open list and its g on improvement; this is the algorithm it means.

use crate::papers::best_first::Recipe;
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::OnMap;
use crate::papers::variants::Variant;
use crate::table::PlannerOptions;

/// The planner.
#[must_use]
pub fn ju_astar(options: &PlannerOptions) -> OnMap<Variant> {
    let recipe = Recipe::plain(Heuristic::Euclid);
    OnMap::new(Variant::of(recipe), options, false)
}
