//! The last second of odometry, to find where the robot was when a scan was captured.

use crate::error::StartError;
use crate::input::Input;
use crate::peer::Peer;
use crate::reader::Stream;
use crate::received::Received;
use crate::roster::Roster;
use std::collections::VecDeque;
use zeronav_casts::Cast;
use zeronav_msgs::header::{Header, Id};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::{Pose, wrap_angle};
use zeronav_msgs::topics::RobotOdometry;

/// Odometry messages that are kept.
const LENGTH: usize = 64;

/// Messages in a row after which the robot counts as stopped.
pub const REST_MESSAGES: usize = 5;

/// Speeds below which it is; the odometry of a stopped robot may be noisy. [m/s], [rad/s]
const REST_MPS: f64 = 0.02;
const REST_RADPS: f64 = 0.05;

/// True when the robot is stopped, by this message alone.
#[must_use]
pub fn is_stopped(odometry: &Odometry) -> bool {
    odometry.v_mps.abs() < REST_MPS && odometry.w_radps.abs() < REST_RADPS
}

/// One odometry message, copied out of shared memory.
#[derive(Debug, Clone, Copy)]
pub struct OdometrySample {
    /// Identity.
    pub id: Id,
    /// Tick.
    pub tick: u64,
    /// Run time. [ns]
    pub run_ns: u64,
    /// Capture, monotonic. [ns]
    pub capture_ns: u64,
    /// When it came in, by this process's own clock. [ns]
    pub came_ns: u64,
    /// The message.
    pub odometry: Odometry,
}

impl OdometrySample {
    /// Its times.
    #[must_use]
    pub fn received(&self) -> Received {
        Received {
            tick: self.tick,
            run_ns: self.run_ns,
            capture_ns: self.capture_ns,
            came_ns: self.came_ns,
        }
    }
}

/// Recent odometry, oldest first.
#[derive(Debug, Default)]
pub struct OdometryHistory {
    samples: VecDeque<OdometrySample>,
}

impl OdometryHistory {
    /// Adds a message. One of another writer, or of an earlier time, clears the history first.
    pub fn push(&mut self, header: &Header, odometry: &Odometry, came_ns: u64) {
        let sample = OdometrySample {
            id: header.id(),
            tick: header.tick,
            run_ns: header.run_ns,
            capture_ns: header.capture_ns,
            came_ns,
            odometry: *odometry,
        };
        let follows = self
            .newest()
            .is_none_or(|last| last.id.epoch() == sample.id.epoch() && last.run_ns < sample.run_ns);
        if !follows {
            self.samples.clear();
        }
        if self.samples.len() == LENGTH {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
    }

    /// The newest message.
    #[must_use]
    pub fn newest(&self) -> Option<&OdometrySample> {
        self.samples.back()
    }

    /// True when the robot is stopped, by the newest messages.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.samples.len() >= REST_MESSAGES
            && (self.samples.iter().rev().take(REST_MESSAGES))
                .all(|sample| is_stopped(&sample.odometry))
    }

    /// `odom_from_base` at a run time before the oldest message, by at most `most_ns`: as its speeds say
    /// that the robot came there. `None` at any other time.
    #[must_use]
    pub fn pose_before(&self, run_ns: u64, most_ns: u64) -> Option<Pose> {
        let oldest = self.samples.front()?;
        let before_ns = oldest.run_ns.checked_sub(run_ns)?;
        let before_s =
            (0 < before_ns && before_ns <= most_ns).then_some(before_ns.to_f64() * 1.0e-9)?;
        let Odometry {
            pose,
            v_mps,
            w_radps,
            ..
        } = oldest.odometry;
        Some(pose.then(&Pose::new(-v_mps * before_s, 0.0, -w_radps * before_s)))
    }

    /// `odom_from_base` at a run time between two messages, or at one; `None` outside the history.
    #[must_use]
    pub fn pose_at(&self, run_ns: u64) -> Option<Pose> {
        let after = self
            .samples
            .partition_point(|sample| sample.run_ns < run_ns);
        let later = self.samples.get(after)?;
        if later.run_ns == run_ns {
            return Some(later.odometry.pose);
        }
        let earlier = self.samples.get(after.checked_sub(1)?)?;
        let share = (run_ns - earlier.run_ns).to_f64() / (later.run_ns - earlier.run_ns).to_f64();
        let (from, to) = (&earlier.odometry.pose, &later.odometry.pose);
        Some(Pose::new(
            from.x_m + share * (to.x_m - from.x_m),
            from.y_m + share * (to.y_m - from.y_m),
            wrap_angle(from.yaw_rad + share * wrap_angle(to.yaw_rad - from.yaw_rad)),
        ))
    }
}

/// Reads `robot/odometry`. Every service polls it before its other inputs: in lockstep it carries
/// the tick, and every message that was sent before it is then found by the polls that follow.
#[derive(Debug)]
pub struct OdometryReader {
    stream: Stream<RobotOdometry>,
    history: OdometryHistory,
}

impl OdometryReader {
    /// Opens the topic.
    ///
    /// # Errors
    /// As [`Peer::stream`].
    pub fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            stream: peer.stream()?,
            history: OdometryHistory::default(),
        })
    }

    /// Takes in what has come; true when there is newer odometry than before.
    pub fn poll(&mut self, roster: &Roster) -> bool {
        let mut moved = false;
        self.stream.drain(roster, |view| {
            self.history.push(view.header, view.meta, roster.woken_ns);
            moved = true;
        });
        moved
    }

    /// What was read.
    #[must_use]
    pub fn history(&self) -> &OdometryHistory {
        &self.history
    }

    /// Identity of the newest message; [`Id::NONE`] before the first.
    #[must_use]
    pub fn id(&self) -> Id {
        self.history.newest().map_or(Id::NONE, |sample| sample.id)
    }

    /// Tick of the newest message; 0 before the first.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.history.newest().map_or(0, |sample| sample.tick)
    }

    /// The newest message.
    #[must_use]
    pub fn newest(&self) -> Option<&OdometrySample> {
        self.history.newest()
    }

    /// True when the newest message came with a scan.
    #[must_use]
    pub fn scan_due(&self) -> bool {
        self.newest()
            .is_some_and(|newest| newest.odometry.scan_due())
    }
}

impl Input for OdometryReader {
    fn refused(&self) -> u64 {
        self.stream.refused()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn push(history: &mut OdometryHistory, tick: u64, x_m: f64, yaw_rad: f64) {
        let header = Header {
            id: Id::new(1, tick).0,
            tick,
            run_ns: tick * 20,
            ..Header::default()
        };
        let pose = Pose::new(x_m, 0.0, yaw_rad);
        history.push(
            &header,
            &Odometry {
                pose,
                ..Odometry::default()
            },
            0,
        );
    }

    #[test]
    fn poses_are_interpolated_through_the_wrap_and_never_extrapolated() {
        let mut history = OdometryHistory::default();
        push(&mut history, 1, 1.0, 3.1);
        push(&mut history, 2, 2.0, -3.1);
        let pose = history.pose_at(30).expect("between the two");
        assert!((pose.x_m - 1.5).abs() < 1e-12);
        assert!(
            (pose.yaw_rad.abs() - core::f64::consts::PI).abs() < 1e-9,
            "{}",
            pose.yaw_rad
        );
        assert_eq!(history.pose_at(40).map(|pose| pose.x_m), Some(2.0));
        assert_eq!(history.pose_at(19), None);
        assert_eq!(history.pose_at(41), None);
    }

    #[test]
    fn before_the_oldest_message_the_robot_came_by_its_speeds() {
        let mut history = OdometryHistory::default();
        assert_eq!(history.pose_before(0, 100), None);
        let header = Header {
            id: Id::new(1, 1).0,
            tick: 1,
            run_ns: 1_000_000_000,
            ..Header::default()
        };
        let odometry = Odometry {
            pose: Pose::new(1.0, 2.0, core::f64::consts::FRAC_PI_2),
            v_mps: 2.0,
            w_radps: 0.5,
            ..Odometry::default()
        };
        history.push(&header, &odometry, 0);
        let before = history.pose_before(990_000_000, 20_000_000);
        let before = before.expect("half a tick before");
        assert!(before.distance_m(&Pose::new(1.0, 1.98, 0.0)) < 1e-9);
        assert!((before.yaw_rad - odometry.pose.yaw_rad + 0.005).abs() < 1e-9);
        assert_eq!(history.pose_before(979_999_999, 20_000_000), None);
        assert_eq!(history.pose_before(1_000_000_000, 20_000_000), None);
        assert_eq!(history.pose_before(1_000_000_001, 20_000_000), None);
    }

    #[test]
    fn another_writer_clears_the_history() {
        let mut history = OdometryHistory::default();
        push(&mut history, 5, 1.0, 0.0);
        let header = Header {
            id: Id::new(2, 1).0,
            tick: 6,
            run_ns: 120,
            ..Header::default()
        };
        history.push(&header, &Odometry::default(), 0);
        // Between the two frames nothing is interpolated.
        assert_eq!(history.samples.len(), 1);
        assert_eq!(history.pose_at(110), None);
        assert!(history.pose_at(120).is_some());
    }

    #[test]
    fn the_robot_is_stopped_after_five_slow_messages_in_a_row() {
        let mut history = OdometryHistory::default();
        let mut push = |tick, v_mps, w_radps| {
            let header = Header {
                id: Id::new(1, tick).0,
                tick,
                run_ns: tick * 20,
                ..Header::default()
            };
            let odometry = Odometry {
                v_mps,
                w_radps,
                ..Odometry::default()
            };
            history.push(&header, &odometry, 0);
            history.is_at_rest()
        };
        assert!(!(1..5).any(|tick| push(tick, 0.0, 0.0)));
        assert!(push(5, 0.01, -0.04));
        assert!(!push(6, -0.03, 0.0));
        assert!(!(7..11).any(|tick| push(tick, 0.0, 0.0)));
        assert!(push(11, 0.0, 0.0));
        assert!(!push(12, 0.0, 0.06));
    }

    #[test]
    fn time_going_back_clears_the_history() {
        let mut history = OdometryHistory::default();
        push(&mut history, 5, 1.0, 0.0);
        push(&mut history, 4, 2.0, 0.0);
        assert_eq!(history.samples.len(), 1);
        assert_eq!(history.newest().map(|sample| sample.tick), Some(4));
    }
}
