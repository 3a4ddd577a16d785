//! A suite in shards: how much sooner two workers of Ray are done than one, and how long 10,000 runs of the same
//! lengths would take on 1,000 cores.

use super::bench::{Bench, Measured};
use super::extract::{list, table};
use super::record::Row;
use super::spread::Figure;
use crate::python::engines;
use core::cmp::Reverse;
use serde_json::Value;
use std::collections::BinaryHeap;
use std::time::Instant;
use zeronav_casts::Cast;
use zeronav_suite::shard::Shard;

/// Rounds, in each of which one worker and two drive the same.
const ROUNDS: usize = 3;

/// The suite.
const SUITE: [&str; 3] = ["generated", "--worlds", "0..36"];

/// Shards of it.
const SHARDS: &str = "12";

/// The schedule that is estimated: runs and cores.
const RUNS: usize = 10_000;
const CORES: usize = 1000;

/// The example that drives shards by Ray.
const JOB: &str = "launch/examples/shards/ray_suite.py";

/// Medians over the rounds, and the schedule.
pub(super) fn make(bench: &mut Bench) -> Result<Measured, String> {
    let python = engines();
    let mut walls_s = [Vec::new(), Vec::new()];
    let mut ratios = Vec::new();
    let mut runs_s: Vec<f64> = Vec::new();
    for round in 0..ROUNDS {
        let mut round_s = [0.0; 2];
        // Each goes first in turn.
        for turn in 0..2 {
            let at = (round + turn) % 2;
            let workers = ["1", "2"][at];
            let arguments = [
                &["--shards", SHARDS, "--workers", workers, "--"],
                &SUITE[..],
            ]
            .concat();
            let began = Instant::now();
            let text = bench.python(&python, JOB, &arguments)?;
            round_s[at] = began.elapsed().as_secs_f64();
            walls_s[at].push(round_s[at]);
            let merged: Value =
                serde_json::from_str(&text).map_err(|error| format!("{JOB}: {error}"))?;
            if workers == "1" {
                runs_s.extend(list(&merged, "run_wall_s").iter().filter_map(Value::as_f64));
            }
        }
        ratios.push(round_s[0] / round_s[1]);
    }
    if runs_s.is_empty() {
        return Err("no run has a wall time".to_owned());
    }
    let row = |name: &str, walls_s: &[f64], ratio| Row {
        name: name.to_owned(),
        n: walls_s.len() as u64,
        figures: vec![Figure::median(walls_s), ratio],
    };
    let driven = vec![
        row("1 worker", &walls_s[0], Figure::plain(None)),
        row("2 workers", &walls_s[1], Figure::median(&ratios)),
    ];
    let many: Vec<f64> = runs_s.iter().copied().cycle().take(RUNS).collect();
    let total_s: f64 = many.iter().sum();
    let longest_first_s = makespan(&sorted(&many), CORES);
    let as_they_come_s = makespan(&many, CORES);
    let estimated = |name: &str, wall_s: f64| Row {
        name: name.to_owned(),
        n: RUNS as u64,
        figures: vec![
            Figure::plain(Some(wall_s)),
            Figure::plain(Some(total_s / wall_s)),
        ],
    };
    let shards_s = (1..=CORES).map(|index| shard_s(&many, index));
    let by_shards_s = shards_s.fold(0.0, f64::max);
    let schedule = vec![
        estimated("one core", total_s),
        estimated("1,000 cores, one of 1,000 shards each", by_shards_s),
        estimated("1,000 cores, runs as they come", as_they_come_s),
        estimated("1,000 cores, longest run first", longest_first_s),
    ];
    Ok(Measured::tables(vec![
        table(
            "36 runs in 12 shards by Ray",
            &["wall time [s]", "times as fast"],
            driven,
        ),
        table(
            "10,000 runs, estimated",
            &["wall time [s]", "times as fast"],
            schedule,
        ),
    ]))
}

/// Time of all runs of shard `index` of as many as there are cores, one after the other. [s]
fn shard_s(times_s: &[f64], index: usize) -> f64 {
    let shard: Option<Shard> = format!("{index}/{CORES}").parse().ok();
    let runs = times_s.iter().enumerate();
    let own = runs
        .filter(|(run, _)| shard.is_some_and(|shard| shard.has(&format!("world_{run:05}-seed1"))));
    own.map(|(_, time_s)| time_s).sum()
}

fn sorted(times_s: &[f64]) -> Vec<f64> {
    let mut times_s = times_s.to_vec();
    times_s.sort_by(|a, b| b.total_cmp(a));
    times_s
}

/// When all runs are over that are begun in this order, each on the core that is free first. [s]
///
/// Source: Graham, "Bounds on Multiprocessing Timing Anomalies", 1969: with the longest first at most 4/3 of the best.
fn makespan(times_s: &[f64], cores: usize) -> f64 {
    /// [ns]: a heap needs an order.
    const NS: f64 = 1.0e9;
    let mut free: BinaryHeap<Reverse<u64>> = (0..cores.max(1)).map(|_| Reverse(0)).collect();
    let mut over_ns = 0;
    for time_s in times_s {
        let time_ns = (time_s.max(0.0) * NS).to_u64();
        if let Some(Reverse(at_ns)) = free.pop() {
            let end_ns = at_ns.saturating_add(time_ns);
            over_ns = over_ns.max(end_ns);
            free.push(Reverse(end_ns));
        }
    }
    over_ns.to_f64() / NS
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Graham's example: 11 where 9 is the best.
    #[test]
    fn runs_begin_on_the_core_that_is_free_first() {
        let times_s = [5.0, 5.0, 4.0, 4.0, 3.0, 3.0, 3.0];
        assert!((makespan(&times_s, 3) - 11.0).abs() < 1.0e-6);
        assert!((makespan(&times_s, 1) - 27.0).abs() < 1.0e-6);
        assert!((makespan(&times_s, 100) - 5.0).abs() < 1.0e-6);
        // The longest run at the end is waited for.
        assert!((makespan(&[1.0, 1.0, 1.0, 1.0, 4.0], 2) - 6.0).abs() < 1.0e-6);
        assert!((makespan(&sorted(&[1.0, 1.0, 1.0, 1.0, 4.0]), 2) - 4.0).abs() < 1.0e-6);
        assert!(makespan(&[], 2).abs() < 1.0e-12);
    }
}
