//! The measures on fixtures: hand-made records with times that can be added in the head.

use zeronav::measure::index::{PathRecord, Records, Sighting};
use zeronav::measure::{EventOutcome, measure};
use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};

/// Microseconds in nanoseconds.
const US: u64 = 1000;
/// Deadline of the fixtures.
const DEADLINE_NS: u64 = 1_000_000 * US;
/// Radius of the robot. [m]
const RADIUS_M: f64 = 0.25;

/// The obstacle stands on the line y = 0; a path is as far from it as its first point's y.
fn clearance_m(_index: usize, points_m: &[[f64; 2]]) -> f64 {
    points_m.first().map_or(f64::INFINITY, |point| point[1])
}

fn span(role: Role, kind: SpanKind, started_us: u64, published_us: u64) -> Span {
    Span {
        role: role.code(),
        kind: kind.code(),
        epoch: 1,
        started_ns: started_us * US,
        published_ns: published_us * US,
        ..Span::default()
    }
}

fn path(id: u64, map: u64, cause: PathCause, y_m: f64) -> PathRecord {
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
fn turn(records: &mut Records, n: u64, t_us: u64, path: u64) {
    let answer = SpanKind::Answer;
    let robot = span(Role::Robot, answer, t_us, t_us + 50);
    let capture_ns = t_us * US;
    records.spans.push(Span {
        scan: n,
        output: n,
        capture_ns,
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
        ..applied
    });
}

/// A drive along y = 0; the obstacle appears at 199 900 us and is first seen by scan 2.
fn drive() -> Records {
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
    });
    records
}

fn near(value: Option<f64>, expected: f64) {
    let value = value.expect("a figure");
    assert!(
        (value - expected).abs() <= expected * 0.002 + 0.1,
        "{value} is not {expected}"
    );
}

#[test]
fn an_answered_event_is_measured_hop_by_hop() {
    let mut records = drive();
    turn(&mut records, 2, 200_000, 2);
    records.paths.push(path(2, 2, PathCause::Obstacle, 2.0));
    let (events, latency) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
    assert_eq!(events[0].outcome, EventOutcome::Answered);
    assert_eq!(events[0].replanning_ns, Some(490 * US));
    assert_eq!(events[0].event_to_motion_ns, Some(600 * US));
    assert_eq!(events[0].closure_error_ns, Some(0));
    let hops_us = [0, 50, 10, 100, 10, 100, 10, 100, 10, 100, 10];
    assert_eq!(events[0].hops_ns, Some(hops_us.map(|hop| hop * US)));
    assert_eq!(latency.replanning.n, 1);
    near(latency.replanning.p50_us, 490.0);
    // The first scan came before anybody followed a path.
    assert_eq!((latency.reaction.n, latency.reaction.censored), (1, 0));
    near(latency.reaction.p50_us, 490.0);
    assert_eq!(latency.closure_error_ns_max, Some(0));
}

#[test]
fn a_path_that_ignores_the_obstacle_is_no_answer() {
    let mut records = drive();
    turn(&mut records, 2, 200_000, 2);
    // Caused by it, made from the right map, and straight through it all the same.
    records.paths.push(path(2, 2, PathCause::Obstacle, 0.1));
    let (events, latency) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
    assert_eq!(events[0].outcome, EventOutcome::Censored);
    assert_eq!((latency.replanning.n, latency.replanning.censored), (1, 1));
    near(latency.replanning.max_us, 1_000_000.0);
    // One scan later it is answered, and the time still counts from the first sight.
    turn(&mut records, 3, 300_000, 3);
    records.paths.push(path(3, 3, PathCause::Obstacle, 2.0));
    let (events, _) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
    assert_eq!(events[0].outcome, EventOutcome::Answered);
    assert_eq!(events[0].replanning_ns, Some(100_490 * US));
    assert_eq!(
        events[0].hops_ns.map(|hops| hops[0]),
        Some(100_000 * US),
        "the wait is in detect"
    );
    assert_eq!(events[0].closure_error_ns, Some(0));
}

#[test]
fn a_clear_path_for_another_reason_is_no_answer() {
    let mut records = drive();
    turn(&mut records, 2, 200_000, 2);
    records.paths.push(path(2, 2, PathCause::Shortcut, 2.0));
    let (events, _) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
    assert_eq!(events[0].outcome, EventOutcome::Censored);
}

#[test]
fn an_answer_before_three_beams_counts_from_the_first_beam() {
    let mut records = drive();
    turn(&mut records, 2, 200_000, 2);
    records.paths.push(path(2, 2, PathCause::Obstacle, 2.0));
    records.sightings[0].first_scan = None;
    records.sightings[0].first_map = None;
    let (events, latency) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
    assert_eq!(events[0].outcome, EventOutcome::Early);
    assert_eq!(latency.early, 1);
    assert_eq!(events[0].replanning_ns, Some(490 * US));
}

#[test]
fn an_obstacle_beside_the_path_asks_for_nothing() {
    let mut records = drive();
    records.paths[0].points_m = vec![[0.0, 1.0], [1.0, 1.0]];
    turn(&mut records, 2, 200_000, 1);
    let (events, latency) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
    assert_eq!(events[0].outcome, EventOutcome::NotInTheWay);
    assert_eq!((latency.replanning.n, latency.not_in_the_way), (0, 1));
    assert_eq!(latency.replanning.p50_us, None);
}

#[test]
fn an_answer_after_the_deadline_is_censored() {
    let mut records = drive();
    turn(&mut records, 2, 200_000, 1);
    turn(&mut records, 20, 2_000_000, 20);
    records.paths.push(path(20, 20, PathCause::Obstacle, 2.0));
    let (events, latency) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
    assert_eq!(events[0].outcome, EventOutcome::Censored);
    assert_eq!(latency.replanning.censored, 1);
}

#[test]
fn a_delay_in_one_process_shows_in_its_hop_and_nowhere_else() {
    let figures = |delay_us: u64| {
        let mut records = drive();
        turn(&mut records, 2, 200_000, 2);
        records.paths.push(path(2, 2, PathCause::Obstacle, 2.0));
        let planned = 200_270 * US;
        for span in &mut records.spans {
            // Everything from the planner's answer on comes later.
            if span.published_ns >= planned || (span.request == 2 && span.output == 0) {
                span.published_ns += delay_us * US;
                if span.role != Role::GlobalPlanner.code() {
                    span.started_ns += delay_us * US;
                }
            }
        }
        measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS)
            .0
            .remove(0)
    };
    let (plain, delayed) = (figures(0), figures(5000));
    let hops = |hops: Option<[u64; 11]>| hops.expect("hops");
    for (n, (before, after)) in hops(plain.hops_ns)
        .iter()
        .zip(hops(delayed.hops_ns))
        .enumerate()
    {
        let more = if n == 5 { 5000 * US } else { 0 };
        assert_eq!(after, before + more, "hop {n}");
    }
    assert_eq!(delayed.closure_error_ns, Some(0));
}
