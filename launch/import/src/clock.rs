//! The times of a log: clocks that jump, stamps that come twice or go back.

use crate::log::{Log, LogPose, LogScan, Report};

/// A step of the clock beyond this, either way, is a jump. [ns]
const JUMP_NS: u64 = 5_000_000_000;

/// Latest time, some hundred years: room for sums. [ns]
const NS_MAX: u64 = u64::MAX / 4;

/// What lies between two messages in place of a jump. [ns]
const STEP_NS: u64 = 50_000_000;

/// The times of all messages of a robot in the order in which they were logged: takes jumps of its clock out.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    newest_ns: Option<u64>,
    /// What is added to the log's times. [ns]
    shift_ns: i128,
}

impl Clock {
    /// The time of the next message without the jumps before it. [ns]
    pub(crate) fn at(&mut self, stamp_ns: u64, report: &mut Report) -> u64 {
        let mut ns = self.late(stamp_ns);
        if let Some(newest_ns) = self.newest_ns
            && ns.abs_diff(newest_ns) > JUMP_NS
        {
            report.mend("jumps of the clock by more than 5 s, taken out");
            ns = newest_ns + STEP_NS;
            self.shift_ns = i128::from(ns) - i128::from(stamp_ns);
        }
        self.newest_ns = Some(self.newest_ns.map_or(ns, |newest_ns| newest_ns.max(ns)));
        ns
    }

    /// The time of a message that is logged much later than others of its time, without the jumps so far. [ns]
    pub(crate) fn late(&self, stamp_ns: u64) -> u64 {
        let ns = u64::try_from(i128::from(stamp_ns) + self.shift_ns).unwrap_or(0);
        ns.min(NS_MAX)
    }
}

/// Leaves out what has the stamp of the message before or an earlier one, and what of the scans lies outside the
/// odometry.
pub(crate) fn put_in_order(log: &mut Log) {
    let Log {
        scans,
        odometry,
        corrected,
        report,
        ..
    } = log;
    // Transforms may be late, and odometry is looked up by time.
    odometry.sort_by_key(|it| it.ns);
    corrected.sort_by_key(|it| it.ns);
    grow(
        odometry,
        |it: &LogPose| it.ns,
        "odometry with the stamp of another",
        report,
    );
    grow(
        corrected,
        |it: &LogPose| it.ns,
        "corrected poses with the stamp of another",
        report,
    );
    grow(
        scans,
        |it: &LogScan| it.ns,
        "scans with a stamp that is not later than the one before",
        report,
    );
    let range = odometry.first().zip(odometry.last());
    let range = range.map(|(first, last)| first.ns..=last.ns);
    let before = scans.len();
    scans.retain(|scan| range.as_ref().is_some_and(|range| range.contains(&scan.ns)));
    for _ in scans.len()..before {
        report.mend("scans before the first or after the last odometry");
    }
}

/// Keeps what is later than everything before it.
fn grow<T>(all: &mut Vec<T>, ns: impl Fn(&T) -> u64, what: &'static str, report: &mut Report) {
    let mut newest_ns = None;
    all.retain(|it| {
        let is_later = newest_ns.is_none_or(|newest_ns| ns(it) > newest_ns);
        if is_later {
            newest_ns = Some(ns(it));
        } else {
            report.mend(what);
        }
        is_later
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::pose::Pose;

    const S: u64 = 1_000_000_000;

    #[test]
    fn a_clock_that_jumps_goes_on_where_it_was() {
        let (mut clock, mut report) = (Clock::default(), Report::default());
        let mut at = |ns| clock.at(ns, &mut report);
        assert_eq!([at(100 * S), at(101 * S)], [100 * S, 101 * S]);
        // Back to the start of the machine, then on from there.
        assert_eq!(
            [at(3 * S), at(4 * S)],
            [101 * S + STEP_NS, 102 * S + STEP_NS]
        );
        // An hour ahead.
        assert_eq!(at(3604 * S), 102 * S + 2 * STEP_NS);
        // A little back is no jump.
        assert_eq!(at(3603 * S), 101 * S + 2 * STEP_NS);
        let jumps: u64 = report.mended.values().sum();
        assert_eq!(jumps, 2);
    }

    fn scan(ns: u64) -> LogScan {
        LogScan {
            ns,
            angle_min_rad: 0.0,
            angle_increment_rad: 0.1,
            time_increment_s: 0.0,
            range_m: [0.1, 9.0],
            ranges: vec![1.0],
        }
    }

    #[test]
    fn stamps_that_come_twice_or_go_back_are_left_out() {
        let pose = |ns| LogPose {
            ns,
            pose: Pose::default(),
        };
        let mut log = Log {
            scans: [5, 20, 20, 30, 25, 40, 99].map(scan).to_vec(),
            // One transform is late.
            odometry: [10, 30, 20, 30, 50].map(pose).to_vec(),
            ..Log::default()
        };
        put_in_order(&mut log);
        let of_scans: Vec<u64> = log.scans.iter().map(|it| it.ns).collect();
        let of_odometry: Vec<u64> = log.odometry.iter().map(|it| it.ns).collect();
        assert_eq!(
            (&of_scans[..], &of_odometry[..]),
            (&[20, 30, 40][..], &[10, 20, 30, 50][..])
        );
        let mended: Vec<u64> = log.report.mended.values().copied().collect();
        assert_eq!(mended, [1, 2, 2], "{:?}", log.report);
    }
}
