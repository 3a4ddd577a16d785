//! Tracks of the topics: how long each message lay there before its reader took it in.

use super::format::{TraceEvent, Track};
use super::layout::{About, TOPICS_PID, id_text};
use crate::Records;
use crate::edges::{EDGES, TopicEdge};
use std::collections::BTreeMap;

/// Writes a track per topic and reader.
pub(super) fn write(records: &Records, about: &About, events: &mut Vec<TraceEvent>) {
    events.extend(TraceEvent::process(TOPICS_PID, "topics"));
    for (tid, way) in (1..).zip(&EDGES) {
        let track = Track {
            pid: TOPICS_PID,
            tid,
        };
        let name = format!("{} -> {}", way.topic, way.reader);
        events.push(TraceEvent::thread(track, &name));
        edge(way, records, about, track, events);
    }
}

/// A message lies there until its reader begins to work with it, or until a newer one takes its
/// place.
fn edge(
    way: &TopicEdge,
    records: &Records,
    about: &About,
    track: Track,
    events: &mut Vec<TraceEvent>,
) {
    let spans = &records.spans;
    let mut taken_ns: BTreeMap<u64, u64> = BTreeMap::new();
    for span in spans.iter().filter(|span| way.is_read_by(span)) {
        let taken = taken_ns.entry((way.read)(span)).or_insert(u64::MAX);
        *taken = (*taken).min(about.since(span.started_ns));
    }
    let sent = spans.iter().filter(|span| way.is_sent_by(span));
    let sent_at = |at_ns: u64| about.since(at_ns);
    let mut sent: Vec<(u64, u64)> = sent
        .map(|span| (sent_at(span.published_ns), (way.sent)(span)))
        .filter(|(sent_ns, _)| *sent_ns > 0)
        .collect();
    sent.sort_unstable();
    for (at, (sent_ns, id)) in sent.iter().enumerate() {
        let next_ns = sent.get(at + 1).map(|(next_ns, _)| *next_ns);
        let taken = taken_ns.get(id).copied();
        let end_ns = match (taken, next_ns) {
            (Some(taken_ns), Some(next_ns)) => taken_ns.min(next_ns),
            (Some(one_ns), None) | (None, Some(one_ns)) => one_ns,
            // What became of the newest one is not known.
            (None, None) => continue,
        };
        let name = if taken.is_some() {
            "queued"
        } else {
            "superseded"
        };
        let slice = TraceEvent::slice(track, name, *sent_ns, end_ns.max(*sent_ns));
        events.push(slice.arg("message", id_text(*id)));
    }
}
