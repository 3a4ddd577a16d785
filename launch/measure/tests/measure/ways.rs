//! Hops: their order, their records, and the robot's second clock.

use crate::fixture::{DEADLINE_NS, RADIUS_M, US, clearance_m, disorder, drive, near, path, turn};
use zeronav_measure::measure;
use zeronav_measure::result::latency::Latency;
use zeronav_msgs::path::PathCause;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_observe::hop_chain::{DIRECT, HOPS, HopChain, THROUGH_MAP};

/// The drive with its answer, `change` applied to the spans of the second turn.
fn changed(change: impl Fn(&mut Span)) -> Latency {
    let mut records = drive();
    let first = records.spans.len();
    turn(&mut records, 2, 200_000, 2);
    records.paths.push(path(2, 2, PathCause::Obstacle, 2.0));
    records.spans[first..].iter_mut().for_each(change);
    measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS).1
}

/// What is done to a record.
type Swap = fn(&mut Span);

#[test]
fn a_stamp_before_its_predecessor_is_counted_at_its_hop_and_nowhere_else() {
    let of =
        |role: Role, span: &Span| span.role == role.code() && span.kind() == Some(SpanKind::Answer);
    // A reading that lies 1 us before the boundary before it, and the hop between the two.
    let swaps: [(Role, Swap, &str); 9] = [
        (
            Role::Robot,
            |span| span.published_ns = span.capture_ns - US,
            "robot",
        ),
        (
            Role::Mapping,
            |span| span.started_ns -= 11 * US,
            "to_mapping",
        ),
        (
            Role::Mapping,
            |span| span.published_ns = span.started_ns - US,
            "mapping",
        ),
        (
            Role::GlobalPlanner,
            |span| span.started_ns -= 11 * US,
            "to_global_planner",
        ),
        (
            Role::GlobalPlanner,
            |span| span.published_ns = span.started_ns - US,
            "global_planner",
        ),
        (
            Role::LocalPlanner,
            |span| span.started_ns -= 11 * US,
            "to_local_planner",
        ),
        (
            Role::LocalPlanner,
            |span| span.published_ns = span.started_ns - US,
            "local_planner",
        ),
        (
            Role::CollisionGuard,
            |span| span.started_ns -= 11 * US,
            "to_collision_guard",
        ),
        (
            Role::CollisionGuard,
            |span| span.published_ns = span.started_ns - US,
            "collision_guard",
        ),
    ];
    for (role, swap, hop) in swaps {
        let latency = changed(|span| {
            if of(role, span) {
                swap(span);
            }
        });
        assert_eq!(disorder(&latency), [(hop, 1)]);
    }
    let applied_early = changed(|span| {
        if span.kind() == Some(SpanKind::Applied) {
            span.started_ns -= 11 * US;
        }
    });
    assert_eq!(disorder(&applied_early), [("to_robot", 1)]);
}

#[test]
fn a_stamp_before_that_of_the_scan_before_it_is_out_of_order_in_detect() {
    let mut records = drive();
    turn(&mut records, 2, 200_000, 2);
    turn(&mut records, 3, 300_000, 3);
    records.paths.push(path(3, 3, PathCause::Obstacle, 2.0));
    for span in records.spans.iter_mut().filter(|span| span.scan == 2) {
        span.capture_ns = 300_001 * US;
    }
    let (_, latency) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
    assert_eq!(latency.hops_out_of_order["detect"], 1);
}

#[test]
fn a_way_whose_record_is_missing_is_counted() {
    for role in [
        Role::Robot,
        Role::Mapping,
        Role::GlobalPlanner,
        Role::LocalPlanner,
        Role::CollisionGuard,
    ] {
        let mut records = drive();
        turn(&mut records, 2, 200_000, 2);
        turn(&mut records, 3, 300_000, 3);
        records.paths.push(path(2, 2, PathCause::Obstacle, 2.0));
        let (_, whole) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
        assert_eq!((whole.ways, whole.ways_broken), (3, 0), "{role}");
        records.spans.retain(|span| {
            let answer = span.kind() == Some(SpanKind::Answer);
            !(answer && span.role == role.code() && span.output == 2)
        });
        let (_, latency) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
        assert_eq!(latency.ways, 2, "{role}");
        assert!(latency.ways_broken > 0, "{role}");
    }
}

#[test]
fn what_came_before_the_records_is_not_missing() {
    let mut records = drive();
    turn(&mut records, 2, 200_000, 2);
    // The collector has let go of the first planner's and mapping's records.
    records.spans.retain(|span| {
        let early = span.role == Role::Mapping.code() || span.role == Role::GlobalPlanner.code();
        !(early && span.output == 1)
    });
    let (_, latency) = measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS);
    assert_eq!((latency.ways, latency.ways_broken), (1, 0));
}

#[test]
fn stamps_that_are_forged_together_show_on_the_second_clock() {
    let ms = 1_000 * US;
    for role in [
        Role::Mapping,
        Role::GlobalPlanner,
        Role::LocalPlanner,
        Role::CollisionGuard,
    ] {
        let latency = changed(|span| {
            if span.role == role.code() {
                span.started_ns += ms;
                span.published_ns += ms;
            }
        });
        let clock = latency.second_clock.expect("readings of it");
        assert_eq!(clock.beyond, 1, "{role}");
        // The transport behind takes 10 us, so 990 us of the millisecond do not fit.
        near(clock.difference.max_us, 990.0);
    }
    // The robot's own stamp of the capture, in order and still wrong.
    let latency = changed(|span| {
        if span.scan == 2 && span.role == Role::Robot.code() {
            span.capture_ns -= ms;
        }
    });
    assert_eq!(disorder(&latency), []);
    let clock = latency.second_clock.expect("readings of it");
    assert_eq!(clock.beyond, 1);
    near(clock.difference.max_us, 1000.0);
}

#[test]
fn the_clocks_may_differ_by_their_slew_and_two_readings() {
    let way = |second_ns: u64| HopChain {
        hops: &DIRECT[..1],
        boundaries_ns: vec![5, 1_000_000_005],
        second_ns: Some(second_ns),
    };
    let most_ns = 500_000 + 40_000;
    for (second_ns, beyond) in [
        (1_000_000_000, false),
        (1_000_000_000 + most_ns, false),
        (1_000_000_000 - most_ns, false),
        (1_000_000_000 + most_ns + 1, true),
        (1_000_000_000 - most_ns - 1, true),
    ] {
        assert_eq!(way(second_ns).is_beyond(), beyond, "{second_ns}");
    }
    let without = HopChain {
        second_ns: None,
        ..way(0)
    };
    assert!(!without.is_beyond());
    assert_eq!(without.difference_ns(), None);
}

#[test]
fn a_delay_in_one_process_shows_in_its_hop_and_nowhere_else() {
    let figures = |role: Role, delay_us: u64| {
        let mut records = drive();
        let first = records.spans.len();
        turn(&mut records, 2, 200_000, 2);
        records.paths.push(path(2, 2, PathCause::Obstacle, 2.0));
        let answers = |span: &&Span| span.role == role.code() && span.output == 2;
        let from_ns = records.spans[first..].iter().find(answers);
        let from_ns = from_ns.expect("its answer").published_ns;
        for span in &mut records.spans[first..] {
            // Everything from its answer on comes later.
            let applied = span.kind() == Some(SpanKind::Applied);
            if span.published_ns >= from_ns || applied {
                span.published_ns += delay_us * US;
                span.raw_ns += if applied { delay_us * US } else { 0 };
                if span.role != role.code() || applied {
                    span.started_ns += delay_us * US;
                }
            }
        }
        measure(&records, &clearance_m, RADIUS_M, DEADLINE_NS)
    };
    let roles = [
        (Role::Mapping, 3),
        (Role::GlobalPlanner, 5),
        (Role::LocalPlanner, 7),
        (Role::CollisionGuard, 9),
    ];
    for (role, place) in roles {
        let (plain, _) = figures(role, 0);
        let (delayed, latency) = figures(role, 5000);
        let hops = |hops: Option<[u64; HOPS.len()]>| hops.expect("hops");
        let pairs = hops(plain[0].hops_ns());
        for (n, (before, after)) in pairs.iter().zip(hops(delayed[0].hops_ns())).enumerate() {
            let more = if n == place { 5000 * US } else { 0 };
            assert_eq!(after, before + more, "{role}, {}", HOPS[n]);
        }
        // The same in the table of every scan, and the second clock agrees.
        for (row, place) in latency.every_scan.through_map.iter().zip(THROUGH_MAP) {
            assert_eq!((row.name.as_str(), row.figures.n), (HOPS[place], 2));
        }
        let row = latency.every_scan.through_map.iter();
        let worst = row.map(|hop| hop.figures.max_us.expect("a time"));
        near(worst.reduce(f64::max), 5100.0);
        assert_eq!(latency.second_clock.expect("readings of it").beyond, 0);
    }
}
