//! [ZM] table 1: A* with a fixed weight (`H_W_A*`) and with the weight exp(eta) (`IM_APF_A*`) against
//! A* (`TRA_A*`), and a sweep of the gains that the paper does not give.

use crate::figure::Drawing;
use crate::maps::{MapFamily, Maze};
use crate::row::{Place, Row};
use crate::solve::{Fault, Method, Way};
use crate::table::{
    Context, Outcome, TableError, change, corners, count, draw, figure, paired, safety, time,
};
use crate::verdict::Printed;
use crate::{stats, timing};
use serde_json::json;
use zeronav_global_planner::CornerRule;

/// Printed: searched nodes 84, 66, 67; nodes of the path 26, 30, 30; times 0.042, 0.016, 0.007 s.
const HW_NODES: f64 = 66.0 / 84.0 - 1.0;
const IM_NODES: f64 = 67.0 / 84.0 - 1.0;
const IM_HW_NODES: f64 = 67.0 / 66.0 - 1.0;
const PATH_NODES: f64 = 30.0 / 26.0 - 1.0;
const IM_HW_TIME: f64 = 0.007 / 0.016 - 1.0;
const HW_TRA_TIME: f64 = 0.016 / 0.042 - 1.0;
const IM_TRA_TIME: f64 = 0.007 / 0.042 - 1.0;

/// Fixed weight of `zm_hw`, which bounds its cost.
const WEIGHT: f64 = 1.5;

fn rule(method: Method) -> Method {
    method.under(CornerRule::Allow)
}

/// Measures the table.
// long: the rows of one table, one after the other
#[allow(
    clippy::too_many_lines,
    reason = "the rows of one table, one after the other"
)]
pub(super) fn run(context: &mut Context) -> Result<Outcome, TableError> {
    let mut outcome = Outcome::default();
    let (tra, hw, im) = (
        rule(Method::new("TRA_A*", "zm_tra")),
        rule(Method::new("H_W_A*", "zm_hw")),
        rule(Method::new("IM_APF_A*", "zm_im")),
    );
    for family in context.families.clone() {
        for ratio in [0.15, 0.25] {
            let spec = corners(family, [20, 20], ratio);
            let (mazes, place) = draw(context, "ZM", "1", &spec)?;
            let mazes = &mazes.mazes;
            let ways = [tra.ways(mazes)?, hw.ways(mazes)?, im.ways(mazes)?];
            bounded(&ways[0], &ways[1])?;
            let [of_tra, of_hw, of_im] = &ways;
            let nodes = |way: &Way| count(way.stats.expanded);
            let cells = |way: &Way| count(way.cells.len() as u64);
            let length = |way: &Way| way.length;
            let rows = &mut outcome.rows;
            let mut push = |claim, metric: &str, name: &str, printed, changes| {
                let changes = change(changes);
                rows.push(place.row(figure(claim, metric, name, printed, changes)));
            };
            let (hw_tra, im_tra, im_hw) = (
                "H_W_A* vs TRA_A*",
                "IM_APF_A* vs TRA_A*",
                "IM_APF_A* vs H_W_A*",
            );
            push(
                "C1",
                "expanded",
                hw_tra,
                Printed::Change(HW_NODES),
                paired(of_tra, of_hw, nodes),
            );
            push(
                "C1",
                "expanded",
                im_tra,
                Printed::Change(IM_NODES),
                paired(of_tra, of_im, nodes),
            );
            push(
                "C2",
                "expanded",
                im_hw,
                Printed::Same(IM_HW_NODES),
                paired(of_hw, of_im, nodes),
            );
            push(
                "C5",
                "cells of the path",
                hw_tra,
                Printed::Change(PATH_NODES),
                paired(of_tra, of_hw, cells),
            );
            push(
                "C5",
                "cells of the path",
                im_tra,
                Printed::Change(PATH_NODES),
                paired(of_tra, of_im, cells),
            );
            push(
                "C5",
                "length",
                hw_tra,
                Printed::Nothing,
                paired(of_tra, of_hw, length),
            );
            push(
                "C5",
                "length",
                im_tra,
                Printed::Nothing,
                paired(of_tra, of_im, length),
            );
            for (name, base, ours, printed) in [
                (im_hw, &hw, &im, IM_HW_TIME),
                (hw_tra, &tra, &hw, HW_TRA_TIME),
                (im_tra, &tra, &im, IM_TRA_TIME),
            ] {
                for changes in timing::changes(base, &[ours], mazes)? {
                    let claim = if base.name == tra.name { "C6" } else { "C3" };
                    rows.push(place.row(time(claim, name, Printed::Change(printed), changes)));
                }
            }
            for (name, ways) in [(hw_tra, of_hw), (im_tra, of_im)] {
                let turns = change(paired(of_tra, ways, |way| 1.0 + count(way.turns())));
                rows.push(
                    place.row(
                        figure("C7", "turning points", name, Printed::Less, turns).noting(
                            "smoother is claimed, no number is printed; the end is counted",
                        ),
                    ),
                );
            }
            if family == MapFamily::Blocky {
                sweep(rows, &place, mazes, of_hw)?;
                if outcome.drawing.is_none() {
                    let named = [("TRA_A*", of_tra), ("H_W_A*", of_hw), ("IM_APF_A*", of_im)];
                    outcome.drawing = Drawing::of(mazes, &named);
                }
            }
            for (name, ways) in [("TRA_A*", of_tra), ("IM_APF_A*", of_im)] {
                outcome
                    .rows
                    .extend(safety("safety", name, ways).map(|figure| place.row(figure)));
            }
        }
    }
    Ok(outcome)
}

/// Weighted A* costs at most its weight times the optimum.
fn bounded(optimum: &crate::solve::Ways, weighted: &crate::solve::Ways) -> Result<(), Fault> {
    for (map, pair) in optimum.iter().zip(weighted).enumerate() {
        if let (Ok(best), Ok(way)) = pair
            && !(best.length - 1.0e-6..=WEIGHT * best.length + 1.0e-6).contains(&way.length)
        {
            return Err(Fault::Broken {
                what: "length of H_W_A* within 1.5 times the optimum".to_owned(),
                map,
                problem: format!("{} and {} cells", way.length, best.length),
            });
        }
    }
    Ok(())
}

/// The gains that are not printed: the best and the median of all that were tried.
fn sweep(
    rows: &mut Vec<Row>,
    place: &Place,
    mazes: &[Maze],
    of_hw: &crate::solve::Ways,
) -> Result<(), Fault> {
    let nodes = |way: &Way| count(way.stats.expanded);
    let mut tried = Vec::new();
    let some = &mazes[..mazes.len().min(100)];
    for p0_cells in [1.0, 2.0, 3.0, 5.0] {
        for alpha in [1.1, 2.0, 4.0] {
            for beta in [0.0, 0.2975, 1.0] {
                let eta = json!({ "eta": { "p0_cells": p0_cells, "alpha": alpha, "beta": beta } });
                let im = rule(Method::new("IM_APF_A*", "zm_im")).with(eta.clone());
                let ways = im.ways(some)?;
                let base = of_hw[..some.len()].to_vec();
                let changes = change(paired(&base, &ways, nodes));
                tried.push((changes, eta));
            }
        }
    }
    tried.sort_by(|a, b| {
        let mean = |entry: &((Option<stats::Estimate>, f64), serde_json::Value)| {
            entry.0.0.map_or(f64::INFINITY, |estimate| estimate.mean)
        };
        mean(a).total_cmp(&mean(b))
    });
    let middle = tried.len() / 2;
    for (name, index) in [("best of 36 gains", 0), ("median of 36 gains", middle)] {
        let (changes, eta) = &tried[index];
        let algorithm = format!("IM_APF_A* vs H_W_A*, {name}");
        let printed = Printed::Same(IM_HW_NODES);
        rows.push(
            place.row(figure("C2", "expanded", &algorithm, printed, *changes).with(eta.clone())),
        );
    }
    Ok(())
}
