//! What an answer sends, rings and records.

use super::*;

#[test]
fn what_an_answer_sent_is_read_by_others_and_recorded() {
    let mut bench = Bench::new(RunMode::Lockstep);
    let mut reader = bench.tap.stream::<ControlRequest>().expect("a reader");
    bench.shell.wait(0);
    let parents = Parents {
        odometry: 1,
        scan: 2,
        map: 3,
        path: 4,
        request: 5,
        goal: 6,
    };
    let draft = bench.shell.begin(answer_to(3), 60, 50, parents);
    let first = bench.send(&draft, 0.1).expect("sent");
    let second = bench
        .shell
        .send_with(&draft, &mut bench.writer, 0, |_| ask(0.2))
        .expect("sent");
    assert_eq!([first.id, second.id], [1, 2].map(|n| Id::new(5, n)));
    bench.shell.finish(&draft, Some(second), 77);
    let mut heard = Vec::new();
    reader.drain(&bench.stage.words().roster(), |view| {
        heard.push((view.header.id(), *view.meta));
    });
    assert_eq!(heard, [(first.id, ask(0.1)), (second.id, ask(0.2))]);
    let span = bench.span();
    assert_eq!((span.role(), span.epoch), (Some(Role::LocalPlanner), 5));
    assert_eq!((span.kind(), span.tick), (Some(SpanKind::Answer), 3));
    let parents = [
        span.odometry,
        span.scan,
        span.map,
        span.path,
        span.request,
        span.goal,
    ];
    assert_eq!(parents, [1, 2, 3, 4, 5, 6]);
    assert_eq!(
        (span.output, span.published_ns),
        (second.id.0, second.published_ns)
    );
    let moments = (draft.capture_ns, draft.woken_ns, draft.started_ns);
    assert_eq!((span.capture_ns, span.woken_ns, span.started_ns), moments);
    assert_eq!(span.work, 77);
    // The prime of FNV; each message of the answer changes it, in order.
    let prime = 0x0000_0100_0000_01b3;
    assert_eq!(span.hash, first.hash.wrapping_mul(prime) ^ second.hash);
    assert!(first.hash != 0 && second.hash != 0);
    // The next answer begins anew.
    let next = bench.begin(answer_to(4));
    let writer = &mut bench.writer;
    let sent = bench.shell.answer(&next, writer, ask(0.3), &[]);
    let span = bench.span();
    assert_eq!(span.hash, sent.expect("sent").hash);
    assert_eq!(span.output, Id::new(5, 3).0);
}

#[test]
fn a_message_rings_its_readers_when_the_answer_ends() {
    let mut bench = Bench::new(RunMode::RealTime);
    let (guard, mapping) = (bench.bell(Role::CollisionGuard), bench.bell(Role::Mapping));
    let event = ControlRequest::ROW.number;
    let draft = bench.begin(answer_to(1));
    let sent = bench.send(&draft, 0.1);
    assert_eq!(guard.rung(), Rung::default(), "the answer goes on");
    bench.shell.finish(&draft, sent, 0);
    assert!(guard.rung().has(event));
    assert_eq!(mapping.rung(), Rung::default(), "it does not read it");
    bench.shell.ring();
    assert_eq!(guard.rung(), Rung::default(), "once a message");
    bench.send(&draft, 0.1);
    bench.shell.ring();
    assert!(guard.rung().has(event));
}

#[test]
fn in_lockstep_odometry_rings_those_who_count_ticks_too_and_records_ring_the_robot() {
    for (mode, rings) in [(RunMode::RealTime, false), (RunMode::Lockstep, true)] {
        let mut bench = Bench::new(mode);
        let (robot, mapping) = (bench.bell(Role::Robot), bench.bell(Role::Mapping));
        let draft = bench.begin(answer_to(1));
        bench.shell.finish(&draft, None, 0);
        assert_eq!(robot.rung().has(SPANS.number), rings, "{mode}");
        let mut shell = bench.stage.open(Role::Robot, 2);
        let mut writer = shell.peer().writer::<RobotOdometry>(0).expect("a writer");
        let sent = shell.answer(&draft, &mut writer, Odometry::default(), &[]);
        assert!(sent.is_some());
        assert_eq!(
            mapping.rung().has(RobotOdometry::ROW.number),
            rings,
            "{mode}"
        );
    }
}

#[test]
fn an_event_without_a_message_rings_the_role_that_it_is_for() {
    let bench = Bench::new(RunMode::RealTime);
    let (mapping, guard) = (bench.bell(Role::Mapping), bench.bell(Role::CollisionGuard));
    bench.shell.ring_event(Role::Mapping, 33);
    assert!(mapping.rung().has(33));
    assert_eq!(guard.rung(), Rung::default());
}

#[test]
fn a_message_beside_the_answers_neither_rings_nor_counts() {
    let mut bench = Bench::new(RunMode::Lockstep);
    let guard = bench.bell(Role::CollisionGuard);
    let draft = bench.begin(answer_to(1));
    assert!(draft.hashed);
    let sent = bench
        .shell
        .send_aside(&draft, &mut bench.writer, ask(0.1), &[])
        .expect("sent");
    assert_eq!((sent.id, sent.hash), (Id::new(5, 1), 0));
    bench.shell.finish(&draft, None, 0);
    assert_eq!(guard.rung(), Rung::default());
    assert_eq!(bench.span().hash, 0);
}
