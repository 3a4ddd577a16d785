//! Whether a recording is complete. Every author counts its messages of a topic from 1 without a gap,
//! so that a missing one is known by the next, and what came before the first by its number.

use std::collections::BTreeMap;
use zeronav_msgs::header::Id;
use zeronav_msgs::topics::{Discipline, TopicRow};

/// Most authors of a topic that are told apart at a time; launch gives out higher epochs with time.
const AUTHORS_MAX: usize = 64;

/// What was read of one topic.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// Messages in the file.
    pub messages: u64,
    /// Messages among them that no reader of the stack accepts; their numbers are not believed.
    pub rejected: u64,
    /// Messages between two of the same author that did not come.
    pub missed: u64,
    /// Messages of an author before its first one that came.
    pub before_first: u64,
    /// Number of the last message of an author, by its epoch.
    last: BTreeMap<u32, u64>,
    /// True when several authors have the same epoch, so that the numbers say nothing.
    are_mixed: bool,
}

impl Tally {
    /// A message with this identity is in the file.
    pub fn see(&mut self, id: Id) {
        self.messages += 1;
        let count = id.count();
        match self.last.insert(id.epoch(), count) {
            Some(last) => self.missed += count.saturating_sub(last.saturating_add(1)),
            None => self.before_first += count.saturating_sub(1),
        }
        if self.last.len() > AUTHORS_MAX {
            self.last.pop_first();
        }
    }

    /// [`Self::see`] on a topic whose authors may have the same epoch. A number that does not grow tells them: from
    /// then on nothing is known to be missing.
    pub fn see_of_any(&mut self, id: Id) {
        let last = self.last.get(&id.epoch());
        self.are_mixed |= last.is_some_and(|last| *last >= id.count());
        self.see(id);
    }

    /// A record without a number is in the file.
    pub fn see_record(&mut self) {
        self.messages += 1;
    }

    /// A message is in the file that no reader accepts.
    pub fn reject(&mut self) {
        self.messages += 1;
        self.rejected += 1;
    }

    /// Messages that are not in the file. [count]
    #[must_use]
    pub fn lost(&self) -> u64 {
        if self.are_mixed {
            return 0;
        }
        self.missed + self.before_first
    }
}

/// Name of the metadata record with the verdict, which ends a recording.
pub const VERDICT: &str = "zeronav";

/// Field of the verdict: `true` when nothing is missing.
pub const VALID: &str = "valid";

/// Field of the verdict that says what is missing.
pub const WHY: &str = "why";

/// Field of the verdict with the tick with which launch ended the run.
pub const END_TICK: &str = "end_tick";

/// Field of the verdict with the outcome of the run in one word, by launch.
pub const OUTCOME: &str = "outcome";

/// [`OUTCOME`] of a run that somebody ended by a signal.
pub const OUTCOME_INTERRUPTED: &str = "interrupted";

/// The verdict on these topics, as the fields of the metadata record [`VERDICT`]; `cut` is why the
/// recording ended before the run, if it did.
///
/// `valid` is `true` when no message is missing from the first one of every author on; `why` says
/// what is missing otherwise. Of each topic with messages there are `TOPIC.messages`, `.missed`,
/// `.before_first` and `.rejected`.
#[must_use]
pub fn verdict<'a>(
    topics: impl Iterator<Item = (&'static TopicRow, &'a Tally)>,
    cut: Option<&str>,
) -> BTreeMap<String, String> {
    let mut fields = BTreeMap::new();
    let mut why: Vec<String> = cut.iter().map(|cut| (*cut).to_owned()).collect();
    let (mut messages, mut missed) = (0, 0);
    for (row, tally) in topics {
        messages += tally.messages;
        missed += tally.lost();
        if tally.messages == 0 {
            continue;
        }
        let name = row.name;
        fields.insert(format!("{name}.messages"), tally.messages.to_string());
        let is_records = row.discipline == Discipline::Records;
        if is_records || tally.are_mixed {
            let why = if is_records {
                "none: missing records are not counted"
            } else {
                "of several authors with one epoch: missing messages are not counted"
            };
            fields.insert(format!("{name}.numbers"), why.to_owned());
            continue;
        }
        for (field, n) in [
            ("missed", tally.missed),
            ("before_first", tally.before_first),
            ("rejected", tally.rejected),
        ] {
            fields.insert(format!("{name}.{field}"), n.to_string());
        }
        if tally.missed > 0 {
            why.push(format!("{name}: {} messages missed", tally.missed));
        }
        if tally.before_first > 0 {
            let n = tally.before_first;
            why.push(format!("{name}: {n} messages sent before the first"));
        }
    }
    fields.insert(VALID.to_owned(), why.is_empty().to_string());
    fields.insert(WHY.to_owned(), why.join("; "));
    fields.insert("messages".to_owned(), messages.to_string());
    fields.insert("missed".to_owned(), missed.to_string());
    fields.insert("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned());
    fields
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::topics::{RobotScan, SPANS, Topic};

    fn seen(ids: &[(u32, u64)]) -> Tally {
        let mut tally = Tally::default();
        for (epoch, count) in ids {
            tally.see(Id::new(*epoch, *count));
        }
        tally
    }

    #[test]
    fn what_is_missing_is_known_by_the_numbers_around_it() {
        let whole = seen(&[(1, 1), (1, 2), (2, 1), (1, 3), (2, 2)]);
        assert_eq!((whole.messages, whole.lost()), (5, 0));
        let gap = seen(&[(1, 1), (1, 5), (2, 4), (1, 6)]);
        assert_eq!((gap.missed, gap.before_first), (3, 3));
        let again = seen(&[(1, 3), (1, 3), (1, 2)]);
        assert_eq!((again.missed, again.before_first), (0, 2));
    }

    #[test]
    fn many_restarts_take_no_more_memory() {
        let mut tally = Tally::default();
        for epoch in 1..10_000 {
            tally.see(Id::new(epoch, 1));
        }
        assert_eq!((tally.last.len(), tally.lost()), (AUTHORS_MAX, 0));
    }

    #[test]
    fn a_recording_with_a_gap_is_not_valid_and_says_where() {
        let scan = RobotScan::ROW;
        let whole = seen(&[(1, 1), (1, 2)]);
        let fields = verdict([(scan, &whole)].into_iter(), None);
        assert_eq!(fields["valid"], "true");
        assert_eq!(fields[&format!("{}.messages", scan.name)], "2");
        let gap = seen(&[(1, 2), (1, 4)]);
        let fields = verdict([(scan, &gap)].into_iter(), None);
        assert_eq!(fields["valid"], "false");
        let name = scan.name;
        assert_eq!(
            fields["why"],
            format!("{name}: 1 messages missed; {name}: 1 messages sent before the first")
        );
        assert_eq!(fields["missed"], "2");
        let cut = verdict([(scan, &whole)].into_iter(), Some("the disk is full"));
        assert_eq!(
            (&*cut["valid"], &*cut["why"]),
            ("false", "the disk is full")
        );
    }

    #[test]
    fn records_without_numbers_are_called_so() {
        let mut tally = Tally::default();
        tally.see_record();
        let fields = verdict([(&SPANS, &tally)].into_iter(), None);
        assert_eq!(fields["valid"], "true");
        assert!(fields[&format!("{}.numbers", SPANS.name)].starts_with("none"));
    }

    #[test]
    fn numbers_of_several_authors_with_one_epoch_are_not_believed() {
        let scan = RobotScan::ROW;
        let seen = |counts: &[u64]| {
            let mut tally = Tally::default();
            for count in counts {
                tally.see_of_any(Id::new(1, *count));
            }
            tally
        };
        let one = seen(&[1, 2, 5]);
        assert_eq!(one.lost(), 2);
        let two = seen(&[1, 2, 1, 3, 2]);
        assert_eq!((two.messages, two.lost()), (5, 0));
        let fields = verdict([(scan, &two)].into_iter(), None);
        assert_eq!(fields["valid"], "true");
        assert!(fields[&format!("{}.numbers", scan.name)].starts_with("of several authors"));
    }
}
