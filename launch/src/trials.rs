//! `zeronav run SCENARIO --trials N`: three rounds of trials, and the floor between them.

use crate::ending::Ending;
use crate::floor::{self, Load};
use crate::measure::{Latency, reactions};
use crate::prepare::Prepared;
use crate::run::{DEADLINE_NS, Driven, Quota, drive};
use serde::Serialize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Rounds, each with a stack of its own.
const ROUNDS: usize = 3;

/// One round.
#[derive(Debug, Clone, Serialize)]
pub struct Round {
    /// Trials that counted.
    pub trials: usize,
    /// Drops that did not count because no path led through the obstacle.
    pub missed: u64,
    /// Run time. [s]
    pub time_s: f64,
    /// What the stages of the floor passed on.
    pub floor_load: Option<Load>,
    /// Its figures.
    pub latency: Latency,
}

/// All rounds.
#[derive(Debug)]
pub struct Trials {
    /// Trials that were asked for.
    pub wanted: usize,
    /// Each round.
    pub rounds: Vec<Round>,
    /// The drives of the rounds, in order.
    pub drives: Vec<Driven>,
    /// All rounds together.
    pub latency: Latency,
}

/// Makes `wanted` trials in three rounds. A round that ends early ends the trials.
///
/// # Errors
/// One line when a stack could not be started at all.
pub fn make(
    prepared: &Prepared,
    wanted: u32,
    interrupted: &Arc<AtomicBool>,
) -> Result<Trials, String> {
    let wanted = wanted as usize;
    let mut rounds = Vec::new();
    let mut drives = Vec::new();
    let mut before = 0;
    for round in 0..ROUNDS {
        let n = wanted / ROUNDS + usize::from(round < wanted % ROUNDS);
        if n == 0 {
            continue;
        }
        let quota = Quota {
            n,
            seed: prepared.seed.wrapping_add(round as u64),
            before,
            total: wanted,
        };
        let mut driven = drive(prepared, Some(quota), interrupted)?;
        before += driven.trials.len();
        let reaction = reactions(&driven.collector.records, DEADLINE_NS).figures();
        let mut latency = Latency::of(&driven.trials, reaction, DEADLINE_NS);
        latency.not_in_the_way = driven.trials_missed;
        let load = (driven.ending == Ending::TrialsOver).then(|| load(prepared, &driven));
        if let Some(load) = load {
            latency.transport_floor = Some(floor::measure(
                prepared,
                load,
                2 * driven.trials.len() as u64,
                interrupted,
            )?);
        }
        // Ctrl-C may also have come while the floor was measured.
        if interrupted.load(Ordering::Relaxed) {
            driven.ending = Ending::Interrupted;
        }
        let over = driven.ending == Ending::TrialsOver;
        rounds.push(Round {
            trials: driven.trials.len(),
            missed: driven.trials_missed,
            time_s: crate::measure::seconds(driven.end_run_ns.saturating_sub(driven.goals_run_ns)),
            floor_load: load,
            latency,
        });
        drives.push(driven);
        if !over {
            break;
        }
    }
    let of_each: Vec<Latency> = rounds.iter().map(|round| round.latency.clone()).collect();
    // One round alone has its own ratio, too.
    for (round, own) in rounds.iter_mut().zip(&of_each) {
        round.latency.replanning_to_floor =
            Latency::of_rounds(std::slice::from_ref(own)).replanning_to_floor;
    }
    Ok(Trials {
        wanted,
        rounds,
        drives,
        latency: Latency::of_rounds(&of_each),
    })
}

/// What the stages of this drive passed on in the middle.
fn load(prepared: &Prepared, driven: &Driven) -> Load {
    let (updates, tiles) = driven.collector.updates;
    let paths = &driven.collector.records.paths;
    let waypoints: usize = paths.iter().map(|path| path.points_m.len()).sum();
    let mean = |sum: usize, n: usize| u32::try_from(sum.div_ceil(n.max(1)).max(1)).unwrap_or(1);
    Load {
        beams: prepared.scenario.robot.lidar.n_beams,
        tiles: mean(
            usize::try_from(tiles).unwrap_or(usize::MAX),
            usize::try_from(updates).unwrap_or(usize::MAX),
        ),
        waypoints: mean(waypoints, paths.len()),
        period_ns: prepared.scan_period_ns(),
    }
}
