//! The last second of odometry, so that a scan can be placed where the robot was at its capture.

use crate::error::StartError;
use crate::peer::Peer;
use crate::reader::Stream;
use crate::roster::Roster;
use std::collections::VecDeque;
use zeronav_msgs::header::{Header, Id};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::{Pose, wrap_angle};
use zeronav_msgs::topics::RobotOdometry;

/// Odometry messages that are kept.
const LENGTH: usize = 64;

/// Messages in a row that say that the robot stands.
pub const REST_MESSAGES: usize = 5;

/// Speeds below which it does; a standing robot's odometry may be noisy. [m/s], [rad/s]
const REST_MPS: f64 = 0.02;
const REST_RADPS: f64 = 0.05;

/// True when this message alone says that the robot stands.
#[must_use]
pub fn stands(odometry: &Odometry) -> bool {
    odometry.v_mps.abs() < REST_MPS && odometry.w_radps.abs() < REST_RADPS
}

/// One odometry message, without its place in shared memory.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// Identity.
    pub id: Id,
    /// Tick.
    pub tick: u64,
    /// Run time. [ns]
    pub run_ns: u64,
    /// Capture, monotonic. [ns]
    pub capture_ns: u64,
    /// The message.
    pub odometry: Odometry,
}

/// Recent odometry, oldest first.
#[derive(Debug, Default)]
pub struct Track {
    moments: VecDeque<Moment>,
}

impl Track {
    /// Adds a message. One of another writer, or of an earlier time, starts the track anew.
    pub fn push(&mut self, header: &Header, odometry: &Odometry) {
        let moment = Moment {
            id: header.id(),
            tick: header.tick,
            run_ns: header.run_ns,
            capture_ns: header.capture_ns,
            odometry: *odometry,
        };
        let follows = self
            .newest()
            .is_none_or(|last| last.id.epoch() == moment.id.epoch() && last.run_ns < moment.run_ns);
        if !follows {
            self.moments.clear();
        }
        if self.moments.len() == LENGTH {
            self.moments.pop_front();
        }
        self.moments.push_back(moment);
    }

    /// The newest message.
    #[must_use]
    pub fn newest(&self) -> Option<&Moment> {
        self.moments.back()
    }

    /// The message of `tick`.
    #[must_use]
    pub fn of_tick(&self, tick: u64) -> Option<&Moment> {
        self.moments.iter().rev().find(|moment| moment.tick == tick)
    }

    /// True when the newest messages say that the robot stands.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.moments.len() >= REST_MESSAGES
            && (self.moments.iter().rev().take(REST_MESSAGES))
                .all(|moment| stands(&moment.odometry))
    }

    /// `odom_from_base` at a run time between two messages, or at one; `None` outside the track.
    #[must_use]
    #[allow(clippy::cast_precision_loss, reason = "nanoseconds between two ticks")]
    pub fn pose_at(&self, run_ns: u64) -> Option<Pose> {
        let after = self
            .moments
            .partition_point(|moment| moment.run_ns < run_ns);
        let later = self.moments.get(after)?;
        if later.run_ns == run_ns {
            return Some(later.odometry.pose);
        }
        let earlier = self.moments.get(after.checked_sub(1)?)?;
        let share = (run_ns - earlier.run_ns) as f64 / (later.run_ns - earlier.run_ns) as f64;
        let (from, to) = (&earlier.odometry.pose, &later.odometry.pose);
        Some(Pose::new(
            from.x_m + share * (to.x_m - from.x_m),
            from.y_m + share * (to.y_m - from.y_m),
            wrap_angle(from.yaw_rad + share * wrap_angle(to.yaw_rad - from.yaw_rad)),
        ))
    }
}

/// Reads `robot/odometry`. Every role polls it before everything else: in lockstep it carries the
/// tick, and what was sent before it is then surely found by the others.
#[derive(Debug)]
pub struct TrackReader {
    stream: Stream<RobotOdometry>,
    track: Track,
}

impl TrackReader {
    /// Opens the topic.
    ///
    /// # Errors
    /// As [`Peer::stream`].
    pub fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            stream: peer.stream()?,
            track: Track::default(),
        })
    }

    /// Takes in what has come; true when there is newer odometry than before.
    pub fn poll(&mut self, roster: &Roster) -> bool {
        let mut moved = false;
        self.stream.drain(roster, |view| {
            self.track.push(view.header, view.meta);
            moved = true;
        });
        moved
    }

    /// What was read last.
    #[must_use]
    pub fn track(&self) -> &Track {
        &self.track
    }

    /// Identity of the newest message; [`Id::NONE`] before the first.
    #[must_use]
    pub fn id(&self) -> Id {
        self.track.newest().map_or(Id::NONE, |moment| moment.id)
    }

    /// Tick of the newest message; 0 before the first.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.track.newest().map_or(0, |moment| moment.tick)
    }

    /// Messages that were refused.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.stream.refused()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn push(track: &mut Track, tick: u64, x_m: f64, yaw_rad: f64) {
        let header = Header {
            id: Id::new(1, tick).0,
            tick,
            run_ns: tick * 20,
            ..Header::default()
        };
        let pose = Pose::new(x_m, 0.0, yaw_rad);
        track.push(
            &header,
            &Odometry {
                pose,
                ..Odometry::default()
            },
        );
    }

    #[test]
    fn poses_are_interpolated_through_the_wrap_and_never_extrapolated() {
        let mut track = Track::default();
        push(&mut track, 1, 1.0, 3.1);
        push(&mut track, 2, 2.0, -3.1);
        let pose = track.pose_at(30).expect("between the two");
        assert!((pose.x_m - 1.5).abs() < 1e-12);
        assert!(
            (pose.yaw_rad.abs() - core::f64::consts::PI).abs() < 1e-9,
            "{}",
            pose.yaw_rad
        );
        assert_eq!(track.pose_at(40).map(|pose| pose.x_m), Some(2.0));
        assert_eq!(track.pose_at(19), None);
        assert_eq!(track.pose_at(41), None);
    }

    #[test]
    fn another_writer_starts_anew() {
        let mut track = Track::default();
        push(&mut track, 5, 1.0, 0.0);
        let header = Header {
            id: Id::new(2, 1).0,
            tick: 6,
            run_ns: 120,
            ..Header::default()
        };
        track.push(&header, &Odometry::default());
        // Between the two frames nothing is interpolated.
        assert!(track.of_tick(5).is_none());
        assert_eq!(track.pose_at(110), None);
        assert!(track.pose_at(120).is_some());
    }

    #[test]
    fn the_robot_stands_when_five_messages_in_a_row_say_so() {
        let mut track = Track::default();
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
            track.push(&header, &odometry);
            track.is_at_rest()
        };
        assert!(!(1..5).any(|tick| push(tick, 0.0, 0.0)));
        assert!(push(5, 0.01, -0.04));
        assert!(!push(6, -0.03, 0.0));
        assert!(!(7..11).any(|tick| push(tick, 0.0, 0.0)));
        assert!(push(11, 0.0, 0.0));
        assert!(!push(12, 0.0, 0.06));
    }

    #[test]
    fn time_going_back_starts_anew() {
        let mut track = Track::default();
        push(&mut track, 5, 1.0, 0.0);
        push(&mut track, 4, 2.0, 0.0);
        assert!(track.of_tick(5).is_none());
        assert_eq!(track.newest().map(|moment| moment.tick), Some(4));
    }
}
