//! What a run or a round of trials tells beside its percentiles; see [`Profile`].

use super::bootstrap;
use super::command_gaps::{self, command_gaps};
use super::distribution::to_us;
use super::edges::{self, edges};
use super::event::{Event, EventOutcome};
use super::index::Records;
use super::latency::Ways;
use super::reaction::Reactions;
use super::series::Series;
use crate::result::latency::Figures;
use crate::result::profile::{CommandGaps, Edge, Profile, ProfileRow};
use std::collections::BTreeMap;
use zeronav_casts::Cast;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_observe::hop_chain::{ALL, DIRECT, HOPS, THROUGH_MAP};
use zeronav_observe::statistics::percentile;

/// Consecutive scans that are resampled together: what disturbs one often disturbs the next.
const SCANS_PER_BLOCK: usize = 10;

/// Trials, and turns of the empty ring, are resampled one by one.
const ALONE: usize = 1;

/// What should come how often, and what is too late.
#[derive(Debug, Clone, Copy)]
#[allow(clippy::struct_field_names, reason = "every time has its unit")]
pub struct Timing {
    /// From scan to scan. [ns]
    pub scan_period_ns: u64,
    /// From command to command. [ns]
    pub command_period_ns: u64,
    /// Time after which a sample counts as unanswered. [ns]
    pub deadline_ns: u64,
}

/// What one round tells.
#[derive(Debug, Clone)]
pub struct RoundProfile {
    rows: Vec<Row>,
    edges: Vec<Edge>,
    commands: CommandGaps,
    answers: BTreeMap<String, u64>,
    deadline_ns: u64,
}

/// One latency of a round.
#[derive(Debug, Clone)]
struct Row {
    name: String,
    series: Series,
    block: usize,
}

/// Names of all rows, in their order.
pub fn names() -> impl Iterator<Item = String> {
    let own = ["replanning", "event_to_motion"].map(str::to_owned);
    let reactions = REACTIONS.map(str::to_owned);
    let hops = HOPS.map(str::to_owned);
    let direct = DIRECT.map(|place| format!("direct.{}", HOPS[place]));
    let through_map = THROUGH_MAP.map(|place| format!("through_map.{}", HOPS[place]));
    reactions
        .into_iter()
        .chain(own)
        .chain(hops)
        .chain([FLOOR.to_owned()])
        .chain(direct)
        .chain(through_map)
}

/// Reactions: of all scans, of those that an author read, of those that were due.
pub const REACTIONS: [&str; 3] = ["reaction", "reaction_answered", "reaction_intended"];

/// The empty ring.
pub const FLOOR: &str = "transport_floor";

impl RoundProfile {
    /// Of the records of a run or a round, and of its events.
    pub fn of(events: &[Event], records: &Records, floor: Option<&Series>, timing: Timing) -> Self {
        let mut rows = Vec::new();
        let mut row = |name: String, series: Series, block| {
            rows.push(Row {
                name,
                series,
                block,
            });
        };
        let reactions = Reactions::of(records, timing.deadline_ns, timing.scan_period_ns);
        let reactions = [reactions.all, reactions.answered, reactions.intended];
        for (name, series) in REACTIONS.iter().zip(reactions) {
            row((*name).to_owned(), series, SCANS_PER_BLOCK);
        }
        let timed = |time_ns: fn(&Event) -> Option<u64>| -> Series {
            let counts = events.iter().filter(|event| match event.outcome {
                EventOutcome::NotInTheWay => false,
                EventOutcome::Censored => true,
                EventOutcome::Answered | EventOutcome::Early => time_ns(event).is_some(),
            });
            counts.map(time_ns).collect()
        };
        let replanning = timed(|event| event.replanning_ns);
        row("replanning".to_owned(), replanning, ALONE);
        let event_to_motion = timed(|event| event.event_to_motion_ns);
        row("event_to_motion".to_owned(), event_to_motion, ALONE);
        let hops_ns: Vec<_> = events.iter().filter_map(Event::hops_ns).collect();
        for place in ALL {
            let series = hops_ns.iter().map(|hops_ns| Some(hops_ns[place]));
            row(HOPS[place].to_owned(), series.collect(), ALONE);
        }
        row(FLOOR.to_owned(), floor.cloned().unwrap_or_default(), ALONE);
        let ways = Ways::follow(records);
        for place in DIRECT {
            let series = ways.direct[place].clone();
            row(format!("direct.{}", HOPS[place]), series, SCANS_PER_BLOCK);
        }
        for place in THROUGH_MAP {
            let series = ways.through_map[place].clone();
            row(
                format!("through_map.{}", HOPS[place]),
                series,
                SCANS_PER_BLOCK,
            );
        }
        Self {
            rows,
            edges: edges(records),
            commands: command_gaps(records, timing.command_period_ns, timing.deadline_ns),
            answers: answers(records),
            deadline_ns: timing.deadline_ns,
        }
    }

    /// The times of a row; unanswered ones at the deadline. [ns]
    pub fn times_ns(&self, name: &str) -> Vec<u64> {
        let row = self.rows.iter().find(|row| row.name == name);
        row.map_or_else(Vec::new, |row| row.series.times_ns(self.deadline_ns))
    }
}

/// Answers of each service.
fn answers(records: &Records) -> BTreeMap<String, u64> {
    let mut answers: BTreeMap<String, u64> = BTreeMap::new();
    for span in &records.spans {
        let is_answer = matches!(span.kind(), Some(SpanKind::Answer | SpanKind::Extra));
        if let Some(role) = span.role().filter(|_| is_answer) {
            *answers.entry(Role::label(role).to_owned()).or_default() += 1;
        }
    }
    answers
}

impl Profile {
    /// Several rounds as one.
    #[must_use]
    pub fn of_rounds(rounds: &[RoundProfile], rate_hz: f64, load: &str) -> Self {
        let first = rounds.first().map_or(&[][..], |round| &round.rows);
        let deadline_ns = rounds.first().map_or(0, |round| round.deadline_ns);
        let rows = first.iter().enumerate().map(|(at, row)| {
            let of_each = rounds.iter().filter_map(|round| round.rows.get(at));
            let of_each: Vec<&Series> = of_each.map(|row| &row.series).collect();
            profile_row(&row.name, &of_each, row.block, deadline_ns)
        });
        let mut answers: BTreeMap<String, u64> = BTreeMap::new();
        for (role, n) in rounds.iter().flat_map(|round| &round.answers) {
            *answers.entry(role.clone()).or_default() += n;
        }
        Self {
            rate_hz,
            load: load.to_owned(),
            rows: rows.collect(),
            edges: edges::of_rounds(rounds.iter().map(|round| &round.edges[..])),
            commands: command_gaps::of_rounds(rounds.iter().map(|round| &round.commands)),
            answers,
        }
    }
}

fn profile_row(name: &str, rounds: &[&Series], block: usize, deadline_ns: u64) -> ProfileRow {
    let rounds = || rounds.iter().filter(|round| !round.is_empty());
    let figures: Vec<Figures> = rounds().map(|round| round.figures(deadline_ns)).collect();
    let figures = Figures::of_rounds(&figures).supported();
    let times_ns: Vec<Vec<u64>> = rounds().map(|round| round.times_ns(deadline_ns)).collect();
    let intervals = bootstrap::intervals(&times_ns, block);
    let interval = |at: usize, value_us: Option<f64>| {
        let [low, high] = intervals?[at];
        let value_us = value_us?;
        // The figures are exact to a thousandth only.
        Some([us(low).min(value_us), us(high).max(value_us)])
    };
    let mut pooled = times_ns.concat();
    let is_told = pooled.len() >= ProfileRow::P999_N_MIN;
    let p999_ns = percentile(&mut pooled, 0.999).filter(|_| is_told);
    ProfileRow {
        name: name.to_owned(),
        p50_interval_us: interval(0, figures.p50_us),
        p90_interval_us: interval(1, figures.p90_us),
        p99_interval_us: interval(2, figures.p99_us),
        p999_us: p999_ns.map(to_us),
        figures,
    }
}

fn us(time_ns: f64) -> f64 {
    to_us(time_ns.round().to_u64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_999th_of_a_thousand_is_that_of_all_rounds_together() {
        let round = |times_us: core::ops::Range<u64>| -> Series {
            times_us.map(|time_us| Some(1000 * time_us)).collect()
        };
        let (one, other, unanswered) = (
            round(1..500),
            round(500..1000),
            [None].into_iter().collect(),
        );
        let row = profile_row(
            "replanning",
            &[&one, &other, &unanswered],
            ALONE,
            5_000_000_000,
        );
        assert_eq!(row.figures.n, 1000);
        assert_eq!(
            row.p999_us,
            Some(999.0),
            "the unanswered one ranks as worst"
        );
        let few = profile_row("replanning", &[&one, &other], ALONE, 5_000_000_000);
        assert_eq!(few.p999_us, None);
    }
}
