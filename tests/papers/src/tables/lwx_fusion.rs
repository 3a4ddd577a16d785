//! [LWX] tables 5 and 6: the whole method, greedy search, potential field over turning points and fit,
//! against an ant colony and a random tree.

use crate::figure::Drawing;
use crate::maps::{MapFamily, Maze};
use crate::rollout::{Rollout, bodies, measured, waypoints};
use crate::solve::{Method, Way};
use crate::stats::{self, median};
use crate::table::{Context, Outcome, TableError, corners, draw, excluded, figure};
use crate::verdict::Printed;
use nalgebra::{Point2, Vector2};
use serde_json::json;
use std::hint::black_box;
use std::time::Instant;
use zeronav_global_planner::CellPath;
use zeronav_local_planner::papers::LawInput;
use zeronav_local_planner::papers::lwx_fusion::LwxFusion;
use zeronav_local_planner::papers::options::LwxFusionConfig;
use zeronav_local_planner::papers::potential::Gains;
use zeronav_local_planner::papers::walk::{End, Trace, Walk};

/// Printed changes of time: against the ant colony, against the random tree.
const PRINTED: [(&str, &str, &str, f64); 2] = [
    ("5", "ant colony", "lwx_aco", -0.652),
    ("6", "random tree", "lwx_rrt", -0.8364),
];

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

/// The plan on a map for a way of the greedy search: the walk, and the fit of it when one is free.
#[must_use]
pub fn plan(maze: &Maze, way: &Way) -> (Rollout, Option<Rollout>) {
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
    let (trace, curve) = fusion().plan(&input);
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
        let (mazes, place) = draw(context, "LWX", table, &spec)?;
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
        let times = times(&other, mazes)?;
        let rows = &mut outcome.rows;
        rows.push(
            place.row(
                figure(
                    "C5",
                    "time",
                    &algorithm,
                    Printed::Change(*printed),
                    (stats::mean(&times), 0.0),
                )
                .noting("whole plans, ratio of medians of 7, interleaved"),
            ),
        );
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

/// Changes of the time of a whole plan, from the other planner to the fusion.
fn times(other: &Method, mazes: &[Maze]) -> Result<Vec<f64>, TableError> {
    const REPETITIONS: usize = 7;
    const MAPS_MAX: usize = 12;
    let greedy = greedy();
    let (mut ours, mut theirs) = (greedy.build()?, other.build()?);
    let mut path = CellPath::default();
    let mut changes = Vec::new();
    for maze in mazes.iter().take(MAPS_MAX) {
        let (mut fusion, mut base) = (Vec::new(), Vec::new());
        let mut solved = true;
        let way = greedy.ways(core::slice::from_ref(maze))?.remove(0);
        let Ok(way) = way else { continue };
        for _ in 0..REPETITIONS {
            let started = Instant::now();
            solved &= black_box(greedy.solve(ours.as_mut(), maze, &mut path)).is_ok();
            black_box(plan(maze, &way));
            fusion.push(started.elapsed().as_secs_f64());
            let started = Instant::now();
            solved &= black_box(other.solve(theirs.as_mut(), maze, &mut path)).is_ok();
            base.push(started.elapsed().as_secs_f64());
        }
        if let (Some(ours), Some(base), true) = (median(fusion), median(base), solved) {
            changes.push(ours / base - 1.0);
        }
    }
    Ok(changes)
}
