//! Who does not make progress. Pure over progress counters.
//!
//! Time counts only as far as launch itself was awake: a machine that is suspended, or a load that
//! keeps launch from looking, makes no process look hung. Seats that stand still together are more likely
//! kept waiting by the machine (a processor that the host took away) than hung at the same moment:
//! they get [`TOGETHER`] times as long.

use core::time::Duration;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use zeronav_msgs::role::Role;

/// Most time that one look adds.
const LOOK_MAX: Duration = Duration::from_millis(20);

/// How many times longer seats may stand still that do it together.
pub(crate) const TOGETHER: u32 = 10;

/// Progress of every seat, as it was seen last.
#[derive(Debug, Clone, Default)]
pub(crate) struct HangWatch {
    seen: HashMap<Role, (u32, u64, Duration)>,
}

impl HangWatch {
    /// One look, `since` after the one before: the seat's epoch and progress counter. True when
    /// the counter has stood still for longer than `limit`, or much longer beside others.
    pub(crate) fn look(
        &mut self,
        role: Role,
        epoch: u32,
        progress: u64,
        since: Duration,
        limit: Duration,
    ) -> bool {
        let fresh = (epoch, progress, Duration::ZERO);
        let seen = match self.seen.entry(role) {
            Entry::Vacant(seat) => seat.insert(fresh),
            Entry::Occupied(seat) => {
                let seen = seat.into_mut();
                if (seen.0, seen.1) == (epoch, progress) {
                    seen.2 += since.min(LOOK_MAX);
                } else {
                    *seen = fresh;
                }
                seen
            }
        };
        let still = seen.2;
        let together = self.seen.values().filter(|seen| seen.2 > limit / 2).count() > 1;
        let times = if together { TOGETHER } else { 1 };
        still > limit.saturating_mul(times)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standing_still_counts_only_while_launch_looks() {
        let limit = Duration::from_millis(500);
        let mut watch = HangWatch::default();
        let mut look =
            |progress, ms| watch.look(Role::Mapping, 1, progress, Duration::from_millis(ms), limit);
        assert!(!look(1, 10));
        assert!(!look(1, 3000), "launch was asleep, too");
        for _ in 0..48 {
            assert!(!look(1, 10));
        }
        assert!(look(1, 10));
        assert!(!look(2, 10), "it goes on");
    }

    #[test]
    fn seats_that_stand_still_together_get_more_time() {
        let limit = Duration::from_millis(100);
        let since = Duration::from_millis(10);
        let mut watch = HangWatch::default();
        let (mut first, mut looks) = (0, 0);
        while first == 0 {
            looks += 1;
            let alone = watch.look(Role::Mapping, 1, looks, since, limit);
            assert!(!alone, "it goes on");
            let one = watch.look(Role::GlobalPlanner, 1, 7, since, limit);
            let other = watch.look(Role::CollisionGuard, 1, 9, since, limit);
            if one || other {
                first = looks;
            }
        }
        // The first look counts no time, and standing still has to last longer than the limit.
        assert_eq!(first, 10 * u64::from(TOGETHER) + 2);
    }

    #[test]
    fn a_successor_starts_with_a_clean_slate() {
        let limit = Duration::from_millis(5);
        let mut watch = HangWatch::default();
        let since = Duration::from_millis(10);
        watch.look(Role::Mapping, 1, 7, since, limit);
        assert!(watch.look(Role::Mapping, 1, 7, since, limit));
        assert!(!watch.look(Role::Mapping, 2, 7, since, limit));
    }
}
