//! `zm_tra`: `TRA_A*` of \[ZM\], A* with the straight distance. Its `Searched_Node` is
//! [`crate::PlanStats::expanded`], its `Path_Node` the number of cells of the path.

use crate::papers::best_first::Recipe;
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::OnMap;
use crate::papers::variants::Variant;
use crate::table::PlannerOptions;

/// The planner.
#[must_use]
pub fn zm_tra(options: &PlannerOptions) -> OnMap<Variant> {
    let recipe = Recipe::plain(Heuristic::Euclid);
    OnMap::new(Variant::of(recipe), options, false)
}
