//! Times of planners beside each other. Only their ratios mean anything, and only between code of the
//! same making.

use crate::maps::Maze;
use crate::solve::{Fault, Method};
use crate::table::excluded;
use std::hint::black_box;
use std::time::Instant;
use zeronav_global_planner::CellPath;
use zeronav_observe::statistics::median;

/// Repetitions on a map.
const REPETITIONS: usize = 31;

/// Most maps that are timed.
const MAPS_MAX: usize = 40;

/// Relative changes of time from `base` to each of `methods` on the maps that are timed, by the medians of
/// 31 interleaved repetitions, each with the share of those maps that is left out because one of the two
/// does not solve them.
///
/// # Errors
/// [`Fault`].
pub fn changes(
    base: &Method,
    methods: &[&Method],
    mazes: &[Maze],
) -> Result<Vec<(Vec<f64>, f64)>, Fault> {
    let all: Vec<&Method> = core::iter::once(base)
        .chain(methods.iter().copied())
        .collect();
    let mut planners = Vec::new();
    for method in &all {
        planners.push(method.build()?);
    }
    let mut changes = vec![Vec::new(); methods.len()];
    let mut path = CellPath::default();
    let timed = &mazes[..mazes.len().min(MAPS_MAX)];
    for maze in timed {
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
    let with_left = |changes: Vec<f64>| {
        let left = excluded(changes.len(), timed.len());
        (changes, left)
    };
    Ok(changes.into_iter().map(with_left).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::MapFamily;
    use crate::table::corners;

    /// Half of such maps and more are closed by full inflation: a time without its share left out would
    /// pass for one of all maps.
    #[test]
    fn a_time_tells_the_share_of_the_maps_that_it_leaves_out() {
        let spec = corners(MapFamily::Blocky, [30, 20], 0.158);
        let mazes = spec.draw(1, 20).unwrap().mazes;
        let (iaa, full) = (
            Method::new("IAA", "bao_iaa"),
            Method::new("full", "bao_full"),
        );
        let unsolved = full.ways(&mazes).unwrap();
        let unsolved = unsolved.iter().filter(|way| way.is_err()).count();
        assert!((1..20).contains(&unsolved), "{unsolved} of 20");
        let (changes, left) = changes(&iaa, &[&full], &mazes).unwrap().remove(0);
        assert_eq!(changes.len(), 20 - unsolved);
        assert!((left - excluded(changes.len(), 20)).abs() < 1e-12, "{left}");
    }
}
