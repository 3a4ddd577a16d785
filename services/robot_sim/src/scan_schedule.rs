//! When the lidar turns: scan k is captured at run time k / rate, whatever the tick.

use zeronav_casts::Cast;

/// A scan that falls due in a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DueScan {
    /// Its number, from 1.
    pub index: u64,
    /// [ns] run time of its capture, within the tick.
    pub capture_run_ns: u64,
}

/// The times of the scans of one lidar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanSchedule {
    rate_hz: f64,
}

impl ScanSchedule {
    /// A lidar of `rate_hz` turns a second; `None` unless this is a number from 0.001 to 1000.
    #[must_use]
    pub fn new(rate_hz: f64) -> Option<Self> {
        (1.0e-3..=1.0e3)
            .contains(&rate_hz)
            .then_some(Self { rate_hz })
    }

    /// Time from scan to scan, to the nearest nanosecond. [ns]
    #[must_use]
    pub fn period_ns(&self) -> u64 {
        self.capture_run_ns(1)
    }

    /// Run time at which scan `index` is captured, to the nearest nanosecond. [ns]
    #[must_use]
    pub fn capture_run_ns(&self, index: u64) -> u64 {
        (index.to_f64() * 1.0e9 / self.rate_hz).round().to_u64()
    }

    /// The newest scan with `after_run_ns < capture <= run_ns`.
    ///
    /// ```
    /// use zeronav_robot_sim::scan_schedule::{DueScan, ScanSchedule};
    /// let lidar = ScanSchedule::new(15.0).unwrap();
    /// let due = lidar.due(60_000_000, 80_000_000);
    /// assert_eq!(due, Some(DueScan { index: 1, capture_run_ns: 66_666_667 }));
    /// ```
    #[must_use]
    pub fn due(&self, after_run_ns: u64, run_ns: u64) -> Option<DueScan> {
        let mut index = (run_ns.to_f64() * 1.0e-9 * self.rate_hz).round().to_u64();
        while self.capture_run_ns(index + 1) <= run_ns {
            index += 1;
        }
        while index > 0 && self.capture_run_ns(index) > run_ns {
            index -= 1;
        }
        let capture_run_ns = self.capture_run_ns(index);
        (index > 0 && capture_run_ns > after_run_ns).then_some(DueScan {
            index,
            capture_run_ns,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK_NS: u64 = 20_000_000;

    /// `(tick, capture_run_ns)` of every scan in the first `ticks` ticks of 50 Hz.
    fn scans(rate_hz: f64, ticks: u64) -> Vec<(u64, u64)> {
        let schedule = ScanSchedule::new(rate_hz).expect("a rate");
        let mut last = 0;
        (1..=ticks)
            .filter_map(|tick| {
                let due = schedule.due((tick - 1) * TICK_NS, tick * TICK_NS)?;
                assert_eq!(due.index, last + 1, "no scan is left out or repeated");
                last = due.index;
                Some((tick, due.capture_run_ns))
            })
            .collect()
    }

    #[test]
    fn ten_hertz_is_every_fifth_tick() {
        let found = scans(10.0, 50_000);
        assert_eq!(found.len(), 10_000);
        for (k, scan) in (1..).zip(found) {
            assert_eq!(scan, (5 * k, k * 100_000_000));
        }
    }

    #[test]
    fn fifteen_hertz_falls_between_ticks_at_its_exact_time() {
        let expected = [
            (4, 66_666_667),
            (7, 133_333_333),
            (10, 200_000_000),
            (14, 266_666_667),
            (17, 333_333_333),
            (20, 400_000_000),
        ];
        assert_eq!(scans(15.0, 22), expected);
        assert_eq!(scans(15.0, 50 * 3600).len(), 15 * 3600);
    }

    #[test]
    fn forty_hertz_leaves_out_every_fifth_tick() {
        let expected = [
            (2, 25_000_000),
            (3, 50_000_000),
            (4, 75_000_000),
            (5, 100_000_000),
            (7, 125_000_000),
            (8, 150_000_000),
            (9, 175_000_000),
            (10, 200_000_000),
        ];
        assert_eq!(scans(40.0, 10), expected);
        assert_eq!(scans(40.0, 50 * 3600).len(), 40 * 3600);
    }

    #[test]
    fn the_tick_rate_itself_gives_a_scan_every_tick() {
        for (k, scan) in (1..).zip(scans(50.0, 5000)) {
            assert_eq!(scan, (k, k * TICK_NS));
        }
    }

    #[test]
    fn rates_must_be_numbers_of_a_lidar() {
        assert_eq!(ScanSchedule::new(0.0), None);
        assert_eq!(ScanSchedule::new(-1.0), None);
        assert_eq!(ScanSchedule::new(f64::NAN), None);
        assert_eq!(ScanSchedule::new(2.0e3), None);
    }
}
