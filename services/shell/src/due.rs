//! When a role has to answer: one rule for both clocks.
//!
//! In lockstep a role answers every tick of its trigger exactly once, when every input of that tick
//! has been received. In real time it answers the newest input of every wake, and inputs that come
//! later lead to a further answer to the same tick.

use crate::roster::Roster;
use zeronav_msgs::span::SpanKind;

/// What has come in, as far as it decides whether an answer is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Trigger {
    /// Newest tick that the role has to answer; 0 before the first.
    pub tick: u64,
    /// Every input that the answer waits for has been received.
    pub complete: bool,
    /// Monotonic time at which an incomplete answer is due all the same, real time only; `None` =
    /// it waits until it is complete. [ns]
    pub deadline_ns: Option<u64>,
    /// Something came in that is worth another answer to the same tick, real time only.
    pub news: bool,
}

/// An answer that is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Due {
    /// Tick that is answered, 0 = idle output.
    pub tick: u64,
    /// What kind of answer it is.
    pub kind: SpanKind,
}

impl Due {
    /// The idle output, the first of all: the process runs and has nothing to say yet.
    pub const IDLE: Self = Self {
        tick: 0,
        kind: SpanKind::Idle,
    };
}

/// When the next answer is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Next {
    /// Now.
    Now(Due),
    /// With the missing input, or at this monotonic time. [ns]
    By(u64),
    /// With another input.
    Later,
}

/// When the next answer of this process is due, which has answered up to `answered_tick`. The clock
/// is read only when it matters.
pub(crate) fn next(
    roster: &Roster,
    answered_tick: u64,
    trigger: &Trigger,
    now_ns: impl FnOnce() -> u64,
) -> Next {
    let tick = trigger.tick;
    let lockstep = roster.lockstep();
    let now = |kind| Next::Now(Due { tick, kind });
    if tick <= answered_tick {
        return if trigger.news && tick > 0 && !lockstep {
            now(SpanKind::Extra)
        } else {
            Next::Later
        };
    }
    if lockstep && !roster.owes(tick) {
        return Next::Later;
    }
    match trigger.deadline_ns {
        _ if trigger.complete => now(SpanKind::Answer),
        Some(deadline_ns) if !lockstep && now_ns() >= deadline_ns => now(SpanKind::Answer),
        Some(deadline_ns) if !lockstep => Next::By(deadline_ns),
        _ => Next::Later,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::role::Role;
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
            own: Some((Role::Mapping, 1)),
            ..Roster::default()
        }
    }

    /// What is due after tick 5 was answered.
    fn check(roster: &Roster, tick: u64, complete: bool, news: bool, kind: Option<SpanKind>) {
        let trigger = Trigger {
            tick,
            complete,
            news,
            ..Trigger::default()
        };
        let expected = kind.map_or(Next::Later, |kind| Next::Now(Due { tick, kind }));
        let at_next = next(roster, 5, &trigger, || 0);
        assert_eq!(at_next, expected, "{trigger:?}");
    }

    #[test]
    fn in_lockstep_every_tick_is_answered_once_and_complete() {
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
    fn in_real_time_news_leads_to_a_further_answer() {
        let roster = roster(RunMode::RealTime, 0, 0);
        check(&roster, 6, true, false, Some(SpanKind::Answer));
        check(&roster, 6, false, true, None);
        check(&roster, 5, true, true, Some(SpanKind::Extra));
        check(&roster, 5, true, false, None);
        let before_the_first = Trigger {
            news: true,
            ..Trigger::default()
        };
        let at_next = next(&roster, 0, &before_the_first, || 0);
        assert_eq!(at_next, Next::Later);
    }

    #[test]
    fn in_real_time_a_deadline_ends_the_wait_for_an_input() {
        let trigger = Trigger {
            tick: 6,
            deadline_ns: Some(100),
            ..Trigger::default()
        };
        let at = |mode, now_ns| next(&roster(mode, 0, 0), 5, &trigger, || now_ns);
        let (tick, kind) = (6, SpanKind::Answer);
        assert_eq!(at(RunMode::RealTime, 99), Next::By(100));
        assert_eq!(at(RunMode::RealTime, 100), Next::Now(Due { tick, kind }));
        assert_eq!(at(RunMode::Lockstep, 100), Next::Later);
    }
}
