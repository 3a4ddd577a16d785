//! [JU] with movers: the paper says that the fusion avoids what moves, and reports no experiment.

use super::lwx_dyn::shares;
use crate::drivers::{DEFAULTS, Driver, JU};
use crate::row::Place;
use crate::scenes::{Scene, ju_dyn};
use crate::table::{Context, Outcome, TableError};

/// Measures the scenes.
pub(super) fn run(context: &mut Context) -> Result<Outcome, TableError> {
    let mut outcome = Outcome::default();
    let seeds = context.seed..context.seed + context.drives;
    let scenes = seeds.map(ju_dyn).collect::<Result<Vec<Scene>, _>>()?;
    let place = Place {
        paper: "JU",
        table: "dyn",
        maps: "3 crossing discs, iid 15x15 m, 22.2 %".to_owned(),
        acceptance: 1.0,
        seed: context.seed,
    };
    for Driver { name, settings } in [JU, DEFAULTS] {
        let drives = context.stack()?.drive(&scenes, settings)?;
        shares(&mut outcome, &place, "C5", name, &drives);
    }
    Ok(outcome)
}
