//! BAO-DYN, figures 30 and 31: discs on the path and across it, driven by the paper's planner and
//! controller and by the defaults of this project, and followed blindly, which must not work.

use super::lwx_dyn::shares;
use crate::drivers::{BAO, DEFAULTS, Driver, HALF_A_CELL};
use crate::row::Place;
use crate::scenes::{BaoDyn, BaoMap, Scene};
use crate::stats;
use crate::table::{Context, Outcome, TableError, excluded, figure};
use crate::verdict::Printed;

/// The planner of [BAO], whose path the discs are placed on.
const PLANNER: &[&str] = &[
    "global_planner.planner=bao_iaa",
    "global_planner.options.cost_weight=0",
    HALF_A_CELL,
];

/// The scenes of some seeds whose path has room for six discs.
pub(crate) fn scenes(context: &mut Context) -> Result<Vec<BaoDyn>, TableError> {
    let seeds = context.seed..context.seed + context.drives;
    let maps = seeds.map(BaoMap::new).collect::<Result<Vec<_>, _>>()?;
    let empty: Vec<Scene> = maps.iter().map(BaoMap::empty).collect();
    let mut scenes = Vec::new();
    for (map, drive) in maps.iter().zip(context.stack()?.drive(&empty, PLANNER)?) {
        let plans = drive.result()?.plans;
        let path = plans.into_iter().find(|plan| plan.status == "found");
        scenes.extend(path.and_then(|plan| map.with_discs(plan.points_m)));
    }
    Ok(scenes)
}

/// Measures the scenes.
pub(super) fn run(context: &mut Context) -> Result<Outcome, TableError> {
    let mut outcome = Outcome::default();
    let scenes = scenes(context)?;
    let asked = usize::try_from(context.drives).unwrap_or(usize::MAX);
    let left = excluded(scenes.len(), asked);
    let place = Place {
        paper: "BAO",
        table: "dyn",
        maps: "3 discs on the path, 3 across it, blocky 20x20 m, 8.0 %".to_owned(),
        acceptance: 1.0 - left,
        seed: context.seed,
    };
    let blind = scenes
        .iter()
        .filter(|scene| scene.blind_follower_collides())
        .count();
    let ours = (stats::share(blind, scenes.len()), left);
    let metric = "collides (share)";
    outcome.rows.push(
        place.row(
            figure(
                "C9",
                metric,
                "follows the path blindly",
                Printed::Nothing,
                ours,
            )
            .noting("more than half, or the scene means nothing"),
        ),
    );
    let texts: Vec<Scene> = scenes.iter().map(|scene| scene.scene.clone()).collect();
    for Driver { name, settings } in [BAO, DEFAULTS] {
        let drives = context.stack()?.drive(&texts, settings)?;
        shares(&mut outcome, &place, "C9", name, &drives);
        let (mut ratios, mut aside) = (Vec::new(), Vec::new());
        for (drive, scene) in drives
            .iter()
            .zip(&scenes)
            .filter(|(drive, _)| drive.arrived())
        {
            ratios.push(drive.driven_m / scene.path_m() - 1.0);
            aside.push(scene.lateral_m(&drive.result()?.track_m));
        }
        let left = excluded(ratios.len(), drives.len());
        for (metric, values) in [
            ("length vs the path", ratios),
            ("largest distance from the path [m]", aside),
        ] {
            let ours = (stats::mean(&values), left);
            outcome
                .rows
                .push(place.row(figure("C9", metric, name, Printed::Nothing, ours)));
        }
    }
    Ok(outcome)
}
