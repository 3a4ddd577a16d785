//! Recordings made by hand, for tests.

use crate::file::{Channel, RecordingFile, Stamped};
use crate::layout::Layout;
use crate::native;
use crate::verdict::{END_TICK, VALID, VERDICT};
use std::collections::BTreeMap;
use std::io::Cursor;
use zeronav_msgs::topics::{RobotOdometry, Topic, TopicRow};

/// Run time of a tick. [ns]
const TICK_NS: u64 = 20_000_000;

/// A value as a test writes it: its path, and its bytes.
pub(crate) type Value = (&'static str, Vec<u8>);

/// A message as a test changes it: values by their paths; all others are 0.
pub(crate) struct Written {
    row: &'static TopicRow,
    values: Vec<Value>,
    items: Vec<Vec<Value>>,
}

impl Written {
    /// With so many items of zeros.
    pub(crate) fn with_items(self, n: usize) -> Self {
        self.with(vec![Vec::new(); n])
    }

    /// With these items.
    pub(crate) fn with(self, items: Vec<Vec<Value>>) -> Self {
        Self { items, ..self }
    }
}

/// A message of the robot.
pub(crate) fn odometry(tick: u64, more: &[Value]) -> Written {
    written(RobotOdometry::ROW, 2, tick, more)
}

/// A message by the role with this code.
pub(crate) fn written(row: &'static TopicRow, role: u8, tick: u64, more: &[Value]) -> Written {
    let mut values = vec![
        ("header.role", vec![role]),
        ("header.tick", tick.to_le_bytes().to_vec()),
        ("header.run_ns", (tick * TICK_NS).to_le_bytes().to_vec()),
    ];
    values.extend_from_slice(more);
    Written {
        row,
        values,
        items: Vec::new(),
    }
}

/// A record on a topic of records.
pub(crate) fn record(row: &'static TopicRow, values: &[Value]) -> Written {
    Written {
        row,
        values: Vec::new(),
        items: vec![values.to_vec()],
    }
}

/// A whole recording of a run that ended with `end_tick`; one that was cut without.
pub(crate) fn recording_until(messages: &[Written], end_tick: Option<u64>) -> Vec<u8> {
    let end_tick = end_tick.map(|tick| (END_TICK.to_owned(), tick.to_string()));
    let fields = end_tick.map(|end_tick| [(VALID.to_owned(), "true".to_owned()), end_tick].into());
    recording_with(messages, fields)
}

/// A recording with this verdict.
pub(crate) fn recording_with(
    messages: &[Written],
    verdict: Option<BTreeMap<String, String>>,
) -> Vec<u8> {
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
        let mut bytes = vec![0; layout.envelope_bytes];
        let put = |part: &mut [u8], leaves: &[crate::layout::Leaf], values: &[Value]| {
            for (path, value) in values {
                let leaf = leaves.iter().find(|leaf| leaf.path == *path);
                let at = leaf.unwrap_or_else(|| panic!("no {path}")).offset;
                part[at..at + value.len()].copy_from_slice(value);
            }
        };
        put(&mut bytes, &layout.envelope, &message.values);
        for item in &message.items {
            let mut part = vec![0; layout.item_bytes];
            put(&mut part, &layout.item, item);
            bytes.extend(part);
        }
        let when = Stamped {
            sequence: 0,
            log_ns: 0,
            publish_ns: 0,
        };
        file.write(channel, when, &bytes).expect("written");
    }
    if let Some(fields) = verdict {
        file.metadata(VERDICT, fields).expect("written");
    }
    file.finish().expect("finished").into_inner()
}
