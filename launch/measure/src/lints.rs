//! What a reader of latencies should know before believing them, as sentences.

use crate::result::latency::{Figures, Latency};
use crate::result::profile::Profile;
use crate::result::trials::Disturbance;
use crate::result::{CommandLag, RunResult};
use std::collections::BTreeMap;
use zeronav_casts::Cast;

/// A service that waited for a processor for less is not named. [us]
const QUEUE_US_MIN: f64 = 10_000.0;

/// The same as a share of the time that it ran.
const QUEUE_SHARE_MIN: f64 = 0.1;

/// Wakes per answer from which on a service is said to wake in vain, and how many there have to be.
const WAKES_PER_ANSWER: u64 = 4;
const WAKES_MIN: u64 = 500;

/// Share of the messages of an edge from which on it is named.
const SUPERSEDED_SHARE_MIN: f64 = 0.01;

/// Load per core before the run from which on the machine was not idle.
const LOAD_PER_CORE_MAX: f64 = 0.25;

/// Share of processor time that the host may give to others.
const STEAL_MAX: f64 = 0.01;

/// Run time that may be lost because the machine was busy. [ms]
const SLIPPED_MS_MAX: f64 = 1.0;

/// The sentences about a run; for one in lockstep, what the robot does not say of itself.
#[must_use]
pub fn lints(result: &RunResult) -> Vec<String> {
    let mut lints: Vec<String> = result.command_lag.iter().map(command_lag).collect();
    let (Some(latency), Some(profile)) = (&result.latency, &result.profile) else {
        return lints;
    };
    let disturbances = disturbances(result);
    lints.extend(waited(&disturbances));
    lints.extend(woke_in_vain(&disturbances, &profile.answers));
    lints.extend(superseded(profile));
    lints.extend(lost(latency));
    lints.extend(refused(profile));
    lints.extend(disturbed(result, profile, &disturbances));
    lints
}

/// The delay that the robot's description should say.
#[must_use]
pub fn command_lag(lag: &CommandLag) -> String {
    format!(
        "commands take effect after {:.2} s, the robot's description says {:.2} s: set `actuation_delay_s`",
        lag.seen_s, lag.declared_s
    )
}

/// What disturbed the run, or each round of its trials.
#[must_use]
pub fn disturbances(result: &RunResult) -> Vec<&Disturbance> {
    let rounds = result.trials.iter().flat_map(|trials| &trials.rounds);
    let rounds = rounds.filter_map(|round| round.disturbance.as_ref());
    result.disturbance.iter().chain(rounds).collect()
}

/// Services that could have run and waited for a processor.
fn waited(disturbances: &[&Disturbance]) -> Option<String> {
    let mut times_us: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for service in disturbances.iter().flat_map(|all| &all.services) {
        let (queue_us, processor_us) = times_us.entry(&service.name).or_default();
        *queue_us += service.queue_us;
        *processor_us += service.processor_us;
    }
    let waited: Vec<String> = times_us
        .iter()
        .filter(|(_, (queue_us, processor_us))| {
            *queue_us >= QUEUE_US_MIN && *queue_us >= QUEUE_SHARE_MIN * processor_us
        })
        .map(|(name, (queue_us, processor_us))| {
            format!(
                "{name} {:.0} ms beside {:.0} ms on one",
                queue_us / 1.0e3,
                processor_us / 1.0e3
            )
        })
        .collect();
    let waited = (!waited.is_empty()).then(|| waited.join(", "));
    waited.map(|waited| format!("services waited for a processor: {waited}"))
}

/// Services that woke often and had nothing to answer.
fn woke_in_vain(disturbances: &[&Disturbance], answers: &BTreeMap<String, u64>) -> Vec<String> {
    let mut wakes: BTreeMap<&str, u64> = BTreeMap::new();
    for service in disturbances.iter().flat_map(|all| &all.services) {
        *wakes.entry(&service.name).or_default() += service.voluntary_switches;
    }
    let sentence = |(name, wakes): (&str, u64)| {
        let answers = answers.get(name).copied().unwrap_or(0);
        let in_vain = wakes >= WAKES_MIN && wakes > WAKES_PER_ANSWER * answers;
        in_vain.then(|| {
            format!("{name} went to sleep {wakes} times and gave {answers} answers: most of its wakes found nothing to do")
        })
    };
    wakes.into_iter().filter_map(sentence).collect()
}

/// Edges on which messages were overtaken.
fn superseded(profile: &Profile) -> Vec<String> {
    let edges = profile.edges.iter();
    let named = edges.filter(|edge| {
        edge.superseded.to_f64() > SUPERSEDED_SHARE_MIN * edge.sent.to_f64() && edge.superseded > 0
    });
    named
        .map(|edge| {
            format!(
                "{} of {} messages on {} were superseded before {} answered them",
                edge.superseded, edge.sent, edge.topic, edge.reader
            )
        })
        .collect()
}

/// Records that are missing or contradict each other.
fn lost(latency: &Latency) -> Vec<String> {
    let mut lints = Vec::new();
    if latency.ways_broken > 0 {
        lints.push(format!(
            "{} commands could not be followed back to their scan: records are missing",
            latency.ways_broken
        ));
    }
    let disorder: u64 = latency.hops_out_of_order.values().sum();
    if disorder > 0 {
        lints.push(format!(
            "stamps that lie before their predecessor: {disorder}"
        ));
    }
    let beyond = latency
        .second_clock
        .as_ref()
        .map_or(0, |clock| clock.beyond);
    if beyond > 0 {
        lints.push(format!(
            "commands for which the robot's second clock differs from the hops by more than the rates \
             of the clocks allow: {beyond}"
        ));
    }
    lints
}

/// Percentiles that are not shown because there are too few samples. The hops of an event are as many
/// as the events, and need no word of their own.
fn refused(profile: &Profile) -> Vec<String> {
    let mut by_n: BTreeMap<u64, Vec<&str>> = BTreeMap::new();
    let named = ["reaction", "replanning", "event_to_motion"];
    for row in profile.rows.iter().filter(|row| row.figures.n > 0) {
        if named.contains(&row.name.as_str()) {
            by_n.entry(row.figures.n).or_default().push(&row.name);
        }
    }
    let sentence = |(n, names): (u64, Vec<&str>)| {
        let percentiles = ["p50", "p90", "p99"].iter().zip(Figures::N_MIN);
        let refused = percentiles.filter(|(_, n_min)| n < *n_min);
        let refused: Vec<String> = refused
            .map(|(name, n_min)| format!("{name} takes {n_min}"))
            .collect();
        (!refused.is_empty()).then(|| {
            let samples = match n {
                1 => "1 sample is".to_owned(),
                n => format!("{n} samples are"),
            };
            format!(
                "{}: {samples} too few for every percentile; {}",
                names.join(", "),
                refused.join(", ")
            )
        })
    };
    by_n.into_iter().filter_map(sentence).collect()
}

/// What else went on while it was measured.
fn disturbed(result: &RunResult, profile: &Profile, all: &[&Disturbance]) -> Vec<String> {
    let mut lints = Vec::new();
    let (cores, load) = (result.environment.cores, result.environment.load_start);
    if load > LOAD_PER_CORE_MAX * cores.to_f64() {
        lints.push(format!(
            "the machine was not idle before the run: load {load:.1} on {cores} cores"
        ));
    }
    if profile.load != "idle" {
        lints.push(format!(
            "{cores} processes computed beside the stack on purpose"
        ));
    }
    let steal = all.iter().map(|one| one.steal);
    let steal = steal.fold(result.environment.steal, f64::max);
    if steal > STEAL_MAX {
        lints.push(format!(
            "the host gave {:.1} % of the processors' time to others",
            1.0e2 * steal
        ));
    }
    if result.slipped_ms > SLIPPED_MS_MAX {
        lints.push(format!(
            "run time slipped by {:.1} ms: the robot's own process was late",
            result.slipped_ms
        ));
    }
    if result.environment.build == "debug" {
        lints.push("measured with a debug build".to_owned());
    }
    lints
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::profile::{CommandGaps, Edge, ProfileRow};
    use crate::result::trials::ServiceDisturbance;

    fn result() -> RunResult {
        let text = include_str!("../tests/data/result_trials.json");
        let mut result: RunResult = serde_json::from_str(text).expect("a result");
        result.environment.load_start = 0.0;
        result.environment.steal = 0.0;
        result.environment.build = "release".to_owned();
        result.slipped_ms = 0.0;
        let trials = result.trials.as_mut().expect("trials");
        for round in &mut trials.rounds {
            round.disturbance = None;
        }
        result.profile = Some(Profile {
            rate_hz: 10.0,
            load: "idle".to_owned(),
            rows: vec![row("replanning", 200)],
            edges: vec![edge(0)],
            commands: CommandGaps::default(),
            answers: [("mapping".to_owned(), 1000)].into(),
        });
        result.disturbance = Some(disturbance());
        result
    }

    fn row(name: &str, n: u64) -> ProfileRow {
        ProfileRow {
            name: name.to_owned(),
            figures: Figures {
                n,
                ..Figures::default()
            },
            p50_interval_us: None,
            p90_interval_us: None,
            p99_interval_us: None,
            p999_us: None,
        }
    }

    fn edge(superseded: u64) -> Edge {
        use zeronav_msgs::topics::{RobotScan, Topic};
        Edge {
            topic: RobotScan::ROW.name.to_owned(),
            reader: "mapping".to_owned(),
            sent: 1000,
            superseded,
        }
    }

    #[test]
    fn a_delay_that_is_not_declared_is_told_in_lockstep_too() {
        let mut result = result();
        (result.latency, result.profile) = (None, None);
        assert_eq!(lints(&result), Vec::<String>::new());
        result.command_lag = Some(CommandLag {
            seen_s: 0.28,
            declared_s: 0.0,
        });
        assert_eq!(
            lints(&result),
            [
                "commands take effect after 0.28 s, the robot's description says 0.00 s: set `actuation_delay_s`"
            ]
        );
    }

    fn disturbance() -> Disturbance {
        let mapping = ServiceDisturbance {
            name: "mapping".to_owned(),
            processor_us: 100_000.0,
            queue_us: 5_000.0,
            off_processor_us_max: 0.0,
            voluntary_switches: 1100,
            involuntary_switches: 0,
            minor_faults: 0,
            major_faults: 0,
        };
        Disturbance {
            load_start: 0.0,
            load_end: 0.0,
            steal: 0.0,
            services: vec![mapping],
        }
    }

    /// The one sentence that a change brings.
    fn sentence(change: impl FnOnce(&mut RunResult)) -> String {
        let mut result = result();
        change(&mut result);
        let mut lints = lints(&result);
        assert_eq!(lints.len(), 1, "{lints:?}");
        lints.remove(0)
    }

    fn mapping(result: &mut RunResult) -> &mut ServiceDisturbance {
        let disturbance = result.disturbance.as_mut().expect("a disturbance");
        &mut disturbance.services[0]
    }

    fn profile(result: &mut RunResult) -> &mut Profile {
        result.profile.as_mut().expect("a profile")
    }

    fn latency(result: &mut RunResult) -> &mut Latency {
        result.latency.as_mut().expect("latencies")
    }

    #[test]
    fn a_quiet_run_needs_no_word() {
        assert_eq!(lints(&result()), Vec::<String>::new());
    }

    #[test]
    fn every_disturbance_has_its_sentence() {
        let said = sentence(|result| mapping(result).queue_us = 40_000.0);
        assert!(said.contains("mapping 40 ms beside 100 ms"), "{said}");
        let said = sentence(|result| mapping(result).voluntary_switches = 9000);
        assert!(said.contains("9000 times and gave 1000 answers"), "{said}");
        let said = sentence(|result| profile(result).edges[0].superseded = 30);
        assert!(
            said.starts_with("30 of 1000 messages on robot/scan"),
            "{said}"
        );
        let said = sentence(|result| latency(result).ways_broken = 2);
        assert!(said.starts_with("2 commands"), "{said}");
        let said = sentence(|result| profile(result).rows[0].figures.n = 30);
        assert_eq!(
            said,
            "replanning: 30 samples are too few for every percentile; p99 takes 100"
        );
        let said = sentence(|result| result.environment.load_start = 1.7);
        assert!(said.contains("load 1.7 on"), "{said}");
        let said = sentence(|result| result.environment.steal = 0.05);
        assert!(said.contains("5.0 %"), "{said}");
        let said = sentence(|result| result.slipped_ms = 12.0);
        assert!(said.contains("12.0 ms"), "{said}");
        let said = sentence(|result| profile(result).load = "busy".to_owned());
        assert!(said.contains("on purpose"), "{said}");
        let said = sentence(|result| result.environment.build = "debug".to_owned());
        assert!(said.contains("debug"), "{said}");
    }

    #[test]
    fn a_little_of_each_is_no_disturbance() {
        let mut result = result();
        mapping(&mut result).queue_us = 9_999.0;
        mapping(&mut result).voluntary_switches = 4000;
        profile(&mut result).edges[0].superseded = 10;
        profile(&mut result).rows[0].figures.n = 100;
        result.environment.steal = 0.01;
        result.slipped_ms = 1.0;
        assert_eq!(lints(&result), Vec::<String>::new());
    }
}
