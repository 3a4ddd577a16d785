//! How long scans take to the wheels, from the records that the processes leave. Pure.
//!
//! As in launch's results: boundaries of hops are single clock readings of the processes, the
//! reaction is the time from the capture of a scan to the first command whose author checked it, and
//! the hops through map and path are those of the first command that follows a new path. The hops of
//! a scan are those of the first command that rests on it: later ones use it again, and what lies
//! between is its age, not the way of a message.
//!
//! A process that is kept from reading loses records, more of them the busier the machine is. What
//! rests on a lost one is counted as missed, never guessed, and percentiles over the rest are
//! withheld, because it is the quiet part.

use core::hash::Hash;
use std::collections::{HashMap, VecDeque};
use zeronav_msgs::header::Id;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_observe::hop_chain::HopChain;
use zeronav_observe::statistics::percentile;

/// Records that are kept of each role.
const KEPT: usize = 512;

/// Scans of which reactions are kept for percentiles.
const REACTIONS: usize = 600;

/// One scan in so many may have been missed without the percentiles being withheld.
const MISSED_ONE_IN: usize = 50;

/// Roles whose records a reaction rests on.
const CONTROL: [Role; 3] = [Role::Robot, Role::LocalPlanner, Role::CollisionGuard];

/// Upper ends of the bins of the histogram; the last bin has none. [us]
pub(crate) const BINS_US: [u64; 16] = [
    100, 150, 220, 330, 500, 750, 1_100, 1_600, 2_400, 3_600, 5_400, 8_000, 12_000, 20_000, 50_000,
    100_000,
];

/// The newest values by key, oldest dropped.
#[derive(Debug)]
struct Recent<K, V> {
    values: HashMap<K, V>,
    order: VecDeque<K>,
}

impl<K, V> Default for Recent<K, V> {
    fn default() -> Self {
        Self {
            values: HashMap::new(),
            order: VecDeque::new(),
        }
    }
}

impl<K: Hash + Eq + Copy, V> Recent<K, V> {
    fn insert(&mut self, key: K, value: V) {
        if self.values.insert(key, value).is_some() {
            return;
        }
        self.order.push_back(key);
        if self.order.len() > KEPT
            && let Some(oldest) = self.order.pop_front()
        {
            self.values.remove(&oldest);
        }
    }

    fn get(&self, key: K) -> Option<&V> {
        self.values.get(&key)
    }
}

/// A way that a command took.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Taken {
    /// Its hops.
    pub way: HopChain,
    /// Run tick of the command.
    pub tick: u64,
}

/// The scan that the local planner uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct InUse {
    scan: u64,
    /// Time since its capture when it was used last. [ns]
    pub age_ns: u64,
    /// Commands that rest on it.
    pub uses: u64,
}

/// Follows records as they come.
#[derive(Debug, Default)]
pub(crate) struct Hops {
    /// Answers by role and main message.
    answers: Recent<(u16, u64), Span>,
    /// The robot's, by scan.
    scans: Recent<u64, Span>,
    /// When the first request was begun that followed a path. [ns]
    driving_ns: Option<u64>,
    /// Newest scan with a reaction.
    reacted: u64,
    /// Of the newest scans; `None` where records that it rests on were lost. [ns]
    reactions_ns: VecDeque<Option<u64>>,
    /// Reactions since the beginning, by bin.
    bins: [u64; BINS_US.len() + 1],
    n_reactions: u64,
    /// Path of the last way through the map.
    followed: u64,
    /// Path that began a new geometry.
    awaited: u64,
    last_replanning: Option<Taken>,
    last_direct: Option<Taken>,
    in_use: Option<InUse>,
    /// The newest main message of each role whose record came.
    newest: HashMap<u16, Id>,
    /// Records that did not come, now and at the last reaction.
    n_lost: u64,
    n_lost_before: u64,
    n_missed: u64,
    /// Commands of the guard that came since the last [`Self::settle`], and before it.
    commands: [Vec<Span>; 2],
    /// Commands at the wheels that came since the last [`Self::settle`], and before it.
    applied: [Vec<Span>; 2],
}

impl Hops {
    /// A path with another geometry was sent: the first command that follows it is of interest.
    pub(crate) fn new_path(&mut self, id: u64) {
        self.awaited = id;
    }

    /// Takes in a record.
    pub(crate) fn take(&mut self, span: &Span) {
        self.count_lost(span);
        match (span.kind(), span.role()) {
            (Some(SpanKind::Applied), _) if self.applied[0].len() < KEPT => {
                self.applied[0].push(*span);
            }
            (Some(SpanKind::Answer | SpanKind::Extra), Some(role)) => {
                if role == Role::Robot && span.scan != 0 {
                    self.scans.insert(span.scan, *span);
                }
                if span.output != 0 {
                    self.answers.insert((span.role, span.output), *span);
                }
                if role == Role::LocalPlanner && span.path != 0 {
                    self.driving_ns.get_or_insert(span.started_ns);
                }
                if role == Role::CollisionGuard && self.commands[0].len() < KEPT {
                    self.commands[0].push(*span);
                }
            }
            _ => {}
        }
    }

    /// Every main message has its record, and they are numbered.
    fn count_lost(&mut self, span: &Span) {
        let is_counted = (span.role()).is_some_and(|role| CONTROL.contains(&role));
        if !is_counted || span.output == 0 {
            return;
        }
        let id = Id(span.output);
        if let Some(before) = self.newest.insert(span.role, id)
            && before.epoch() == id.epoch()
        {
            let between = id.count().saturating_sub(before.count());
            self.n_lost += between.saturating_sub(1);
        }
    }

    /// Follows the commands at the wheels back to their scans; gives the way through the map of the
    /// first one after a new path. To be called whenever all that has come was taken in.
    ///
    /// Records come writer by writer, and paths by themselves: a command may come before the records
    /// that it rests on. These are there one call later.
    pub(crate) fn settle(&mut self) -> Option<Taken> {
        let [fresh, due] = core::mem::take(&mut self.commands);
        for guard in &due {
            self.commanded(guard);
        }
        self.commands = [Vec::new(), fresh];
        let [fresh, mut due] = core::mem::take(&mut self.applied);
        let replanned = due.drain(..).fold(None, |before, span| {
            let taken = self.applied(&span).cloned();
            before.or(taken)
        });
        self.applied = [due, fresh];
        replanned
    }

    fn answer(&self, role: Role, output: u64) -> Option<&Span> {
        self.answers.get((role.code(), output))
    }

    /// The record before one of the same process; `None` when it did not come or there is none.
    fn before(&self, span: &Span) -> Option<&Span> {
        (self.answers).get((
            span.role,
            Id(span.output).count().checked_sub(1)? | epoch_of(span),
        ))
    }

    /// Whether an answer is the first one on its scan; `None` when the record before it was lost.
    /// Of the guard, that of its request counts.
    fn is_first_on_its_scan(&self, span: &Span) -> Option<bool> {
        if Id(span.output).count() <= 1 {
            return Some(true);
        }
        let before = self.before(span)?;
        let scan = |span: &Span| match span.role() {
            Some(Role::CollisionGuard) if span.request == 0 => Some(0),
            Some(Role::CollisionGuard) => Some(self.answer(Role::LocalPlanner, span.request)?.scan),
            _ => Some(span.scan),
        };
        Some(scan(before)? != scan(span)?)
    }

    /// The guard has sent a command: perhaps the first one after a scan.
    fn commanded(&mut self, guard: &Span) {
        let Some(local) = self.answer(Role::LocalPlanner, guard.request) else {
            return;
        };
        if local.scan <= self.reacted || local.path == 0 {
            return;
        }
        let (scan, Some(robot)) = (local.scan, self.scans.get(local.scan)) else {
            return;
        };
        if self
            .driving_ns
            .is_none_or(|from_ns| robot.capture_ns < from_ns)
        {
            // As in results: reactions are those of scans that came while a path was followed.
            (self.reacted, self.n_lost_before) = (scan, self.n_lost);
            return;
        }
        let is_first = self.is_first_on_its_scan(guard) == Some(true);
        let reaction_ns = guard.published_ns.saturating_sub(robot.capture_ns);
        let is_measured = is_first.then_some(reaction_ns);
        let (first, now) = (Id(self.reacted), Id(scan));
        if self.n_lost > self.n_lost_before && first.is_some() && first.epoch() == now.epoch() {
            // Nothing came of the scans between.
            let between = now.count().saturating_sub(first.count() + 1);
            (0..between.min(REACTIONS as u64)).for_each(|_| self.miss());
        }
        self.n_lost_before = self.n_lost;
        self.reacted = scan;
        match is_measured {
            Some(reaction_ns) => self.measured(reaction_ns),
            // Of the first scan of all, nobody was there to see what was before.
            None if first.is_some() => self.miss(),
            None => {}
        }
    }

    fn measured(&mut self, reaction_ns: u64) {
        self.keep(Some(reaction_ns));
        let bin = BINS_US.partition_point(|end_us| end_us * 1000 <= reaction_ns);
        self.bins[bin] += 1;
        self.n_reactions += 1;
    }

    fn miss(&mut self) {
        self.keep(None);
        self.n_missed += 1;
    }

    fn keep(&mut self, reaction_ns: Option<u64>) {
        if self.reactions_ns.len() == REACTIONS {
            self.reactions_ns.pop_front();
        }
        self.reactions_ns.push_back(reaction_ns);
    }

    /// A command reached the wheels.
    fn applied(&mut self, applied: &Span) -> Option<&Taken> {
        let guard = *self.answer(Role::CollisionGuard, applied.request)?;
        let local = *self.answer(Role::LocalPlanner, guard.request)?;
        let (tick, path) = (applied.tick, local.path);
        if let Some(scan) = self.scans.get(local.scan) {
            let uses = self.in_use.filter(|before| before.scan == local.scan);
            let in_use = InUse {
                scan: local.scan,
                age_ns: local.started_ns.saturating_sub(scan.capture_ns),
                uses: uses.map_or(1, |before| before.uses + 1),
            };
            if self.is_first_on_its_scan(&local) == Some(true) {
                let way = HopChain::direct([scan, &local, &guard, applied]);
                self.last_direct = Some(Taken { way, tick });
            }
            self.in_use = Some(in_use);
        }
        if path < self.awaited || path == 0 || self.followed >= self.awaited {
            return None;
        }
        self.followed = self.awaited;
        let global = self.answer(Role::GlobalPlanner, self.awaited)?;
        let mapping = self.answer(Role::Mapping, global.map)?;
        let scan = self.scans.get(mapping.scan)?;
        let way = HopChain::through_map([scan, mapping, global, &local, &guard, applied]);
        self.last_replanning = Some(Taken { way, tick });
        self.last_replanning.as_ref()
    }

    /// The hops of the first command that followed the last new path, where it came of a scan.
    pub(crate) fn replanning(&self) -> Option<&Taken> {
        self.last_replanning.as_ref()
    }

    /// The hops of the last command at the wheels that was the first one on its scan.
    pub(crate) fn direct(&self) -> Option<&Taken> {
        self.last_direct.as_ref()
    }

    /// The scan that the last command at the wheels rests on.
    pub(crate) fn in_use(&self) -> Option<InUse> {
        self.in_use
    }

    /// Records that did not come, and scans whose reaction is not known for that.
    pub(crate) fn lost(&self) -> (u64, u64) {
        (self.n_lost, self.n_missed)
    }

    /// How many reactions were measured, and how many of them in each bin.
    pub(crate) fn histogram(&self) -> (u64, &[u64]) {
        (self.n_reactions, &self.bins)
    }

    /// Quantiles of the newest reactions; `None` when there are none, and when more than one scan in
    /// [`MISSED_ONE_IN`] was missed among them. [ns]
    pub(crate) fn quantiles<const N: usize>(&self, wanted: [f64; N]) -> Option<[u64; N]> {
        let mut times_ns: Vec<u64> = self.reactions_ns.iter().copied().flatten().collect();
        let n_missed = self.reactions_ns.len() - times_ns.len();
        if times_ns.is_empty() || n_missed * MISSED_ONE_IN > self.reactions_ns.len() {
            return None;
        }
        Some(wanted.map(|share| percentile(&mut times_ns, share).unwrap_or_default()))
    }
}

/// The epoch of the process that wrote a record, as it stands in ids.
fn epoch_of(span: &Span) -> u64 {
    Id::new(Id(span.output).epoch(), 0).0
}

#[cfg(test)]
mod tests;
