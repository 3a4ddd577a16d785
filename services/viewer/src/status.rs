//! Reads how the services and the latencies are, for the tables of the page.

use crate::events::Events;
use crate::model::Model;
use serde_json::{Value, json};
use zeronav_msgs::command::VelocityCommand;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{HealthTopic, health_of};
use zeronav_observe::health::Condition;
use zeronav_observe::usage::{Meter, Reading};
use zeronav_shell::clock::now_ns;
use zeronav_shell::{Latest, Peer, Roster, StartError};

/// Time between two looks at processor time and memory. [ns]
const USAGE_PAUSE_NS: u64 = 1_000_000_000;

/// The seats and the latencies.
#[derive(Debug)]
pub(crate) struct Seats {
    hearts: Vec<(Role, Latest<HealthTopic>)>,
    pub(crate) model: Model,
    /// When the processes were looked at. [ns]
    looked_ns: u64,
    own: Meter,
    /// The guard's newest command.
    pub(crate) command: Option<VelocityCommand>,
}

impl Seats {
    /// Opens the heartbeats.
    ///
    /// # Errors
    /// One line when one cannot be opened.
    pub(crate) fn open(peer: &Peer) -> Result<Self, StartError> {
        let rows = Role::SERVICES.into_iter();
        let rows = rows.filter_map(|role| Some((role, health_of(role)?)));
        let hearts = rows.map(|(role, row)| Ok((role, peer.latest_on(row)?)));
        Ok(Self {
            hearts: hearts.collect::<Result<_, StartError>>()?,
            model: Model::default(),
            looked_ns: 0,
            own: Meter::default(),
            command: None,
        })
    }

    /// All records that have come were taken in.
    pub(crate) fn settle(&mut self, events: &mut Events) {
        if let Some(hops_us) = self.model.settle() {
            events.replanned(hops_us);
        }
    }

    /// Takes in heartbeats.
    pub(crate) fn listen(&mut self, roster: &Roster, events: &mut Events) {
        for (role, heart) in &mut self.hearts {
            let epoch = roster.seat(*role).map_or(0, |seat| seat.epoch);
            self.model.obeyed(*role, epoch, now_ns());
            heart.poll(roster);
            if let Some(beat) = heart.get().filter(|beat| roster.is_current(beat.header)) {
                self.model.beat(beat.header, beat.meta);
            }
        }
        for (role, condition) in self.model.conditions(now_ns()) {
            if condition != Condition::Absent {
                events.heart(role, condition == Condition::Silent);
            }
        }
    }

    /// The tables as JSON.
    pub(crate) fn report(&mut self, roster: &Roster, watchers: usize) -> Value {
        self.look_at_processes();
        let own = self.own.usage(std::process::id());
        json!({
            "paused": roster.control.paused == 1,
            "stopping": roster.control.stopping == 1,
            "services": self.model.services(now_ns()),
            "latency": self.model.latency(),
            "viewer": {
                "clients": watchers,
                "cpu_percent": own.cpu_percent.unwrap_or_default(),
                "memory_bytes": own.memory_bytes.unwrap_or_default(),
            },
        })
    }

    fn look_at_processes(&mut self) {
        let now_ns = now_ns();
        if now_ns.saturating_sub(self.looked_ns) < USAGE_PAUSE_NS {
            return;
        }
        self.looked_ns = now_ns;
        let read = |pid| Reading::of(pid, now_ns);
        self.model.look(now_ns, read);
        self.own.read(read(std::process::id()));
    }
}
