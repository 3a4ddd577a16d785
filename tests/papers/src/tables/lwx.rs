//! [LWX] tables 1 to 4: the "optimised A*", which is a greedy search without an open list, against A*
//! (1 to 3) and against the bidirectional search to the middle (4).
//!
//! Every table has maps of its own, as those of the paper are of different figures. The corner rule of the
//! paper is not said and its pictures cut corners: both rules are measured, on both sides of a comparison.

use crate::figure::Drawing;
use crate::maps::{MapFamily, MapSpec, Maze, Mazes};
use crate::row::{Place, Row};
use crate::solve::{Fault, Method, Way, Ways};
use crate::stats;
use crate::table::{
    Context, Outcome, TableError, change, corners, count, draw_from, excluded, failures, figure,
    paired, safety, solved, time,
};
use crate::timing;
use crate::verdict::Printed;
use serde_json::json;
use zeronav_global_planner::CornerRule;
use zeronav_world::generate::GenerateError;

/// Between the seeds of the maps of two tables: more than anybody asks maps of one.
const APART: u64 = 1_000_000;

/// The maps of a table of [LWX], which no other one has, and the place of their figures.
pub(super) fn own_maps(
    context: &Context,
    table: &'static str,
    spec: &MapSpec,
) -> Result<(Mazes, Place), GenerateError> {
    let number = table.parse().unwrap_or(0_u64);
    draw_from(context, "LWX", table, spec, context.seed + APART * number)
}

struct Printout {
    table: &'static str,
    side: u32,
    time: f64,
    /// Searched nodes, where they are printed.
    nodes: Option<f64>,
}

const PRINTED: [Printout; 4] = [
    Printout {
        table: "1",
        side: 20,
        time: -0.655,
        nodes: None,
    },
    Printout {
        table: "2",
        side: 20,
        time: -0.548,
        nodes: None,
    },
    Printout {
        table: "3",
        side: 40,
        time: -0.706,
        nodes: None,
    },
    Printout {
        table: "4",
        side: 20,
        time: -0.652,
        nodes: Some(70.0 / 103.0 - 1.0),
    },
];

/// Corner rules with what a row says of them.
const RULES: [(CornerRule, &str); 2] = [
    (CornerRule::ForbidAny, "no corner is cut"),
    (CornerRule::Allow, "corners are cut, as in the paper"),
];

/// The methods of a table under a corner rule.
struct Methods {
    greedy: Method,
    back: Method,
    base: Method,
    optimum: Method,
}

impl Methods {
    fn new(table: &str, rule: CornerRule) -> Self {
        let of = |dead_end: &str| json!({ "greedy": { "dead_end": dead_end } });
        let base = if table == "4" {
            Method::new("bidirectional", "lwx_bi")
        } else {
            Method::new("A*", "lwx_ta")
        };
        Self {
            greedy: Method::new("greedy", "lwx_oa").with(of("fail")).under(rule),
            back: Method::new("greedy with backtracking", "lwx_oa")
                .with(of("backtrack"))
                .under(rule),
            base: base.under(rule),
            optimum: Method::new("A*", "tn_a8")
                .with(json!({ "heuristic": "octile" }))
                .under(rule),
        }
    }
}

/// Measures a table.
pub(super) fn run(context: &mut Context, index: usize) -> Result<Outcome, TableError> {
    let printed = &PRINTED[index];
    let mut outcome = Outcome::default();
    for family in context.families.clone() {
        for ratio in [0.1, 0.2, 0.3] {
            let spec = corners(family, [printed.side; 2], ratio);
            let (mazes, place) = own_maps(context, printed.table, &spec)?;
            for (rule, note) in RULES {
                let methods = Methods::new(printed.table, rule);
                let drawing = rows(
                    &mut outcome.rows,
                    (&place, note),
                    printed,
                    (&methods, &mazes.mazes),
                )?;
                let is_drawn = family == MapFamily::Blocky && rule == CornerRule::ForbidAny;
                if is_drawn && outcome.drawing.is_none() {
                    outcome.drawing = drawing;
                }
            }
        }
    }
    Ok(outcome)
}

/// The rows of the maps of a kind under a corner rule, which `note` names, and a picture of one map.
fn rows(
    rows: &mut Vec<Row>,
    (place, note): (&Place, &str),
    printed: &Printout,
    (methods, mazes): (&Methods, &[Maze]),
) -> Result<Option<Drawing>, Fault> {
    let (of_greedy, of_back) = (methods.greedy.ways(mazes)?, methods.back.ways(mazes)?);
    let (of_base, of_best) = (methods.base.ways(mazes)?, methods.optimum.ways(mazes)?);
    let claim = if printed.table == "4" { "C4" } else { "C1" };
    let mut put = |figure: crate::row::Figure| {
        let note = if figure.note.is_empty() {
            note.to_owned()
        } else {
            format!("{note}; {}", figure.note)
        };
        rows.push(place.row(figure.noting(note)));
    };
    let name = format!("greedy vs {}", methods.base.name);
    let nodes = |way: &Way| count(way.stats.expanded);
    let changes = change(paired(&of_base, &of_greedy, nodes));
    let of_nodes = Printed::Change(printed.nodes.unwrap_or(printed.time));
    let said = if printed.nodes.is_none() {
        "printed is time"
    } else {
        ""
    };
    put(figure(claim, "expanded", &name, of_nodes, changes).noting(said));
    for changes in timing::changes(&methods.base, &[&methods.greedy], mazes)? {
        put(time(claim, &name, Printed::Change(printed.time), changes));
    }
    let name = "greedy vs optimal A*";
    let changes = change(paired(&of_best, &of_greedy, |way: &Way| way.length));
    put(figure("C2", "length", name, Printed::Nothing, changes));
    put(figure(
        "C2",
        "same length as A* (share)",
        "greedy, where it arrives",
        Printed::Always,
        same(&of_best, &of_greedy),
    ));
    let success = (solved(&of_greedy), 0.0);
    put(
        figure("C3", "success (share)", "greedy", Printed::Always, success)
            .noting(failures(&of_greedy)),
    );
    let success = (solved(&of_back), 0.0);
    put(figure(
        "C3",
        "success (share)",
        methods.back.name,
        Printed::Nothing,
        success,
    )
    .noting("what the text may mean; on ways as long as the next row says"));
    let name = "greedy with backtracking vs optimal A*";
    let changes = change(paired(&of_best, &of_back, |way: &Way| way.length));
    put(figure("C3", "length", name, Printed::Nothing, changes));
    for figure in safety("safety", "greedy", &of_greedy) {
        put(figure);
    }
    let named = [
        ("greedy", &of_greedy),
        ("greedy with backtracking", &of_back),
        (methods.base.name, &of_base),
    ];
    Ok(Drawing::of(mazes, &named))
}

/// Share of the maps that both solve on which both ways are equally long.
fn same(best: &Ways, ours: &Ways) -> (Option<stats::Estimate>, f64) {
    let pairs: Vec<bool> = best
        .iter()
        .zip(ours)
        .filter_map(|pair| match pair {
            (Ok(best), Ok(ours)) => Some((best.length - ours.length).abs() < 1.0e-6),
            _ => None,
        })
        .collect();
    let equal = pairs.iter().filter(|equal| **equal).count();
    (
        stats::share(equal, pairs.len()),
        excluded(pairs.len(), best.len()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 2 is of "another map" and table 4 of another figure: their maps are none of table 1.
    #[test]
    fn every_table_has_its_own_maps() {
        let context = Context {
            seeds: 5,
            drives: 0,
            seed: 1,
            families: vec![MapFamily::Blocky],
            stack: None,
        };
        let spec = corners(MapFamily::Blocky, [20, 20], 0.2);
        let first = |table| own_maps(&context, table, &spec).unwrap();
        let all = ["1", "2", "4", "5", "6"].map(first);
        for (n, (mazes, place)) in all.iter().enumerate() {
            for (others, other) in &all[..n] {
                assert_ne!(place.seed, other.seed);
                for (one, two) in mazes.mazes.iter().zip(&others.mazes) {
                    assert!(!one.is_same_map(two), "{} and {}", place.table, other.table);
                }
            }
        }
    }

    /// With the corners of the paper both sides may cut them; without, neither does.
    #[test]
    fn both_sides_of_a_comparison_have_the_same_corner_rule() {
        for (rule, _) in RULES {
            for table in ["1", "4"] {
                let methods = Methods::new(table, rule);
                let Methods {
                    greedy,
                    back,
                    base,
                    optimum,
                } = &methods;
                for method in [greedy, back, base, optimum] {
                    assert_eq!(method.own_rule(), rule, "{}", method.name);
                }
            }
        }
        let is_papers = |(rule, _): &(CornerRule, &str)| *rule == CornerRule::Allow;
        assert!(RULES.iter().any(is_papers), "the rule of the paper");
    }
}
