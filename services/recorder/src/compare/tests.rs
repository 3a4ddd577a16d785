//! Two recordings beside each other, made by hand.

use super::*;
use crate::file::{Channel, RecordingFile, Stamped};
use crate::native;
use crate::verdict::{END_TICK, VERDICT};
use std::io::Cursor;
use zeronav_msgs::topics::{PlanPath, RobotOdometry, RunControlTopic, TopicRow};

/// A message as a test changes it: values by their paths, in the item behind it with `items`.
struct Written {
    row: &'static TopicRow,
    values: Vec<(&'static str, Vec<u8>)>,
    items: usize,
}

fn odometry(tick: u64, more: &[(&'static str, Vec<u8>)]) -> Written {
    written(RobotOdometry::ROW, 2, tick, more)
}

fn written(
    row: &'static TopicRow,
    role: u8,
    tick: u64,
    more: &[(&'static str, Vec<u8>)],
) -> Written {
    let mut values = vec![
        ("header.role", vec![role]),
        ("header.tick", tick.to_le_bytes().to_vec()),
        ("header.run_ns", (tick * 20_000_000).to_le_bytes().to_vec()),
    ];
    values.extend_from_slice(more);
    Written {
        row,
        values,
        items: 0,
    }
}

fn recording_until(messages: &[Written], end_tick: Option<u64>) -> Vec<u8> {
    let mut file = RecordingFile::new(Cursor::new(Vec::new())).expect("a file");
    let topics = native::topics();
    for message in messages {
        let topic = topics
            .iter()
            .find(|topic| topic.row.number == message.row.number)
            .expect("a topic");
        let channel = file
            .channel(&Channel {
                topic: &topic.channel(),
                encoding: native::ENCODING,
                schema: topic.type_name,
                schema_encoding: "",
                definition: b"",
                metadata: topic.metadata(),
            })
            .expect("a channel");
        let layout = Layout::of("it", &topic.metadata()).expect("a layout");
        let items = message.items * layout.item_bytes;
        let mut bytes = vec![0; layout.envelope_bytes + items];
        for (path, value) in &message.values {
            let leaf = layout.envelope.iter().find(|leaf| leaf.path == *path);
            let at = leaf.expect("a field").offset;
            bytes[at..at + value.len()].copy_from_slice(value);
        }
        let when = Stamped {
            sequence: 0,
            log_ns: 0,
            publish_ns: 0,
        };
        file.write(channel, when, &bytes).expect("written");
    }
    if let Some(tick) = end_tick {
        let fields = [(END_TICK.to_owned(), tick.to_string())];
        file.metadata(VERDICT, fields.into()).expect("written");
    }
    file.finish().expect("finished").into_inner()
}

fn recording(messages: &[Written]) -> Vec<u8> {
    recording_until(messages, None)
}

fn compared(a: &[Written], b: &[Written]) -> Comparison {
    let (a, b) = (recording(a), recording(b));
    let open = |second: bool| Ok(Cursor::new(if second { b.clone() } else { a.clone() }));
    compare(open).expect("compared")
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
    let path = |items| Written {
        items,
        ..written(PlanPath::ROW, 4, 1, &[])
    };
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
        let topics = compare(open).expect("compared").topics;
        (topics[0].equal, topics[0].only_a, topics[0].only_b)
    };
    assert_eq!(counts(Some(6)), (5, 0, 0));
    assert_eq!(counts(None), (7, 0, 2));
    // One run ends in the middle: its recording has a little more.
    let (a, b) = (with(9, Some(9)), with(6, Some(5)));
    let open = |second: bool| Ok(Cursor::new(if second { b.clone() } else { a.clone() }));
    let first = compare(open)
        .expect("compared")
        .first
        .expect("a difference");
    assert_eq!((first.tick, first.b), (5, None));
    assert!(first.a.is_some());
}

#[test]
fn what_is_no_recording_of_a_stack_is_named() {
    let ours = recording(&[odometry(1, &[])]);
    let foreign = crate::file::tests::recording(10);
    let compared = compare(|second| Ok(Cursor::new(if second { &foreign } else { &ours })));
    let error = compared.map(|_| ()).expect_err("foreign");
    assert!(matches!(error, (true, MessagesError::Foreign)), "{error:?}");
    let cut = &ours[..ours.len() / 20];
    let compared = compare(|second| Ok(Cursor::new(if second { &ours[..] } else { cut })));
    let error = compared.map(|_| ()).expect_err("cut");
    assert!(
        matches!(error, (false, MessagesError::Read(_))),
        "{error:?}"
    );
}
