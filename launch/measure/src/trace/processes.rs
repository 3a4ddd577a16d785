//! Tracks of the processes: their cycles, and the commands at the robot's wheels.

use super::format::{TraceEvent, Track};
use super::layout::{About, CYCLES, Key, Slice, WHEELS, id_text, key, pid};
use crate::Records;
use std::collections::BTreeMap;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};

/// Writes the cycles of every process and the commands at the wheels; `slices` gets where the work of
/// each record lies.
pub(super) fn write(
    records: &Records,
    about: &About,
    events: &mut Vec<TraceEvent>,
    slices: &mut BTreeMap<Key, Slice>,
) {
    for role in Role::SERVICES {
        let is_cycle =
            |span: &&Span| span.role == role.code() && span.kind() != Some(SpanKind::Applied);
        let mut spans: Vec<&Span> = records.spans.iter().filter(is_cycle).collect();
        if spans.is_empty() {
            continue;
        }
        spans.sort_by_key(|span| (span.woken_ns, span.started_ns));
        about.name(role, events);
        let mut end_ns = None;
        for span in spans {
            end_ns = Some(cycle(role, span, end_ns, about, events, slices));
        }
    }
    wheels(records, about, events, slices);
}

/// Writes a cycle: the wait before it, the reading of the inputs, the work with its stages inside. A
/// process works on one thing at a time, so no cycle begins before the end of the one before. Returns
/// the end. [ns]
fn cycle(
    role: Role,
    span: &Span,
    before_ns: Option<u64>,
    about: &About,
    events: &mut Vec<TraceEvent>,
    slices: &mut BTreeMap<Key, Slice>,
) -> u64 {
    let track = Track {
        pid: pid(role),
        tid: CYCLES,
    };
    let not_before_ns = before_ns.unwrap_or(0);
    // A second answer of the same wake begins where the first one ended.
    let woken_ns = about.since(span.woken_ns).max(not_before_ns);
    let started_ns = about.since(span.started_ns).max(woken_ns);
    let end_ns = about.since(span.published_ns).max(started_ns);
    if let Some(before_ns) = before_ns.filter(|before_ns| *before_ns < woken_ns) {
        events.push(TraceEvent::slice(track, "wait", before_ns, woken_ns));
    }
    if woken_ns < started_ns {
        events.push(TraceEvent::slice(track, "read", woken_ns, started_ns));
    }
    let kind = span.kind().map_or("unknown", SpanKind::label);
    let mut work = TraceEvent::slice(track, "compute", started_ns, end_ns)
        .arg("kind", kind.into())
        .arg("tick", span.tick.into());
    let off_us = span.off_processor_ns / 1000;
    for (name, value) in [
        ("work", u64::from(span.work)),
        ("superseded", u64::from(span.superseded)),
        ("off processor [us]", off_us),
    ] {
        if value > 0 {
            work = work.arg(name, value.into());
        }
    }
    for (name, id) in [("scan", span.scan), ("map", span.map), ("path", span.path)] {
        if id > 0 {
            work = work.arg(name, id_text(id));
        }
    }
    events.push(work);
    for (stage, from_ns, to_ns) in span.stages() {
        // Inside their cycle, whatever a foreign process has written.
        let within = |at_ns| about.since(at_ns).clamp(started_ns, end_ns);
        let (from_ns, to_ns) = (within(from_ns), within(to_ns));
        if from_ns < to_ns {
            let slice = TraceEvent::slice(track, stage.label(), from_ns, to_ns);
            events.push(slice);
        }
    }
    if role == Role::GlobalPlanner && span.output != 0 {
        let expansions = TraceEvent::counter(pid(role), "expansions", end_ns);
        events.push(expansions.arg("nodes", span.work.into()));
    }
    let slice = Slice {
        track,
        from_ns: started_ns,
        to_ns: end_ns,
    };
    slices.insert(key(span), slice);
    end_ns
}

/// Writes each command at the wheels from its application to that of the next.
fn wheels(
    records: &Records,
    about: &About,
    events: &mut Vec<TraceEvent>,
    slices: &mut BTreeMap<Key, Slice>,
) {
    let is_applied = |span: &&Span| span.kind() == Some(SpanKind::Applied);
    let mut applied: Vec<&Span> = records.spans.iter().filter(is_applied).collect();
    applied.sort_by_key(|span| span.started_ns);
    let track = Track {
        pid: pid(Role::Robot),
        tid: WHEELS,
    };
    if !applied.is_empty() {
        events.push(TraceEvent::thread(track, "wheels"));
    }
    // Of the last one the end is not known.
    for pair in applied.windows(2) {
        let from_ns = about.since(pair[0].started_ns);
        let to_ns = about.since(pair[1].started_ns);
        let command = TraceEvent::slice(track, "command", from_ns, to_ns);
        events.push(command.arg("command", id_text(pair[0].request)));
        let slice = Slice {
            track,
            from_ns,
            to_ns,
        };
        slices.insert(key(pair[0]), slice);
    }
}
