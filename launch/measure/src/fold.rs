//! The hash of a lockstep run.

use core::fmt::Write;
use std::collections::BTreeMap;
use zeronav_msgs::message::{FNV_OFFSET, fnv1a};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};

/// Folds the hashes of all answers by (tick, role). Two runs with the same seed and the same
/// binaries on the same machine give the same value, whatever the load.
#[derive(Debug, Clone, Default)]
pub struct RunHash {
    answers: BTreeMap<(u64, u16), u64>,
}

impl RunHash {
    /// Takes in a span; idle outputs and applied commands do not count.
    pub fn add(&mut self, span: &Span) {
        if span.kind() == Some(SpanKind::Answer) && span.tick > 0 {
            self.answers.insert((span.tick, span.role), span.hash);
        }
    }

    /// Every answer up to `last_tick` as lines `tick,role,hash`, so that two runs that should be
    /// alike can be laid side by side.
    #[must_use]
    pub fn to_csv(&self, last_tick: u64) -> String {
        let mut text = "tick,role,hash\n".to_owned();
        for ((tick, role), hash) in self.answers.range(..=(last_tick, u16::MAX)) {
            let role = Role::from_code(*role).map_or("unknown", Role::label);
            let _ = writeln!(text, "{tick},{role},{hash:016x}");
        }
        text
    }

    /// The hash over ticks 1 to `last_tick`, as 16 hexadecimal digits.
    #[must_use]
    pub fn value(&self, last_tick: u64) -> String {
        let mut state = FNV_OFFSET;
        for ((tick, role), hash) in self.answers.range(..=(last_tick, u16::MAX)) {
            state = fnv1a(state, &tick.to_le_bytes());
            state = fnv1a(state, &role.to_le_bytes());
            state = fnv1a(state, &hash.to_le_bytes());
        }
        format!("{state:016x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(tick: u64, role: u16, hash: u64) -> Span {
        Span {
            tick,
            role,
            hash,
            epoch: 1,
            kind: SpanKind::Answer.code(),
            ..Span::default()
        }
    }

    #[test]
    fn order_of_arrival_does_not_matter_but_every_bit_does() {
        let fold = |spans: &[Span]| {
            let mut hash = RunHash::default();
            for span in spans {
                hash.add(span);
            }
            hash.value(9)
        };
        let (a, b) = (answer(1, 2, 7), answer(1, 3, 8));
        assert_eq!(fold(&[a, b]), fold(&[b, a]));
        assert_ne!(fold(&[a, b]), fold(&[a, answer(1, 3, 9)]));
        assert_ne!(fold(&[a, b]), fold(&[a]));
        assert_eq!(
            fold(&[a, b]),
            fold(&[a, b, answer(10, 2, 1)]),
            "later ticks stay out"
        );
        let idle = Span {
            kind: SpanKind::Idle.code(),
            ..answer(0, 4, 3)
        };
        assert_eq!(fold(&[a, b]), fold(&[a, b, idle]));
        // Before the first tick nothing is owed, so whether there is an answer is chance.
        assert_eq!(fold(&[a, b]), fold(&[a, b, answer(0, 4, 3)]));
    }
}
