//! [ZM] tables 2 and 3: an obstacle appears when the robot is four cells away. The searches are counted
//! on the grid of the paper, the drives are those of the real stack.

use super::lwx_dyn::shares;
use super::zm_walk::unbraked;
use crate::drivers::{Driver, ZM_HW, ZM_IM};
use crate::maps::{MapFamily, Maze};
use crate::row::Place;
use crate::scenes::{ZmScene, zm_dyn};
use crate::solve::{Fault, Method, Way};
use crate::stats;
use crate::table::{Context, Outcome, TableError, change, corners, count, excluded, figure, time};
use crate::timing;
use crate::verdict::{Printed, Standing};
use zeronav_global_planner::CornerRule;
use zeronav_msgs::Cell;

/// Share of obstacles; the paper gives none.
const RATIO: f64 = 0.15;

/// Distance at which the obstacle appears. [cells]
const NEAR: f64 = 4.0;

/// Printed: searched nodes 47 and 36, times 0.009 and 0.005 s.
const NODES: f64 = 36.0 / 47.0 - 1.0;
const TIME: f64 = 0.005 / 0.009 - 1.0;

/// Measures a table.
// long: the rows of one table, one after the other
#[allow(
    clippy::too_many_lines,
    reason = "the rows of one table, one after the other"
)]
pub(super) fn run(context: &mut Context, table: &'static str) -> Result<Outcome, TableError> {
    let mut outcome = Outcome::default();
    let scene = if table == "2" {
        ZmScene::Table2
    } else {
        ZmScene::Table3
    };
    let spec = corners(MapFamily::Blocky, [20, 20], RATIO);
    let mazes = spec.draw(context.seed, context.seeds)?;
    let place = |acceptance| Place {
        paper: "ZM",
        table,
        maps: format!("{}, an obstacle at {:?}", spec.name(), scene.cell()),
        acceptance,
        seed: context.seed,
    };
    let on_grid = place(mazes.acceptance);
    let rule = |method: Method| method.under(CornerRule::Allow);
    let hw = rule(Method::new("H_W_A*", "zm_hw"));
    let im = rule(Method::new("IM_APF_A*", "zm_im"));
    let (mut pairs, mut changed) = (Vec::new(), Vec::new());
    for maze in mazes.mazes.iter().filter(|maze| maze.is_free(scene.cell())) {
        let again = (
            replanned(&hw, maze, scene.cell())?,
            replanned(&im, maze, scene.cell())?,
        );
        if let (Some((from_hw, hw)), Some((_, im))) = again {
            pairs.push([hw, im]);
            changed.push(from_hw);
        }
    }
    let left = excluded(pairs.len(), mazes.mazes.len());
    let changes = |value: &dyn Fn(&Way) -> f64| {
        let changes = pairs.iter().map(|[hw, im]| value(im) / value(hw) - 1.0);
        change((changes.collect(), left))
    };
    let name = "IM_APF_A* vs H_W_A*, the second search";
    let note = "maps on which the first path passes the obstacle within four cells";
    outcome.rows.push(
        on_grid.row(
            figure(
                "C2",
                "expanded",
                name,
                Printed::Change(NODES),
                changes(&|way| count(way.stats.expanded)),
            )
            .noting(note),
        ),
    );
    let cells = changes(&|way| count(way.cells.len() as u64));
    outcome.rows.push(
        on_grid.row(
            figure("C2", "cells of the path", name, Printed::Same(0.0), cells)
                .noting("printed: 15 and 15"),
        ),
    );
    for changes in timing::changes(&hw, &[&im], &changed)? {
        let row = time("C6", name, Printed::Change(TIME), changes);
        outcome.rows.push(on_grid.row(row));
    }
    for (name, method) in [("zm_hw and zm_full", &hw), ("zm_im and zm_full", &im)] {
        let walks = unbraked(method, &mazes.mazes, scene)?;
        let untouched = walks.iter().filter(|walk| walk.contact.is_none()).count();
        let left = excluded(walks.len(), mazes.mazes.len());
        for (metric, hits, printed) in [
            ("no contact (share)", untouched, Printed::Always),
            (
                "arrives (share)",
                walks.iter().filter(|walk| walk.arrived).count(),
                Printed::Nothing,
            ),
        ] {
            let algorithm = format!("{name}, nobody brakes");
            let ours = (stats::share(hits, walks.len()), left);
            outcome
                .rows
                .push(on_grid.row(figure("C4", metric, &algorithm, printed, ours)));
        }
    }
    let mut scenes = Vec::new();
    for seed in context.seed..context.seed + context.drives {
        scenes.extend(zm_dyn(scene, RATIO, seed)?);
    }
    let driven = place(
        1.0 - excluded(
            scenes.len(),
            usize::try_from(context.drives).unwrap_or(usize::MAX),
        ),
    );
    for Driver { name, settings } in [ZM_HW, ZM_IM] {
        let drives = context.stack()?.drive(&scenes, settings)?;
        shares(&mut outcome, &driven, "C4", name, &drives);
        let untouched = drives
            .iter()
            .filter(|drive| drive.contacts_moving + drive.contacts_standing == 0);
        let ours = (stats::share(untouched.count(), drives.len()), 0.0);
        outcome.rows.push(
            driven.row(
                figure("C4", "no contact (share)", name, Printed::Always, ours)
                    .standing(Standing::NotComparable)
                    .noting(
                        "the pilot of this project brakes before contact whatever is asked for",
                    ),
            ),
        );
    }
    Ok(outcome)
}

/// The second way of a method: from the cell of its first way where the obstacle appears, around it; and the
/// map that it is searched on.
fn replanned(
    method: &Method,
    maze: &Maze,
    obstacle: Cell,
) -> Result<Option<(Maze, Way)>, TableError> {
    let first = method.ways(core::slice::from_ref(maze))?.remove(0);
    let Ok(first) = first else { return Ok(None) };
    let near = first
        .cells
        .iter()
        .find(|cell| f64::from(cell.x - obstacle.x).hypot(f64::from(cell.y - obstacle.y)) <= NEAR);
    let Some(near) = near.filter(|cell| **cell != obstacle && **cell != maze.goal) else {
        return Ok(None);
    };
    let changed = maze.with_block(obstacle, *near)?;
    let second: Result<Vec<_>, Fault> = method.ways(core::slice::from_ref(&changed));
    Ok(second?.remove(0).ok().map(|way| (changed, way)))
}
