//! Where two recordings begin to differ: the messages of the contract, topic by topic, by tick and author.
//!
//! Stamps of the machine's clock, checksums and the numbers of starts are left out, so that two lockstep runs
//! that did the same are equal. Not compared are `run/spans` and `health/*`, by which processes speak of
//! themselves, `run/clock` and `run/control`, with which launch follows the clock, `map/keyframe`, which comes when a
//! reader asks for it, what services say before they answer a tick, what companions say, which follow no tick, and
//! everything from the tick on with which the run ended.

use crate::layout::{Layout, Leaf};
use crate::messages::{Conclusion, MessagesError, native_messages};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hasher};
use std::io::Read;
use zeronav_msgs::fields::ID;
use zeronav_msgs::header::{Id, SHADOW_EPOCH_MIN};
use zeronav_msgs::role::Role;
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::{
    HEALTH, MapKeyframe, RunClockTopic, RunControlTopic, SPANS, Topic, topics,
};

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
    /// The tick with which each run ended, where its recording says so.
    pub end_ticks: [Option<u64>; 2],
    /// Why each recording is not the whole of a run that came to its end; none when it is.
    pub incomplete: [Option<String>; 2],
}

impl Comparison {
    /// True when nothing differs that is compared and both are whole: of what is missing nobody knows.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        self.first.is_none() && self.incomplete.iter().all(Option::is_none)
    }
}

/// Which message: tick, author in the order of the data flow, whether a shadow wrote it, and which of those with
/// all of this in common, in the order of their authors' starts: two processes in a seat write in any order.
type Key = (u64, u16, bool, u32);

/// Which message of one recording: as [`Key`], with its identity in the place of the last.
type Place = (u64, u16, bool, u64);

/// What is kept of a message: a hash of what is compared, and its identity.
type Kept = (u64, u64);

/// What is kept of a recording, by topic.
type Digests = BTreeMap<String, BTreeMap<Key, Kept>>;

/// A message that differs, or is in one recording only.
#[derive(Default, Clone)]
struct Found {
    envelope: Vec<u8>,
    items: Vec<u8>,
    layout: Option<Layout>,
}

/// What of two recordings is compared.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Scope {
    /// Whose messages; none = everybody's.
    pub authors: Option<Vec<Role>>,
    /// The first and the last tick.
    pub ticks: [u64; 2],
    /// True when the numbers of messages are compared, too.
    pub numbers: bool,
}

impl Default for Scope {
    /// Everything.
    fn default() -> Self {
        Self {
            authors: None,
            ticks: [0, u64::MAX],
            numbers: true,
        }
    }
}

impl Scope {
    fn holds(&self, role: u16, tick: u64) -> bool {
        let [first, last] = self.ticks;
        let is_author = |authors: &Vec<Role>| authors.iter().any(|author| author.code() == role);
        (first..=last).contains(&tick) && self.authors.as_ref().is_none_or(is_author)
    }

    /// The bytes of a value that are compared.
    fn of<'a>(&self, leaf: &Leaf, value: &'a [u8]) -> &'a [u8] {
        if !self.numbers && leaf.unit.as_deref() == Some(ID) {
            return &[];
        }
        leaf.repeatable(value)
    }

    /// Why a recording is not the whole of what is compared.
    fn incomplete(&self, end: &Conclusion) -> Option<String> {
        let Some(authors) = &self.authors else {
            return end.incomplete.clone();
        };
        let theirs = topics().into_iter().filter(|row| {
            let is_one = |role: &Role| authors.contains(role);
            is_compared(row.name) && row.writers.iter().any(is_one)
        });
        let theirs: Vec<&str> = theirs.map(|row| row.name).collect();
        end.incomplete_of(&theirs)
    }
}

/// Compares two recordings; `open` opens the first (`false`) or the second (`true`) from its beginning. It is called
/// twice for each.
///
/// # Errors
/// [`MessagesError`], with the recording that it is about.
pub fn compare<R: Read>(
    scope: &Scope,
    mut open: impl FnMut(bool) -> Result<R, MessagesError>,
) -> Result<Comparison, (bool, MessagesError)> {
    let mut of = |second: bool| {
        let digests = open(second).and_then(|input| digests(scope, input));
        digests.map_err(|error| (second, error))
    };
    let ((a, end_of_a), (b, end_of_b)) = (of(false)?, of(true)?);
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
        for ((second, digests), found) in [(false, &a), (true, &b)].into_iter().zip(&mut found) {
            let places = firsts.iter().filter_map(|(name, key)| {
                let (_, id) = digests.get(name)?.get(key)?;
                Some((name.clone(), (key.0, key.1, key.2, *id)))
            });
            let places: BTreeMap<String, Place> = places.collect();
            let messages = open(second).and_then(|input| find(scope, input, &places));
            *found = messages.map_err(|error| (second, error))?;
        }
    }
    let mut first: Option<(Key, Difference)> = None;
    for topic in &mut topics {
        let Some(key) = firsts.get(&topic.topic) else {
            continue;
        };
        let [a, b] = [&found[0], &found[1]].map(|found| found.get(&topic.topic));
        let difference = difference(scope, &topic.topic, *key, a, b);
        if first.as_ref().is_none_or(|(before, _)| key < before) {
            first = Some((*key, difference.clone()));
        }
        topic.first = Some(difference);
    }
    Ok(Comparison {
        first: first.map(|(_, difference)| difference),
        topics,
        end_ticks: [end_of_a.end_tick, end_of_b.end_tick],
        incomplete: [scope.incomplete(&end_of_a), scope.incomplete(&end_of_b)],
    })
}

/// Counts, and the first message that is not the same in both.
fn beside(
    name: &str,
    a: &BTreeMap<Key, Kept>,
    b: &BTreeMap<Key, Kept>,
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
    for (key, (digest, _)) in a {
        match b.get(key) {
            Some((other, _)) if other == digest => counted.equal += 1,
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
    let left_out = [
        SPANS.name,
        RunClockTopic::ROW.name,
        RunControlTopic::ROW.name,
        MapKeyframe::ROW.name,
    ];
    let is_health = HEALTH.iter().any(|row| row.name == name);
    !is_health && !left_out.contains(&name)
}

/// Shows every message that is compared, with the name of its topic, its layout and its two parts. What the recording
/// says of its end.
fn messages(
    scope: &Scope,
    input: impl Read,
    mut see: impl FnMut(&str, &Layout, Place, [&[u8]; 2]),
) -> Result<Conclusion, MessagesError> {
    native_messages(input, is_compared, |name, layout, [envelope, items]| {
        let number = |path: &str| layout.number(envelope, path).unwrap_or(0);
        let tick = number("header.tick");
        let role = u16::try_from(number("header.role")).unwrap_or(u16::MAX);
        // A companion follows no tick.
        let is_guest = role == Role::Tap.code();
        let is_idle = tick == 0 && ![Role::Launch, Role::Robot].map(Role::code).contains(&role);
        if is_guest || is_idle || !scope.holds(role, tick) {
            return;
        }
        let id = Id(number("header.id"));
        let shadow = id.epoch() >= SHADOW_EPOCH_MIN;
        // The epoch of a shadow is its process id.
        let order = if shadow { id.count() } else { id.0 };
        see(name, layout, (tick, role, shadow, order), [envelope, items]);
    })
}

fn digests(scope: &Scope, input: impl Read) -> Result<(Digests, Conclusion), MessagesError> {
    let mut digests: BTreeMap<String, BTreeMap<Place, u64>> = BTreeMap::new();
    let end = messages(scope, input, |name, layout, place, [envelope, items]| {
        let mut hasher = DefaultHasher::new();
        let mut hash = |leaves: &[Leaf], part: &[u8]| {
            for leaf in leaves {
                hasher.write(scope.of(leaf, leaf.of(part).unwrap_or_default()));
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
        topic.insert(place, hasher.finish());
    })?;
    let ranked = |(name, mut topic): (String, BTreeMap<Place, u64>)| {
        topic.retain(|(tick, ..), _| end.end_tick.is_none_or(|end_tick| *tick < end_tick));
        (name, ranked(topic))
    };
    Ok((digests.into_iter().map(ranked).collect(), end))
}

/// Numbers those that have all but their identity in common.
fn ranked(topic: BTreeMap<Place, u64>) -> BTreeMap<Key, Kept> {
    let mut last = None;
    let mut n = 0;
    let numbered = topic.into_iter().map(|((tick, role, shadow, id), digest)| {
        let same = Some((tick, role, shadow));
        n = if last == same { n + 1 } else { 0 };
        last = same;
        ((tick, role, shadow, n), (digest, id))
    });
    numbered.collect()
}

/// The messages of these topics at these places.
fn find(
    scope: &Scope,
    input: impl Read,
    wanted: &BTreeMap<String, Place>,
) -> Result<BTreeMap<String, Found>, MessagesError> {
    let mut found = BTreeMap::new();
    messages(scope, input, |name, layout, place, [envelope, items]| {
        if wanted.get(name) == Some(&place) {
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
fn difference(
    scope: &Scope,
    topic: &str,
    key: Key,
    a: Option<&Found>,
    b: Option<&Found>,
) -> Difference {
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
    if let Some((field, unit, [a, b])) = field(scope, a, b) {
        difference.field = Some(field);
        difference.unit = unit;
        (difference.a, difference.b) = (Some(a), Some(b));
    }
    difference
}

/// The first value that differs: name, unit and both values.
fn field(scope: &Scope, a: &Found, b: &Found) -> Option<(String, Option<String>, [String; 2])> {
    let (of_a, of_b) = (a.layout.as_ref()?, b.layout.as_ref()?);
    let by_path = |leaves: &'_ [Leaf]| -> BTreeMap<String, Leaf> {
        let named = leaves.iter().map(|leaf| (leaf.path.clone(), leaf.clone()));
        named.collect()
    };
    let (envelope_of_b, item_of_b) = (by_path(&of_b.envelope), by_path(&of_b.item));
    let first =
        |leaves: &[Leaf], a: &[u8], others: &BTreeMap<String, Leaf>, b: &[u8], within: &str| {
            leaves.iter().find_map(|leaf| {
                let value = leaf.of(a)?;
                // Of another version of the contract by its name; a value that it lacks differs.
                let other = others.get(&leaf.path);
                let (text, repeatable) = match other.and_then(|other| Some((other, other.of(b)?))) {
                    Some((other, value)) => (other.text(value), scope.of(other, value)),
                    None => ("no such field".to_owned(), &[0; 9][..]),
                };
                (scope.of(leaf, value) != repeatable).then(|| {
                    let name = format!("{within}{}", leaf.path);
                    let name = name.trim_end_matches('.').to_owned();
                    (name, leaf.unit.clone(), [leaf.text(value), text])
                })
            })
        };
    let fixed = first(&of_a.envelope, &a.envelope, &envelope_of_b, &b.envelope, "");
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
                first(&of_a.item, a, &item_of_b, b, &format!("items[{n}]."))
            })
        })
}

#[cfg(test)]
mod tests;
