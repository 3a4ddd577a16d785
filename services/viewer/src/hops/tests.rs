use super::*;

fn span(role: Role, output: u64, started_ns: u64, published_ns: u64) -> Span {
    Span {
        role: role.code(),
        kind: SpanKind::Answer.code(),
        epoch: 1,
        output,
        started_ns,
        published_ns,
        ..Span::default()
    }
}

/// The records of one scan through map and path to the wheels, in the order in which they are read:
/// those of the robot first.
fn cycle(hops: &mut Hops, id: u64, at_ns: u64) -> Option<Taken> {
    take_cycle(hops, id, at_ns);
    hops.settle().or_else(|| hops.settle())
}

fn take_cycle(hops: &mut Hops, id: u64, at_ns: u64) {
    let of =
        |role, output, started, published| span(role, output, at_ns + started, at_ns + published);
    hops.take(&Span {
        scan: id,
        capture_ns: at_ns,
        ..of(Role::Robot, id, 0, 10)
    });
    hops.take(&Span {
        kind: SpanKind::Applied.code(),
        request: id,
        tick: id,
        ..of(Role::Robot, 0, 550, 0)
    });
    hops.take(&Span {
        scan: id,
        ..of(Role::Mapping, id, 30, 60)
    });
    hops.take(&Span {
        map: id,
        ..of(Role::GlobalPlanner, id, 100, 150)
    });
    hops.take(&Span {
        path: id,
        scan: id,
        ..of(Role::LocalPlanner, id, 210, 280)
    });
    hops.take(&Span {
        request: id,
        ..of(Role::CollisionGuard, id, 360, 450)
    });
}

fn lengths_ns(taken: &Taken) -> Vec<u64> {
    taken
        .way
        .lengths_ns()
        .map(|(_, length_ns)| length_ns)
        .collect()
}

#[test]
fn hops_are_differences_of_the_boundaries() {
    let mut hops = Hops::default();
    assert_eq!(cycle(&mut hops, 1, 1_000), None, "no new path was told");
    assert_eq!(hops.replanning(), None);
    hops.new_path(2);
    let taken = cycle(&mut hops, 2, 2_000).expect("a way");
    assert_eq!(hops.replanning(), Some(&taken));
    assert_eq!(taken.way.named_us().last(), Some(("to_robot", 0.1)));
    assert_eq!(
        lengths_ns(&taken),
        [10, 20, 30, 40, 50, 60, 70, 80, 90, 100]
    );
    let direct = hops.direct().expect("a way");
    assert_eq!(lengths_ns(direct), [10, 200, 70, 80, 90, 100]);
    // Later commands on the same path are no replanning.
    assert_eq!(cycle(&mut hops, 3, 9_000), None);
    assert_eq!(hops.replanning().map(|way| way.tick), Some(2));
    assert_eq!(hops.quantiles([0.5]), Some([450]));
}

#[test]
fn what_a_command_rests_on_may_come_after_it() {
    let mut hops = Hops::default();
    take_cycle(&mut hops, 1, 1_000);
    assert_eq!(hops.settle(), None);
    // The path was sent before the command, but is read after it.
    hops.new_path(1);
    take_cycle(&mut hops, 2, 20_000);
    let taken = hops.settle().expect("a way");
    assert_eq!((taken.tick, lengths_ns(&taken)[5]), (1, 60));
    assert_eq!(hops.settle(), None, "later commands are no replanning");
    assert_eq!(hops.direct().map(|way| way.tick), Some(2));
}

#[test]
fn every_scan_counts_once_and_memory_is_bounded() {
    let mut hops = Hops::default();
    for id in 1..2_000 {
        cycle(&mut hops, id, id * 1_000_000);
        cycle(&mut hops, id, id * 1_000_000 + 500);
    }
    let (n, bins) = hops.histogram();
    // All but the first, which came before a path was followed.
    assert_eq!(n, 1_998);
    assert_eq!(bins[0], 1_998);
    assert_eq!(hops.answers.values.len(), KEPT);
    assert_eq!(hops.reactions_ns.len(), REACTIONS);
}

/// Commands of the local planner and of the guard, one of each every 20 ms.
fn commands(hops: &mut Hops, ids: core::ops::Range<u64>, scan: u64, seen: bool) {
    for id in ids {
        let at_ns = id * 20_000_000;
        let local = Span {
            path: 1,
            scan,
            ..span(Role::LocalPlanner, id, at_ns, at_ns + 100)
        };
        let guard = Span {
            request: id,
            ..span(Role::CollisionGuard, id, at_ns + 200, at_ns + 300)
        };
        let applied = Span {
            kind: SpanKind::Applied.code(),
            request: id,
            tick: id,
            ..span(Role::Robot, 0, at_ns + 400, 0)
        };
        for span in [local, guard, applied] {
            if seen {
                hops.take(&span);
            }
        }
    }
    hops.settle();
    hops.settle();
}

fn captured(hops: &mut Hops, scan: u64, at_ns: u64) {
    hops.take(&Span {
        scan,
        capture_ns: at_ns,
        ..span(Role::Robot, scan, at_ns, at_ns + 10)
    });
}

#[test]
fn the_age_of_a_scan_that_is_used_again_is_no_hop() {
    let mut hops = Hops::default();
    captured(&mut hops, 1, 20_000_000 - 50);
    commands(&mut hops, 1..10, 1, true);
    let direct = hops.direct().expect("a way");
    assert_eq!(lengths_ns(direct), [10, 40, 100, 100, 100, 100]);
    let in_use = hops.in_use().expect("a scan");
    assert_eq!((in_use.uses, in_use.age_ns), (9, 160_000_050));
}

#[test]
fn what_rests_on_lost_records_is_counted_and_not_measured() {
    let mut hops = Hops::default();
    let at = |scan: u64| (2 * scan) * 20_000_000 - 50;
    for scan in 1..100 {
        captured(&mut hops, scan, at(scan));
        commands(&mut hops, 2 * scan..2 * scan + 2, scan, true);
    }
    assert_eq!((hops.lost(), hops.histogram().0), ((0, 0), 98));
    assert_eq!(hops.quantiles([0.5]), Some([350]));
    // Three scans go by unseen, and of the fourth only the second use is seen: 20 ms late.
    for scan in 100..104 {
        captured(&mut hops, scan, at(scan));
        commands(&mut hops, 2 * scan..2 * scan + 1, scan, false);
    }
    commands(&mut hops, 207..208, 103, true);
    assert_eq!(hops.lost(), (2 * 7, 4));
    assert_eq!(hops.histogram().0, 98, "none of them was measured");
    assert_eq!(hops.quantiles([0.5]), None, "it would be of the quiet part");
    for scan in 104..204 {
        captured(&mut hops, scan, at(scan));
        commands(&mut hops, 2 * scan..2 * scan + 2, scan, true);
    }
    assert_eq!(hops.quantiles([0.5]), Some([350]), "4 of 202 are few");
}
