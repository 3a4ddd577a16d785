//! Where two recordings begin to differ: the messages of the contract, topic by topic, by tick and author.
//!
//! Stamps of the machine's clock, checksums and the numbers of starts are left out, so that two lockstep runs
//! that did the same are equal. Not compared are `run/spans`, which holds nothing but times, and `run/clock`
//! and `run/control`, with which launch follows the clock.

use crate::layout::{Layout, Leaf};
use crate::messages::{MessagesError, native_messages};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hasher};
use std::io::Read;
use zeronav_msgs::header::{Id, SHADOW_EPOCH_MIN};
use zeronav_msgs::role::Role;
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::{RunClockTopic, RunControlTopic, SPANS, Topic};

/// What differs first.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// The topic.
    pub topic: String,
    /// Who wrote the message.
    pub author: String,
    /// The tick that it answers.
    pub tick: u64,
    /// Run time of that tick. [s]
    pub run_s: f64,
    /// The value, such as `meta.v_mps`, or `items` when there are more or fewer; none when only one of the
    /// recordings has the message.
    pub field: Option<String>,
    /// Its unit.
    pub unit: Option<String>,
    /// The value in the first recording; none without the message.
    pub a: Option<String>,
    /// The value in the second recording; none without the message.
    pub b: Option<String>,
}

/// The messages of one topic.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TopicComparison {
    /// Its name.
    pub topic: String,
    /// Messages in both that are equal.
    pub equal: u64,
    /// Messages in both that differ.
    pub different: u64,
    /// Messages in the first recording only.
    pub only_a: u64,
    /// Messages in the second recording only.
    pub only_b: u64,
    /// The first that differs.
    pub first: Option<Difference>,
}

/// Two recordings beside each other.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// What differs first of all, in the order of the data flow within a tick.
    pub first: Option<Difference>,
    /// The topics that one of them has, by name.
    pub topics: Vec<TopicComparison>,
}

/// Which message: tick, author in the order of the data flow, whether a shadow wrote it, and which of those with
/// all of this in common.
type Key = (u64, u16, bool, u32);

/// What is kept of a recording, by topic: of each message a hash of what is compared.
type Digests = BTreeMap<String, BTreeMap<Key, u64>>;

/// A message that differs, or is in one recording only.
#[derive(Default, Clone)]
struct Found {
    envelope: Vec<u8>,
    items: Vec<u8>,
    layout: Option<Layout>,
}

/// Compares two recordings; `open` opens the first (`false`) or the second (`true`) from its beginning. It is called
/// twice for each.
///
/// # Errors
/// [`MessagesError`], with the recording that it is about.
pub fn compare<R: Read>(
    mut open: impl FnMut(bool) -> Result<R, MessagesError>,
) -> Result<Comparison, (bool, MessagesError)> {
    let mut of = |second: bool| {
        let digests = open(second).and_then(digests);
        digests.map_err(|error| (second, error))
    };
    let (a, b) = (of(false)?, of(true)?);
    let names: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    let none = BTreeMap::new();
    let mut topics = Vec::new();
    let mut firsts = BTreeMap::new();
    for name in names {
        let (counted, first) = beside(
            name,
            a.get(name).unwrap_or(&none),
            b.get(name).unwrap_or(&none),
        );
        topics.push(counted);
        firsts.extend(first.map(|key| (name.clone(), key)));
    }
    let mut found = [BTreeMap::new(), BTreeMap::new()];
    if !firsts.is_empty() {
        for (second, found) in [false, true].into_iter().zip(&mut found) {
            let messages = open(second).and_then(|input| find(input, &firsts));
            *found = messages.map_err(|error| (second, error))?;
        }
    }
    let mut first: Option<(Key, Difference)> = None;
    for topic in &mut topics {
        let Some(key) = firsts.get(&topic.topic) else {
            continue;
        };
        let [a, b] = [&found[0], &found[1]].map(|found| found.get(&topic.topic));
        let difference = difference(&topic.topic, *key, a, b);
        if first.as_ref().is_none_or(|(before, _)| key < before) {
            first = Some((*key, difference.clone()));
        }
        topic.first = Some(difference);
    }
    Ok(Comparison {
        first: first.map(|(_, difference)| difference),
        topics,
    })
}

/// Counts, and the first message that is not the same in both.
fn beside(
    name: &str,
    a: &BTreeMap<Key, u64>,
    b: &BTreeMap<Key, u64>,
) -> (TopicComparison, Option<Key>) {
    let mut counted = TopicComparison {
        topic: name.to_owned(),
        equal: 0,
        different: 0,
        only_a: 0,
        only_b: 0,
        first: None,
    };
    let mut first: Option<Key> = None;
    let mut differs = |key: &Key| first = Some(first.map_or(*key, |before| before.min(*key)));
    for (key, digest) in a {
        match b.get(key) {
            Some(other) if other == digest => counted.equal += 1,
            Some(_) => {
                counted.different += 1;
                differs(key);
            }
            None => {
                counted.only_a += 1;
                differs(key);
            }
        }
    }
    for key in b.keys().filter(|key| !a.contains_key(key)) {
        counted.only_b += 1;
        differs(key);
    }
    (counted, first)
}

/// True for a topic that is compared.
fn is_compared(name: &str) -> bool {
    ![
        SPANS.name,
        RunClockTopic::ROW.name,
        RunControlTopic::ROW.name,
    ]
    .contains(&name)
}

/// Shows every message that is compared, with the name of its topic, its layout and its two parts.
fn messages(
    input: impl Read,
    mut see: impl FnMut(&str, &Layout, Key, [&[u8]; 2]),
) -> Result<(), MessagesError> {
    let mut counts: BTreeMap<(String, u64, u16, bool), u32> = BTreeMap::new();
    native_messages(input, is_compared, |name, layout, [envelope, items]| {
        let number = |path: &str| layout.number(envelope, path).unwrap_or(0);
        let tick = number("header.tick");
        let role = u16::try_from(number("header.role")).unwrap_or(u16::MAX);
        let shadow = Id(number("header.id")).epoch() >= SHADOW_EPOCH_MIN;
        let n = counts
            .entry((name.to_owned(), tick, role, shadow))
            .or_default();
        let key = (tick, role, shadow, *n);
        *n = n.saturating_add(1);
        see(name, layout, key, [envelope, items]);
    })
}

fn digests(input: impl Read) -> Result<Digests, MessagesError> {
    let mut digests = Digests::new();
    messages(input, |name, layout, key, [envelope, items]| {
        let mut hasher = DefaultHasher::new();
        let mut hash = |leaves: &[Leaf], part: &[u8]| {
            for leaf in leaves {
                hasher.write(leaf.repeatable(leaf.of(part).unwrap_or_default()));
            }
        };
        hash(&layout.envelope, envelope);
        for item in items.chunks_exact(layout.item_bytes.max(1)) {
            hash(&layout.item, item);
        }
        let topic = match digests.get_mut(name) {
            Some(topic) => topic,
            None => digests.entry(name.to_owned()).or_default(),
        };
        topic.insert(key, hasher.finish());
    })?;
    Ok(digests)
}

/// The messages of these topics with these keys.
fn find(
    input: impl Read,
    wanted: &BTreeMap<String, Key>,
) -> Result<BTreeMap<String, Found>, MessagesError> {
    let mut found = BTreeMap::new();
    messages(input, |name, layout, key, [envelope, items]| {
        if wanted.get(name) == Some(&key) {
            let message = Found {
                envelope: envelope.to_vec(),
                items: items.to_vec(),
                layout: Some(layout.clone()),
            };
            found.insert(name.to_owned(), message);
        }
    })?;
    Ok(found)
}

/// What differs between two messages, of which one may be missing.
fn difference(topic: &str, key: Key, a: Option<&Found>, b: Option<&Found>) -> Difference {
    let (tick, role, shadow, _) = key;
    let role = Role::from_code(role).map_or_else(|| role.to_string(), |role| role.to_string());
    let whole = a.or(b);
    let run_ns = whole.and_then(|it| {
        let layout = it.layout.as_ref()?;
        layout.number(&it.envelope, "header.run_ns")
    });
    let mut difference = Difference {
        topic: topic.to_owned(),
        author: if shadow {
            format!("{role} (shadow)")
        } else {
            role
        },
        tick,
        run_s: seconds(run_ns.unwrap_or(0)),
        field: None,
        unit: None,
        a: None,
        b: None,
    };
    let (Some(a), Some(b)) = (a, b) else {
        let there = || Some("the message".to_owned());
        difference.a = a.and_then(|_| there());
        difference.b = b.and_then(|_| there());
        return difference;
    };
    if let Some((field, unit, [a, b])) = field(a, b) {
        difference.field = Some(field);
        difference.unit = unit;
        (difference.a, difference.b) = (Some(a), Some(b));
    }
    difference
}

/// The first value that differs: name, unit and both values.
fn field(a: &Found, b: &Found) -> Option<(String, Option<String>, [String; 2])> {
    let (of_a, of_b) = (a.layout.as_ref()?, b.layout.as_ref()?);
    let first = |leaves: &[Leaf], a: &[u8], others: &[Leaf], b: &[u8], within: &str| {
        leaves.iter().find_map(|leaf| {
            let value = leaf.of(a)?;
            // Of another version of the contract by its name; a value that it lacks differs.
            let other = others.iter().find(|other| other.path == leaf.path);
            let (text, repeatable) = match other.and_then(|other| Some((other, other.of(b)?))) {
                Some((other, value)) => (other.text(value), other.repeatable(value)),
                None => ("no such field".to_owned(), &[0; 9][..]),
            };
            (leaf.repeatable(value) != repeatable).then(|| {
                let unit = leaf.unit.clone();
                (
                    format!("{within}{}", leaf.path),
                    unit,
                    [leaf.text(value), text],
                )
            })
        })
    };
    let fixed = first(&of_a.envelope, &a.envelope, &of_b.envelope, &b.envelope, "");
    let items_of = |found: &'_ Found, layout: &Layout| found.items.len() / layout.item_bytes.max(1);
    let counts = [items_of(a, of_a), items_of(b, of_b)];
    fixed
        .or_else(|| {
            let differ = counts[0] != counts[1];
            differ.then(|| ("items".to_owned(), None, counts.map(|n| n.to_string())))
        })
        .or_else(|| {
            let a = a.items.chunks_exact(of_a.item_bytes.max(1));
            let b = b.items.chunks_exact(of_b.item_bytes.max(1));
            a.zip(b).enumerate().find_map(|(n, (a, b))| {
                first(&of_a.item, a, &of_b.item, b, &format!("items[{n}]."))
            })
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::{Channel, RecordingFile, Stamped};
    use crate::native;
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

    fn recording(messages: &[Written]) -> Vec<u8> {
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
        file.finish().expect("finished").into_inner()
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
}
