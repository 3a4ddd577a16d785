//! `zm_im`: `IM_APF_A*` of \[ZM\], `f = g + exp(eta) h` with eta by the distance to the nearest
//! obstacle, eq. (5).
//!
//! Nodes near obstacles get a higher f, so that the search prefers open space. The gains are not
//! printed; see [`crate::papers::options::EtaOptions`]. The estimate is not consistent, so closed
//! nodes are opened again; the path costs at most `exp(eta_max)` times the optimum.

use crate::papers::best_first::Recipe;
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::OnMap;
use crate::papers::variants::Variant;
use crate::papers::weight::Weight;
use crate::table::PlannerOptions;

/// The planner.
#[must_use]
pub fn zm_im(options: &PlannerOptions) -> OnMap<Variant> {
    let recipe = Recipe {
        weight: Weight::Eta(options.papers.eta),
        ..Recipe::plain(Heuristic::Euclid)
    };
    OnMap::new(Variant::of(recipe), options, false)
}
