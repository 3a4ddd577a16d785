//! Latency of replanning, event by event.
//!
//! For an obstacle O that appears:
//! - `s`: first scan with at least 3 beams on O,
//! - `m`: first map revision, current as of s or later, with a sensed lethal cell at O's outline,
//! - `p`: first path with map parent >= m, cause obstacle, whose swept robot is clear of O,
//! - `c`: first command whose request names p or a later path.
//!
//! *Replanning* is published(c) - captured(s), *event to motion* is applied(c) - appearance. The
//! way from captured(s) to applied(c) is split into contiguous hops, each boundary one clock
//! reading of one process; their sum is compared with the robot's own two readings.

use super::distribution::{Distribution, Figures};
use super::index::{PathRecord, Records, Sighting};
use serde::Serialize;
use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::Span;

/// Names of the hops, in order. The first ends at the capture of the scan that p's map is current
/// as of; `to_` hops are transport and waking, the others the work of a process.
pub const HOPS: [&str; 11] = [
    "detect",
    "robot",
    "to_mapping",
    "mapping",
    "to_global_planner",
    "global_planner",
    "to_local_planner",
    "local_planner",
    "to_collision_guard",
    "collision_guard",
    "to_robot",
];

/// How an event ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EventOutcome {
    /// Answered through the map.
    Answered,
    /// Answered before the map showed three beams' worth of it; measured from the first beam.
    Early,
    /// Not answered before the deadline or the end of the run.
    Censored,
    /// The path never led through it, so there was nothing to answer.
    NotInTheWay,
}

/// One obstacle and what became of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Place in the scenario's list.
    pub index: usize,
    /// How it ended.
    pub outcome: EventOutcome,
    /// published(c) - captured(s). [ns]
    pub replanning_ns: Option<u64>,
    /// applied(c) - appearance. [ns]
    pub event_to_motion_ns: Option<u64>,
    /// Lengths of the hops, in the order of [`HOPS`]. [ns]
    pub hops_ns: Option<[u64; HOPS.len()]>,
    /// |sum of the hops - the robot's own end-to-end time|. [ns]
    pub closure_error_ns: Option<u64>,
}

/// One hop of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Hop {
    /// Its name.
    pub name: &'static str,
    /// Its figures.
    #[serde(flatten)]
    pub figures: Figures,
}

/// The latency part of a result.
#[derive(Debug, Clone, Serialize)]
pub struct Latency {
    /// captured(scan) -> published(first command whose request checked that scan's points).
    pub reaction: Figures,
    /// captured(s) -> published(c).
    pub replanning: Figures,
    /// Appearance -> applied(c).
    pub event_to_motion: Figures,
    /// The way from captured(s) to applied(c).
    pub hops: Vec<Hop>,
    /// The same way through five processes that do nothing, at the same pace and with messages of
    /// the same size; measured by trials only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transport_floor: Option<Figures>,
    /// Median of replanning over that of the floor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replanning_to_floor: Option<f64>,
    /// Worst disagreement between the hops and the robot's own end-to-end time. [ns]
    pub closure_error_ns_max: Option<u64>,
    /// Events answered before the map showed three beams' worth of the obstacle.
    pub early: u64,
    /// Obstacles that no path led through.
    pub not_in_the_way: u64,
}

/// Tells how near a path comes to an obstacle. [m]
pub type Clearance<'a> = &'a dyn Fn(usize, &[[f64; 2]]) -> f64;

/// Latencies of all events and all scans. `radius_m` is that of the swept robot, `deadline_ns`
/// the time after which an event or a scan counts as unanswered.
#[must_use]
pub fn measure(
    records: &Records,
    clearance_m: Clearance<'_>,
    radius_m: f64,
    deadline_ns: u64,
) -> (Vec<Event>, Latency) {
    let events: Vec<Event> = records
        .sightings
        .iter()
        .map(|sighting| judge(records, sighting, clearance_m, radius_m, deadline_ns))
        .collect();
    let latency = Latency::of(
        &events,
        reactions(records, deadline_ns).figures(),
        deadline_ns,
    );
    (events, latency)
}

impl Latency {
    /// The figures of `events`.
    #[must_use]
    pub fn of(events: &[Event], reaction: Figures, deadline_ns: u64) -> Self {
        let mut replanning = Distribution::new();
        let mut event_to_motion = Distribution::new();
        let mut hops: Vec<Distribution> = HOPS.iter().map(|_| Distribution::new()).collect();
        for event in events {
            match event.outcome {
                EventOutcome::NotInTheWay => {}
                EventOutcome::Censored => {
                    replanning.censor(deadline_ns);
                    event_to_motion.censor(deadline_ns);
                }
                EventOutcome::Answered | EventOutcome::Early => {
                    event
                        .replanning_ns
                        .into_iter()
                        .for_each(|time| replanning.add(time));
                    event
                        .event_to_motion_ns
                        .into_iter()
                        .for_each(|time| event_to_motion.add(time));
                }
            }
            for (hop, time) in hops.iter_mut().zip(event.hops_ns.into_iter().flatten()) {
                hop.add(time);
            }
        }
        let count = |outcome| {
            events
                .iter()
                .filter(|event| event.outcome == outcome)
                .count() as u64
        };
        Self {
            reaction,
            replanning: replanning.figures(),
            event_to_motion: event_to_motion.figures(),
            hops: HOPS
                .iter()
                .zip(&hops)
                .map(|(name, hop)| Hop {
                    name,
                    figures: hop.figures(),
                })
                .collect(),
            transport_floor: None,
            replanning_to_floor: None,
            closure_error_ns_max: events
                .iter()
                .filter_map(|event| event.closure_error_ns)
                .max(),
            early: count(EventOutcome::Early),
            not_in_the_way: count(EventOutcome::NotInTheWay),
        }
    }

    /// Several rounds as one: percentiles are the median of the rounds', the worst is the worst
    /// of all, samples are counted together.
    #[must_use]
    pub fn of_rounds(rounds: &[Self]) -> Self {
        let figures = |of: &dyn Fn(&Self) -> Option<Figures>| {
            let of_each: Vec<Figures> = rounds.iter().filter_map(of).collect();
            (!of_each.is_empty()).then(|| Figures::of_rounds(&of_each))
        };
        let replanning = figures(&|round| Some(round.replanning)).unwrap_or_default();
        let transport_floor = figures(&|round| round.transport_floor);
        let floor_us = transport_floor.and_then(|floor| floor.p50_us);
        Self {
            reaction: figures(&|round| Some(round.reaction)).unwrap_or_default(),
            replanning,
            event_to_motion: figures(&|round| Some(round.event_to_motion)).unwrap_or_default(),
            hops: (0..HOPS.len())
                .map(|at| Hop {
                    name: HOPS[at],
                    figures: figures(&|round| round.hops.get(at).map(|hop| hop.figures))
                        .unwrap_or_default(),
                })
                .collect(),
            transport_floor,
            replanning_to_floor: replanning
                .p50_us
                .zip(floor_us)
                .map(|(replanning_us, floor_us)| replanning_us / floor_us),
            closure_error_ns_max: rounds
                .iter()
                .filter_map(|round| round.closure_error_ns_max)
                .max(),
            early: rounds.iter().map(|round| round.early).sum(),
            not_in_the_way: rounds.iter().map(|round| round.not_in_the_way).sum(),
        }
    }
}

/// Reaction times of all scans that came while a path was followed.
#[must_use]
pub fn reactions(records: &Records, deadline_ns: u64) -> Distribution {
    let mut distribution = Distribution::new();
    let mut requests: Vec<&Span> = records
        .answers(Role::LocalPlanner)
        .filter(|span| span.output != 0)
        .collect();
    requests.sort_unstable_by_key(|span| span.output);
    let mut commands: Vec<&Span> = records
        .answers(Role::CollisionGuard)
        .filter(|span| span.output != 0)
        .collect();
    commands.sort_unstable_by_key(|span| span.output);
    let Some(driving_ns) = requests
        .iter()
        .filter(|request| request.path != 0)
        .map(|request| request.started_ns)
        .min()
    else {
        return distribution;
    };
    let scans = records.answers(Role::Robot);
    for scan in scans.filter(|span| span.scan != 0 && span.capture_ns >= driving_ns) {
        // Scans and requests both grow, so the first that checked it is found by bisection.
        let at = requests.partition_point(|request| request.scan < scan.scan);
        let Some(request) = requests.get(at) else {
            // The records end before the deadline of the last scans: they say nothing.
            let recorded_ns = commands.last().map_or(0, |last| last.published_ns);
            if recorded_ns.saturating_sub(scan.capture_ns) > deadline_ns {
                distribution.censor(deadline_ns);
            }
            continue;
        };
        if request.path == 0 {
            continue;
        }
        let at = commands.partition_point(|command| command.request < request.output);
        if let Some(command) = commands.get(at) {
            distribution.add(command.published_ns.saturating_sub(scan.capture_ns));
        }
    }
    distribution
}

/// What became of one obstacle.
#[must_use]
pub fn judge(
    records: &Records,
    sighting: &Sighting,
    clearance_m: Clearance<'_>,
    radius_m: f64,
    deadline_ns: u64,
) -> Event {
    let blank = |outcome| Event {
        index: sighting.index,
        outcome,
        replanning_ns: None,
        event_to_motion_ns: None,
        hops_ns: None,
        closure_error_ns: None,
    };
    let clear = |path: &PathRecord| clearance_m(sighting.index, &path.points_m) > radius_m;
    let seen = sighting.first_beam_scan.and_then(|scan| records.scan(scan));
    let in_the_way = seen.is_some_and(|seen| {
        let published = |path: &&PathRecord| {
            records
                .output(Role::GlobalPlanner, path.id)
                .is_some_and(|span| span.published_ns <= seen.published_ns)
        };
        let before = records.paths.iter().rfind(published);
        before.is_some_and(|path| path.status == PathStatus::Found && !clear(path))
    });
    if !in_the_way {
        return blank(EventOutcome::NotInTheWay);
    }
    let answers = |path: &&PathRecord, map: u64| {
        path.map >= map
            && path.cause == PathCause::Obstacle
            && path.status == PathStatus::Found
            && clear(path)
    };
    let first_map_as_of = |scan: u64| {
        records
            .answers(Role::Mapping)
            .filter(|span| span.scan >= scan && span.output != 0)
            .map(|span| span.output)
            .min()
    };
    let by_map = sighting
        .first_map
        .and_then(|map| records.paths.iter().find(|path| answers(path, map)));
    let by_beam = sighting
        .first_beam_scan
        .and_then(first_map_as_of)
        .and_then(|map| records.paths.iter().find(|path| answers(path, map)));
    // An answer that came before m is measured from the first beam, never thrown away.
    let early = match (by_beam, by_map) {
        (Some(beam), Some(map)) => beam.id < map.id,
        (Some(_), None) => true,
        _ => false,
    };
    let (path, start, outcome) = if early {
        (by_beam, sighting.first_beam_scan, EventOutcome::Early)
    } else {
        (by_map, sighting.first_scan, EventOutcome::Answered)
    };
    let answered = path
        .zip(start.and_then(|scan| records.scan(scan)))
        .and_then(|(path, start)| chain(records, path, start, sighting.appeared_ns));
    match answered {
        Some(answered)
            if answered
                .replanning_ns
                .is_some_and(|time| time <= deadline_ns) =>
        {
            Event {
                index: sighting.index,
                outcome,
                ..answered
            }
        }
        _ => blank(EventOutcome::Censored),
    }
}

/// The hops from `start` through `path` to the wheels.
fn chain(records: &Records, path: &PathRecord, start: &Span, appeared_ns: u64) -> Option<Event> {
    let global = records.output(Role::GlobalPlanner, path.id)?;
    let mapping = records.output(Role::Mapping, path.map)?;
    let scan = records.scan(mapping.scan)?;
    let local = records.first_request_with_path(path.id)?;
    let guard = records.first_command(local.output)?;
    let applied = records.applied(guard.output)?;
    let boundaries = [
        start.capture_ns,
        scan.capture_ns,
        scan.published_ns,
        mapping.started_ns,
        mapping.published_ns,
        global.started_ns,
        global.published_ns,
        local.started_ns,
        local.published_ns,
        guard.started_ns,
        guard.published_ns,
        applied.started_ns,
    ];
    let mut hops_ns = [0; HOPS.len()];
    for (hop, pair) in hops_ns.iter_mut().zip(boundaries.windows(2)) {
        *hop = pair[1].saturating_sub(pair[0]);
    }
    // The robot took both readings itself: the capture of the scan and the moment of effect.
    let end_to_end_ns = applied.started_ns.saturating_sub(start.capture_ns);
    Some(Event {
        index: 0,
        outcome: EventOutcome::Answered,
        replanning_ns: Some(guard.published_ns.saturating_sub(start.capture_ns)),
        event_to_motion_ns: Some(applied.started_ns.saturating_sub(appeared_ns)),
        closure_error_ns: Some(hops_ns.iter().sum::<u64>().abs_diff(end_to_end_ns)),
        hops_ns: Some(hops_ns),
    })
}
