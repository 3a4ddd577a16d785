//! What has come on each topic since the view began, and rates over the last seconds.

use super::view::TopicLine;
use std::collections::VecDeque;
use zeronav_casts::Cast;
use zeronav_msgs::time::seconds;

/// Time over which rates are taken. [ns]
const WINDOW_NS: u64 = 5_000_000_000;

/// What has come on one topic.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Count {
    messages: u64,
    bytes: u64,
}

/// What has come on every topic.
#[derive(Debug, Default)]
pub(super) struct Totals {
    names: Vec<&'static str>,
    counts: Vec<Count>,
    missed: Vec<u64>,
    /// When the newest message was sent, monotonic; 0 = none. [ns]
    newest_ns: Vec<u64>,
    /// Moment [ns] and counts, the oldest first.
    marks: VecDeque<(u64, Vec<Count>)>,
}

impl Totals {
    /// Of topics with these names.
    pub(super) fn new(names: Vec<&'static str>) -> Self {
        Self {
            counts: vec![Count::default(); names.len()],
            missed: vec![0; names.len()],
            newest_ns: vec![0; names.len()],
            names,
            marks: VecDeque::new(),
        }
    }

    /// A message was read on the topic at `index`, sent at `sent_ns`, after `missed` that were not.
    pub(super) fn add(&mut self, index: usize, bytes: usize, sent_ns: u64, missed: u64) {
        self.newest_ns[index] = self.newest_ns[index].max(sent_ns);
        self.missed[index] += missed;
        // What waited for this reader was sent before the first mark and is no part of any rate.
        if self
            .marks
            .front()
            .is_none_or(|(began_ns, _)| sent_ns < *began_ns)
        {
            return;
        }
        let count = &mut self.counts[index];
        count.messages += 1 + missed;
        // Those that were missed count as large as this one.
        count.bytes += bytes as u64 * (1 + missed);
    }

    /// Notes the counts of this moment. [ns]
    pub(super) fn mark(&mut self, now_ns: u64) {
        self.marks.push_back((now_ns, self.counts.clone()));
        // The oldest one that stays is at least a window old.
        while let Some((next_ns, _)) = self.marks.get(1)
            && now_ns.saturating_sub(*next_ns) >= WINDOW_NS
        {
            self.marks.pop_front();
        }
    }

    /// Time between the oldest mark and the newest. [s]
    pub(super) fn window_s(&self) -> f64 {
        let ends = self.marks.front().zip(self.marks.back());
        ends.map_or(0.0, |(first, last)| seconds(last.0 - first.0))
    }

    /// The lines of all topics at `now_ns`, with the rates between the marks.
    pub(super) fn lines(&self, now_ns: u64) -> Vec<TopicLine> {
        let window_s = self.window_s();
        let per_second = |n: u64| {
            if window_s > 0.0 {
                count(n) / window_s
            } else {
                0.0
            }
        };
        let ends = self.marks.front().zip(self.marks.back());
        let line = |(index, topic): (usize, &&'static str)| {
            let (messages, bytes) = ends.map_or((0, 0), |((_, first), (_, last))| {
                let (first, last) = (first[index], last[index]);
                (last.messages - first.messages, last.bytes - first.bytes)
            });
            let newest_ns = self.newest_ns[index];
            TopicLine {
                topic,
                hz: per_second(messages),
                bytes_per_s: per_second(bytes),
                age_s: (newest_ns > 0).then(|| seconds(now_ns.saturating_sub(newest_ns))),
                missed: self.missed[index],
            }
        };
        self.names.iter().enumerate().map(line).collect()
    }
}

fn count(n: u64) -> f64 {
    n.to_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    #[test]
    fn rates_are_those_of_the_last_seconds_and_count_what_was_missed() {
        let mut totals = Totals::new(vec!["a", "b"]);
        totals.add(0, 10, S, 0);
        totals.mark(2 * S);
        totals.add(0, 10, S, 0);
        let line = &totals.lines(3 * S)[0];
        assert_eq!(
            (line.hz, line.age_s),
            (0.0, Some(2.0)),
            "sent before it began"
        );
        for n in 0..20 {
            totals.add(0, 100, 2 * S + n * S / 20, u64::from(n == 3));
        }
        totals.mark(3 * S);
        let lines = totals.lines(3 * S);
        assert!((lines[0].hz - 21.0).abs() < 1e-9, "{lines:?}");
        assert!((lines[0].bytes_per_s - 2100.0).abs() < 1e-9, "{lines:?}");
        assert_eq!(lines[0].missed, 1);
        assert_eq!((lines[1].hz, lines[1].age_s), (0.0, None), "nothing came");
        // Silence: after a window nothing is left of the rate.
        for second in 4..=8 {
            totals.mark(second * S);
        }
        assert!((totals.window_s() - 5.0).abs() < 1e-9);
        assert!(totals.lines(8 * S)[0].hz.abs() < 1e-12);
    }
}
