//! `zm_hw`: `H_W_A*` of \[ZM\], `f = g + w h` with a fixed weight. The path costs at most w times
//! the optimum.

use crate::papers::best_first::Recipe;
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::OnMap;
use crate::papers::options::WEIGHT_MAX;
use crate::papers::variants::Variant;
use crate::papers::weight::Weight;
use crate::table::PlannerOptions;

/// The planner.
#[must_use]
pub fn zm_hw(options: &PlannerOptions) -> OnMap<Variant> {
    let weight = options.papers.weight.clamp(1.0, WEIGHT_MAX);
    let recipe = Recipe {
        weight: Weight::Fixed(weight),
        ..Recipe::plain(Heuristic::Euclid)
    };
    OnMap::new(Variant::of(recipe), options, false)
}
