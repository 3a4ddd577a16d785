//! Processes whose answers do not count: newcomers before they are obeyed, predecessors after.

use crate::Distribution;
use crate::result::swap::AnswerTimes;
use std::collections::{BTreeSet, VecDeque};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};

/// Changes of what counts that are remembered; the oldest go first.
const RANGES_MAX: usize = 64;

/// Answers of one process that may wait for the robot's record of their tick; more are not taken.
const CLAIMS_MAX: usize = 1024;

/// Ticks by which a process may seem ahead of the robot in real time: records of different processes
/// do not come in order.
pub const AHEAD_TICKS: u64 = 2;

/// Ticks at which the answers of a process do not count.
#[derive(Debug, Clone, Copy)]
struct Range {
    role: u16,
    epoch: u32,
    from_tick: u64,
    until_tick: u64,
}

/// A process whose answers are watched, whether they count or not.
#[derive(Debug, Default)]
struct Watched {
    role: u16,
    epoch: u32,
    answered_tick: u64,
    /// Answered ticks that the robot is not known to have begun.
    claimed: BTreeSet<u64>,
    times: Distribution,
}

/// See the module's description.
#[derive(Debug, Default)]
pub struct ShadowAnswers {
    ranges: VecDeque<Range>,
    watched: Vec<Watched>,
    /// Newest tick that the robot has begun.
    robot_tick: u64,
    /// Tick of the newest velocity command of the guard that is obeyed.
    command_tick: u64,
    /// Most ticks from one command to the next.
    command_gap_ticks: u64,
}

impl ShadowAnswers {
    /// From `from_tick` on the answers of this process do not count.
    pub fn begin(&mut self, role: Role, epoch: u32, from_tick: u64) {
        if self.ranges.len() == RANGES_MAX {
            self.ranges.pop_front();
        }
        self.ranges.push_back(Range {
            role: role.code(),
            epoch,
            from_tick,
            until_tick: u64::MAX,
        });
    }

    /// From `tick` on they count again.
    pub fn end(&mut self, role: Role, epoch: u32, tick: u64) {
        let open = |range: &&mut Range| {
            (range.role, range.epoch, range.until_tick) == (role.code(), epoch, u64::MAX)
        };
        if let Some(range) = self.ranges.iter_mut().find(open) {
            range.until_tick = tick;
        }
    }

    /// True when the answer counts.
    #[must_use]
    pub fn counts(&self, span: &Span) -> bool {
        !self.ranges.iter().any(|range| {
            (range.role, range.epoch) == (span.role, span.epoch)
                && (range.from_tick..range.until_tick).contains(&span.tick)
        })
    }

    /// Watches these processes of a seat from now on, and no others.
    pub fn watch(&mut self, role: Role, epochs: &[u32]) {
        let mut before = core::mem::take(&mut self.watched);
        for epoch in epochs {
            let of = |it: &Watched| (it.role, it.epoch) == (role.code(), *epoch);
            let known = before.iter().position(of);
            self.watched.push(known.map_or_else(
                || Watched {
                    role: role.code(),
                    epoch: *epoch,
                    ..Watched::default()
                },
                |at| before.swap_remove(at),
            ));
        }
        self.command_gap_ticks = 0;
    }

    /// Takes in a velocity command of the guard that is obeyed. `last` is the last tick that it can have.
    pub fn command(&mut self, tick: u64, last: u64) {
        if (self.command_tick + 1..=last).contains(&tick) {
            if self.command_tick > 0 {
                self.command_gap_ticks = self.command_gap_ticks.max(tick - self.command_tick);
            }
            self.command_tick = tick;
        }
    }

    /// Most ticks from one velocity command to the next since the processes are watched; 1 when none
    /// is missing.
    #[must_use]
    pub fn command_gap_ticks(&self) -> u64 {
        self.command_gap_ticks
    }

    /// Forgets the times, as of another part of a swap.
    pub fn restart_times(&mut self) {
        for watched in &mut self.watched {
            watched.times = Distribution::default();
        }
    }

    /// Takes in a record of a watched process.
    pub fn note(&mut self, span: &Span) {
        let of = |it: &&mut Watched| (it.role, it.epoch) == (span.role, span.epoch);
        if span.kind() != Some(SpanKind::Answer) {
            return;
        }
        if let Some(watched) = self.watched.iter_mut().find(of) {
            if span.tick <= self.robot_tick {
                watched.answered_tick = watched.answered_tick.max(span.tick);
            } else if watched.claimed.len() < CLAIMS_MAX {
                watched.claimed.insert(span.tick);
            }
            if span.output != 0 {
                (watched.times).add(span.published_ns.saturating_sub(span.woken_ns));
            }
        }
    }

    /// The robot has begun `robot_tick`, and can have begun none after `last`. Answers of ticks that it
    /// has not begun do not count until it has, and those after `last` never: a process that claims
    /// them would not be missed once it is mute.
    pub fn settle(&mut self, robot_tick: u64, last: u64) {
        self.robot_tick = robot_tick;
        for watched in &mut self.watched {
            let (begun, ahead) = core::mem::take(&mut watched.claimed)
                .into_iter()
                .partition::<BTreeSet<_>, _>(|tick| *tick <= robot_tick);
            let newest = begun.last().copied().unwrap_or(0);
            watched.answered_tick = watched.answered_tick.max(newest);
            watched.claimed = ahead.into_iter().filter(|tick| *tick <= last).collect();
        }
    }

    fn of(&self, epoch: u32) -> Option<&Watched> {
        self.watched.iter().find(|watched| watched.epoch == epoch)
    }

    /// Newest tick that a watched process has answered.
    #[must_use]
    pub fn answered(&self, epoch: u32) -> u64 {
        self.of(epoch).map_or(0, |watched| watched.answered_tick)
    }

    /// How long a watched process took from wake to answer.
    #[must_use]
    pub fn times(&self, epoch: u32) -> AnswerTimes {
        let figures = self.of(epoch).map(|watched| watched.times.figures());
        let figures = figures.unwrap_or_default();
        AnswerTimes {
            n: figures.n,
            p50_us: figures.p50_us,
            p99_us: figures.p99_us,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_of_ticks_that_the_robot_has_not_begun_do_not_count() {
        let (role, mut aside) = (Role::CollisionGuard, ShadowAnswers::default());
        aside.watch(role, &[1, 2]);
        let answer = |aside: &mut ShadowAnswers, epoch, tick| {
            aside.note(&Span {
                role: role.code(),
                kind: SpanKind::Answer.code(),
                epoch,
                tick,
                ..Span::default()
            });
        };
        // Records of the processes come before those of the robot, and one claims what is to come.
        for tick in 1..=9 {
            answer(&mut aside, 1, tick);
        }
        for tick in [9, 10, 11, 12, 13, u64::MAX] {
            answer(&mut aside, 2, tick);
        }
        aside.settle(9, 9 + AHEAD_TICKS);
        assert_eq!((aside.answered(1), aside.answered(2)), (9, 9));
        for tick in 10..=20 {
            answer(&mut aside, 1, tick);
            aside.settle(tick, tick + AHEAD_TICKS);
        }
        let mute_since = 9 + AHEAD_TICKS;
        assert_eq!((aside.answered(1), aside.answered(2)), (20, mute_since));
        aside.command(u64::MAX, 22);
        for tick in [20, 23] {
            aside.command(tick, 25);
        }
        assert_eq!(aside.command_gap_ticks(), 3);
    }

    #[test]
    fn answers_count_for_the_ticks_at_which_their_process_is_obeyed() {
        let (role, mut aside) = (Role::LocalPlanner, ShadowAnswers::default());
        // Process 2 is warm, is obeyed from tick 10 on, and no longer from tick 20 on.
        aside.begin(role, 2, 0);
        aside.end(role, 2, 10);
        aside.begin(role, 1, 10);
        aside.begin(role, 2, 20);
        aside.end(role, 1, 20);
        let counts = |epoch, tick| {
            aside.counts(&Span {
                role: role.code(),
                epoch,
                tick,
                ..Span::default()
            })
        };
        for (tick, obeyed) in [(9, 1), (10, 2), (19, 2), (20, 1)] {
            assert!(counts(obeyed, tick) && !counts(3 - obeyed, tick), "{tick}");
        }
    }
}
