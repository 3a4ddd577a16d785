//! The tracker of mapping against the truth, without processes: worlds with moving obstacles are
//! played through the library of the simulator into that of mapping.
//!
//! How to read it: `cases` says which worlds are played and `plan` with which robot, `way` how it
//! moves; `play` is one run, with the truth from `course`; `score` compares scan by scan, by `pairs` and
//! `ellipse`; `tally` is what it came to, and `report` makes tables of that.
//!
//! Mapping's pose drifts. What is true is taken into its map by
//! `map_from_base (estimated) * base_from_map (true)` of every scan before anything is compared, so
//! errors of the tracker and of the pose do not mix.

pub mod cases;
mod course;
mod ellipse;
mod pairs;
mod plan;
mod play;
mod report;
mod score;
mod tally;
mod way;

use cases::Case;
use core::sync::atomic::{AtomicUsize, Ordering};
pub use plan::Plan;
pub use report::tables;
pub use tally::Tally;

/// Plays every case on all processors; what each came to, in the order of the cases. The same cases
/// give the same tallies.
///
/// # Errors
/// One line about the first world that cannot be played.
pub fn play_all(cases: &[Case], plan: &Plan) -> Result<Vec<Tally>, String> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        while let Some((at, case)) = take(&next, cases) {
            done.push((at, play::play(case, plan)));
        }
        done
    };
    let n_workers = std::thread::available_parallelism().map_or(1, usize::from);
    let mut done = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..n_workers).map(|_| scope.spawn(work)).collect();
        let mut done = Vec::new();
        for worker in workers {
            done.extend(worker.join().map_err(|_| "a run has panicked")?);
        }
        Ok::<_, String>(done)
    })?;
    done.sort_by_key(|(at, _)| *at);
    done.into_iter().map(|(_, tally)| tally).collect()
}

/// The next case that nobody plays.
fn take<'a>(next: &AtomicUsize, cases: &'a [Case]) -> Option<(usize, &'a Case)> {
    let at = next.fetch_add(1, Ordering::Relaxed);
    cases.get(at).map(|case| (at, case))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::shipped_data;

    #[test]
    fn a_world_is_played_alike_every_time_and_what_moves_in_it_is_found() {
        let mut cases = cases::dynabarn(&shipped_data("dynabarn"), 1).expect("worlds");
        cases.truncate(2);
        let plan = Plan {
            duration_s: 6.0,
            rate_hz: None,
            exact: false,
        };
        let tallies = play_all(&cases, &plan).expect("runs");
        assert_eq!(tallies, play_all(&cases, &plan).expect("runs"));
        let [stands, drives] = &tallies[..] else {
            panic!("{} tallies", tallies.len());
        };
        assert_ne!(stands, drives);
        for tally in &tallies {
            assert!(tally.sights > 0 && !tally.delays_s.is_empty(), "{tally:?}");
            assert!((tally.run_s - 6.0).abs() < 0.1, "{}", tally.run_s);
        }
    }
}
