//! How the services and the latencies are, for the tables of the page.

use crate::events::Events;
use crate::hops::{BINS_US, Hops, Taken};
use serde_json::{Value, json};
use std::time::{Duration, Instant};
use zeronav_msgs::command::VelocityCommand;
use zeronav_msgs::header::Id;
use zeronav_msgs::health::{
    HealthState, REASON_CLOCK, REASON_LINK, REASON_MAP, REASON_NO_LOAN, REASON_ODOMETRY,
    REASON_PATH, REASON_PUBLISHERS, REASON_REFUSED, REASON_REQUEST, REASON_SCAN, REASON_TOO_LONG,
    REASON_TRANSFORM, SILENT_AFTER_NS,
};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::{HealthTopic, health_of};
use zeronav_observe::usage::{Meter, Reading};
use zeronav_observe::way::to_us;
use zeronav_shell::clock::now_ns;
use zeronav_shell::{Latest, Peer, Roster, StartError};

/// A service whose heart has not beaten for this long is silent.
const SILENT: Duration = Duration::from_nanos(SILENT_AFTER_NS);

/// Time between two looks above which this process was kept from looking: it has a low priority, and
/// what it did not see says nothing about the others.
const LATE: Duration = Duration::from_millis(50);

/// For how long a restart stands in the table.
const RESTARTED: Duration = Duration::from_secs(2);

/// Time between two looks at processor time and memory.
const USAGE_PAUSE: Duration = Duration::from_secs(1);

/// A word for each reason bit.
const REASONS: [(u32, &str); 12] = [
    (REASON_SCAN, "no scan"),
    (REASON_ODOMETRY, "no odometry"),
    (REASON_MAP, "no map"),
    (REASON_PATH, "no path"),
    (REASON_REQUEST, "no request"),
    (REASON_REFUSED, "messages rejected"),
    (REASON_NO_LOAN, "no memory to send"),
    (REASON_TOO_LONG, "output too long"),
    (REASON_TRANSFORM, "no transform to the lidar"),
    (REASON_CLOCK, "the robot's clock was set"),
    (REASON_PUBLISHERS, "two publishers"),
    (REASON_LINK, "the way to its host is cut"),
];

/// What is known of one seat.
#[derive(Debug)]
struct SeatLine {
    role: Role,
    health: Latest<HealthTopic>,
    progress: u64,
    beaten: Option<Instant>,
    epoch: u32,
    restarted: Option<Instant>,
    meter: Meter,
    /// Answers since the beginning, and at the last look at them.
    answers: u64,
    before: (u64, Instant),
    rate_hz: f64,
}

/// The seats and the latencies.
#[derive(Debug)]
pub(crate) struct Seats {
    lines: Vec<SeatLine>,
    /// The last look at the heartbeats.
    listened: Instant,
    looked: Option<Instant>,
    own: Meter,
    hops: Hops,
    /// The guard's newest command.
    pub(crate) command: Option<VelocityCommand>,
}

impl Seats {
    /// Opens the heartbeats.
    ///
    /// # Errors
    /// One line when one cannot be opened.
    pub(crate) fn open(peer: &Peer) -> Result<Self, StartError> {
        let mut lines = Vec::new();
        for role in Role::SERVICES {
            let Some(row) = health_of(role) else {
                continue;
            };
            lines.push(SeatLine {
                role,
                health: peer.latest_on(row)?,
                progress: 0,
                beaten: None,
                epoch: 0,
                restarted: None,
                meter: Meter::default(),
                answers: 0,
                before: (0, Instant::now()),
                rate_hz: 0.0,
            });
        }
        Ok(Self {
            lines,
            listened: Instant::now(),
            looked: None,
            own: Meter::default(),
            hops: Hops::default(),
            command: None,
        })
    }

    /// A command of the guard.
    pub(crate) fn command(&mut self, command: &VelocityCommand) {
        self.command = Some(*command);
    }

    /// A path with another geometry.
    pub(crate) fn new_path(&mut self, id: Id) {
        self.hops.new_path(id.0);
    }

    /// A record of a cycle.
    pub(crate) fn record(&mut self, span: &Span) {
        self.hops.take(span);
        let is_answer = matches!(span.kind(), Some(SpanKind::Answer | SpanKind::Extra));
        let line = self.lines.iter_mut();
        if let Some(line) = line
            .filter(|_| is_answer)
            .find(|line| line.role.code() == span.role)
        {
            line.answers += 1;
        }
    }

    /// All records that have come were taken in.
    pub(crate) fn settle(&mut self, events: &mut Events) {
        if let Some(taken) = self.hops.settle() {
            events.replanned(taken.way.named_us().collect());
        }
    }

    /// Takes in heartbeats.
    pub(crate) fn listen(&mut self, roster: &Roster, events: &mut Events) {
        let absent = self.listened.elapsed();
        self.listened = Instant::now();
        for line in &mut self.lines {
            if absent > LATE {
                line.beaten = line.beaten.map(|beaten| beaten + absent);
            }
            let epoch = roster.seat(line.role).map_or(0, |seat| seat.epoch);
            if line.epoch != epoch {
                line.restarted = (line.epoch != 0).then(Instant::now);
                line.epoch = epoch;
            }
            line.health.poll(roster);
            let beat = line
                .health
                .get()
                .filter(|beat| roster.is_current(beat.header));
            if let Some(beat) = beat
                && beat.meta.progress != line.progress
            {
                line.progress = beat.meta.progress;
                line.beaten = Some(Instant::now());
            }
            if line.beaten.is_some() {
                events.heart(line.role, line.is_silent());
            }
        }
    }

    /// The tables as JSON.
    pub(crate) fn report(&mut self, roster: &Roster, watchers: usize) -> Value {
        self.look_at_processes();
        let services: Vec<Value> = self.lines.iter().map(SeatLine::report).collect();
        let own = self.own.usage(std::process::id());
        json!({
            "paused": roster.control.paused == 1,
            "stopping": roster.control.stopping == 1,
            "services": services,
            "latency": self.latency(),
            "viewer": {
                "clients": watchers,
                "cpu_percent": own.cpu_percent.unwrap_or_default(),
                "memory_bytes": own.memory_bytes.unwrap_or_default(),
            },
        })
    }

    fn look_at_processes(&mut self) {
        if self
            .looked
            .is_some_and(|looked| looked.elapsed() < USAGE_PAUSE)
        {
            return;
        }
        self.looked = Some(Instant::now());
        for line in &mut self.lines {
            if let Some(beat) = line.health.get() {
                line.meter.read(Reading::of(beat.meta.pid, now_ns()));
            }
            line.count_rate();
        }
        self.own.read(Reading::of(std::process::id(), now_ns()));
    }

    fn latency(&self) -> Value {
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

impl SeatLine {
    fn is_silent(&self) -> bool {
        self.beaten.is_none_or(|beaten| beaten.elapsed() > SILENT)
    }

    #[allow(clippy::cast_precision_loss, reason = "answers of a second")]
    fn count_rate(&mut self) {
        let (before, since) = self.before;
        let elapsed_s = since.elapsed().as_secs_f64().max(1.0e-3);
        self.rate_hz = (self.answers - before) as f64 / elapsed_s;
        self.before = (self.answers, Instant::now());
    }

    fn report(&self) -> Value {
        let beat = self.health.get().map(|beat| *beat.meta);
        let beat = beat.unwrap_or_default();
        let restarted_s = self.restarted.map(|restarted| restarted.elapsed());
        let recently = restarted_s.is_some_and(|elapsed| elapsed < RESTARTED);
        let state = match beat.state() {
            _ if self.is_silent() => "silent",
            _ if recently => "restarted",
            Some(state) => state.label(),
            None => HealthState::Starting.label(),
        };
        let usage = self.meter.usage(beat.pid);
        let reasons = REASONS.iter().filter(|(bit, _)| beat.reasons & bit != 0);
        json!({
            "role": self.role.label(),
            "state": state,
            "reasons": reasons.map(|(_, word)| *word).collect::<Vec<_>>(),
            "epoch": self.epoch,
            "restarts": self.epoch.saturating_sub(1),
            "pid": beat.pid,
            "cpu_percent": usage.cpu_percent.unwrap_or_default(),
            "memory_bytes": usage.memory_bytes.unwrap_or_default(),
            "rate_hz": tenths(self.rate_hz),
            "superseded": beat.superseded,
            "rejected": beat.refused,
            "slipped_s": seconds(beat.slipped_ns),
        })
    }
}

fn tenths(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
