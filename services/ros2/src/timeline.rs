//! Run time and ticks of a robot that keeps no time of the run itself.

/// Which tick a moment belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tick {
    /// Its number, from 1.
    pub tick: u64,
    /// Run time of the moment. [ns]
    pub run_ns: u64,
    /// True for the first moment in the tick.
    pub is_new: bool,
}

/// Run time: the moments of the robot without those in which the run was paused.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Timeline {
    /// The moment at run time 0, which moves on while the run is paused; `None` before the first one. [ns]
    zero_ns: Option<u64>,
    tick: u64,
    run_ns: u64,
    paused_since_ns: Option<u64>,
}

impl Timeline {
    /// Goes on where the process before this one in the seat was. [ns]
    #[must_use]
    pub fn from_zero(zero_ns: Option<u64>) -> Self {
        Self {
            zero_ns,
            ..Self::default()
        }
    }

    /// The moment at run time 0. [ns]
    #[must_use]
    pub fn zero_ns(&self) -> Option<u64> {
        self.zero_ns
    }

    /// Run time stands from now on, or goes on. [ns]
    pub fn pause(&mut self, paused: bool, now_ns: u64) {
        match (paused, self.paused_since_ns) {
            (true, None) => self.paused_since_ns = Some(now_ns),
            (false, Some(since_ns)) => {
                let stood_ns = now_ns.saturating_sub(since_ns);
                self.zero_ns = self.zero_ns.map(|zero_ns| zero_ns + stood_ns);
                self.paused_since_ns = None;
            }
            _ => {}
        }
    }

    /// True while run time stands.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.paused_since_ns.is_some()
    }

    /// Run time of a moment; `None` before the first tick. [ns]
    #[must_use]
    pub fn run_ns(&self, at_ns: u64) -> Option<u64> {
        at_ns.checked_sub(self.zero_ns?)
    }

    /// The tick of odometry of this moment; `None` while run time stands, and for what is not later than the
    /// odometry before it. The first one is that of tick 1. [ns]
    pub fn advance(&mut self, at_ns: u64, tick_ns: u64) -> Option<Tick> {
        if self.is_paused() {
            return None;
        }
        let zero_ns = *(self.zero_ns).get_or_insert(at_ns.saturating_sub(tick_ns));
        let run_ns = at_ns.checked_sub(zero_ns)?;
        let tick = run_ns.checked_div(tick_ns)?.max(self.tick);
        if run_ns <= self.run_ns || tick == 0 {
            return None;
        }
        let is_new = tick > self.tick;
        (self.tick, self.run_ns) = (tick, run_ns);
        Some(Tick {
            tick,
            run_ns,
            is_new,
        })
    }

    /// Run time of the newest odometry; `None` before the first. [ns]
    #[must_use]
    pub fn newest_run_ns(&self) -> Option<u64> {
        (self.tick > 0).then_some(self.run_ns)
    }

    /// The newest tick; 0 before the first.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.tick
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn ticks(timeline: &mut Timeline, at_ms: &[u64]) -> Vec<Option<(u64, u64, bool)>> {
        let at = |ms: &u64| timeline.advance(ms * MS, 20 * MS);
        let all = at_ms.iter().map(at);
        all.map(|it| it.map(|it| (it.tick, it.run_ns / MS, it.is_new)))
            .collect()
    }

    #[test]
    fn odometry_may_be_faster_or_slower_than_ticks_and_never_goes_back() {
        let mut timeline = Timeline::default();
        let expected = [
            Some((1, 20, true)),
            Some((1, 30, false)),
            Some((2, 40, true)),
            None,
            Some((7, 145, true)),
        ];
        let found = ticks(&mut timeline, &[1000, 1010, 1020, 1015, 1125]);
        assert_eq!(found, expected);
        assert_eq!(timeline.run_ns(1_100 * MS), Some(120 * MS));
        assert_eq!(timeline.run_ns(900 * MS), None);
    }

    #[test]
    fn run_time_stands_while_the_run_is_paused() {
        let mut timeline = Timeline::default();
        assert_eq!(ticks(&mut timeline, &[1000]), [Some((1, 20, true))]);
        timeline.pause(true, 1_010 * MS);
        assert_eq!(ticks(&mut timeline, &[1020]), [None]);
        timeline.pause(false, 5_010 * MS);
        assert_eq!(ticks(&mut timeline, &[5020]), [Some((2, 40, true))]);
    }

    #[test]
    fn a_successor_goes_on_at_the_time_that_it_is() {
        let mut first = Timeline::default();
        ticks(&mut first, &[1000, 1020]);
        let mut second = Timeline::from_zero(first.zero_ns());
        assert_eq!(ticks(&mut second, &[3000]), [Some((101, 2020, true))]);
    }
}
