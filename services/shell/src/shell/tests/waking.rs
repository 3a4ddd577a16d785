//! Seats, waits, and what is due and how an answer begins.

use super::*;

#[test]
fn a_process_in_its_seat_may_be_obeyed_and_a_shadow_never() {
    let mut stage = stage(RunMode::RealTime);
    let seated = stage.open(Role::LocalPlanner, 5);
    assert!(seated.is_obeyable());
    assert_eq!(seated.peer().epoch(), 5);
    let shadow = stage.open_shadow(Role::LocalPlanner);
    assert!(!shadow.is_obeyable());
    assert!(shadow.peer().epoch() >= SHADOW_EPOCH_MIN);
    let mut flags = stage.flags(&["--epoch", "6"]);
    flags.shadow = true;
    let both = stage
        .open_with(&flags, Role::CollisionGuard)
        .expect("a shell");
    assert!(!both.is_obeyable(), "a shadow takes no seat");
    assert!(both.peer().epoch() >= SHADOW_EPOCH_MIN);
}

#[test]
fn a_seat_that_is_taken_or_expects_another_is_refused_by_name() {
    let mut stage = stage(RunMode::RealTime);
    let _seated = stage.open(Role::LocalPlanner, 5);
    for (role, epoch, problem) in [
        (
            Role::LocalPlanner,
            "5",
            "the seat of local_planner is taken by",
        ),
        (Role::Mapping, "2", "the seat of mapping expects --epoch 3"),
    ] {
        let flags = stage.flags(&["--epoch", epoch]);
        let error = stage.open_with(&flags, role).expect_err(problem);
        assert!(matches!(error, StartError::Usage(_)), "{error}");
        assert!(error.to_string().contains(problem), "{error}");
    }
}

#[test]
fn a_ring_ends_the_wait_and_says_its_event() {
    let mut bench = Bench::new(RunMode::RealTime);
    Bells::open(&bench.tap)
        .expect("the doorbells")
        .ring(Role::LocalPlanner, 40);
    let before_ns = now_ns();
    let rung = bench.shell.wait(before_ns + SECOND_NS);
    assert!(rung.has(40) && !rung.has(39), "{rung:?}");
    let woken_ns = bench.shell.woken_ns();
    assert!((before_ns..=now_ns()).contains(&woken_ns));
    assert_eq!(bench.shell.roster().woken_ns, woken_ns);
}

#[test]
fn a_wake_takes_in_what_launch_says() {
    let mut stage = stage(RunMode::RealTime);
    let mut shell = stage.open(Role::LocalPlanner, 5);
    assert_eq!(shell.roster().seats, stage.words().seats);
    stage.say(Words::of(RunMode::RealTime, &SEATS[3..]));
    shell.wait(0);
    assert_eq!(shell.roster().seats, stage.words().seats);
}

#[test]
fn the_next_wake_is_the_earliest_that_was_asked_for_since_the_last() {
    let mut bench = Bench::new(RunMode::RealTime);
    assert_eq!(bench.shell.wake_by_ns(), u64::MAX);
    bench.shell.wake_by(500);
    bench.shell.wake_by(900);
    assert_eq!(bench.shell.wake_by_ns(), 500);
    bench.shell.wait(0);
    assert_eq!(bench.shell.wake_by_ns(), u64::MAX);
}

#[test]
fn while_messages_are_late_on_purpose_they_are_looked_for_between_rings() {
    let mut stage = stage(RunMode::RealTime);
    let mut shell = stage.open(Role::LocalPlanner, 5);
    let mut control = RunControl::default();
    control.topic_faults[1] = TopicFault {
        kind: TopicFaultKind::Delay.code(),
        delay_us: 5,
        ..TopicFault::default()
    };
    stage.say(Words {
        control,
        ..Words::of(RunMode::RealTime, &SEATS)
    });
    shell.wait(0);
    assert_eq!(shell.wake_by_ns(), shell.woken_ns() + link::LOOK_NS);
}

#[test]
fn run_time_is_counted_in_ticks() {
    let bench = Bench::new(RunMode::RealTime);
    assert_eq!(
        [0, 1, 3].map(|tick| bench.shell.run_ns(tick)),
        [0, TICK_NS, 3 * TICK_NS]
    );
}

#[test]
fn nothing_is_due_before_the_clock_is_known() {
    let mut stage = stage(RunMode::RealTime);
    let mut shadow = stage.open_shadow(Role::LocalPlanner);
    assert_eq!(shadow.due(&complete(1)).count(), 0);
    stage.say(Words::of(RunMode::RealTime, &SEATS));
    shadow.wait(0);
    let due: Vec<Due> = shadow.due(&complete(1)).collect();
    assert_eq!(due, [Due::IDLE, answer_to(1)]);
}

#[test]
fn the_idle_output_comes_first_and_makes_the_service_ready() {
    let mut bench = Bench::new(RunMode::RealTime);
    assert_eq!(bench.due(Trigger::default()), [Due::IDLE]);
    let draft = bench.begin(Due::IDLE);
    bench.shell.finish(&draft, None, 0);
    assert_eq!(bench.how(SECOND_NS).0, Some(HealthState::Starting));
    assert_eq!(
        bench.due(Trigger::default()),
        [Due::IDLE],
        "it was not sent"
    );
    let sent = bench.send(&draft, 0.0);
    bench.shell.finish(&draft, sent, 0);
    assert_eq!(bench.how(SECOND_NS + 1).0, Some(HealthState::Ready));
    assert_eq!(bench.due(Trigger::default()), []);
    assert_eq!(bench.shell.answered_tick(), 0);
}

#[test]
fn an_answer_to_a_tick_is_due_once() {
    let mut bench = Bench::new(RunMode::RealTime);
    assert_eq!(bench.due(complete(7)), [Due::IDLE, answer_to(7)]);
    let draft = bench.begin(answer_to(7));
    bench.shell.finish(&draft, None, 0);
    assert_eq!(bench.shell.answered_tick(), 7);
    assert_eq!(bench.due(complete(7)), [Due::IDLE]);
    let late = bench.begin(answer_to(6));
    bench.shell.finish(&late, None, 0);
    assert_eq!(bench.shell.answered_tick(), 7, "the newest one counts");
}

#[test]
fn an_answer_that_waits_for_an_input_brings_the_next_wake_forward() {
    let mut bench = Bench::new(RunMode::RealTime);
    let deadline_ns = now_ns() + 3600 * SECOND_NS;
    let waiting = Trigger {
        tick: 1,
        deadline_ns: Some(deadline_ns),
        ..Trigger::default()
    };
    assert_eq!(bench.due(waiting), [Due::IDLE]);
    assert_eq!(bench.shell.wake_by_ns(), deadline_ns);
}

#[test]
fn a_draft_says_what_is_answered_and_when_it_began() {
    let mut bench = Bench::new(RunMode::RealTime);
    bench.shell.wait(0);
    let parents = Parents {
        odometry: 8,
        ..Parents::default()
    };
    let before_ns = now_ns();
    let draft = bench.shell.begin(answer_to(3), 60, 50, parents);
    assert_eq!((draft.tick, draft.kind), (3, SpanKind::Answer));
    assert_eq!((draft.run_ns, draft.capture_ns), (60, 50));
    assert_eq!(draft.parents, parents);
    assert_eq!(draft.woken_ns, bench.shell.woken_ns());
    assert!((before_ns..=now_ns()).contains(&draft.started_ns));
}

#[test]
fn in_lockstep_the_answers_to_ticks_count_for_the_hash_of_the_run() {
    for (mode, tick, counts) in [
        (RunMode::Lockstep, 0, false),
        (RunMode::Lockstep, 1, true),
        (RunMode::Lockstep, 2, true),
        (RunMode::RealTime, 0, false),
        (RunMode::RealTime, 1, false),
    ] {
        let mut bench = Bench::new(mode);
        let draft = bench.begin(answer_to(tick));
        assert_eq!(draft.hashed, counts, "{mode}, tick {tick}");
        let sent = bench.send(&draft, 0.5).expect("sent");
        assert_eq!(sent.hash != 0, counts, "{mode}, tick {tick}");
    }
}

#[test]
fn a_delay_that_launch_injects_is_spent_in_answers_and_recorded_as_time_off_the_processor() {
    let mut bench = Bench::new(RunMode::RealTime);
    assert_eq!(bench.shell.delay(1), Duration::ZERO);
    let mut words = bench.stage.words().clone();
    // Steps of 10 us.
    words.seats[3].delay = 500;
    bench.stage.say(words);
    bench.shell.wait(0);
    let delays = [0, 1, 2].map(|tick| bench.shell.delay(tick));
    let delay = Duration::from_millis(5);
    assert_eq!(delays, [Duration::ZERO, delay, delay]);
    let draft = bench.begin(answer_to(1));
    assert!(now_ns() >= draft.started_ns + 5_000_000, "it was not spent");
    bench.shell.finish(&draft, None, 0);
    let span = bench.span();
    // The two clocks are read one after the other.
    assert!(span.off_processor_ns > 4_500_000, "{span:?}");
}

#[test]
fn stages_are_timed_when_launch_asks_for_it_in_real_time() {
    for (mode, stages, is_timed) in [
        (RunMode::RealTime, 1, true),
        (RunMode::RealTime, 0, false),
        (RunMode::Lockstep, 1, false),
        (RunMode::Lockstep, 0, false),
    ] {
        let mut words = Words::of(mode, &SEATS);
        words.clock = RunClock {
            stages,
            ..words.clock
        };
        let mut stage = Stage::new(words);
        let shell = stage.open(Role::LocalPlanner, 5);
        let mut timer = shell.stage_timer(0);
        timer.mark(WorkStage::Prepare);
        let took_ns = timer.stages_ns()[WorkStage::Prepare.place()];
        assert_eq!(took_ns > 0, is_timed, "{mode}, {stages}");
    }
}

#[test]
fn the_age_of_an_input_is_that_at_the_beginning_of_the_answer() {
    let message = Received {
        tick: 3,
        run_ns: 60,
        capture_ns: 1_000,
        came_ns: 1_200,
    };
    let draft = Draft {
        run_ns: 100,
        started_ns: 9_000,
        ..Draft::default()
    };
    for (mode, age_ns) in [(RunMode::Lockstep, 40), (RunMode::RealTime, 8_000)] {
        let bench = Bench::new(mode);
        assert_eq!(bench.shell.age_ns(&draft, &message), age_ns, "{mode}");
    }
}
