//! Hand-made records with times that can be added in the head.

use zeronav_measure::index::{PathRecord, Records, Sighting};
use zeronav_measure::result::latency::Latency;
use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};

/// Microseconds in nanoseconds.
pub(crate) const US: u64 = 1000;
/// Deadline of the fixtures.
pub(crate) const DEADLINE_NS: u64 = 1_000_000 * US;
/// Radius of the robot. [m]
pub(crate) const RADIUS_M: f64 = 0.25;

/// How far the robot's second clock is ahead of the first.
pub(crate) const AHEAD_NS: u64 = 77_000_000_000;

/// The obstacle is on the line y = 0; a path is as far from it as its first point's y.
pub(crate) fn clearance_m(_index: usize, points_m: &[[f64; 2]]) -> f64 {
    points_m.first().map_or(f64::INFINITY, |point| point[1])
}

pub(crate) fn span(role: Role, kind: SpanKind, started_us: u64, published_us: u64) -> Span {
    Span {
        role: role.code(),
        kind: kind.code(),
        epoch: 1,
        started_ns: started_us * US,
        published_ns: published_us * US,
        ..Span::default()
    }
}

pub(crate) fn path(id: u64, map: u64, cause: PathCause, y_m: f64) -> PathRecord {
    PathRecord {
        id,
        map,
        run_ns: 0,
        status: PathStatus::Found,
        cause,
        planner: "test".to_owned(),
        length_m: 1.0,
        beside_goal_m: 0.0,
        expanded: 1,
        points_m: vec![[0.0, y_m], [1.0, y_m]],
    }
}

/// One turn of the ring: a scan captured at `t_us`, the map, path `path`, request and command that
/// follow from it, each 100 us of work and 10 us on the way.
pub(crate) fn turn(records: &mut Records, n: u64, t_us: u64, path: u64) {
    let answer = SpanKind::Answer;
    let robot = span(Role::Robot, answer, t_us, t_us + 50);
    let capture_ns = t_us * US;
    records.spans.push(Span {
        scan: n,
        output: n,
        capture_ns,
        raw_ns: capture_ns + AHEAD_NS,
        ..robot
    });
    let mapping = span(Role::Mapping, answer, t_us + 60, t_us + 160);
    records.spans.push(Span {
        scan: n,
        output: n,
        capture_ns,
        ..mapping
    });
    let global = span(Role::GlobalPlanner, answer, t_us + 170, t_us + 270);
    records.spans.push(Span {
        map: n,
        output: n,
        capture_ns,
        ..global
    });
    let local = span(Role::LocalPlanner, answer, t_us + 280, t_us + 380);
    records.spans.push(Span {
        scan: n,
        path,
        output: n,
        capture_ns,
        ..local
    });
    let guard = span(Role::CollisionGuard, answer, t_us + 390, t_us + 490);
    records.spans.push(Span {
        scan: n,
        request: n,
        output: n,
        capture_ns,
        ..guard
    });
    let applied = span(Role::Robot, SpanKind::Applied, t_us + 500, 0);
    records.spans.push(Span {
        request: n,
        raw_ns: applied.started_ns + AHEAD_NS,
        ..applied
    });
}

/// A drive along y = 0; the obstacle appears at 199 900 us and is first seen by scan 2.
pub(crate) fn drive() -> Records {
    let mut records = Records::default();
    turn(&mut records, 1, 100_000, 1);
    records.paths.push(path(1, 1, PathCause::Goal, 0.0));
    records.sightings.push(Sighting {
        index: 0,
        appeared_run_ns: 0,
        appeared_ns: 199_900 * US,
        first_beam_scan: Some(2),
        first_scan: Some(2),
        first_map: Some(2),
        sensed: Vec::new(),
    });
    records
}

pub(crate) fn near(value: Option<f64>, expected: f64) {
    let value = value.expect("a figure");
    assert!(
        (value - expected).abs() <= expected * 0.002 + 0.1,
        "{value} is not {expected}"
    );
}

/// Hops with stamps before their predecessor, and how many.
pub(crate) fn disorder(latency: &Latency) -> Vec<(&str, u64)> {
    let hops = latency.hops_out_of_order.iter();
    hops.filter(|(_, n)| **n > 0)
        .map(|(hop, n)| (hop.as_str(), *n))
        .collect()
}
