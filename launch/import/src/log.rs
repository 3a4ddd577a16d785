//! A log, whatever it was read from.

use std::collections::BTreeMap;
use zeronav_msgs::pose::Pose;
use zeronav_ros_messages::received::InvalidRanges;

/// Which topics are read; the only one of its type without.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Topics {
    /// Of `sensor_msgs/LaserScan`.
    pub scan: Option<String>,
    /// Of `nav_msgs/Odometry`.
    pub odometry: Option<String>,
    /// Of `nav_msgs/OccupancyGrid`; without, the only one, or `/map`.
    pub map: Option<String>,
}

/// What was missing, assumed, left out or mended.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Report {
    /// What the log does not have, a line each.
    pub missing: Vec<String>,
    /// What was taken to be so, a line each.
    pub assumed: Vec<String>,
    /// What was left out or mended, and how often.
    pub mended: BTreeMap<&'static str, u64>,
}

impl Report {
    /// One more of these.
    pub fn mend(&mut self, what: &'static str) {
        *self.mended.entry(what).or_default() += 1;
    }

    /// Ranges that mean nothing.
    pub(crate) fn invalid(&mut self, ranges: InvalidRanges) {
        let InvalidRanges { nan, below } = ranges;
        for (what, n) in [
            ("ranges that are NaN", nan),
            ("ranges below the least", below),
        ] {
            if n > 0 {
                *self.mended.entry(what).or_default() += n;
            }
        }
    }
}

/// One turn of a lidar.
#[derive(Debug, Clone, PartialEq)]
pub struct LogScan {
    /// When its last beam was. [ns]
    pub ns: u64,
    /// Direction of the first beam. [rad]
    pub angle_min_rad: f32,
    /// Step from beam to beam. [rad]
    pub angle_increment_rad: f32,
    /// Time from beam to beam. [s]
    pub time_increment_s: f32,
    /// Limits of what is a hit. [m]
    pub range_m: [f32; 2],
    /// Ranges as the contract has them: infinite without a return, NaN when invalid. [m]
    pub ranges: Vec<f32>,
}

/// Where the robot was at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogPose {
    /// The moment. [ns]
    pub ns: u64,
    /// The pose.
    pub pose: Pose,
}

/// A map that the robot knew.
#[derive(Debug, Clone, PartialEq)]
pub struct LogMap {
    /// The frame in which it lies, without slashes.
    pub frame: String,
    /// Where the lower left corner lies in the frame `map`, and how the grid is turned.
    pub corner: Pose,
    /// Side of a cell. [m]
    pub resolution_m: f64,
    /// Columns and rows, each 1 to [`zeronav_msgs::grid::SIDE_CELLS_MAX`].
    pub size: (u32, u32),
    /// Row by row from the lower left: 0 to 100 for how sure it is occupied, anything else unknown. [percent]
    pub cells: Vec<i8>,
}

/// Everything of a log that is used, each in the order of its times.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Log {
    /// Name of the format.
    pub format: &'static str,
    /// Scans.
    pub scans: Vec<LogScan>,
    /// `odom_from_base`.
    pub odometry: Vec<LogPose>,
    /// `map_from_base` as the log says itself that it was: corrected poses.
    pub corrected: Vec<LogPose>,
    /// `base_from_laser`.
    pub laser: Pose,
    /// The map that was known.
    pub map: Option<LogMap>,
    /// What was missing and assumed.
    pub report: Report,
    /// Beams of all scans.
    pub(crate) n_beams: usize,
}

/// Most beams, and most poses of each kind, that are held: a gigabyte.
const BEAMS_HELD_MAX: usize = 1 << 28;
const POSES_HELD_MAX: usize = 1 << 24;

impl Log {
    /// Takes a scan in, as long as there is room.
    pub(crate) fn add_scan(&mut self, scan: LogScan) {
        self.n_beams += scan.ranges.len();
        if self.n_beams > BEAMS_HELD_MAX {
            self.report
                .mend("scans behind the longest log that is held");
        } else {
            self.scans.push(scan);
        }
    }
}

/// Takes a pose in, as long as there is room.
pub(crate) fn add_pose(to: &mut Vec<LogPose>, pose: LogPose, report: &mut Report) {
    if to.len() < POSES_HELD_MAX {
        to.push(pose);
    } else {
        report.mend("poses behind the longest log that is held");
    }
}
