//! `zeronav run SCENARIO --trials N`: three rounds of trials, and the floor between them.

use crate::drive::{Driven, drive};
use crate::ending::Ending;
use crate::floor;
use crate::prepare::Prepared;
use crate::run_plan::TRIAL_ROUNDS;
use crate::trial_runner::{Quota, Trial};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use zeronav_casts::Cast;
use zeronav_measure::DEADLINE_NS;
use zeronav_measure::Event;
use zeronav_measure::distribution::to_us;
use zeronav_measure::profile::{RoundProfile, Timing};
use zeronav_measure::result::latency::Latency;
use zeronav_measure::result::profile::Profile;
use zeronav_measure::result::trials::{Load, Round, SlowHop, SlowTrial};
use zeronav_measure::timings::{Drive, Gathering, Timings};
use zeronav_observe::hop_chain::HOPS;

/// Slowest trials that are listed with what disturbed them.
const WORST: usize = 10;

/// Usual wall time of a trial in `blocked_aisle`. [s]
const TRIAL_S: f64 = 1.2;

/// About how long so many trials take, in words: "usually about 4 min".
#[must_use]
pub(crate) fn usual_time(trials: u64) -> String {
    let minutes = trials.to_f64() * TRIAL_S / 60.0;
    format!("usually about {:.0} min", minutes.max(1.0))
}

/// All rounds.
#[derive(Debug)]
pub(crate) struct Trials {
    /// Trials that were asked for.
    pub wanted: usize,
    /// Each round.
    pub rounds: Vec<Round>,
    /// The drives of the rounds, in order.
    pub drives: Vec<Driven>,
    /// All rounds together.
    pub latency: Latency,
    /// How sure that is, and what lies behind it.
    pub profile: Profile,
    /// The slowest trials, slowest first.
    pub worst: Vec<SlowTrial>,
    /// The times of all rounds.
    pub timings: Timings,
}

/// Makes `wanted` trials in three rounds. A round that ends early ends the trials.
///
/// # Errors
/// One line when a stack could not be started at all.
pub(crate) fn make(
    prepared: &Prepared,
    wanted: u32,
    interrupted: &Arc<AtomicBool>,
) -> Result<Trials, String> {
    let wanted = wanted as usize;
    let mut rounds = Vec::new();
    let mut drives = Vec::new();
    let mut worst = Vec::new();
    let mut profiles = Vec::new();
    let mut gathering = Gathering::default();
    let mut before = 0;
    for round in 0..TRIAL_ROUNDS {
        let n = wanted / TRIAL_ROUNDS + usize::from(round < wanted % TRIAL_ROUNDS);
        if n == 0 {
            continue;
        }
        let quota = Quota {
            n,
            seed: prepared.seed.wrapping_add(round as u64),
            before,
            total: wanted,
            round: round + 1,
        };
        let mut driven = drive(prepared, Some(quota), interrupted)?;
        before += driven.trials.len();
        let trials = std::mem::take(&mut driven.trials);
        let events: Vec<Event> = trials.iter().map(|trial| trial.event.clone()).collect();
        let mut latency = Latency::of(&events, &driven.collector.records, DEADLINE_NS);
        gather(&mut gathering, prepared, &driven, &events, round + 1);
        latency.not_in_the_way = driven.trials_missed;
        let load = (driven.ending == Ending::TrialsOver).then(|| load(prepared, &driven));
        let cycles = 2 * trials.len() as u64;
        let floor = load.map(|load| floor::measure(prepared, load, cycles, interrupted));
        let floor = floor.transpose()?;
        latency.transport_floor = floor.as_ref().map(|floor| floor.figures(DEADLINE_NS));
        let records = &driven.collector.records;
        let timing = timing(prepared);
        profiles.push(RoundProfile::of(&events, records, floor.as_ref(), timing));
        // Ctrl-C may also have come while the floor was measured.
        if interrupted.load(Ordering::Relaxed) {
            driven.ending = Ending::Interrupted;
        }
        slow(round + 1, &trials, &latency, &mut worst);
        let over = driven.ending == Ending::TrialsOver;
        rounds.push(Round {
            trials: trials.len(),
            missed: driven.trials_missed,
            time_s: zeronav_msgs::time::seconds(
                driven.end_run_ns.saturating_sub(driven.goals_run_ns),
            ),
            floor_load: load,
            disturbance: driven.disturbance.clone(),
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
        worst,
        timings: gathering.timings(false),
        latency: Latency::of_rounds(&of_each),
        profile: profile(prepared, &profiles),
    })
}

/// Several rounds as one.
pub(crate) fn profile(prepared: &Prepared, rounds: &[RoundProfile]) -> Profile {
    let rate_hz = prepared.scenario.robot.lidar.rate_hz;
    Profile::of_rounds(rounds, rate_hz, prepared.load.label())
}

/// What should come how often in this run.
pub(crate) fn timing(prepared: &Prepared) -> Timing {
    Timing {
        scan_period_ns: prepared.scan_period_ns(),
        command_period_ns: prepared.scenario.run.tick_ns(),
        deadline_ns: DEADLINE_NS,
    }
}

/// Adds the times of a round.
fn gather(
    gathering: &mut Gathering,
    prepared: &Prepared,
    driven: &Driven,
    events: &[Event],
    round: usize,
) {
    let records = &driven.collector.records;
    gathering.compute(records);
    let times = Drive {
        records,
        events,
        round: Some(round),
        tick_ns: prepared.scenario.run.tick_ns(),
        from_ns: driven.goals_run_ns,
    };
    gathering.latencies(times, DEADLINE_NS);
}

/// Adds the trials of a round to the slowest of all, which stay few.
fn slow(round: usize, trials: &[Trial], latency: &Latency, worst: &mut Vec<SlowTrial>) {
    worst.extend(trials.iter().enumerate().map(|(at, trial)| SlowTrial {
        round,
        trial: at + 1,
        replanning_us: trial.event.replanning_ns.map(to_us),
        hop: slow_hop(&trial.event, latency),
        disturbance: trial.disturbance.clone(),
    }));
    // One without an answer is slower than any with one.
    let time_us = |trial: &SlowTrial| trial.replanning_us.unwrap_or(f64::INFINITY);
    worst.sort_by(|a, b| time_us(b).total_cmp(&time_us(a)));
    worst.truncate(WORST);
}

/// The hop of this trial that took longest beyond its median. The last, from the command to the
/// wheels, is no part of replanning.
fn slow_hop(event: &Event, latency: &Latency) -> Option<SlowHop> {
    let hops = HOPS.iter().zip(event.hops_ns()?).zip(&latency.hops);
    let slow = hops.take(HOPS.len() - 1);
    let slow = slow.map(|((name, time_ns), hop)| SlowHop {
        name: (*name).to_owned(),
        time_us: to_us(time_ns),
        p50_us: hop.figures.supported().p50_us,
    });
    let beyond_us = |hop: &SlowHop| hop.time_us - hop.p50_us.unwrap_or(0.0);
    slow.max_by(|a, b| beyond_us(a).total_cmp(&beyond_us(b)))
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

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_measure::result::latency::Hop;
    use zeronav_measure::{EventOutcome, Records};
    use zeronav_observe::hop_chain::{ALL, HopChain};

    #[test]
    fn the_usual_time_is_said_in_whole_minutes() {
        assert_eq!(usual_time(3), "usually about 1 min");
        assert_eq!(usual_time(200), "usually about 4 min");
    }

    fn trial(replanning_us: Option<u64>, hops_us: [u64; HOPS.len()]) -> Trial {
        let mut boundaries_ns = vec![0];
        let mut at_ns = 0;
        for us in hops_us {
            at_ns += us * 1000;
            boundaries_ns.push(at_ns);
        }
        Trial {
            event: Event {
                index: 0,
                outcome: EventOutcome::Answered,
                replanning_ns: replanning_us.map(|us| us * 1000),
                event_to_motion_ns: None,
                way: Some(HopChain {
                    hops: &ALL,
                    boundaries_ns,
                    second_ns: None,
                }),
                way_broken: false,
                revised: 0,
            },
            disturbance: None,
        }
    }

    #[test]
    fn the_slowest_trials_name_the_hop_that_is_farthest_beyond_its_median() {
        let mut latency = Latency::of(&[], &Records::default(), DEADLINE_NS);
        for (at, Hop { figures, .. }) in latency.hops.iter_mut().enumerate() {
            figures.n = 7;
            figures.p50_us = Some(if at == 5 { 1500.0 } else { 100.0 });
        }
        let mut usual = [100; HOPS.len()];
        usual[5] = 1500;
        // The longest hop is the search, but it is a wake that took longer than usual.
        let mut late_wake = usual;
        late_wake[4] = 900;
        // Behind the command, so it explains nothing.
        late_wake[HOPS.len() - 1] = 20_000;
        let mut trials: Vec<Trial> = (0..12).map(|at| trial(Some(2000 + at), usual)).collect();
        trials.push(trial(Some(3000), late_wake));
        trials.push(trial(None, usual));
        let mut worst = Vec::new();
        slow(2, &trials, &latency, &mut worst);
        assert_eq!(worst.len(), WORST);
        let order: Vec<_> = worst
            .iter()
            .map(|slow| (slow.trial, slow.replanning_us))
            .collect();
        let expected = [(14, None), (13, Some(3000.0)), (12, Some(2011.0))];
        assert_eq!(order[..3], expected);
        assert_eq!(order[WORST - 1], (5, Some(2004.0)));
        let hop = SlowHop {
            name: "to_global_planner".to_owned(),
            time_us: 900.0,
            p50_us: Some(100.0),
        };
        assert_eq!(worst[1].hop, Some(hop));
        // Those of a later round take their places.
        slow(3, &[trial(Some(9000), usual)], &latency, &mut worst);
        assert_eq!((worst[1].round, worst[1].trial), (3, 1));
        assert_eq!(worst.len(), WORST);
    }
}
