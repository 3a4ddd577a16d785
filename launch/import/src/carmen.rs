//! CARMEN logs: a line of text for each message.
//!
//! `ODOM x y theta tv rv accel time host logger_time`, `FLASER n r1 .. rn x y theta odom_x odom_y odom_theta time host
//! logger_time`. Beams lie evenly over half a turn from right to left. When `x y theta` of the scans are other poses than
//! the odometry, they are corrected ones.

use crate::clock::{Clock, put_in_order};
use crate::log::{Log, LogPose, LogScan, add_pose};
use core::f32::consts::PI;
use std::io::{BufRead, BufReader, Read};
use zeronav_casts::Cast;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::scan::BEAMS_MAX;
use zeronav_msgs::time::nanoseconds;
use zeronav_ros_messages::received::clean_ranges;

/// Longest line. [bytes]
const LINE_BYTES_MAX: u64 = 1 << 20;

/// Readings from here on are no return: what the lasers of the time gave then. [m]
const RANGE_M_MAX: f32 = 50.0;
const RANGE_M_MIN: f32 = 0.05;

/// Odometry that is older than the one before by more than this is none. [ns]
const RESET_NS: u64 = 5_000_000_000;

/// Reads a log.
///
/// # Errors
/// Why it is none.
pub(crate) fn read(input: impl Read) -> Result<Log, String> {
    let mut input = BufReader::new(input);
    let mut log = Log {
        format: "CARMEN",
        ..Log::default()
    };
    let (mut clock, mut raw, mut line) = (Clock::default(), Vec::new(), Vec::new());
    let mut start = Pose::default();
    loop {
        line.clear();
        let n = (&mut input)
            .take(LINE_BYTES_MAX)
            .read_until(b'\n', &mut line)
            .map_err(|error| error.to_string())?;
        if n == 0 {
            break;
        }
        let text = String::from_utf8_lossy(&line);
        let mut words = text.split_ascii_whitespace();
        let known = match words.next() {
            Some("ODOM") => odometry(words, &mut log, &mut clock, &mut start),
            Some("FLASER") => scan(words, &mut log, &clock, &mut raw),
            _ => continue,
        };
        if known.is_none() {
            log.report.mend("lines that cannot be read");
        }
    }
    if log.scans.is_empty() {
        return Err(
            "it is no MCAP file, no SQLite file and no CARMEN log: no line begins with FLASER"
                .to_owned(),
        );
    }
    if log.odometry.is_empty() {
        log.odometry = raw;
        let missing = &mut log.report.missing;
        missing.push("no ODOM lines: the odometry is that of the FLASER lines".to_owned());
        log.corrected.clear();
    }
    let assumed = [
        "beams evenly over 180 degrees, from right to left".to_owned(),
        format!("readings from {RANGE_M_MAX} m on are no return"),
        "the lidar is in the middle of the robot and looks ahead".to_owned(),
        "poses in FLASER lines are corrected ones".to_owned(),
    ];
    log.report.assumed.extend(assumed);
    log.report
        .missing
        .push("no outline and no limits of the robot".to_owned());
    put_in_order(&mut log);
    Ok(log)
}

fn number<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<f64> {
    let number: f64 = words.next()?.parse().ok()?;
    number.is_finite().then_some(number)
}

fn pose<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<Pose> {
    let [x_m, y_m, yaw_rad] = [number(words)?, number(words)?, number(words)?];
    Some(Pose::new(x_m, y_m, zeronav_msgs::pose::wrap_angle(yaw_rad)))
}

fn odometry<'a>(
    mut words: impl Iterator<Item = &'a str>,
    log: &mut Log,
    clock: &mut Clock,
    start: &mut Pose,
) -> Option<()> {
    let pose = pose(&mut words)?;
    let _twist = [
        number(&mut words)?,
        number(&mut words)?,
        number(&mut words)?,
    ];
    let ns = nanoseconds(number(&mut words)?);
    if let Some(last) = log.odometry.last()
        && clock.late(ns) + RESET_NS < last.ns
    {
        // Who corrects poses lets the odometry go on from the corrected one, in a line of no time.
        *start = last.pose.then(&Pose::from(pose.isometry().inverse()));
        log.report
            .mend("corrections of the pose in the odometry, taken out");
        return Some(());
    }
    let ns = clock.at(ns, &mut log.report);
    let pose = start.then(&pose);
    add_pose(&mut log.odometry, LogPose { ns, pose }, &mut log.report);
    Some(())
}

fn scan<'a>(
    mut words: impl Iterator<Item = &'a str>,
    log: &mut Log,
    clock: &Clock,
    raw: &mut Vec<LogPose>,
) -> Option<()> {
    let n: usize = words.next()?.parse().ok()?;
    if !(2..=BEAMS_MAX).contains(&n) {
        return None;
    }
    let mut ranges = Vec::with_capacity(n);
    for _ in 0..n {
        ranges.push(words.next()?.parse::<f32>().ok()?);
    }
    let (corrected, own) = (pose(&mut words)?, pose(&mut words)?);
    // Who corrects poses writes scans long after the odometry of their time.
    let ns = clock.late(nanoseconds(number(&mut words)?));
    let invalid = clean_ranges(&mut ranges, [RANGE_M_MIN, RANGE_M_MAX]);
    log.report.invalid(invalid);
    let step_rad = PI / (n.to_f32() - 1.0);
    log.add_scan(LogScan {
        ns,
        angle_min_rad: -PI / 2.0,
        angle_increment_rad: step_rad,
        time_increment_s: 0.0,
        range_m: [RANGE_M_MIN, RANGE_M_MAX],
        ranges,
    });
    let place = |pose| LogPose { ns, pose };
    add_pose(&mut log.corrected, place(corrected), &mut log.report);
    add_pose(raw, place(own), &mut log.report);
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LOG: &str = "PARAM a 1\nODOM 0 0 0 0 0 0 1.0 h 1.0\nODOM 1 0 0.5 0 0 0 2.0 h 2.0\n\
        FLASER 3 1.5 81.83 0.0 7 8 9.0 0.5 0 0 1.5 h 1.5\nFLASER 3 1 2\nODOM 2 0 1 0 0 0 3.0 h 3.0\n";

    #[test]
    fn lines_become_odometry_scans_and_corrected_poses() {
        let log = read(LOG.as_bytes()).expect("a log");
        let times: Vec<u64> = log.odometry.iter().map(|it| it.ns / 1_000_000).collect();
        assert_eq!(times, [1000, 2000, 3000]);
        let [scan] = &log.scans[..] else {
            panic!("{:?}", log.scans);
        };
        assert_eq!(scan.ranges[0].to_bits(), 1.5_f32.to_bits());
        assert!(scan.ranges[1].is_infinite() && scan.ranges[2].is_nan());
        assert!(
            (scan.angle_min_rad + 2.0 * scan.angle_increment_rad + scan.angle_min_rad).abs() < 1e-6
        );
        let yaw = log.corrected[0].pose.yaw_rad;
        assert!(
            (yaw - (9.0 - 2.0 * core::f64::consts::PI)).abs() < 1e-9,
            "{yaw}"
        );
        assert_eq!(log.report.mended["lines that cannot be read"], 1);
    }

    #[test]
    fn odometry_that_was_put_right_goes_on_as_the_wheels_count() {
        let log = "ODOM 0 0 0 0 0 0 10.0 h 10\nFLASER 2 1 1 0 0 0 0 0 0 10.5 h 10\nODOM 1 0 0 0 0 0 11.0 h 11\n\
            ODOM 1.5 2 0 0 0 0 0 h 0\nODOM 2.5 2 0 0 0 0 12.0 h 12\n";
        let log = read(log.as_bytes()).expect("a log");
        let places: Vec<f64> = log.odometry.iter().map(|it| it.pose.x_m).collect();
        assert_eq!(places, [0.0, 1.0, 2.0]);
        assert!(log.odometry.iter().all(|it| it.pose.y_m.abs() < 1e-12));
    }

    #[test]
    fn what_is_no_log_is_named() {
        let error = read(&b"this is no log at all\n"[..]).expect_err("no log");
        assert!(error.contains("no CARMEN log"), "{error}");
    }

    proptest! {
        #[test]
        fn no_text_makes_it_panic(at in 0_usize..400, byte: u8, len in 0_usize..400) {
            let mut bytes = LOG.as_bytes().to_vec();
            let n = bytes.len();
            bytes[at % n] = byte;
            let _ = read(&bytes[..]);
            let _ = read(&bytes[..len.min(n)]);
        }
    }
}
