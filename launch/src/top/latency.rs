//! Latencies of the last seconds, from the records of the processes.

use super::view::{HopLine, Replanning};
use std::collections::VecDeque;
use zeronav_measure::joins::Joins;
use zeronav_measure::result::latency::Figures;
use zeronav_measure::{DEADLINE_NS, Records, reactions};
use zeronav_msgs::span::Span;
use zeronav_msgs::time::seconds;
use zeronav_observe::hop_chain::{HopChain, to_us};

/// Time for which records are kept: of a lidar with 10 scans a second more than the 100 that a 99th
/// percentile needs. [ns]
const WINDOW_NS: u64 = 12_000_000_000;

/// Records that are kept at most.
const SPANS_MAX: usize = 20_000;

/// A path around an obstacle whose way to the wheels is not known yet.
#[derive(Debug, Clone, Copy)]
struct NewPath {
    id: u64,
    map: u64,
    run_ns: u64,
}

/// The records of the last seconds, and what they say.
#[derive(Debug, Default)]
pub(super) struct Latency {
    spans: VecDeque<Span>,
    new_path: Option<NewPath>,
    reaction: Figures,
    replanning: Option<Replanning>,
}

impl Latency {
    /// Takes in a record.
    pub(super) fn span(&mut self, span: &Span) {
        if self.spans.len() == SPANS_MAX {
            self.spans.pop_front();
        }
        self.spans.push_back(*span);
    }

    /// A path around an obstacle has come, made with the revision `map`.
    pub(super) fn path(&mut self, id: u64, map: u64, run_ns: u64) {
        self.new_path = Some(NewPath { id, map, run_ns });
    }

    /// Forgets what is too old at `now_ns` and reads the rest.
    pub(super) fn refresh(&mut self, now_ns: u64) {
        let sent_ns = |span: &Span| span.published_ns.max(span.started_ns);
        while let Some(span) = self.spans.front()
            && sent_ns(span).saturating_add(WINDOW_NS) < now_ns
        {
            self.spans.pop_front();
        }
        let records = Records {
            spans: self.spans.iter().copied().collect(),
            ..Records::default()
        };
        self.reaction = reactions(&records, DEADLINE_NS).figures(DEADLINE_NS);
        if let Some(path) = self.new_path
            && let Some(replanning) = follow(&records, path)
        {
            self.replanning = Some(replanning);
            self.new_path = None;
        }
    }

    /// Reaction times of the last seconds.
    pub(super) fn reaction(&self) -> Figures {
        self.reaction
    }

    /// The last path around an obstacle whose way is known.
    pub(super) fn replanning(&self) -> Option<&Replanning> {
        self.replanning.as_ref()
    }
}

/// The way of a path from the capture of its scan to the wheels; `None` while a record is missing.
fn follow(records: &Records, path: NewPath) -> Option<Replanning> {
    let way = HopChain::through_map(Joins::of(records).of_path(path.id, path.map)?);
    let hops = way.named_us().map(|(hop, us)| HopLine { hop, us });
    Some(Replanning {
        time_s: seconds(path.run_ns),
        total_us: to_us(way.sum_ns()),
        hops: hops.collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::header::Id;
    use zeronav_msgs::role::Role;
    use zeronav_msgs::span::SpanKind;
    use zeronav_observe::hop_chain::HOPS;

    const US: u64 = 1000;

    /// The records of one scan, captured at `at_ns`, on its way to the wheels; each stage takes so
    /// long and is reached after 10 us.
    fn way(at_ns: u64, n: u64) -> Vec<Span> {
        let id = Id::new(1, n).0;
        let span = |role: Role, place: u64| Span {
            role: role.code(),
            kind: SpanKind::Answer.code(),
            epoch: 1,
            tick: n,
            scan: id,
            map: id,
            path: id,
            request: id,
            output: id,
            capture_ns: at_ns,
            started_ns: at_ns + place * 100 * US,
            published_ns: at_ns + place * 100 * US + 50 * US,
            ..Span::default()
        };
        let mut spans = vec![
            span(Role::Robot, 0),
            span(Role::Mapping, 1),
            span(Role::GlobalPlanner, 2),
            span(Role::LocalPlanner, 3),
            span(Role::CollisionGuard, 4),
        ];
        spans.push(Span {
            kind: SpanKind::Applied.code(),
            output: 0,
            ..span(Role::Robot, 5)
        });
        spans
    }

    #[test]
    fn a_new_path_is_followed_to_the_wheels_hop_by_hop() {
        let mut latency = Latency::default();
        let id = Id::new(1, 7).0;
        latency.path(id, id, 2_000_000_000);
        latency.refresh(1_000_000);
        assert_eq!(latency.replanning(), None, "its records have not come");
        for span in way(1_000_000, 7) {
            latency.span(&span);
        }
        latency.refresh(10_000_000);
        let replanning = latency.replanning().expect("it is followed");
        assert!((replanning.total_us - 500.0).abs() < 1e-9, "{replanning:?}");
        let names: Vec<&str> = replanning.hops.iter().map(|hop| hop.hop).collect();
        assert_eq!(names, HOPS[1..]);
        assert!(
            replanning
                .hops
                .iter()
                .all(|hop| (hop.us - 50.0).abs() < 1e-9)
        );
    }

    #[test]
    fn reactions_are_those_of_the_last_seconds() {
        let mut latency = Latency::default();
        let s = 1_000_000_000;
        for n in 1..=300 {
            for span in &way(n * s / 10, n) {
                latency.span(span);
            }
        }
        latency.refresh(30 * s);
        let reaction = latency.reaction();
        assert_eq!(reaction.p50_us.map(f64::round), Some(450.0), "{reaction:?}");
        assert!((115..=122).contains(&reaction.n), "{reaction:?}");
        latency.refresh(60 * s);
        assert_eq!(
            latency.reaction(),
            Figures::default(),
            "nothing comes any more"
        );
    }
}
