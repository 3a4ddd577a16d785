//! What a report shows of the times of a run beside its figures: histograms, how long each service
//! computed, and the slowest answers hop by hop.

use super::distribution::{Distribution, to_us};
use super::event::{Event, EventOutcome};
use super::index::Records;
use super::joins::Joins;
use super::reaction::{Reaction, reactions_of};
use crate::result::latency::Figures;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use zeronav_casts::Cast;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::time::seconds;
use zeronav_observe::hop_chain::{ALL, HOPS};

/// Slowest answers that are kept, of reactions and of replannings each.
const SLOWEST: usize = 10;

/// Bins of a histogram from one power of ten to the next.
pub const BINS_PER_DECADE: f64 = 12.0;

/// Places in [`HOPS`] of the hops of a reaction.
const REACTION: [usize; 5] = [1, 6, 7, 8, 9];

/// Times of one kind.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Spread {
    /// Percentiles.
    pub figures: Figures,
    /// Interval of the median at 95 %; null where there are too few samples. [us]
    #[serde(default)]
    pub p50_interval_us: Option<[f64; 2]>,
    /// The same of the 99th percentile. [us]
    #[serde(default)]
    pub p99_interval_us: Option<[f64; 2]>,
    /// Bin and samples in it: bin k holds the times from 10^(k / 12) us to 10^((k + 1) / 12) us.
    pub bins: Vec<(i32, u64)>,
}

/// A slow answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Slow {
    /// Run time of its scan. [s]
    pub time_s: f64,
    /// Round of the trials it belongs to, from 1; null without trials.
    pub round: Option<usize>,
    /// From the capture of the scan to the command. [us]
    pub total_us: f64,
    /// Its hops in order: name and length. [us]
    pub hops: Vec<(String, f64)>,
    /// The stages of the processes that worked on it, in order.
    #[serde(default)]
    pub stages: Vec<SlowStage>,
}

/// A stage of the work on a slow answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SlowStage {
    /// Hop that it is a part of.
    pub hop: String,
    /// Its name.
    pub name: String,
    /// When it began, since the capture of the scan; below 0 before it. [us]
    pub from_us: f64,
    /// How long it took. [us]
    pub time_us: f64,
}

/// The times of a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Timings {
    /// Of reactions; null in lockstep, which has no latencies.
    pub reaction: Option<Spread>,
    /// Of replannings; null in lockstep.
    pub replanning: Option<Spread>,
    /// From the inputs taken in to the main message sent, of every answer by seat.
    pub computing: Vec<(String, Spread)>,
    /// The slowest reactions, slowest first.
    pub slowest_reactions: Vec<Slow>,
    /// The slowest replannings, slowest first.
    pub slowest_replannings: Vec<Slow>,
}

/// Times while they are gathered.
#[derive(Debug, Default)]
struct Gathered {
    distribution: Distribution,
    bins: BTreeMap<i32, u64>,
}

impl Gathered {
    fn add(&mut self, time_ns: u64) {
        self.distribution.add(time_ns);
        self.count(time_ns);
    }

    fn censor(&mut self, deadline_ns: u64) {
        self.distribution.censor(deadline_ns);
        self.count(deadline_ns);
    }

    fn count(&mut self, time_ns: u64) {
        let us = time_ns.max(1).to_f64() / 1.0e3;
        let bin = (us.log10() * BINS_PER_DECADE).floor().to_i32();
        *self.bins.entry(bin).or_default() += 1;
    }

    fn spread(&self) -> Spread {
        Spread {
            figures: self.distribution.figures(),
            p50_interval_us: self.distribution.interval_us(0.5),
            p99_interval_us: self.distribution.interval_us(0.99),
            bins: self.bins.iter().map(|(bin, n)| (*bin, *n)).collect(),
        }
    }
}

/// One drive.
#[derive(Debug, Clone, Copy)]
pub struct Drive<'a> {
    /// What was recorded of it.
    pub records: &'a Records,
    /// What became of its obstacles.
    pub events: &'a [Event],
    /// Round of the trials, from 1.
    pub round: Option<usize>,
    /// Run time of a tick. [ns]
    pub tick_ns: u64,
    /// Run time at which the clock of the report begins. [ns]
    pub from_ns: u64,
}

/// Gathers the times of drives.
#[derive(Debug, Default)]
pub struct Gathering {
    reaction: Gathered,
    replanning: Gathered,
    computing: BTreeMap<Role, Gathered>,
    slowest_reactions: Vec<Slow>,
    slowest_replannings: Vec<Slow>,
}

impl Gathering {
    /// How long the services computed, which does not depend on the clock of the run.
    pub fn compute(&mut self, records: &Records) {
        for span in &records.spans {
            let Some(role) = span.role() else {
                continue;
            };
            if span.kind() == Some(SpanKind::Answer) && span.tick > 0 && span.output != 0 {
                let time_ns = span.published_ns.saturating_sub(span.started_ns);
                self.computing.entry(role).or_default().add(time_ns);
            }
        }
    }

    /// The latencies of a drive in real time.
    pub fn latencies(&mut self, drive: Drive<'_>, deadline_ns: u64) {
        let time_s = |tick: u64| seconds((tick * drive.tick_ns).saturating_sub(drive.from_ns));
        let joins = Joins::of(drive.records);
        for reaction in reactions_of(&joins, drive.records, deadline_ns) {
            let Reaction {
                scan,
                answer,
                times,
            } = reaction;
            let Some((request, command)) = answer else {
                self.reaction.censor(deadline_ns);
                continue;
            };
            let boundaries_ns = [
                scan.capture_ns,
                scan.published_ns,
                request.started_ns,
                request.published_ns,
                command.started_ns,
                command.published_ns,
            ];
            self.reaction.add(times.time_ns.unwrap_or(0));
            let time_s = time_s(scan.tick);
            let slow = || slow(drive, time_s, &REACTION, &boundaries_ns);
            keep(
                &mut self.slowest_reactions,
                boundaries_ns[5].saturating_sub(boundaries_ns[0]),
                slow,
            );
        }
        for event in drive.events {
            match event.outcome {
                EventOutcome::NotInTheWay => continue,
                EventOutcome::Censored => {
                    self.replanning.censor(deadline_ns);
                    continue;
                }
                EventOutcome::Answered | EventOutcome::Early => {}
            }
            let Some(time_ns) = event.replanning_ns else {
                continue;
            };
            self.replanning.add(time_ns);
            // The last boundary is at the wheels, behind the command.
            if let Some([boundaries_ns @ .., _]) =
                event.way.as_ref().map(|way| &way.boundaries_ns[..])
            {
                let captured = |scan: &&Span| Some(&scan.capture_ns) == boundaries_ns.first();
                let tick = joins.scans().find(captured).map_or(0, |scan| scan.tick);
                let slow = || slow(drive, time_s(tick), &ALL, boundaries_ns);
                keep(&mut self.slowest_replannings, time_ns, slow);
            }
        }
    }

    /// What was gathered.
    #[must_use]
    pub fn timings(self, lockstep: bool) -> Timings {
        let spread = |of: &Gathered| (!lockstep).then(|| of.spread());
        let seats = Role::SERVICES.into_iter();
        Timings {
            reaction: spread(&self.reaction),
            replanning: spread(&self.replanning),
            computing: seats
                .filter_map(|role| Some((role.to_string(), self.computing.get(&role)?.spread())))
                .collect(),
            slowest_reactions: self.slowest_reactions,
            slowest_replannings: self.slowest_replannings,
        }
    }
}

/// Keeps an answer when it is among the slowest.
fn keep(slowest: &mut Vec<Slow>, total_ns: u64, slow: impl FnOnce() -> Slow) {
    let total_us = to_us(total_ns);
    let at = slowest.partition_point(|slow| slow.total_us >= total_us);
    if at < SLOWEST {
        slowest.insert(at, slow());
        slowest.truncate(SLOWEST);
    }
}

fn slow(drive: Drive<'_>, time_s: f64, places: &[usize], boundaries_ns: &[u64]) -> Slow {
    let captured_ns = boundaries_ns.first().copied().unwrap_or(0);
    let since_us = |at_ns: u64| to_us(at_ns.saturating_sub(captured_ns));
    let (mut hops, mut stages) = (Vec::new(), Vec::new());
    for (place, pair) in places.iter().zip(boundaries_ns.windows(2)) {
        let hop = HOPS[*place];
        hops.push((hop.to_owned(), to_us(pair[1].saturating_sub(pair[0]))));
        let worked = |span: &&Span| {
            let is_its = span.role().is_some_and(|role| role.label() == hop);
            is_its && span.output != 0 && span.published_ns == pair[1]
        };
        let span = drive.records.spans.iter().find(worked);
        let told = span.into_iter().flat_map(Span::stages);
        stages.extend(told.map(|(stage, from_ns, to_ns)| SlowStage {
            hop: hop.to_owned(),
            name: stage.label().to_owned(),
            // The robot moves before it captures.
            from_us: since_us(from_ns) - to_us(captured_ns.saturating_sub(from_ns)),
            time_us: to_us(to_ns - from_ns),
        }));
    }
    Slow {
        time_s,
        round: drive.round,
        total_us: boundaries_ns.last().map_or(0.0, |last| since_us(*last)),
        hops,
        stages,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(records: &Records) -> Drive<'_> {
        Drive {
            records,
            events: &[],
            round: None,
            tick_ns: 20_000_000,
            from_ns: 0,
        }
    }

    #[test]
    fn stages_of_a_slow_answer_lie_inside_their_hop() {
        let answer = |role: Role, started_ns, published_ns, stages_ns| Span {
            role: role.code(),
            kind: SpanKind::Answer.code(),
            epoch: 1,
            output: 7,
            started_ns,
            published_ns,
            stages_ns,
            ..Span::default()
        };
        let records = Records {
            spans: vec![
                answer(Role::LocalPlanner, 200, 300, [9, 9, 9, 9]),
                answer(Role::Robot, 500, 4_000, [700, 2_000, 0, 0]),
                answer(Role::LocalPlanner, 5_000, 9_000, [0, 500, 3_000, 0]),
                answer(Role::CollisionGuard, 9_500, 9_900, [0; 4]),
            ],
            ..Records::default()
        };
        let boundaries_ns = [1_000, 4_000, 5_000, 9_000, 9_500, 9_900];
        let slow = slow(drive(&records), 1.5, &REACTION, &boundaries_ns);
        let told: Vec<_> = slow
            .stages
            .iter()
            .map(|stage| (&*stage.hop, &*stage.name, stage.from_us, stage.time_us))
            .collect();
        assert_eq!(
            told,
            [
                ("robot", "step", -0.5, 0.7),
                ("robot", "ray casting", 0.2, 2.0),
                ("local_planner", "look", 4.0, 0.5),
                ("local_planner", "rollouts", 4.5, 3.0),
            ]
        );
    }

    #[test]
    fn the_slowest_are_kept_in_order() {
        let records = Records::default();
        let mut slowest = Vec::new();
        for at in 0..100_u64 {
            // 0, 37, 74, 11, ... in no order.
            let total_ns = (at * 37 % 100) * 1000;
            keep(&mut slowest, total_ns, || {
                slow(drive(&records), 0.0, &REACTION, &[0, 0, 0, 0, 0, total_ns])
            });
        }
        let totals: Vec<f64> = slowest.iter().map(|slow| slow.total_us).collect();
        assert_eq!(
            totals,
            [99.0, 98.0, 97.0, 96.0, 95.0, 94.0, 93.0, 92.0, 91.0, 90.0]
        );
        assert_eq!(slowest[0].hops[4], ("collision_guard".to_owned(), 99.0));
        assert_eq!(slowest[0].hops.len(), 5);
    }

    #[test]
    fn a_time_lies_between_the_edges_of_its_bin() {
        let mut gathered = Gathered::default();
        for time_ns in [1_000, 1_500, 999_999, 5_000_000_000] {
            gathered.add(time_ns);
        }
        let spread = gathered.spread();
        assert_eq!(spread.figures.n, 4);
        assert_eq!(spread.bins.iter().map(|(_, n)| n).sum::<u64>(), 4);
        let edge = |bin: i32| 10f64.powf(f64::from(bin) / BINS_PER_DECADE);
        for (bin, us) in spread.bins.iter().zip([1.0, 1.5, 999.999, 5.0e6]) {
            assert!(
                (edge(bin.0)..edge(bin.0 + 1)).contains(&us),
                "{bin:?}: {us}"
            );
        }
    }
}
