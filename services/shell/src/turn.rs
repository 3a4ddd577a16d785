//! When a role has to answer: one rule for both clocks.
//!
//! In lockstep a role answers every tick of its trigger exactly once, when everything that belongs
//! to the tick is there. In real time it answers the newest input of every wake, and what comes
//! in after that repeats the tick.

use crate::roster::Roster;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;

/// What has come in, as far as it decides whether an answer is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Trigger {
    /// Newest tick that the role has to answer; 0 before the first.
    pub tick: u64,
    /// Everything that the answer waits for is there.
    pub complete: bool,
    /// Something came in that is worth another answer to the same tick, real time only.
    pub news: bool,
}

/// An answer that is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Turn {
    /// Tick that is answered, 0 = idle output.
    pub tick: u64,
    /// What kind of answer it is.
    pub kind: SpanKind,
}

impl Turn {
    /// The idle output, with which a role says that it is there.
    pub const IDLE: Self = Self {
        tick: 0,
        kind: SpanKind::Idle,
    };
}

/// The answer that is due from `role`, which has answered up to `answered_tick`.
pub(crate) fn due(
    roster: &Roster,
    role: Role,
    answered_tick: u64,
    trigger: &Trigger,
) -> Option<Turn> {
    let tick = trigger.tick;
    let kind = if tick > answered_tick {
        let obliged = !roster.lockstep() || roster.answers(role, tick);
        (trigger.complete && obliged).then_some(SpanKind::Answer)
    } else {
        (trigger.news && tick > 0 && !roster.lockstep()).then_some(SpanKind::Extra)
    };
    kind.map(|kind| Turn { tick, kind })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::run::{RunClock, RunMode, Seat};

    fn roster(mode: RunMode, off_tick: u64, on_tick: u64) -> Roster {
        Roster {
            clock: RunClock {
                mode: mode.code(),
                ..RunClock::default()
            },
            seats: vec![Seat {
                role: Role::Mapping.code(),
                epoch: 1,
                off_tick,
                on_tick,
                ..Seat::default()
            }],
            ..Roster::default()
        }
    }

    /// What is due after tick 5 was answered.
    fn check(roster: &Roster, tick: u64, complete: bool, news: bool, kind: Option<SpanKind>) {
        let trigger = Trigger {
            tick,
            complete,
            news,
        };
        assert_eq!(
            due(roster, Role::Mapping, 5, &trigger),
            kind.map(|kind| Turn { tick, kind }),
            "{trigger:?}"
        );
    }

    #[test]
    fn in_lockstep_every_tick_is_answered_once_and_whole() {
        let roster = roster(RunMode::Lockstep, 0, 0);
        check(&roster, 6, true, false, Some(SpanKind::Answer));
        check(&roster, 6, true, true, Some(SpanKind::Answer));
        check(&roster, 6, false, true, None);
        check(&roster, 5, true, true, None);
        check(&roster, 0, true, true, None);
    }

    #[test]
    fn in_lockstep_an_empty_seat_owes_nothing() {
        let roster = roster(RunMode::Lockstep, 6, 9);
        check(&roster, 6, true, true, None);
        check(&roster, 9, true, false, Some(SpanKind::Answer));
    }

    #[test]
    fn in_real_time_news_repeats_the_tick() {
        let roster = roster(RunMode::RealTime, 0, 0);
        check(&roster, 6, true, false, Some(SpanKind::Answer));
        check(&roster, 6, false, true, None);
        check(&roster, 5, true, true, Some(SpanKind::Extra));
        check(&roster, 5, true, false, None);
        let before_the_first = Trigger {
            news: true,
            ..Trigger::default()
        };
        assert_eq!(due(&roster, Role::Mapping, 0, &before_the_first), None);
    }
}
