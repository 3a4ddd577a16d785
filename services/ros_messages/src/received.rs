//! Messages that others sent, which may hold anything, as far as the contract can hold them.

use crate::messages::{LaserScan, Quaternion, Time, Vector3};
use byteorder::{BigEndian, LittleEndian};
use cdr_encoding::from_bytes;
use serde::de::DeserializeOwned;
use zeronav_msgs::pose::{Pose, wrap_angle};
use zeronav_msgs::scan::{BEAMS_MAX, Scan};
use zeronav_msgs::time::nanoseconds;

/// Farthest range of the contract. [m]
const RANGE_M_MAX: f32 = 1.0e3;

/// Longest time from beam to beam. [s]
const TIME_INCREMENT_S_MAX: f32 = 1.0;

/// A message in CDR of either byte order; what stands behind its fields is left. `None` when it is cut or no CDR.
#[must_use]
pub fn decoded<T: DeserializeOwned>(data: &[u8]) -> Option<T> {
    let (head, body) = data.split_at_checked(4)?;
    match head[1] & 1 {
        1 => from_bytes::<T, LittleEndian>(body).ok().map(|(it, _)| it),
        _ => from_bytes::<T, BigEndian>(body).ok().map(|(it, _)| it),
    }
}

/// The name of a frame without a slash and a name space.
#[must_use]
pub fn plain_frame(frame: &str) -> &str {
    frame.rsplit('/').next().unwrap_or(frame)
}

/// A stamp. [ns] A negative one is 0, which ROS takes for none.
#[must_use]
pub fn stamp_ns(stamp: Time) -> u64 {
    u64::try_from(stamp.sec).unwrap_or(0) * 1_000_000_000 + u64::from(stamp.nanosec)
}

/// A pose in the plane; `None` when a number of it is not finite.
#[must_use]
pub fn planar_pose(at: &Vector3, turn: &Quaternion) -> Option<Pose> {
    let sin = 2.0 * (turn.w * turn.z + turn.x * turn.y);
    let cos = 1.0 - 2.0 * (turn.y * turn.y + turn.z * turn.z);
    let yaw_rad = sin.atan2(cos);
    // Infinite ones would have a yaw.
    let numbers = [at.x, at.y, turn.x, turn.y, turn.z, turn.w];
    let is_finite = numbers.iter().all(|it| it.is_finite());
    is_finite.then(|| Pose::new(at.x, at.y, wrap_angle(yaw_rad)))
}

/// What was wrong with the ranges of a scan, and how often.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct InvalidRanges {
    /// NaN.
    pub nan: u64,
    /// Below the sensor's least range.
    pub below: u64,
}

/// A scan of somebody else's lidar.
#[derive(Debug, Clone, PartialEq)]
pub struct ReceivedScan {
    /// Fixed fields of the contract.
    pub scan: Scan,
    /// Ranges as the contract has them. [m]
    pub ranges: Vec<f32>,
    /// From the first beam, whose stamp the message has, to the last. [ns]
    pub turn_ns: u64,
    /// What became NaN.
    pub invalid: InvalidRanges,
}

/// A step in time between two beams that can be one; drivers that leave it out leave anything. [s]
fn step_s(time_increment: f32) -> f32 {
    if (0.0..=TIME_INCREMENT_S_MAX).contains(&time_increment) {
        time_increment
    } else {
        0.0
    }
}

/// From the first beam, whose stamp the message has, to the last; of more beams than the contract holds, 0. [ns]
#[must_use]
pub fn turn_ns(message: &LaserScan) -> u64 {
    match u32::try_from(message.ranges.len()) {
        Ok(n @ 1..) if n as usize <= BEAMS_MAX => {
            nanoseconds(f64::from(step_s(message.time_increment)) * f64::from(n - 1))
        }
        _ => 0,
    }
}

/// A scan, its ranges as the contract has them.
///
/// # Errors
/// Why it cannot be one, naming the field.
pub fn scan(message: LaserScan) -> Result<ReceivedScan, &'static str> {
    let turn_ns = turn_ns(&message);
    let LaserScan {
        angle_min,
        angle_increment,
        time_increment,
        range_min,
        range_max,
        mut ranges,
        ..
    } = message;
    let is_within = |it: f32, max: f32| it.is_finite() && it.abs() < max;
    if !is_within(angle_min, 12.6) {
        return Err("angle_min is not an angle");
    }
    if !is_within(angle_increment, 1.6) || angle_increment.abs() <= 1.0e-6 {
        return Err("angle_increment is not a step between two beams");
    }
    if !(range_min.is_finite() && range_max.is_finite() && (0.0..=range_max).contains(&range_min)) {
        return Err("range_min and range_max are not limits of a range");
    }
    if range_min > RANGE_M_MAX {
        return Err("range_min is farther than a lidar sees");
    }
    let n_beams = match u32::try_from(ranges.len()) {
        Ok(n @ 1..) if n as usize <= BEAMS_MAX => n,
        Ok(0) => return Err("it has no ranges"),
        _ => return Err("it has more ranges than the contract holds (4096)"),
    };
    let range_m = [range_min, range_max.min(RANGE_M_MAX)];
    let invalid = clean_ranges(&mut ranges, range_m);
    Ok(ReceivedScan {
        turn_ns,
        scan: Scan {
            n_beams,
            angle_min_rad: angle_min,
            angle_increment_rad: angle_increment,
            time_increment_s: step_s(time_increment),
            range_m_min: range_m[0],
            range_m_max: range_m[1],
            ..Scan::default()
        },
        ranges,
        invalid,
    })
}

/// Makes ranges of a sensor with these limits those of the contract: what is closer than it can see, or is NaN, is
/// invalid (NaN); what is farther is no return (+inf).
pub fn clean_ranges(ranges: &mut [f32], [min_m, max_m]: [f32; 2]) -> InvalidRanges {
    let mut invalid = InvalidRanges::default();
    for range in ranges {
        if range.is_nan() {
            invalid.nan += 1;
        } else if *range < min_m {
            invalid.below += 1;
            *range = f32::NAN;
        } else if *range >= max_m {
            *range = f32::INFINITY;
        }
    }
    invalid
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_that_mean_nothing_become_invalid_or_no_return() {
        let mut ranges = [
            1.0,
            0.0,
            -1.0,
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            30.0,
            80.0,
        ];
        let invalid = clean_ranges(&mut ranges, [0.1, 30.0]);
        assert_eq!(ranges[0].to_bits(), 1.0_f32.to_bits());
        assert!(ranges[1].is_nan() && ranges[2].is_nan() && ranges[3].is_nan());
        assert!(ranges[5].is_nan());
        assert!(
            [ranges[4], ranges[6], ranges[7]]
                .iter()
                .all(|it| *it == f32::INFINITY)
        );
        assert_eq!(invalid, InvalidRanges { nan: 1, below: 3 });
    }

    #[test]
    fn poses_that_are_not_finite_are_none() {
        let at = Vector3::default();
        let turn = Quaternion {
            x: 0.0,
            y: 0.0,
            z: 1.0,
            w: 0.0,
        };
        let yaw_rad = planar_pose(&at, &turn).map(|pose| pose.yaw_rad.abs());
        assert_eq!(yaw_rad, Some(core::f64::consts::PI));
        for spoilt in [f64::NAN, f64::INFINITY] {
            let turn = Quaternion { z: spoilt, ..turn };
            assert_eq!(planar_pose(&at, &turn), None);
            let at = Vector3 { y: spoilt, ..at };
            assert_eq!(planar_pose(&at, &turn), None);
        }
    }

    fn message() -> LaserScan {
        LaserScan {
            header: crate::messages::Header::default(),
            angle_min: -1.0,
            angle_max: 1.0,
            angle_increment: 0.5,
            time_increment: 0.007_812_5,
            scan_time: 0.1,
            range_min: 0.1,
            range_max: 10.0,
            ranges: vec![1.0; 5],
            intensities: Vec::new(),
        }
    }

    type Spoil = fn(&mut LaserScan);

    #[test]
    fn a_scan_that_cannot_be_one_is_rejected_with_its_field() {
        let received = scan(message()).expect("a scan");
        assert_eq!((received.scan.n_beams, received.turn_ns), (5, 31_250_000));
        assert!(received.scan.check(&received.ranges).is_ok());
        let spoilt: [(Spoil, &str); 7] = [
            (|it| it.angle_min = f32::NAN, "angle_min"),
            (|it| it.angle_increment = 0.0, "angle_increment"),
            (|it| it.angle_increment = f32::INFINITY, "angle_increment"),
            (|it| it.range_min = -1.0, "range_min"),
            (|it| it.range_max = f32::NAN, "range_max"),
            (|it| it.ranges = vec![1.0; BEAMS_MAX + 1], "4096"),
            (|it| it.ranges.clear(), "no ranges"),
        ];
        for (spoil, word) in spoilt {
            let mut message = message();
            spoil(&mut message);
            let why = scan(message).expect_err(word);
            assert!(why.contains(word), "{why}");
        }
        let mut unbounded = message();
        (unbounded.time_increment, unbounded.range_max) = (f32::NAN, f32::MAX);
        let received = scan(unbounded).expect("a scan");
        assert_eq!((received.turn_ns, received.scan.range_m_max), (0, 1.0e3));
        assert!(received.scan.check(&received.ranges).is_ok());
    }
}
