//! What the tables of the page say of services and latencies. Pure: every moment comes from outside.

use crate::hops::{BINS_US, Hops, Taken};
use serde_json::{Value, json};
use zeronav_casts::Cast;
use zeronav_msgs::header::{Header, Id};
use zeronav_msgs::health::Health;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::time::seconds;
use zeronav_observe::health::{Condition, Heart};
use zeronav_observe::hop_chain::to_us;
use zeronav_observe::usage::{Meter, Reading};

/// For how long a restart stands in the table. [ns]
const RESTARTED_NS: u64 = 2_000_000_000;

/// What is known of one seat.
#[derive(Debug)]
struct Seat {
    role: Role,
    heart: Heart,
    /// Which start of the seat is obeyed.
    epoch: u32,
    restarted_ns: Option<u64>,
    meter: Meter,
    /// Answers since the beginning.
    answers: u64,
    /// Answers at the last look at them, and when that was. [ns]
    before: Option<(u64, u64)>,
    rate_hz: f64,
}

/// What is known of the services and of the ways of scans.
#[derive(Debug)]
pub struct Model {
    seats: Vec<Seat>,
    hops: Hops,
}

impl Default for Model {
    fn default() -> Self {
        let seat = |role| Seat {
            role,
            heart: Heart::default(),
            epoch: 0,
            restarted_ns: None,
            meter: Meter::default(),
            answers: 0,
            before: None,
            rate_hz: 0.0,
        };
        Self {
            seats: Role::SERVICES.map(seat).into(),
            hops: Hops::default(),
        }
    }
}

impl Model {
    fn seat(&mut self, role: Option<Role>) -> Option<&mut Seat> {
        let mut seats = self.seats.iter_mut();
        seats.find(|seat| role == Some(seat.role))
    }

    /// The process of this epoch is obeyed in a seat from `now_ns` on.
    pub fn obeyed(&mut self, role: Role, epoch: u32, now_ns: u64) {
        if let Some(seat) = self.seat(Some(role)).filter(|seat| seat.epoch != epoch) {
            seat.restarted_ns = (seat.epoch != 0).then_some(now_ns);
            seat.epoch = epoch;
        }
    }

    /// A heartbeat of a process that is obeyed.
    pub fn beat(&mut self, header: &Header, beat: &Health) {
        if let Some(seat) = self.seat(header.role()) {
            seat.heart = Heart::of(header, beat);
        }
    }

    /// How each seat is at a moment. [ns]
    pub fn conditions(&self, now_ns: u64) -> impl Iterator<Item = (Role, Condition)> + '_ {
        let seats = self.seats.iter();
        seats.map(move |seat| (seat.role, seat.heart.condition(now_ns)))
    }

    /// Reads the processes in the seats with `read`, and counts what they have answered until `now_ns`.
    pub fn look(&mut self, now_ns: u64, read: impl Fn(u32) -> Option<Reading>) {
        for seat in &mut self.seats {
            if seat.heart.epoch != 0 {
                seat.meter.read(read(seat.heart.beat.pid));
            }
            seat.count_rate(now_ns);
        }
    }

    /// A path with another geometry was sent.
    pub fn new_path(&mut self, id: Id) {
        self.hops.new_path(id.0);
    }

    /// A record of a cycle.
    pub fn record(&mut self, span: &Span) {
        self.hops.take(span);
        let is_answer = matches!(span.kind(), Some(SpanKind::Answer | SpanKind::Extra));
        if let Some(seat) = self.seat(span.role()).filter(|_| is_answer) {
            seat.answers += 1;
        }
    }

    /// All records that have come were taken in: the hops of the first command that followed a new path,
    /// when it is one of them. [us]
    pub fn settle(&mut self) -> Option<Vec<(&'static str, f64)>> {
        let taken = self.hops.settle()?;
        Some(taken.way.named_us().collect())
    }

    /// The table of services at a moment. [ns]
    #[must_use]
    pub fn services(&self, now_ns: u64) -> Value {
        self.seats.iter().map(|seat| seat.report(now_ns)).collect()
    }

    /// The tables of latencies.
    #[must_use]
    pub fn latency(&self) -> Value {
        let (n, bins) = self.hops.histogram();
        let quantiles = self.hops.quantiles([0.5, 0.9, 0.99, 1.0]);
        let way = |taken: Option<&Taken>| {
            let hops_us = taken.map(|taken| taken.way.named_us().collect::<Vec<_>>());
            taken.map(|taken| json!({ "tick": taken.tick, "hops_us": hops_us }))
        };
        let (n_lost, n_missed) = self.hops.lost();
        let in_use = self.hops.in_use();
        json!({
            "records_lost": n_lost,
            "scan_in_use": in_use.map(|scan| json!({
                "age_us": to_us(scan.age_ns),
                "uses": scan.uses,
            })),
            "reaction": {
                "n": n,
                "missed": n_missed,
                "ends_us": BINS_US,
                "bins": bins,
                "p50_us": quantiles.map(|all| to_us(all[0])),
                "p90_us": quantiles.map(|all| to_us(all[1])),
                "p99_us": quantiles.map(|all| to_us(all[2])),
                "max_us": quantiles.map(|all| to_us(all[3])),
            },
            "replanning": way(self.hops.replanning()),
            "direct": way(self.hops.direct()),
        })
    }
}

impl Seat {
    fn count_rate(&mut self, now_ns: u64) {
        let (answers, since_ns) = self.before.unwrap_or((self.answers, now_ns));
        let elapsed_s = seconds(now_ns.saturating_sub(since_ns)).max(1.0e-3);
        self.rate_hz = (self.answers - answers).to_f64() / elapsed_s;
        self.before = Some((self.answers, now_ns));
    }

    fn report(&self, now_ns: u64) -> Value {
        let beat = &self.heart.beat;
        let restarted = |at_ns: u64| now_ns.saturating_sub(at_ns) < RESTARTED_NS;
        let state = match self.heart.condition(now_ns) {
            Condition::Beats(_) if self.restarted_ns.is_some_and(restarted) => "restarted",
            condition => condition.label(),
        };
        let usage = self.meter.usage(beat.pid);
        json!({
            "role": self.role.label(),
            "state": state,
            "reasons": self.heart.reasons(),
            "epoch": self.epoch,
            "restarts": self.epoch.saturating_sub(1),
            "pid": beat.pid,
            "cpu_percent": usage.cpu_percent.unwrap_or_default(),
            "memory_bytes": usage.memory_bytes.unwrap_or_default(),
            "rate_hz": (self.rate_hz * 10.0).round() / 10.0,
            "superseded": beat.superseded,
            "rejected": beat.refused,
            "slipped_s": seconds(beat.slipped_ns),
        })
    }
}
