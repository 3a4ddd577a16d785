//! How long scans take to the wheels, from the records that the processes leave. Pure.
//!
//! As in launch's results: boundaries of hops are single clock readings of the processes, the
//! reaction is the time from the capture of a scan to the first command whose author checked it, and
//! the hops through map and path are those of the first command that follows a new path.

use core::hash::Hash;
use std::collections::{HashMap, VecDeque};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};

/// Names of the hops through the map, in order.
pub(crate) const THROUGH_MAP: [&str; 10] = [
    "robot",
    "to_mapping",
    "mapping",
    "to_global_planner",
    "global_planner",
    "to_local_planner",
    "local_planner",
    "to_collision_guard",
    "collision_guard",
    "to_robot",
];

/// Names of the hops of a scan that the local planner checks itself.
pub(crate) const DIRECT: [&str; 6] = [
    "robot",
    "to_local_planner",
    "local_planner",
    "to_collision_guard",
    "collision_guard",
    "to_robot",
];

/// Records that are kept of each role.
const KEPT: usize = 512;

/// Reaction times that are kept for percentiles.
const REACTIONS: usize = 600;

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

/// A way that a command took, hop by hop.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Way {
    /// Lengths of the hops. [ns]
    pub hops_ns: Vec<u64>,
    /// Run tick of the command.
    pub tick: u64,
}

impl Way {
    /// Its hops with these names and their lengths. [us]
    pub(crate) fn named_us(&self, names: &[&'static str]) -> Vec<(&'static str, f64)> {
        let hops = names.iter().zip(&self.hops_ns);
        hops.map(|(name, ns)| (*name, micros(*ns))).collect()
    }
}

/// Nanoseconds as microseconds with one decimal.
#[allow(clippy::cast_precision_loss, reason = "times of a cycle")]
pub(crate) fn micros(ns: u64) -> f64 {
    (ns as f64 / 100.0).round() / 10.0
}

/// Follows records as they come.
#[derive(Debug, Default)]
pub(crate) struct Hops {
    /// Answers by role and main message.
    answers: Recent<(u16, u64), Span>,
    /// The robot's, by scan.
    scans: Recent<u64, Span>,
    /// Newest scan with a reaction.
    reacted: u64,
    reactions_ns: VecDeque<u64>,
    /// Reactions since the beginning, by bin.
    bins: [u64; BINS_US.len() + 1],
    n_reactions: u64,
    /// Path of the last way through the map.
    followed: u64,
    /// Path that began a new geometry.
    awaited: u64,
    last_replanning: Option<Way>,
    last_direct: Option<Way>,
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
                if role == Role::CollisionGuard {
                    self.commanded(span);
                }
            }
            _ => {}
        }
    }

    /// Follows the commands at the wheels back to their scans; gives the way through the map of the
    /// first one after a new path. To be called whenever all that has come was taken in.
    ///
    /// Records come writer by writer, and paths by themselves: a command may come before the records
    /// that it rests on. These are there one call later.
    pub(crate) fn settle(&mut self) -> Option<Way> {
        let [fresh, mut due] = core::mem::take(&mut self.applied);
        let replanned = due.drain(..).fold(None, |before, span| {
            let way = self.applied(&span).cloned();
            before.or(way)
        });
        self.applied = [due, fresh];
        replanned
    }

    fn answer(&self, role: Role, output: u64) -> Option<&Span> {
        self.answers.get((role.code(), output))
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
        let reaction_ns = guard.published_ns.saturating_sub(robot.capture_ns);
        self.reacted = scan;
        if self.reactions_ns.len() == REACTIONS {
            self.reactions_ns.pop_front();
        }
        self.reactions_ns.push_back(reaction_ns);
        let bin = BINS_US.partition_point(|end_us| end_us * 1000 <= reaction_ns);
        self.bins[bin] += 1;
        self.n_reactions += 1;
    }

    /// A command reached the wheels.
    fn applied(&mut self, applied: &Span) -> Option<&Way> {
        let guard = self.answer(Role::CollisionGuard, applied.request)?;
        let local = self.answer(Role::LocalPlanner, guard.request)?;
        let control = [
            local.started_ns,
            local.published_ns,
            guard.started_ns,
            guard.published_ns,
            applied.started_ns,
        ];
        let (tick, path) = (applied.tick, local.path);
        let direct = self.scans.get(local.scan).map(|scan| {
            let mut boundaries = vec![scan.capture_ns, scan.published_ns];
            boundaries.extend(control);
            way(&boundaries, tick)
        });
        if direct.is_some() {
            self.last_direct = direct;
        }
        if path < self.awaited || path == 0 || self.followed >= self.awaited {
            return None;
        }
        self.followed = self.awaited;
        self.last_replanning = Some(self.through_map(self.awaited, &control, tick)?);
        self.last_replanning.as_ref()
    }

    fn through_map(&self, path: u64, control: &[u64; 5], tick: u64) -> Option<Way> {
        let global = self.answer(Role::GlobalPlanner, path)?;
        let mapping = self.answer(Role::Mapping, global.map)?;
        let scan = self.scans.get(mapping.scan)?;
        let mut boundaries = vec![
            scan.capture_ns,
            scan.published_ns,
            mapping.started_ns,
            mapping.published_ns,
            global.started_ns,
            global.published_ns,
        ];
        boundaries.extend(control);
        Some(way(&boundaries, tick))
    }

    /// The hops of the first command that followed the last new path, where it came of a scan.
    pub(crate) fn replanning(&self) -> Option<&Way> {
        self.last_replanning.as_ref()
    }

    /// The hops of the last command that reached the wheels.
    pub(crate) fn direct(&self) -> Option<&Way> {
        self.last_direct.as_ref()
    }

    /// How many reactions were measured, and how many of them in each bin.
    pub(crate) fn histogram(&self) -> (u64, &[u64]) {
        (self.n_reactions, &self.bins)
    }

    /// Quantiles of the newest reactions; `None` when there are none. [ns]
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        clippy::cast_sign_loss,
        reason = "at most 600 samples"
    )]
    pub(crate) fn quantiles<const N: usize>(&self, wanted: [f64; N]) -> Option<[u64; N]> {
        let mut sorted: Vec<u64> = self.reactions_ns.iter().copied().collect();
        sorted.sort_unstable();
        let last = sorted.len().checked_sub(1)?;
        Some(wanted.map(|part| sorted[(part * last as f64).round() as usize]))
    }
}

/// Lengths between boundaries; a hop that ends before it begins is 0 long.
fn way(boundaries_ns: &[u64], tick: u64) -> Way {
    let pairs = boundaries_ns.windows(2);
    Way {
        hops_ns: pairs.map(|pair| pair[1].saturating_sub(pair[0])).collect(),
        tick,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(role: Role, output: u64, started_ns: u64, published_ns: u64) -> Span {
        Span {
            role: role.code(),
            kind: SpanKind::Answer.code(),
            epoch: 1,
            output,
            started_ns,
            published_ns,
            ..Span::default()
        }
    }

    /// The records of one scan through map and path to the wheels, in the order in which they are read:
    /// those of the robot first.
    fn cycle(hops: &mut Hops, id: u64, at_ns: u64) -> Option<Way> {
        take_cycle(hops, id, at_ns);
        hops.settle().or_else(|| hops.settle())
    }

    fn take_cycle(hops: &mut Hops, id: u64, at_ns: u64) {
        let of = |role, output, started, published| {
            span(role, output, at_ns + started, at_ns + published)
        };
        hops.take(&Span {
            scan: id,
            capture_ns: at_ns,
            ..of(Role::Robot, id, 0, 10)
        });
        hops.take(&Span {
            kind: SpanKind::Applied.code(),
            request: id,
            tick: id,
            ..of(Role::Robot, 0, 550, 0)
        });
        hops.take(&Span {
            scan: id,
            ..of(Role::Mapping, id, 30, 60)
        });
        hops.take(&Span {
            map: id,
            ..of(Role::GlobalPlanner, id, 100, 150)
        });
        hops.take(&Span {
            path: id,
            scan: id,
            ..of(Role::LocalPlanner, id, 210, 280)
        });
        hops.take(&Span {
            request: id,
            ..of(Role::CollisionGuard, id, 360, 450)
        });
    }

    #[test]
    fn hops_are_differences_of_the_boundaries() {
        let mut hops = Hops::default();
        assert_eq!(cycle(&mut hops, 1, 1_000), None, "no new path was told");
        assert_eq!(hops.replanning(), None);
        hops.new_path(2);
        let way = cycle(&mut hops, 2, 2_000).expect("a way");
        assert_eq!(hops.replanning(), Some(&way));
        assert_eq!(way.named_us(&THROUGH_MAP)[9], ("to_robot", 0.1));
        assert_eq!(way.hops_ns, [10, 20, 30, 40, 50, 60, 70, 80, 90, 100]);
        assert_eq!(way.hops_ns.len(), THROUGH_MAP.len());
        let direct = hops.direct().expect("a way");
        assert_eq!(direct.hops_ns, [10, 200, 70, 80, 90, 100]);
        assert_eq!(direct.hops_ns.len(), DIRECT.len());
        // Later commands on the same path are no replanning.
        assert_eq!(cycle(&mut hops, 3, 9_000), None);
        assert_eq!(hops.replanning().map(|way| way.tick), Some(2));
        assert_eq!(hops.quantiles([0.5]), Some([450]));
    }

    #[test]
    fn what_a_command_rests_on_may_come_after_it() {
        let mut hops = Hops::default();
        take_cycle(&mut hops, 1, 1_000);
        assert_eq!(hops.settle(), None);
        // The path was sent before the command, but is read after it.
        hops.new_path(1);
        take_cycle(&mut hops, 2, 20_000);
        let way = hops.settle().expect("a way");
        assert_eq!((way.tick, way.hops_ns[5]), (1, 60));
        assert_eq!(hops.settle(), None, "later commands are no replanning");
        assert_eq!(hops.direct().map(|way| way.tick), Some(2));
    }

    #[test]
    fn every_scan_counts_once_and_memory_is_bounded() {
        let mut hops = Hops::default();
        for id in 1..2_000 {
            cycle(&mut hops, id, id * 1_000_000);
            cycle(&mut hops, id, id * 1_000_000 + 500);
        }
        let (n, bins) = hops.histogram();
        assert_eq!(n, 1_999);
        assert_eq!(bins[0], 1_999);
        assert_eq!(hops.answers.values.len(), KEPT);
        assert_eq!(hops.reactions_ns.len(), REACTIONS);
    }
}
