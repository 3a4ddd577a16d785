//! [LWX] tables 5 and 6: the whole method, greedy search, potential field over turning points and fit,
//! against an ant colony and a random tree.

use super::lwx::own_maps;
use crate::figure::Drawing;
use crate::maps::{MapFamily, Maze};
use crate::rollout::{Rollout, bodies, measured, roll, waypoints};
use crate::row::{Place, Row};
use crate::solve::{Method, Way, Ways};
use crate::stats;
use crate::table::{Context, Outcome, TableError, corners, count, excluded, figure, time};
use crate::verdict::{Printed, Standing};
use nalgebra::{Point2, Vector2};
use serde_json::json;
use std::hint::black_box;
use std::time::Instant;
use zeronav_global_planner::CellPath;
use zeronav_local_planner::papers::LawInput;
use zeronav_local_planner::papers::ju_apf::JuApf;
use zeronav_local_planner::papers::lwx_fusion::LwxFusion;
use zeronav_local_planner::papers::options::LwxFusionConfig;
use zeronav_local_planner::papers::potential::Gains;
use zeronav_local_planner::papers::walk::{End, Trace, Walk};
use zeronav_observe::statistics::median;

/// Printed changes of time: against the ant colony, against the random tree.
const PRINTED: [(&str, &str, &str, f64); 2] = [
    ("5", "ant colony", "lwx_aco", -0.652),
    ("6", "random tree", "lwx_rrt", -0.8364),
];

/// What the conclusion says of the time of the whole method.
const FUSION_TIME: f64 = -0.40;

/// The method in cells.
fn fusion() -> LwxFusion {
    let config = LwxFusionConfig {
        attract: Gains::LWX.attract,
        repel: Gains::LWX.repel,
        reach_m: Gains::LWX.reach,
        steps_per_m: 10.0,
        ..LwxFusionConfig::default()
    };
    LwxFusion::new(&config, Walk::LWX)
}

/// The plan on a map for a way of the greedy search: the walk, and the fit of it when one is free. This is
/// all that is timed: how near it comes to obstacles is measured by the caller.
fn planned(maze: &Maze, way: &Way) -> (Trace, Option<Vec<Point2<f64>>>) {
    let (around, route) = (bodies(maze), waypoints(maze, way));
    let end = |waypoint: Option<&zeronav_msgs::path::Waypoint>| {
        waypoint.map_or(Point2::origin(), |at| Point2::new(at.x_m, at.y_m))
    };
    let input = LawInput {
        at: end(route.first()),
        velocity: Vector2::zeros(),
        goal: end(route.last()),
        bodies: &around,
        path: &route,
        geometry: 1,
        literal: false,
        steps: 1.0,
        ground: None,
    };
    fusion().plan(&input)
}

/// The same with its distance from obstacles.
#[must_use]
pub fn plan(maze: &Maze, way: &Way) -> (Rollout, Option<Rollout>) {
    let (trace, curve) = planned(maze, way);
    let fit = curve.map(|points| {
        let trace = Trace {
            points,
            end: End::Reached,
            steps: 0,
        };
        measured(maze, trace)
    });
    (measured(maze, trace), fit)
}

fn greedy() -> Method {
    Method::new("greedy", "lwx_oa").with(json!({ "greedy": { "dead_end": "fallback_astar" } }))
}

/// Measures a table.
// long: the rows of one table, one after the other
pub(super) fn run(context: &mut Context, table: &'static str) -> Result<Outcome, TableError> {
    let mut outcome = Outcome::default();
    let Some((_, name, key, printed)) = PRINTED.iter().find(|(of, ..)| *of == table) else {
        return Ok(outcome);
    };
    let other = Method::new(name, key);
    // A colony takes a hundred times as long as what it is compared with.
    let seeds = if *key == "lwx_aco" {
        context.seeds.min(100)
    } else {
        context.seeds
    };
    for family in context.families.clone() {
        let spec = corners(family, [20, 20], 0.2);
        let (mazes, place) = own_maps(context, table, &spec)?;
        let mazes = &mazes.mazes[..usize::try_from(seeds)
            .unwrap_or(usize::MAX)
            .min(mazes.mazes.len())];
        let (ways, others) = (greedy().ways(mazes)?, other.ways(mazes)?);
        let plans: Vec<Option<(Rollout, Option<Rollout>)>> = mazes
            .iter()
            .zip(&ways)
            .map(|(maze, way)| Some(plan(maze, way.as_ref().ok()?)))
            .collect();
        let algorithm = format!("fusion vs {name}");
        let changes = times(&other, mazes)?;
        let rows = &mut outcome.rows;
        let note = "whole plans, ratio of medians of 7, interleaved";
        let printed = Printed::Change(*printed);
        rows.push(place.row(time("C5", &algorithm, printed, changes).noting(note)));
        if table == "6" {
            let astar = Method::new("A*", "lwx_ta");
            let printed = Printed::Change(FUSION_TIME);
            let changes = times(&astar, mazes)?;
            rows.push(
                place.row(
                    time("C8", "fusion vs A*", printed, changes)
                        .standing(Standing::NotComparable)
                        .noting("said in the conclusion, in no table; of what, is not said"),
                ),
            );
            whole(rows, &place, (mazes, &ways), &plans);
        }
        let changes: Vec<f64> = plans
            .iter()
            .zip(&others)
            .zip(mazes)
            .filter_map(|((plan, other), maze)| {
                let (walk, fit) = plan.as_ref()?;
                let ours = fit.as_ref().unwrap_or(walk);
                let length = ours.length(crate::rollout::goal_of(maze));
                walk.arrived()
                    .then_some(length / other.as_ref().ok()?.length - 1.0)
            })
            .collect();
        let left = excluded(changes.len(), mazes.len());
        rows.push(place.row(figure(
            "C5",
            "length",
            &algorithm,
            Printed::Nothing,
            (stats::mean(&changes), left),
        )));
        let made: Vec<&(Rollout, Option<Rollout>)> = plans.iter().flatten().collect();
        for (metric, hits) in [
            (
                "arrives without a collision (share)",
                made.iter().filter(|(walk, _)| walk.is_clean()).count(),
            ),
            (
                "fitted (share)",
                made.iter().filter(|(_, fit)| fit.is_some()).count(),
            ),
            (
                "fit collides (share)",
                made.iter()
                    .filter(|(_, fit)| fit.as_ref().is_some_and(|fit| fit.clearance <= 0.0))
                    .count(),
            ),
        ] {
            let share = (
                stats::share(hits, made.len()),
                excluded(made.len(), mazes.len()),
            );
            rows.push(place.row(figure("C5", metric, "fusion", Printed::Nothing, share)));
        }
        if family == MapFamily::Blocky {
            let drawn: Vec<Rollout> = plans
                .iter()
                .flatten()
                .map(|(walk, fit)| fit.clone().unwrap_or_else(|| walk.clone()))
                .collect();
            let found: Vec<Way> = ways.iter().flatten().cloned().collect();
            outcome.drawing = Drawing::of_rollouts(mazes, &found, &[("fusion", &drawn)]);
        }
    }
    Ok(outcome)
}

/// What the paper says of the whole method besides its time: fewer inflection points and more distance
/// from obstacles than the path of the search, and no local optimum that holds it.
fn whole(
    rows: &mut Vec<Row>,
    place: &Place,
    (mazes, ways): (&[Maze], &Ways),
    plans: &[Option<(Rollout, Option<Rollout>)>],
) {
    let driven = |plan: &(Rollout, Option<Rollout>)| {
        let (walk, fit) = plan;
        walk.arrived()
            .then(|| fit.clone().unwrap_or_else(|| walk.clone()))
    };
    let pairs: Vec<(Rollout, &Way)> = plans
        .iter()
        .zip(ways)
        .filter_map(|(plan, way)| Some((driven(plan.as_ref()?)?, way.as_ref().ok()?)))
        .collect();
    let left = excluded(pairs.len(), mazes.len());
    let name = "fusion vs its greedy path";
    for (claim, metric, printed, values) in [
        (
            "C9",
            "inflection points",
            Printed::Less,
            pairs
                .iter()
                .map(|(fit, way)| {
                    let (ours, base) = (inflections(&fit.trace.points), way.turns());
                    (1.0 + count(ours)) / (1.0 + count(base)) - 1.0
                })
                .collect::<Vec<f64>>(),
        ),
        (
            "C10",
            "min_clearance",
            Printed::More,
            pairs
                .iter()
                .map(|(fit, way)| fit.clearance / way.clearance - 1.0)
                .collect(),
        ),
    ] {
        let ours = (stats::mean(&values), left);
        rows.push(
            place.row(
                figure(claim, metric, name, printed, ours)
                    .noting("better is claimed, no number is printed"),
            ),
        );
    }
    let alone: Vec<bool> = mazes
        .iter()
        .map(|maze| {
            let mut law = JuApf::new(Gains::LWX);
            roll(&mut law, maze, &bodies(maze), &[], &Walk::LWX).arrived()
        })
        .collect();
    let arrived = plans.iter().flatten().filter(|(walk, _)| walk.arrived());
    let whole = arrived.count();
    let hits = alone.iter().filter(|arrived| **arrived).count();
    for (name, hits, printed) in [
        ("fusion", whole, Printed::Always),
        ("the field alone", hits, Printed::Nothing),
    ] {
        let ours = (stats::share(hits, mazes.len()), 0.0);
        rows.push(place.row(figure("C11", "arrives (share)", name, printed, ours)));
    }
}

/// Changes of the side to which a curve turns; turns of less than a thousandth do not count.
fn inflections(points: &[Point2<f64>]) -> u64 {
    let turns = points.windows(3).filter_map(|w| {
        let (before, after) = (w[1] - w[0], w[2] - w[1]);
        let turn = before.perp(&after).atan2(before.dot(&after));
        (turn.abs() > 1.0e-3).then_some(turn > 0.0)
    });
    let sides: Vec<bool> = turns.collect();
    sides.windows(2).filter(|pair| pair[0] != pair[1]).count() as u64
}

/// Changes of the time of a whole plan, from the other planner to the fusion, on the maps that are timed,
/// and the share left out because one of the two has no plan there.
fn times(other: &Method, mazes: &[Maze]) -> Result<(Vec<f64>, f64), TableError> {
    const REPETITIONS: usize = 7;
    const MAPS_MAX: usize = 20;
    let greedy = greedy();
    let (mut ours, mut theirs) = (greedy.build()?, other.build()?);
    let mut path = CellPath::default();
    let mut changes = Vec::new();
    let timed = &mazes[..mazes.len().min(MAPS_MAX)];
    for maze in timed {
        let (mut fusion, mut base) = (Vec::new(), Vec::new());
        let mut solved = true;
        let way = greedy.ways(core::slice::from_ref(maze))?.remove(0);
        let Ok(way) = way else { continue };
        for _ in 0..REPETITIONS {
            let started = Instant::now();
            solved &= black_box(greedy.solve(ours.as_mut(), maze, &mut path)).is_ok();
            // A walk that is caught somewhere is no plan, and ends early or late.
            solved &= black_box(planned(maze, &way)).0.end == End::Reached;
            fusion.push(started.elapsed().as_secs_f64());
            let started = Instant::now();
            solved &= black_box(other.solve(theirs.as_mut(), maze, &mut path)).is_ok();
            base.push(started.elapsed().as_secs_f64());
        }
        if let (Some(ours), Some(base), true) = (median(fusion), median(base), solved) {
            changes.push(ours / base - 1.0);
        }
    }
    let left = excluded(changes.len(), timed.len());
    Ok((changes, left))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On every tenth map the walk is caught somewhere: what that took is no time of a plan.
    #[test]
    fn a_plan_that_does_not_arrive_has_no_time() {
        let spec = corners(MapFamily::Blocky, [20, 20], 0.2);
        let mazes = spec.draw(1, 20).unwrap().mazes;
        let ways = greedy().ways(&mazes).unwrap();
        let arrives = |(maze, way): (&Maze, &Result<Way, _>)| {
            let way = way.as_ref().ok()?;
            Some(planned(maze, way).0.end == End::Reached)
        };
        let arrived = mazes.iter().zip(&ways).filter_map(arrives);
        let arrived = arrived.filter(|arrived| *arrived).count();
        assert!((1..20).contains(&arrived), "{arrived} of 20");
        let (changes, left) = times(&Method::new("A*", "lwx_ta"), &mazes).unwrap();
        assert_eq!(changes.len(), arrived);
        assert!((left - excluded(arrived, 20)).abs() < 1.0e-12, "{left}");
    }

    #[test]
    fn inflections_are_changes_of_side() {
        let of = |points: &[(f64, f64)]| {
            let points: Vec<_> = points.iter().map(|&(x, y)| Point2::new(x, y)).collect();
            inflections(&points)
        };
        assert_eq!(of(&[(0., 0.), (1., 0.), (2., 0.)]), 0);
        // All to the left, then to the right and to the left again.
        assert_eq!(of(&[(0., 0.), (1., 0.), (1.5, 0.5), (1.5, 1.5)]), 0);
        assert_eq!(of(&[(0., 0.), (1., 0.), (2., 1.), (3., 1.), (4., 2.)]), 2);
    }
}
