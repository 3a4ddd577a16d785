//! Which process, topic and record has which place in the trace.

use super::format::{TraceEvent, Track};
use std::collections::BTreeMap;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::Span;

/// Number of the process that holds the tracks of the topics.
pub(super) const TOPICS_PID: u32 = 100;

/// Thread of the cycles of a process.
pub(super) const CYCLES: u32 = 1;

/// Thread of the commands at the robot's wheels.
pub(super) const WHEELS: u32 = 2;

/// What of a run is no record.
#[derive(Debug, Clone, Default)]
pub struct About {
    /// Scenario.
    pub scenario: String,
    /// Moment of run time 0. [ns]
    pub zero_ns: u64,
    /// Process id of each seat.
    pub pids: BTreeMap<String, u32>,
}

/// Where the work of a record lies in the trace. [ns]
#[derive(Debug, Clone, Copy)]
pub(super) struct Slice {
    pub track: Track,
    pub from_ns: u64,
    pub to_ns: u64,
}

/// A record by which it is found again: role, kind, and main message, request or scan.
pub(super) type Key = (u16, u16, u64);

pub(super) fn key(span: &Span) -> Key {
    let ids = [span.output, span.request, span.scan];
    let id = ids.into_iter().find(|id| *id != 0);
    (span.role, span.kind, id.unwrap_or(0))
}

/// The process of a role in the trace.
pub(super) fn pid(role: Role) -> u32 {
    u32::from(role.code())
}

/// An id for people: a whole number of 64 bits is no number in every reader of JSON.
pub(super) fn id_text(id: u64) -> serde_json::Value {
    zeronav_msgs::header::Id(id).to_string().into()
}

impl About {
    /// Since run time 0. [ns]
    pub(super) fn since(&self, at_ns: u64) -> u64 {
        at_ns.saturating_sub(self.zero_ns)
    }

    /// Names of a process and its thread of cycles.
    pub(super) fn name(&self, role: Role, events: &mut Vec<TraceEvent>) {
        let label = role.label();
        let name = match self.pids.get(label) {
            Some(pid) => format!("{label} (pid {pid})"),
            None => label.to_owned(),
        };
        events.extend(TraceEvent::process(pid(role), &name));
        let track = Track {
            pid: pid(role),
            tid: CYCLES,
        };
        events.push(TraceEvent::thread(track, "cycles"));
    }
}
