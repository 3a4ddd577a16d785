//! What a robot of ROS 2 sends, as measurements of the contract: checked, in order, in one frame and on one clock.

use crate::frames::{BASES, Frames};
use crate::publishers::{Gid, Publishers};
use crate::stamps::{Moment, Stamps};
use core::fmt;
use std::collections::VecDeque;
use zeronav_casts::Cast;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::scan::Scan;
use zeronav_ros_messages::messages::{self as ros, TfMessage};
use zeronav_ros_messages::received::{self, plain_frame, planar_pose, stamp_ns};

/// Time for which a trouble is named after it was seen last. [ns]
const NAMED_NS: u64 = 1_000_000_000;

/// For how long stamps may stand still. [ns]
const STANDING_NS: u64 = 300_000_000;

/// Farther than the robot can have come: odometry that begins anew. [m], [rad]
const JUMP_M: f64 = 1.0;
const JUMP_RAD: f64 = 1.5;

/// What came of the robot.
#[derive(Debug, Clone)]
pub enum Event {
    /// A turn of the lidar.
    Scan(ros::LaserScan),
    /// Odometry.
    Odometry(Box<ros::Odometry>),
    /// Transforms, of either topic.
    Transforms(TfMessage),
}

/// An event, when it came, and from whom.
#[derive(Debug, Clone)]
pub struct Arrived {
    /// What came.
    pub event: Event,
    /// When, monotonic. [ns]
    pub came_ns: u64,
    /// Who published it.
    pub publisher: Gid,
}

/// A measurement of the robot.
#[derive(Debug, Clone, PartialEq)]
pub enum Measured {
    /// A scan; odometry of a later moment may come before or after it.
    Scan {
        /// When its last beam was.
        moment: Moment,
        /// Fixed fields.
        scan: Scan,
        /// Ranges. [m]
        ranges: Vec<f32>,
        /// `base_from_laser`.
        base_from_laser: Pose,
    },
    /// Odometry in the stack's frame.
    Odometry {
        /// When.
        moment: Moment,
        /// What it says.
        odometry: Odometry,
    },
}

/// What is wrong with what comes. The robot stands meanwhile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    /// No transforms lead from the frame of the scans to that of the robot.
    Transform,
    /// Its clock was set, or stands.
    Clock,
    /// Two nodes publish scans, or odometry.
    Publishers,
}

impl Trouble {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Transform, Self::Clock, Self::Publishers];
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Transform => {
                "no transforms lead from the frame of the scans to that of the robot"
            }
            Self::Clock => "the clock of the robot was set or stands still",
            Self::Publishers => "two nodes publish scans or odometry",
        })
    }
}

/// What is expected of the robot.
#[derive(Debug, Clone)]
pub struct Expected {
    /// Frame of the odometry.
    pub odom_frame: String,
    /// Frame of the robot.
    pub base_frame: String,
    /// Where the laser is when transforms do not say it.
    pub fixed_laser: Option<Pose>,
    /// Where the robot is at its first odometry, `map_from_base`.
    pub start: Pose,
}

/// See the module's description.
#[derive(Debug)]
pub struct Inputs {
    expected: Expected,
    stamps: Stamps,
    frames: Frames,
    scans: Publishers,
    odometries: Publishers,
    /// `stack_from_odom`: the stack's odometry begins where the robot starts.
    anchor: Option<Pose>,
    /// Newest odometry: its moment on the robot's clock, and its poses before and after the anchor.
    newest: Option<(u64, Pose, Pose)>,
    newest_scan_ns: u64,
    /// When stamps grew last. [ns]
    grew_ns: Option<u64>,
    seen_ns: [Option<u64>; 3],
    ready: VecDeque<Measured>,
    rejected: u64,
    /// The kinds of rejections that were logged.
    said: Vec<&'static str>,
}

impl Inputs {
    /// Nothing has come yet. `anchor` is that of a process before this one in the seat.
    #[must_use]
    pub fn new(expected: Expected, stamps: Stamps, anchor: Option<Pose>) -> Self {
        Self {
            expected,
            stamps,
            anchor,
            frames: Frames::default(),
            scans: Publishers::default(),
            odometries: Publishers::default(),
            newest: None,
            newest_scan_ns: 0,
            grew_ns: None,
            seen_ns: [None; 3],
            ready: VecDeque::new(),
            rejected: 0,
            said: Vec::new(),
        }
    }

    /// Takes in what came; what can be measured by it is given by [`Self::next_measured`].
    pub fn take(&mut self, arrived: Arrived) {
        let Arrived {
            event,
            came_ns,
            publisher,
        } = arrived;
        match event {
            Event::Transforms(message) => self.frames.take(&message),
            Event::Odometry(message) => {
                self.odometries.heard(publisher, came_ns);
                self.odometry(&message, came_ns);
            }
            Event::Scan(message) => {
                self.scans.heard(publisher, came_ns);
                self.scan(message, came_ns);
            }
        }
        if self.odometries.are_two(came_ns) || self.scans.are_two(came_ns) {
            self.note(Trouble::Publishers, came_ns);
            self.ready.clear();
        }
    }

    /// The next measurement, oldest first.
    pub fn next_measured(&mut self) -> Option<Measured> {
        self.ready.pop_front()
    }

    fn odometry(&mut self, message: &ros::Odometry, came_ns: u64) {
        if plain_frame(&message.header.frame_id) != plain_frame(&self.expected.odom_frame) {
            return self.reject("odometry in another frame than odom_frame");
        }
        let child = plain_frame(&message.child_frame_id);
        if child != plain_frame(&self.expected.base_frame) && !BASES.contains(&child) {
            return self.reject("odometry of another frame than base_frame");
        }
        let at = &message.pose.pose;
        let Some(raw) = planar_pose(&at.position, &at.orientation) else {
            return self.reject("odometry with a pose that is not finite");
        };
        let twist = &message.twist.twist;
        let variance = [0, 1, 5].map(|n| message.pose.covariance[n][n]);
        let variance = variance.map(|it| {
            if (0.0..=1.0e12).contains(&it) {
                it
            } else {
                0.0
            }
        });
        let mut odometry = Odometry {
            pose: raw,
            v_mps: twist.linear.x,
            w_radps: twist.angular.z,
            variance,
            ..Odometry::default()
        };
        if odometry.check().is_err() {
            return self.reject("odometry that no robot can have");
        }
        let stamp_ns = stamp_ns(message.header.stamp);
        let Some(moment) = self.moment(stamp_ns, came_ns) else {
            return;
        };
        if self.newest.is_some_and(|(at_ns, ..)| moment.at_ns <= at_ns) {
            let stands = |grew_ns: u64| came_ns.saturating_sub(grew_ns) > STANDING_NS;
            if self.grew_ns.is_some_and(stands) {
                self.note(Trouble::Clock, came_ns);
            }
            return;
        }
        self.grew_ns = Some(came_ns);
        self.anchor_to(&raw, moment.at_ns, odometry.v_mps);
        let anchor = *self.anchor.get_or_insert_with(|| {
            let raw_from_stack = raw.isometry().inverse();
            Pose::from(self.expected.start.isometry() * raw_from_stack)
        });
        odometry.pose = anchor.then(&raw);
        if odometry.check().is_err() {
            return self.reject("odometry that no robot can have");
        }
        self.newest = Some((moment.at_ns, raw, odometry.pose));
        self.ready
            .push_back(Measured::Odometry { moment, odometry });
    }

    /// Odometry that begins anew, as that of a base that was switched off and on, goes on from where it was.
    fn anchor_to(&mut self, raw: &Pose, at_ns: u64, v_mps: f64) {
        let Some((before_ns, before, stack)) = self.newest else {
            return;
        };
        let gap_s = at_ns.saturating_sub(before_ns).to_f64() * 1.0e-9;
        let turned_rad = zeronav_msgs::pose::wrap_angle(raw.yaw_rad - before.yaw_rad).abs();
        let is_jump = before.distance_m(raw) > JUMP_M + v_mps.abs() * gap_s
            || (turned_rad > JUMP_RAD && gap_s < 0.5);
        if is_jump {
            tracing::warn!(
                distance_m = before.distance_m(raw),
                turned_rad,
                "odometry jumped: it goes on from where it was"
            );
            let raw_from_stack = raw.isometry().inverse();
            self.anchor = Some(Pose::from(stack.isometry() * raw_from_stack));
        }
    }

    fn scan(&mut self, message: ros::LaserScan, came_ns: u64) {
        let (stamp, frame) = (
            stamp_ns(message.header.stamp),
            message.header.frame_id.clone(),
        );
        let received = match received::scan(message) {
            Ok(received) => received,
            Err(why) => return self.reject(why),
        };
        let base_from_laser = match self.expected.fixed_laser {
            Some(pose) => pose,
            None => match self.frames.base_from(&self.expected.base_frame, &frame) {
                Some(pose) => pose,
                None => return self.note(Trouble::Transform, came_ns),
            },
        };
        let last_beam_ns = stamp.saturating_add(received.turn_ns);
        let Some(moment) = self.moment(last_beam_ns, came_ns) else {
            return;
        };
        if moment.at_ns <= self.newest_scan_ns {
            return;
        }
        self.newest_scan_ns = moment.at_ns;
        self.ready.push_back(Measured::Scan {
            moment,
            scan: received.scan,
            ranges: received.ranges,
            base_from_laser,
        });
    }

    /// The moment of a message, or `None` while the clock cannot be relied on. [ns]
    fn moment(&mut self, stamp_ns: u64, came_ns: u64) -> Option<Moment> {
        let moment = self.stamps.moment(stamp_ns, came_ns);
        if let Some(by_ns) = moment.set_by_ns {
            let by_s = by_ns / 1_000_000_000;
            tracing::warn!(by_s, "the clock of the robot was set");
            self.note(Trouble::Clock, came_ns);
        }
        Some(moment).filter(|_| self.holds(Trouble::Clock, came_ns).is_none())
    }

    fn note(&mut self, trouble: Trouble, now_ns: u64) {
        let seen_ns = &mut self.seen_ns[trouble as usize];
        if seen_ns.is_none_or(|at_ns| now_ns.saturating_sub(at_ns) >= NAMED_NS) {
            tracing::warn!("{trouble}: the robot stands");
        }
        *seen_ns = Some(now_ns);
    }

    /// The trouble, while it holds. [ns]
    #[must_use]
    pub fn holds(&self, trouble: Trouble, now_ns: u64) -> Option<Trouble> {
        let seen_ns = self.seen_ns[trouble as usize]?;
        (now_ns.saturating_sub(seen_ns) < NAMED_NS).then_some(trouble)
    }

    fn reject(&mut self, why: &'static str) {
        self.rejected += 1;
        if !self.said.contains(&why) {
            self.said.push(why);
            tracing::warn!("rejected: {why}");
        }
    }

    /// Messages that were rejected.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.rejected + self.frames.rejected()
    }

    /// Why messages were rejected, each reason once.
    #[must_use]
    pub fn reasons(&self) -> &[&'static str] {
        &self.said
    }

    /// `stack_from_odom`, once odometry has come.
    #[must_use]
    pub fn anchor(&self) -> Option<Pose> {
        self.anchor
    }

    /// The clock of the robot.
    #[must_use]
    pub fn stamps(&self) -> &Stamps {
        &self.stamps
    }
}

#[cfg(test)]
mod tests;
