//! What became of an obstacle that appeared.
//!
//! For an obstacle O:
//! - `s`: first scan with at least 3 beams on O,
//! - `m`: first map revision, current as of s or later, with a sensed lethal cell at O's outline,
//! - `p`: first path with map parent >= m, cause obstacle, whose swept robot is clear of what of O
//!   had been sensed when that map was made. Nothing has seen O's hidden back by then; a later path
//!   that makes good for it is counted as a revision.
//! - `c`: first command whose request names p or a later path.
//!
//! *Replanning* is published(c) - captured(s), *event to motion* is applied(c) - appearance.

use super::index::{PathRecord, Records, Sighting};
use super::joins::Joins;
use serde::Serialize;
use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::Span;
use zeronav_observe::hop_chain::{HOPS, HopChain};

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
    /// The way from captured(s) to applied(c).
    pub way: Option<HopChain>,
    /// True when a path answered it, but the records lead from there to no command.
    pub way_broken: bool,
    /// Later paths that made good for what of O had not been seen before.
    pub revised: u32,
}

impl Event {
    /// One without an answer.
    const fn blank(index: usize, outcome: EventOutcome) -> Self {
        Self {
            index,
            outcome,
            replanning_ns: None,
            event_to_motion_ns: None,
            way: None,
            way_broken: false,
            revised: 0,
        }
    }

    /// Lengths of the hops, in the order of [`HOPS`]. [ns]
    #[must_use]
    pub fn hops_ns(&self) -> Option<[u64; HOPS.len()]> {
        let mut hops_ns = [0; HOPS.len()];
        for (place, length_ns) in self.way.as_ref()?.lengths_ns() {
            hops_ns[place] = length_ns;
        }
        Some(hops_ns)
    }
}

/// Tells how near a path comes to an obstacle, all of it. [m]
pub type Clearance<'a> = &'a dyn Fn(usize, &[[f64; 2]]) -> f64;

/// Distance of a path from the nearest of `cells_m`, centre by centre; infinite without any. [m]
fn distance_m(points_m: &[[f64; 2]], cells_m: &[[f64; 2]]) -> f64 {
    let to_leg = |from: [f64; 2], to: [f64; 2], cell: [f64; 2]| {
        let leg = [to[0] - from[0], to[1] - from[1]];
        let out = [cell[0] - from[0], cell[1] - from[1]];
        let square = leg[0] * leg[0] + leg[1] * leg[1];
        let along = if square > 0.0 {
            ((out[0] * leg[0] + out[1] * leg[1]) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (out[0] - along * leg[0]).hypot(out[1] - along * leg[1])
    };
    let mut nearest_m = f64::INFINITY;
    for (at, from) in points_m.iter().enumerate() {
        // A path of one point is that point.
        let to = points_m.get(at + 1).unwrap_or(from);
        for cell in cells_m {
            nearest_m = nearest_m.min(to_leg(*from, *to, *cell));
        }
    }
    nearest_m
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
    let joins = Joins::of(records);
    let index = sighting.index;
    let clear_of_all = |path: &PathRecord| clearance_m(index, &path.points_m) > radius_m;
    // Of what the map showed; before it showed anything, all of O is what there is to judge by.
    let clear = |path: &PathRecord| match sighting.sensed_by(path.map) {
        [] => clear_of_all(path),
        cells_m => distance_m(&path.points_m, cells_m) > radius_m,
    };
    let seen = sighting.first_beam_scan.and_then(|scan| joins.scan(scan));
    let in_the_way = seen.is_some_and(|seen| {
        let published = |path: &&PathRecord| {
            joins
                .output(Role::GlobalPlanner, path.id)
                .is_some_and(|span| span.published_ns <= seen.published_ns)
        };
        let before = records.paths.iter().rfind(published);
        before.is_some_and(|path| path.status == PathStatus::Found && !clear_of_all(path))
    });
    if !in_the_way {
        return Event::blank(index, EventOutcome::NotInTheWay);
    }
    let by_obstacle =
        |path: &&PathRecord| path.cause == PathCause::Obstacle && path.status == PathStatus::Found;
    let first_answer = |map: u64| {
        let answers = |path: &&PathRecord| path.map >= map && clear(path);
        records.paths.iter().filter(by_obstacle).find(answers)
    };
    let by_map = sighting.first_map.and_then(first_answer);
    let by_beam = sighting
        .first_beam_scan
        .and_then(|scan| joins.first_map_as_of(scan))
        .and_then(first_answer);
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
    let censored = Event::blank(index, EventOutcome::Censored);
    let Some(path) = path else {
        return censored;
    };
    let start = start.and_then(|scan| joins.scan(scan));
    let Some(event) = start.and_then(|start| answered(&joins, path, start, sighting)) else {
        return Event {
            way_broken: true,
            ..censored
        };
    };
    if event.replanning_ns.is_none_or(|time| time > deadline_ns) {
        return censored;
    }
    // Until the path clears all of O, every further one makes good for some of it.
    let mut cleared = clear_of_all(path);
    let after = |later: &&PathRecord| later.id > path.id;
    let mut revised = 0;
    for later in records.paths.iter().filter(by_obstacle).filter(after) {
        revised += u32::from(!cleared);
        cleared |= clear_of_all(later);
    }
    Event {
        outcome,
        revised,
        ..event
    }
}

/// The times of an event that `path` answered.
fn answered(
    joins: &Joins<'_>,
    path: &PathRecord,
    start: &Span,
    sighting: &Sighting,
) -> Option<Event> {
    let way = HopChain::from_earlier(start, joins.of_path(path.id, path.map)?);
    let [.., commanded_ns, applied_ns] = way.boundaries_ns[..] else {
        return None;
    };
    Some(Event {
        replanning_ns: Some(commanded_ns.saturating_sub(start.capture_ns)),
        event_to_motion_ns: Some(applied_ns.saturating_sub(sighting.appeared_ns)),
        way: Some(way),
        ..Event::blank(sighting.index, EventOutcome::Answered)
    })
}
