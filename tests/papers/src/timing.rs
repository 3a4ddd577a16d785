//! Times of planners beside each other. Only their ratios mean anything, and only between code of the
//! same making.

use crate::maps::Maze;
use crate::solve::{Fault, Method};
use crate::stats::median;
use std::hint::black_box;
use std::time::Instant;
use zeronav_global_planner::CellPath;

/// Repetitions on a map.
const REPETITIONS: usize = 31;

/// Most maps that are timed.
const MAPS_MAX: usize = 40;

/// Relative change of time from `base` to each of `methods` on each map, by the medians of 31
/// interleaved repetitions; maps that one of the two does not solve are left out.
///
/// # Errors
/// [`Fault`].
pub fn changes(base: &Method, methods: &[&Method], mazes: &[Maze]) -> Result<Vec<Vec<f64>>, Fault> {
    let all: Vec<&Method> = core::iter::once(base)
        .chain(methods.iter().copied())
        .collect();
    let mut planners = Vec::new();
    for method in &all {
        planners.push(method.build()?);
    }
    let mut changes = vec![Vec::new(); methods.len()];
    let mut path = CellPath::default();
    for maze in mazes.iter().take(MAPS_MAX) {
        let mut times = vec![Vec::with_capacity(REPETITIONS); all.len()];
        let mut solved = vec![true; all.len()];
        for _ in 0..REPETITIONS {
            for (n, method) in all.iter().enumerate() {
                let started = Instant::now();
                let result = black_box(method.solve(planners[n].as_mut(), maze, &mut path));
                times[n].push(started.elapsed().as_secs_f64());
                solved[n] &= result.is_ok();
            }
        }
        let medians: Vec<Option<f64>> = times.into_iter().map(median).collect();
        for (n, changes) in changes.iter_mut().enumerate() {
            if let (Some(base), Some(time), true) =
                (medians[0], medians[n + 1], solved[0] && solved[n + 1])
            {
                changes.push(time / base - 1.0);
            }
        }
    }
    Ok(changes)
}
