//! Flows from scan to wheel, the ages of scan and plan at the wheels, and what happened meanwhile.

use super::format::{FlowPart, TraceEvent};
use super::layout::{About, Key, Slice, key, pid};
use crate::Records;
use crate::joins::Joins;
use std::collections::{BTreeMap, BTreeSet};
use zeronav_casts::Cast;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::Span;

/// Writes a flow from every scan to the first command whose author checked it, another from the scan
/// behind every new path, and the counters.
pub(super) fn write(
    records: &Records,
    about: &About,
    slices: &BTreeMap<Key, Slice>,
    events: &mut Vec<TraceEvent>,
) {
    let joins = Joins::of(records);
    let mut ids = 1..;
    let mut flow = |name: &str, spans: &[&Span]| {
        let parts: Option<Vec<Slice>> = spans
            .iter()
            .map(|span| slices.get(&key(span)).copied())
            .collect();
        if let Some((parts, id)) = parts.zip(ids.next()) {
            write_flow(name, &parts, id, events);
        }
    };
    let mut scans = BTreeSet::new();
    for applied in joins.applied() {
        if let Ok(spans) = joins.direct(applied)
            && scans.insert(spans[0].scan)
        {
            flow("scan to wheel", &spans);
        }
    }
    for path in &records.paths {
        let global = joins.output(Role::GlobalPlanner, path.id);
        if let Some(spans) = global.and_then(|global| joins.of_path(path.id, global.map)) {
            flow("new path", &spans);
        }
    }
    for applied in joins.applied() {
        write_ages(&joins, applied, about, events);
    }
    write_moments(records, about, &joins, events);
}

/// A flow leaves its first slice at its end and enters the others at their beginning, a nanosecond
/// inside so that it binds to them and to no neighbour. One with a stamp before its predecessor, which
/// the result counts, is left out: no viewer can draw it.
fn write_flow(name: &str, parts: &[Slice], id: u64, events: &mut Vec<TraceEvent>) {
    let last = parts.len().saturating_sub(1);
    let place = |(at, slice): (usize, &Slice)| match at {
        0 => slice.to_ns.saturating_sub(1).max(slice.from_ns),
        _ => (slice.from_ns + 1).min(slice.to_ns),
    };
    let places_ns: Vec<u64> = parts.iter().enumerate().map(place).collect();
    if !places_ns.is_sorted() {
        return;
    }
    for (at, (slice, at_ns)) in parts.iter().zip(places_ns).enumerate() {
        let part = match at {
            0 => FlowPart::Start,
            at if at == last => FlowPart::Finish,
            _ => FlowPart::Step,
        };
        events.push(TraceEvent::flow(slice.track, name, at_ns, id, part));
    }
}

/// How old scan and plan are when a command reaches the wheels.
fn write_ages<'a>(
    joins: &Joins<'a>,
    applied: &'a Span,
    about: &About,
    events: &mut Vec<TraceEvent>,
) {
    let Ok([scan, local, ..]) = joins.direct(applied) else {
        return;
    };
    let age_ms = |since_ns: u64| applied.started_ns.saturating_sub(since_ns).to_f64() / 1.0e6;
    let at_ns = about.since(applied.started_ns);
    let ages = TraceEvent::counter(pid(Role::Robot), "age at the wheels [ms]", at_ns);
    let mut ages = ages.arg("scan", age_ms(scan.capture_ns).into());
    if let Some(plan) = joins.output(Role::GlobalPlanner, local.path) {
        ages = ages.arg("plan", age_ms(plan.published_ns).into());
    }
    events.push(ages);
}

/// Obstacles that appeared, and new paths.
fn write_moments(
    records: &Records,
    about: &About,
    joins: &Joins<'_>,
    events: &mut Vec<TraceEvent>,
) {
    for sighting in &records.sightings {
        let at_ns = about.since(sighting.appeared_ns);
        events.push(TraceEvent::instant(
            pid(Role::Robot),
            "an obstacle appears",
            at_ns,
        ));
    }
    for path in &records.paths {
        if let Some(span) = joins.output(Role::GlobalPlanner, path.id) {
            let name = format!("path: {}, cause {}", path.status, path.cause);
            let at_ns = about.since(span.published_ns);
            events.push(TraceEvent::instant(pid(Role::GlobalPlanner), &name, at_ns));
        }
    }
}
