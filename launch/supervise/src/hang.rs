//! Who does not make progress. Pure over progress counters and the kernel's counters.
//!
//! What counts against a process that stands still is its own time: what it computed, and what it slept
//! or was stopped ([`OwnTime`]). Time in a run queue does not count: a process that waits for a processor is
//! starved, and a successor would starve as well. Time counts only as far as launch itself was awake: a
//! machine that is suspended, or a load that keeps launch from looking, makes no process look hung.
//! Seats that stand still together are more likely kept waiting by the machine (a processor that the host
//! took away) than hung at the same moment: they get [`LENIENT`] times as long. So do waits for a device,
//! and in lockstep computing, which takes longer on another machine: a long search must not end otherwise
//! there.

use super::own_time::{OwnTime, Reading, awake};
use core::time::Duration;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use zeronav_msgs::role::Role;

/// How many times longer seats may stand still that the machine may keep waiting.
pub const LENIENT: u32 = 10;

/// The kernel is asked from this share of the limit on: one over it.
const ASK_FROM: u32 = 4;

/// When a process that stands still is hung.
#[derive(Debug, Clone, Copy)]
pub struct Limit {
    /// `hang_after_s` of the scenario.
    pub after: Duration,
    /// True in lockstep.
    pub lockstep: bool,
}

/// A service that stood still because it got no processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Starved {
    /// Its seat.
    pub role: Role,
    /// For how long it waited for a processor while it stood still.
    pub waited: Duration,
    /// For how long it stood still.
    pub still: Duration,
}

/// A seat as it was seen last.
#[derive(Debug, Clone)]
struct Observed {
    epoch: u32,
    progress: u64,
    /// For how long it has stood still, by launch's clock.
    still: Duration,
    /// Where that time went, from [`ASK_FROM`] on; before that it counts as blocked.
    spent: OwnTime,
    asked: bool,
}

impl Observed {
    fn new(epoch: u32, progress: u64) -> Self {
        Self {
            epoch,
            progress,
            still: Duration::ZERO,
            spent: OwnTime::default(),
            asked: false,
        }
    }

    /// What counts against the limit.
    fn counted(&self, lockstep: bool) -> Duration {
        let OwnTime {
            ran,
            blocked,
            device,
            ..
        } = self.spent;
        if lockstep {
            blocked + (ran + device) / LENIENT
        } else {
            blocked + ran + device / LENIENT
        }
    }

    /// Its time without a processor, when it would have counted as hung with it.
    fn starved(&self, role: Role, limit: Duration) -> Option<Starved> {
        let waited = self.spent.waited;
        (self.spent.total() + waited > limit && waited > self.spent.total()).then_some(Starved {
            role,
            waited,
            still: self.still,
        })
    }
}

/// Progress of every seat, as it was seen last.
#[derive(Debug, Clone, Default)]
pub struct HangWatch {
    seen: HashMap<Role, Observed>,
    starved: Vec<Starved>,
}

impl HangWatch {
    /// One look, `since` after the one before: the seat's epoch and progress counter, and what the
    /// kernel says of its process. True when the counter has stood still for more than the limit of
    /// the process's own time, or much more beside others.
    pub fn look(
        &mut self,
        role: Role,
        (epoch, progress): (u32, u64),
        since: Duration,
        limit: Limit,
        reading: impl FnOnce() -> Option<Reading>,
    ) -> bool {
        let seen = match self.seen.entry(role) {
            Entry::Vacant(seat) => seat.insert(Observed::new(epoch, progress)),
            Entry::Occupied(seat) => {
                let seen = seat.into_mut();
                if (seen.epoch, seen.progress) == (epoch, progress) {
                    seen.stand_still(since, limit.after, reading);
                } else {
                    let before = core::mem::replace(seen, Observed::new(epoch, progress));
                    self.starved.extend(before.starved(role, limit.after));
                }
                seen
            }
        };
        let counted = seen.counted(limit.lockstep);
        let half = limit.after / 2;
        let with_it = |seen: &&Observed| seen.counted(limit.lockstep) > half;
        let together = self.seen.values().filter(with_it).count() > 1;
        let times = if together { LENIENT } else { 1 };
        counted > limit.after.saturating_mul(times)
    }

    /// The services that were starved and have gone on since this was last asked.
    pub fn take_starved(&mut self) -> Vec<Starved> {
        core::mem::take(&mut self.starved)
    }

    /// The services that are starved now.
    #[must_use]
    pub fn starving(&self, limit: Duration) -> Vec<Starved> {
        let all = self.seen.iter();
        all.filter_map(|(role, seen)| seen.starved(*role, limit))
            .collect()
    }
}

impl Observed {
    fn stand_still(
        &mut self,
        since: Duration,
        after: Duration,
        reading: impl FnOnce() -> Option<Reading>,
    ) {
        self.still += since;
        if self.asked {
            self.spent.add(since, awake(since), reading);
            return;
        }
        // No need to ask the kernel before.
        self.spent.blocked += awake(since);
        if self.spent.blocked >= after / ASK_FROM {
            self.asked = true;
            self.spent = OwnTime::after(self.spent.blocked, reading());
        }
    }
}

#[cfg(test)]
mod tests;
