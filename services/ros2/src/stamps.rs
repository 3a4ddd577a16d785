//! The stamps of a robot's clock as moments of this host's.
//!
//! Stamp and arrival of each message are apart by the offset of the clocks and the delay of the network. The least
//! difference of the last seconds is taken for the offset, so that what remains is delay: the filter of a one-way clock
//! synchronisation (Paxson, "On calibrating measurements of packet transit times", 1998).

/// For how long a difference counts: one to two of these. [ns]
const WINDOW_NS: u64 = 5_000_000_000;

/// A difference that is this far from the offset comes of a clock that was set. [ns]
const JUMP_NS: i64 = 1_000_000_000;

/// For how long stamps are that much too old until the clock, and not the network, is taken to be the reason. [ns]
const SET_BACK_NS: u64 = 2_000_000_000;

/// Offsets within this of that of the host's own clock: the two are synchronised, and stamps are taken as they are. [ns]
const SAME_CLOCK_NS: i64 = 50_000_000;

/// By how much a stamp may seem to come before its message all the same. [ns]
const SAME_CLOCK_EARLY_NS: i64 = 2_000_000;

/// A stamp as a moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// On the axis of run time: grows as the robot's clock does. [ns]
    pub at_ns: u64,
    /// Monotonic, for ages. [ns]
    pub capture_ns: u64,
    /// By how much the robot's clock was set since the message before, if it was. [ns]
    pub set_by_ns: Option<i64>,
}

/// How the robot's clock relates to this host's.
#[derive(Debug, Clone, Default)]
pub struct Stamps {
    /// The clock is that of a simulation: it may be slower or faster than time.
    sim_time: bool,
    /// Least difference in the current window and in the one before. [ns]
    least: [Option<i64>; 2],
    window_until_ns: u64,
    /// The difference of `CLOCK_MONOTONIC` and the time of the system. [ns]
    host_offset_ns: i64,
    /// Since when stamps are too old.
    old_since_ns: Option<u64>,
    /// What is added to stamps in simulated time. [ns]
    sim_offset_ns: Option<i64>,
}

fn signed(ns: u64) -> i64 {
    i64::try_from(ns).unwrap_or(i64::MAX)
}

impl Stamps {
    /// Nothing has come yet. `host_offset_ns` is `CLOCK_MONOTONIC` minus the time of the system. [ns]
    #[must_use]
    pub fn new(sim_time: bool, host_offset_ns: i64) -> Self {
        Self {
            sim_time,
            host_offset_ns,
            ..Self::default()
        }
    }

    /// The moment of a message with this stamp that came at `came_ns`, monotonic. [ns]
    pub fn moment(&mut self, stamp_ns: u64, came_ns: u64) -> Moment {
        if self.sim_time {
            return self.simulated(stamp_ns, came_ns);
        }
        let difference_ns = signed(came_ns).saturating_sub(signed(stamp_ns));
        let set_by_ns = self.note(difference_ns, came_ns);
        let offset_ns = self.used_offset_ns().unwrap_or(difference_ns);
        let at_ns = signed(stamp_ns).saturating_add(offset_ns);
        let at_ns = u64::try_from(at_ns).unwrap_or(0).min(came_ns);
        Moment {
            at_ns,
            capture_ns: at_ns,
            set_by_ns,
        }
    }

    /// Simulated time begins at the arrival of its first message.
    fn simulated(&mut self, stamp_ns: u64, came_ns: u64) -> Moment {
        let (stamp, came) = (signed(stamp_ns), signed(came_ns));
        let offset_ns = *self.sim_offset_ns.get_or_insert(came.saturating_sub(stamp));
        let at_ns = u64::try_from(stamp.saturating_add(offset_ns)).unwrap_or(0);
        Moment {
            at_ns,
            capture_ns: came_ns,
            set_by_ns: None,
        }
    }

    /// A simulation has begun again: its time goes on from here.
    pub fn restart(&mut self) {
        self.sim_offset_ns = None;
    }

    /// Takes a difference in; by how much the robot's clock was set, if it was. [ns]
    fn note(&mut self, difference_ns: i64, came_ns: u64) -> Option<i64> {
        let offset_ns = self.offset_ns();
        let by_ns = offset_ns.map_or(0, |offset_ns| offset_ns.saturating_sub(difference_ns));
        if by_ns < -JUMP_NS {
            // Late, or the clock was set back: the network is never late for so long without a break.
            let since_ns = *self.old_since_ns.get_or_insert(came_ns);
            if came_ns.saturating_sub(since_ns) < SET_BACK_NS {
                return None;
            }
        }
        self.old_since_ns = None;
        let was_set = by_ns.abs() > JUMP_NS;
        if was_set {
            self.least = [None; 2];
        }
        if came_ns >= self.window_until_ns {
            self.least = [None, self.least[0]];
            self.window_until_ns = came_ns + WINDOW_NS;
        }
        let least = self.least[0].map_or(difference_ns, |it| it.min(difference_ns));
        self.least[0] = Some(least);
        was_set.then_some(by_ns)
    }

    /// The least difference; `None` before the first message. [ns]
    fn offset_ns(&self) -> Option<i64> {
        self.least.into_iter().flatten().min()
    }

    /// What is added to stamps.
    fn used_offset_ns(&self) -> Option<i64> {
        let offset_ns = self.offset_ns()?;
        Some(if self.is_same_clock() {
            self.host_offset_ns
        } else {
            offset_ns
        })
    }

    /// True when the robot's clock is synchronised with this host's, so that delays are known, too.
    #[must_use]
    pub fn is_same_clock(&self) -> bool {
        let apart_ns = self
            .offset_ns()
            .map(|it| it.saturating_sub(self.host_offset_ns));
        apart_ns.is_some_and(|it| (-SAME_CLOCK_EARLY_NS..=SAME_CLOCK_NS).contains(&it))
    }

    /// By how much the robot's clock is ahead of the time of this system, as far as delays allow to say; `None` before
    /// the first message and in simulated time. [ns]
    #[must_use]
    pub fn ahead_ns(&self) -> Option<i64> {
        let offset_ns = self.offset_ns()?;
        Some(self.host_offset_ns.saturating_sub(offset_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;
    const S: u64 = 1_000 * MS;
    /// Monotonic time is far behind that of the system. [ns]
    const HOST_NS: i64 = -1_700_000_000_000_000_000;

    /// The system's time at a monotonic moment. [ns]
    fn system_ns(monotonic_ns: u64) -> u64 {
        monotonic_ns + HOST_NS.unsigned_abs()
    }

    #[test]
    fn clocks_that_agree_show_the_delay_of_each_message() {
        let mut stamps = Stamps::new(false, HOST_NS);
        for (n, delay_ns) in [30 * MS, 8 * MS, 25 * MS].into_iter().enumerate() {
            let captured_ns = 100 * S + n as u64 * 20 * MS;
            let moment = stamps.moment(system_ns(captured_ns), captured_ns + delay_ns);
            assert_eq!(moment.capture_ns, captured_ns);
            assert_eq!(moment.set_by_ns, None);
        }
        assert!(stamps.is_same_clock());
    }

    #[test]
    fn of_a_clock_that_is_off_the_shortest_delay_is_taken_for_none() {
        let mut stamps = Stamps::new(false, HOST_NS);
        let ahead_ns = 3_600 * S;
        let mut moment = |captured_ns: u64, delay_ns| {
            stamps.moment(system_ns(captured_ns) + ahead_ns, captured_ns + delay_ns)
        };
        assert_eq!(moment(100 * S, 9 * MS).at_ns, 100 * S + 9 * MS);
        assert_eq!(moment(100 * S + 20 * MS, 2 * MS).at_ns, 100 * S + 22 * MS);
        // From now on 2 ms are what the network takes.
        assert_eq!(moment(100 * S + 40 * MS, 9 * MS).at_ns, 100 * S + 42 * MS);
        assert!(!stamps.is_same_clock());
        let ahead_s = stamps.ahead_ns().map(|it| it / 1_000_000_000);
        assert_eq!(ahead_s, Some(3_599));
    }

    #[test]
    fn a_clock_that_drifts_is_followed() {
        let mut stamps = Stamps::new(false, HOST_NS);
        let mut last = None;
        // 1 ms in a second, the robot's clock is slow.
        for n in 0..600_u64 {
            let came_ns = 100 * S + n * 50 * MS;
            let stamp_ns = 7 * S + n * 50 * MS - n * 50_000;
            let moment = stamps.moment(stamp_ns, came_ns);
            assert!(moment.set_by_ns.is_none());
            assert!(came_ns - moment.at_ns <= 11 * MS, "{n}");
            assert!(last.is_none_or(|last| moment.at_ns > last), "{n}");
            last = Some(moment.at_ns);
        }
    }

    #[test]
    fn a_clock_that_is_set_is_named_and_followed() {
        let mut stamps = Stamps::new(false, HOST_NS);
        let mut set = Vec::new();
        let mut at = |came_ns: u64, stamp_ns: u64| {
            let moment = stamps.moment(stamp_ns, came_ns);
            if let Some(by_ns) = moment.set_by_ns {
                set.push((came_ns / S, by_ns / 1_000_000_000));
            }
            moment
        };
        for n in 0..50 {
            at(100 * S + n * 20 * MS, 1_000 * S + n * 20 * MS);
        }
        // An hour ahead: at once.
        let moment = at(101 * S, 4_601 * S);
        assert_eq!(moment.at_ns, 101 * S);
        // Ten seconds back: first taken for late messages, then for what it is.
        let mut old_ns = 0;
        for n in 0..150 {
            let came_ns = 102 * S + n * 20 * MS;
            let moment = at(came_ns, 4_592 * S + n * 20 * MS);
            old_ns = old_ns.max(came_ns - moment.at_ns);
        }
        assert_eq!(old_ns, 10 * S, "what is late is old");
        assert_eq!(set, [(101, 3600), (104, -10)]);
    }

    #[test]
    fn simulated_time_may_be_slow_and_ages_are_those_of_arrival() {
        let mut stamps = Stamps::new(true, HOST_NS);
        let first = stamps.moment(5 * S, 100 * S);
        let second = stamps.moment(6 * S, 102 * S);
        assert_eq!((first.at_ns, second.at_ns), (100 * S, 101 * S));
        assert_eq!(second.capture_ns, 102 * S);
        stamps.restart();
        assert_eq!(stamps.moment(S, 110 * S).at_ns, 110 * S);
    }
}
