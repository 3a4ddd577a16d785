//! Events and reactions: what is answered, when, and what is not.

use crate::fixture::{
    DEADLINE_NS, RADIUS_M, US, clearance_m, disorder, drive, near, path, span, turn,
};
use zeronav_measure::index::{PathRecord, Records, Sensed};
use zeronav_measure::{EventOutcome, measure, reactions};
use zeronav_msgs::path::PathCause;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;

#[test]
fn an_answered_event_is_measured_hop_by_hop() {
    let mut records = drive();
    turn(&mut records, 2, 200_000, 2);
    records.paths.push(path(2, 2, PathCause::Obstacle, 2.0));
    let (events, latency) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
    assert_eq!(events[0].outcome, EventOutcome::Answered);
    assert_eq!(events[0].replanning_ns, Some(490 * US));
    assert_eq!(events[0].event_to_motion_ns, Some(600 * US));
    let hops_us = [0, 50, 10, 100, 10, 100, 10, 100, 10, 100, 10];
    assert_eq!(events[0].hops_ns(), Some(hops_us.map(|hop| hop * US)));
    assert_eq!(latency.replanning.n, 1);
    near(latency.replanning.p50_us, 490.0);
    // The first scan came before anybody followed a path.
    assert_eq!((latency.reaction.n, latency.reaction.censored), (1, 0));
    near(latency.reaction.p50_us, 490.0);
    assert_eq!(disorder(&latency), []);
    assert_eq!((latency.ways, latency.ways_broken), (2, 0));
    let clock = latency.second_clock.expect("readings of it");
    assert_eq!((clock.end_to_end.n, clock.beyond), (2, 0));
    near(clock.end_to_end.p50_us, 500.0);
    near(clock.difference.max_us, 0.0);
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
        events[0].hops_ns().map(|hops| hops[0]),
        Some(100_000 * US),
        "the wait is in detect"
    );
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
fn an_unanswered_reaction_is_censored_and_never_dropped() {
    let figures = |records: &Records| {
        let figures = reactions(records, DEADLINE_NS).figures(DEADLINE_NS);
        (figures.n, figures.censored)
    };
    let driving = || {
        let mut records = drive();
        turn(&mut records, 2, 200_000, 2);
        records
    };
    let later = |records: &mut Records, t_us: u64| {
        let robot = span(Role::Robot, SpanKind::Answer, t_us, t_us);
        records.spans.push(robot);
    };
    let without = |records: &mut Records, role: Role| {
        records
            .spans
            .retain(|span| span.role != role.code() || span.output != 3);
    };
    let mut answered = driving();
    turn(&mut answered, 3, 300_000, 3);
    assert_eq!(figures(&answered), (2, 0));
    for role in [Role::LocalPlanner, Role::CollisionGuard] {
        let mut records = driving();
        turn(&mut records, 3, 300_000, 3);
        without(&mut records, role);
        // So far the records say nothing about it.
        assert_eq!(figures(&records), (1, 0), "{role}");
        later(&mut records, 1_300_001);
        assert_eq!(figures(&records), (2, 1), "{role}");
    }
    // One that is answered, but after the deadline.
    let mut records = driving();
    turn(&mut records, 3, 300_000, 3);
    without(&mut records, Role::LocalPlanner);
    turn(&mut records, 14, 1_400_000, 3);
    assert_eq!(figures(&records), (3, 1));
}

#[test]
fn a_path_is_judged_by_what_had_been_seen_of_the_obstacle() {
    // Of a disc of 0.3 m around (3, 0) the scan sees the front; the path passes it by 0.32 m and
    // cuts in behind it.
    let front_m = [[2.7, 0.0], [2.75, 0.15], [2.85, 0.25]];
    let whole_m = [
        front_m.to_vec(),
        vec![[3.15, 0.25], [3.25, 0.15], [3.3, 0.0]],
    ]
    .concat();
    let round = [[0.0, 0.0], [2.4, 0.4], [3.0, 0.62]];
    let cuts_in = [&round[..], &[[3.4, 0.15], [6.0, 0.0]]].concat();
    let around = [&round[..], &[[3.3, 0.62], [6.0, 0.0]]].concat();
    let disc_m = |_: usize, points_m: &[[f64; 2]]| {
        let near_m = |point: &[f64; 2]| (point[0] - 3.0).hypot(point[1]) - 0.3;
        points_m.iter().map(near_m).fold(f64::INFINITY, f64::min)
    };
    let run = |first: &[[f64; 2]], then: Option<&[[f64; 2]]>, seen_later: bool| {
        let mut records = drive();
        records.paths[0].points_m = vec![[0.0, 0.0], [3.0, 0.0], [6.0, 0.0]];
        let seen = |map, cells_m: &[[f64; 2]]| Sensed {
            map,
            cells_m: cells_m.to_vec(),
        };
        records.sightings[0].sensed.push(seen(2, &front_m));
        if seen_later {
            records.sightings[0].sensed.push(seen(4, &whole_m));
        }
        for n in 2..=5 {
            turn(&mut records, n, n * 100_000, n);
        }
        let found = |id, points_m: &[[f64; 2]]| PathRecord {
            points_m: points_m.to_vec(),
            ..path(id, id, PathCause::Obstacle, 0.0)
        };
        records.paths.push(found(2, first));
        if let Some(then) = then {
            records.paths.push(found(4, then));
        }
        let (mut events, latency) = measure(&records, &disc_m, RADIUS_M, DEADLINE_NS);
        let event = events.remove(0);
        let replanning_us = event.replanning_ns.map(|time| time / US);
        (event.outcome, replanning_us, event.revised, latency.revised)
    };
    let answered = EventOutcome::Answered;
    assert_eq!(run(&around, None, true), (answered, Some(490), 0, 0));
    assert_eq!(run(&cuts_in, None, false), (answered, Some(490), 0, 0));
    // Its back comes into sight, and another path makes good for it.
    let corrected = run(&cuts_in, Some(&around), true);
    assert_eq!(corrected, (answered, Some(490), 1, 1));
    // Another path for the same reason, though nothing was wrong with the first.
    assert_eq!(
        run(&around, Some(&cuts_in), true),
        (answered, Some(490), 0, 0)
    );
    // Through what had been seen: no answer, until one leads around it.
    let ignores = vec![[0.0, 0.0], [6.0, 0.0]];
    let ignored = (EventOutcome::Censored, None, 0, 0);
    assert_eq!(run(&ignores, None, true), ignored);
    let late = run(&ignores, Some(&around), true);
    assert_eq!(late, (answered, Some(200_490), 0, 0));
}
