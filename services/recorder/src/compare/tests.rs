//! Two recordings beside each other, made by hand.

use super::*;
use crate::fixture::{Written, odometry, recording_until, recording_with, written};
use crate::verdict::{END_TICK, OUTCOME, OUTCOME_INTERRUPTED, VALID, WHY};
use std::io::Cursor;
use zeronav_msgs::topics::{PlanPath, RobotOdometry, RunControlTopic, TopicRow};

fn recording(messages: &[Written]) -> Vec<u8> {
    recording_until(messages, None)
}

fn compared(a: &[Written], b: &[Written]) -> Comparison {
    let (a, b) = (recording(a), recording(b));
    let open = |second: bool| Ok(Cursor::new(if second { b.clone() } else { a.clone() }));
    compare(&Scope::default(), open).expect("compared")
}

#[test]
fn what_the_clock_says_is_no_difference() {
    let a = [
        odometry(1, &[("header.stamps.woken_ns", vec![1])]),
        written(RunControlTopic::ROW, 1, 0, &[("header.id", vec![1])]),
    ];
    let b = [
        odometry(
            1,
            &[
                ("header.stamps.woken_ns", vec![9]),
                ("header.checksum", vec![3]),
            ],
        ),
        written(RunControlTopic::ROW, 1, 0, &[("header.id", vec![7])]),
    ];
    let compared = compared(&a, &b);
    assert_eq!(compared.first, None);
    assert_eq!(compared.topics.len(), 1, "{compared:?}");
    assert_eq!(compared.topics[0].equal, 1);
}

#[test]
fn the_first_difference_is_that_of_the_first_tick_and_of_whoever_computes_first() {
    let path = |tick, cost: f64| {
        let cost = ("meta.cost", cost.to_le_bytes().to_vec());
        written(PlanPath::ROW, 4, tick, &[cost])
    };
    let at = |tick, x: u8| odometry(tick, &[("header.parents.map", vec![x])]);
    // Written in another order, as two recorders may.
    let a = [at(1, 0), path(1, 1.0), at(2, 5), path(2, 2.0), at(3, 0)];
    let b = [path(1, 1.0), at(1, 0), path(2, 3.0), at(2, 6), path(4, 2.0)];
    let compared = compared(&a, &b);
    let first = compared.first.expect("a difference");
    assert_eq!((first.tick, &*first.author), (2, "robot"));
    assert_eq!(first.field.as_deref(), Some("header.parents.map"));
    assert_eq!(
        (first.a.as_deref(), first.b.as_deref()),
        (Some("0:5"), Some("0:6"))
    );
    assert!((first.run_s - 0.04).abs() < 1e-9, "{first:?}");
    let counts =
        |topic: &TopicComparison| [topic.equal, topic.different, topic.only_a, topic.only_b];
    let [plan, robot] = &compared.topics[..] else {
        panic!("{:?}", compared.topics);
    };
    assert_eq!(counts(plan), [1, 1, 0, 1]);
    assert_eq!(counts(robot), [1, 1, 1, 0]);
    let cost = plan.first.as_ref().expect("a difference");
    assert_eq!(cost.field.as_deref(), Some("meta.cost"));
    assert_eq!(
        (cost.a.as_deref(), cost.b.as_deref()),
        (Some("2"), Some("3"))
    );
}

/// While a seat is handed over, two processes answer a tick.
#[test]
fn two_in_a_seat_may_write_in_any_order() {
    let by = |epoch: u32, cost: f64| {
        let id = ("header.id", Id::new(epoch, 9).0.to_le_bytes().to_vec());
        let cost = ("meta.cost", cost.to_le_bytes().to_vec());
        written(PlanPath::ROW, 4, 7, &[id, cost])
    };
    let one = compared(&[by(1, 1.0), by(2, 2.0)], &[by(2, 2.0), by(1, 1.0)]);
    assert_eq!((one.first, one.topics[0].equal), (None, 2));
    // Another start of the same author is the same one.
    let other = compared(&[by(1, 1.0)], &[by(3, 1.0)]);
    assert_eq!((other.first, other.topics[0].equal), (None, 1));
    let first = compared(&[by(1, 1.0), by(2, 2.0)], &[by(2, 5.0), by(1, 1.0)]).first;
    let first = first.expect("a difference");
    assert_eq!(
        (first.a.as_deref(), first.b.as_deref()),
        (Some("2"), Some("5"))
    );
}

/// A successor says that it is there, which is no answer.
#[test]
fn idle_outputs_are_no_difference() {
    let idle = || written(PlanPath::ROW, 4, 0, &[]);
    let answer = || written(PlanPath::ROW, 4, 1, &[]);
    let compared = compared(&[idle(), answer()], &[idle(), answer(), idle()]);
    assert_eq!(compared.first, None);
    assert_eq!(compared.topics[0].equal, 1);
}

#[test]
fn more_items_and_missing_messages_are_differences() {
    let path = |items| written(PlanPath::ROW, 4, 1, &[]).with_items(items);
    let first = compared(&[path(2)], &[path(3)])
        .first
        .expect("a difference");
    assert_eq!(first.field.as_deref(), Some("items"));
    assert_eq!(
        (first.a.as_deref(), first.b.as_deref()),
        (Some("2"), Some("3"))
    );
    let first = compared(&[path(2)], &[odometry(9, &[])])
        .first
        .expect("a difference");
    assert_eq!((first.tick, first.field, first.b), (1, None, None));
    assert!(first.a.is_some());
}

#[test]
fn what_comes_after_the_end_of_the_run_is_not_compared() {
    let with = |ticks: u64, end_tick| {
        let messages: Vec<Written> = (1..=ticks).map(|tick| odometry(tick, &[])).collect();
        recording_until(&messages, end_tick)
    };
    let counts = |end_tick| {
        let (a, b) = (with(7, end_tick), with(9, end_tick));
        let open = |second: bool| Ok(Cursor::new(if second { b.clone() } else { a.clone() }));
        let topics = compare(&Scope::default(), open).expect("compared").topics;
        (topics[0].equal, topics[0].only_a, topics[0].only_b)
    };
    assert_eq!(counts(Some(6)), (5, 0, 0));
    assert_eq!(counts(None), (7, 0, 2));
    // One run ends in the middle: its recording has a little more.
    let (a, b) = (with(9, Some(9)), with(6, Some(5)));
    let open = |second: bool| Ok(Cursor::new(if second { b.clone() } else { a.clone() }));
    let first = compare(&Scope::default(), open)
        .expect("compared")
        .first
        .expect("a difference");
    assert_eq!((first.tick, first.b), (5, None));
    assert!(first.a.is_some());
}

/// What is missing may differ: two recordings are equal only when both are whole.
#[test]
fn what_is_not_whole_is_never_equal() {
    let with = |fields: &[(&str, &str)]| {
        let owned = fields
            .iter()
            .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
        recording_with(&[odometry(1, &[])], Some(owned.collect()))
    };
    let (valid, end) = ((VALID, "true"), (END_TICK, "9"));
    let whole = with(&[valid, end, (OUTCOME, "reached")]);
    let compared = |other: &[u8]| {
        let open = |second: bool| {
            Ok(Cursor::new(if second {
                other.to_vec()
            } else {
                whole.clone()
            }))
        };
        compare(&Scope::default(), open).expect("compared")
    };
    let one = compared(&whole);
    assert!(one.is_equal() && one.incomplete == [None, None], "{one:?}");
    for (other, why) in [
        (
            recording_with(&[odometry(1, &[])], None),
            "its recorder ended before",
        ),
        (with(&[(VALID, "false"), (WHY, "a gap"), end]), "a gap"),
        (
            with(&[valid]),
            "the recorder, or launch, ended before the run did",
        ),
        (
            with(&[valid, end, (OUTCOME, OUTCOME_INTERRUPTED)]),
            "the run was interrupted",
        ),
    ] {
        let one = compared(&other);
        assert_eq!((&one.first, &one.incomplete[0]), (&None, &None), "{why}");
        let said = one.incomplete[1].as_deref().unwrap_or_default();
        assert!(said.starts_with(why), "{said}");
        assert!(!one.is_equal(), "{why}");
    }
}

#[test]
fn a_scope_leaves_authors_ticks_and_numbers_out() {
    let id = |count: u64| ("header.id", Id::new(1, count).0.to_le_bytes().to_vec());
    let path = |tick, count, cost: f64| {
        let cost = ("meta.cost", cost.to_le_bytes().to_vec());
        written(PlanPath::ROW, 4, tick, &[id(count), cost])
    };
    let a = [
        odometry(1, &[]),
        path(1, 1, 1.0),
        path(2, 2, 2.0),
        path(3, 3, 3.0),
    ];
    let b = [
        odometry(1, &[("meta.scan_due", vec![1])]),
        path(1, 7, 9.0),
        path(2, 8, 2.0),
    ];
    let (a, b) = (recording(&a), recording(&b));
    let within = |scope: &Scope| {
        let open = |second: bool| Ok(Cursor::new(if second { b.clone() } else { a.clone() }));
        compare(scope, open).expect("compared")
    };
    let scope = Scope {
        authors: Some(vec![Role::GlobalPlanner]),
        ticks: [2, 2],
        numbers: false,
    };
    let one = within(&scope);
    assert_eq!((&one.first, one.topics.len()), (&None, 1), "{one:?}");
    let field = |scope: &Scope| within(scope).first.and_then(|first| first.field);
    let numbers = Scope {
        numbers: true,
        ..scope.clone()
    };
    assert_eq!(field(&numbers).as_deref(), Some("header.id"));
    let earlier = Scope {
        ticks: [1, 2],
        ..scope.clone()
    };
    assert_eq!(field(&earlier).as_deref(), Some("meta.cost"));
    let all = Scope {
        authors: None,
        ..earlier
    };
    assert_eq!(field(&all).as_deref(), Some("meta.scan_due"));
}

/// Of what a robot sent before the recorder came, a planner that is compared alone says nothing.
#[test]
fn within_a_scope_only_its_own_topics_have_to_be_complete() {
    let gap = |row: &TopicRow| {
        let fields = [(VALID, "false"), (WHY, "a gap"), (END_TICK, "9")];
        let mut fields: std::collections::BTreeMap<String, String> = fields
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .into();
        fields.insert(format!("{}.before_first", row.name), "3".to_owned());
        recording_with(&[written(PlanPath::ROW, 4, 1, &[])], Some(fields))
    };
    let of_planner = Scope {
        authors: Some(vec![Role::GlobalPlanner]),
        ..Scope::default()
    };
    let compared = |bytes: &[u8], scope: &Scope| {
        compare(scope, |_| Ok(Cursor::new(bytes.to_vec()))).expect("compared")
    };
    let robot = gap(RobotOdometry::ROW);
    assert!(!compared(&robot, &Scope::default()).is_equal());
    assert!(compared(&robot, &of_planner).is_equal());
    let planner = compared(&gap(PlanPath::ROW), &of_planner);
    let said = planner.incomplete[0].as_deref();
    assert_eq!(
        said,
        Some(&*format!("{}: 3 messages are missing", PlanPath::ROW.name))
    );
}

#[test]
fn what_is_no_recording_of_a_stack_is_named() {
    let ours = recording(&[odometry(1, &[])]);
    let foreign = crate::file::tests::recording(10);
    let compared = compare(&Scope::default(), |second| {
        Ok(Cursor::new(if second { &foreign } else { &ours }))
    });
    let error = compared.map(|_| ()).expect_err("foreign");
    assert!(matches!(error, (true, MessagesError::Foreign)), "{error:?}");
    let cut = &ours[..ours.len() / 20];
    let compared = compare(&Scope::default(), |second| {
        Ok(Cursor::new(if second { &ours[..] } else { cut }))
    });
    let error = compared.map(|_| ()).expect_err("cut");
    assert!(
        matches!(error, (false, MessagesError::Read(_))),
        "{error:?}"
    );
}
