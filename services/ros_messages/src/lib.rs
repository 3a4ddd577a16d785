//! The messages of ROS 2, in CDR: what a stack stands for there ([`Ros`]), and what others sent ([`received`]).
//!
//! [`Ros`] shows what is obeyed: a shadow, or a newcomer that is not obeyed yet, moves nothing here.
//!
//! Pure: no middleware, no files, no clock.

#![forbid(unsafe_code)]

mod grid;
pub mod messages;
pub mod reasons;
pub mod received;
pub mod times;
mod topics;
pub mod view;

/// Why a message has no form in CDR.
pub use cdr_encoding::Error as CdrError;
pub use topics::{Qos, RosTopic, frame};

use bytemuck::{AnyBitPattern, NoUninit, pod_collect_to_vec, try_pod_read_unaligned};
use byteorder::LittleEndian;
use cdr_encoding::to_writer;
use grid::Grid;
use reasons::{Reason, Reasons};
use serde::Serialize;
use std::collections::BTreeMap;
use times::TimeBase;
use zeronav_msgs::description::Description;
use zeronav_msgs::header::{Header, Id};
use zeronav_msgs::health::Health;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::rollouts::RolloutOutcome;
use zeronav_msgs::run::Seat;
use zeronav_msgs::task::{Goal, TaskKind};
use zeronav_msgs::topics::{
    ControlRequest, DebugRollouts, Envelope, HEALTH, HealthTopic, MapKeyframe, MapObstacles,
    MapUpdate, PlanPath, RobotCommand, RobotDescription, RobotOdometry, RobotScan, RunControlTopic,
    TaskGoal, TaskState, Topic, TopicRow,
};

/// What CDR in little-endian order begins with.
const CDR_LE: [u8; 4] = [0, 1, 0, 0];

/// Longest time between two messages on `/diagnostics`, in the file's time. [ns]
const DIAGNOSTICS_NS: u64 = 1_000_000_000;

/// A message of ROS 2.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RosMessage {
    /// Its topic.
    pub topic: RosTopic,
    /// The moment that it is about, in the file's time. [ns]
    pub log_ns: u64,
    /// It in CDR.
    pub bytes: Vec<u8>,
}

/// `message` in CDR: 4 bytes that name the byte order, then its fields.
///
/// # Errors
/// For what has no form in CDR, such as a sequence of unknown length.
pub fn cdr<T: Serialize>(message: &T) -> Result<Vec<u8>, CdrError> {
    let mut bytes = CDR_LE.to_vec();
    to_writer::<T, LittleEndian, _>(&mut bytes, message)?;
    Ok(bytes)
}

/// Turns messages of the contract into those of ROS 2.
#[derive(Debug, Default)]
pub struct Ros {
    times: TimeBase,
    seats: Vec<Seat>,
    description: Option<Description>,
    grid: Grid,
    /// The goals of the newest task, and the one that was shown last.
    goals: Vec<Goal>,
    shown_goal: u64,
    health: BTreeMap<Role, Health>,
    diagnosed_ns: Option<u64>,
    reasons: Reasons,
    /// What comes of the message that is taken in.
    made: Vec<RosMessage>,
}

/// A message of the contract, as its bytes.
#[derive(Debug, Clone, Copy)]
pub struct Bytes<'a> {
    /// The topic.
    pub row: &'static TopicRow,
    /// The file's time of the moment that it is about. [ns]
    pub log_ns: u64,
    /// Header and fixed fields.
    pub envelope: &'a [u8],
    /// The items.
    pub items: &'a [u8],
}

impl Bytes<'_> {
    /// Header, fixed fields and items, if it is of topic `T`.
    fn of<T: Topic>(&self) -> Option<(Header, T::Meta, Vec<T::Item>)> {
        let is_health = T::ROW.number == HealthTopic::ROW.number
            && HEALTH.iter().any(|row| row.number == self.row.number);
        if self.row.number != T::ROW.number && !is_health {
            return None;
        }
        let envelope: T::Envelope = try_pod_read_unaligned(self.envelope).ok()?;
        let items = items(self.items)?;
        Some((*envelope.header(), *envelope.meta(), items))
    }
}

fn items<T: NoUninit + AnyBitPattern>(bytes: &[u8]) -> Option<Vec<T>> {
    let is_whole = bytes.len().is_multiple_of(size_of::<T>());
    is_whole.then(|| pod_collect_to_vec(bytes))
}

impl Ros {
    /// Nothing has come yet.
    #[must_use]
    pub fn new(times: TimeBase) -> Self {
        Self {
            times,
            ..Self::default()
        }
    }

    /// Moments are from now on told by these times.
    pub fn set_times(&mut self, times: TimeBase) {
        self.times = times;
    }

    /// True when the map can only be shown again with a keyframe of mapping.
    #[must_use]
    pub fn needs_keyframe(&self) -> bool {
        self.grid.needs_keyframe()
    }

    /// Costs within `half_m` of a pose in the map along both axes, as a costmap of Nav2 is published; `None` off the
    /// map and before it is known. [m], [ns]
    #[must_use]
    pub fn costs_around(&self, ns: u64, at: &Pose, half_m: f64) -> Option<messages::OccupancyGrid> {
        let (geometry, costs) = self.grid.costs_around(at, half_m)?;
        Some(view::map(ns, &geometry, &costs))
    }

    /// What comes of an accepted message, in the order in which it belongs into the file.
    ///
    /// # Errors
    /// As [`cdr`].
    pub fn see(&mut self, message: &Bytes<'_>) -> Result<Vec<RosMessage>, CdrError> {
        if let Some((_, _, seats)) = message.of::<RunControlTopic>() {
            self.seats = seats;
        } else if let Some((header, meta, ranges)) = self.obeyed::<RobotScan>(message) {
            let ns = self.times.at_run(header.run_ns);
            let scan = view::scan(ns, &meta, &ranges, self.description.as_ref());
            self.make(RosTopic::Scan, ns, &scan)?;
            self.make(RosTopic::ScanPoints, ns, &view::hits(ns, &meta, &ranges))?;
        } else if let Some((header, meta, _)) = self.obeyed::<RobotOdometry>(message) {
            let ns = self.times.at_run(header.run_ns);
            self.make(RosTopic::Odom, ns, &view::odometry(ns, &meta))?;
            let tf = view::transform(ns, frame::ODOM, frame::BASE, &meta.pose);
            self.make(RosTopic::Tf, ns, &tf)?;
        } else if let Some((header, meta, _)) = self.obeyed::<RobotCommand>(message) {
            let ns = self.times.at_run(header.run_ns);
            self.make(RosTopic::CmdVel, ns, &view::command(ns, &meta))?;
            let reason = self.reasons.command(&meta);
            self.tell(ns, reason)?;
        } else if let Some((header, _, obstacles)) = self.obeyed::<MapObstacles>(message) {
            let ns = self.times.at_run(header.run_ns);
            let markers = view::obstacles(ns, &obstacles);
            self.make(RosTopic::TrackedObstacles, ns, &markers)?;
        } else if let Some((header, meta, waypoints)) = self.obeyed::<PlanPath>(message) {
            let ns = self.times.at_run(header.run_ns);
            let path = view::path(ns, view::waypoints(&waypoints));
            self.make(RosTopic::Plan, ns, &path)?;
            let points_m = waypoints.iter().map(|it| [it.x_m, it.y_m]);
            let cloud = view::cloud(ns, frame::MAP, points_m);
            self.make(RosTopic::PlanPoints, ns, &cloud)?;
            let reason = self.reasons.path(&meta);
            self.tell(ns, reason)?;
        } else if let Some((header, meta, _)) = self.obeyed::<ControlRequest>(message) {
            let reason = self.reasons.request(&meta);
            self.tell(self.times.at_run(header.run_ns), reason)?;
        } else {
            self.see_rare(message)?;
            self.see_map(message)?;
            self.see_task(message)?;
        }
        Ok(core::mem::take(&mut self.made))
    }

    fn see_rare(&mut self, message: &Bytes<'_>) -> Result<(), CdrError> {
        if let Some((_, meta, _)) = self.obeyed::<RobotDescription>(message) {
            self.description = Some(meta);
            let ns = message.log_ns;
            let tf = view::transform(ns, frame::BASE, frame::LASER, &meta.base_from_laser);
            self.make(RosTopic::TfStatic, ns, &tf)?;
        } else if let Some((header, _, rollouts)) = self.obeyed::<DebugRollouts>(message) {
            let ns = self.times.at_run(header.run_ns);
            let mut all = rollouts.iter();
            let chosen = all.find(|it| it.outcome() == Some(RolloutOutcome::Chosen));
            if let Some(chosen) = chosen {
                let path = view::path(ns, view::rollout(chosen));
                self.make(RosTopic::LocalPlan, ns, &path)?;
            }
        } else if let Some((header, meta, _)) = self.obeyed::<HealthTopic>(message) {
            let Some(role) = header.role() else {
                return Ok(());
            };
            let before = self.health.insert(role, meta);
            let is_news = before.is_none_or(|before| {
                (before.state, before.reasons, before.pid) != (meta.state, meta.reasons, meta.pid)
            });
            let ns = message.log_ns;
            let is_due = (self.diagnosed_ns)
                .is_none_or(|before_ns| ns.saturating_sub(before_ns) >= DIAGNOSTICS_NS);
            if is_news || is_due {
                self.diagnosed_ns = Some(ns);
                let all = self.health.iter();
                let array = messages::DiagnosticArray {
                    header: view::header(ns, ""),
                    status: all.map(|(role, it)| view::diagnostic(*role, it)).collect(),
                };
                self.make(RosTopic::Diagnostics, ns, &array)?;
            }
        }
        Ok(())
    }

    fn see_map(&mut self, message: &Bytes<'_>) -> Result<(), CdrError> {
        if let Some((header, info, tiles)) = self.obeyed::<MapUpdate>(message) {
            self.grid.update(header.id(), &info, &tiles);
            if info.is_last_part() {
                let ns = self.times.at_run(header.run_ns);
                let tf = view::transform(ns, frame::MAP, frame::ODOM, &info.map_from_odom);
                self.make(RosTopic::Tf, ns, &tf)?;
            }
        } else if let Some((_, info, tiles)) = self.obeyed::<MapKeyframe>(message) {
            self.grid.keyframe(&info, &tiles);
        } else {
            return Ok(());
        }
        let ns = message.log_ns;
        let news = self.grid.take_news(ns);
        for rect in &news.changed {
            let update = view::map_update(ns, &news.geometry, self.grid.cells(), rect);
            self.make(RosTopic::MapUpdates, ns, &update)?;
        }
        if news.whole {
            let map = view::map(ns, &news.geometry, self.grid.cells());
            self.make(RosTopic::Map, ns, &map)?;
        }
        Ok(())
    }

    fn see_task(&mut self, message: &Bytes<'_>) -> Result<(), CdrError> {
        let goal = if let Some((_, task, goals)) = message.of::<TaskGoal>() {
            self.goals = goals;
            self.shown_goal = 0;
            match task.kind() {
                Some(TaskKind::Go) => self.goals.first().copied(),
                _ => None,
            }
        } else if let Some((_, status, _)) = self.obeyed::<TaskState>(message) {
            let mut goals = self.goals.iter();
            goals.find(|goal| goal.id == status.goal).copied()
        } else {
            None
        };
        let Some(goal) = goal.filter(|goal| goal.id != self.shown_goal) else {
            return Ok(());
        };
        self.shown_goal = goal.id;
        let ns = message.log_ns;
        self.make(RosTopic::GoalPose, ns, &view::pose_in_map(ns, &goal.pose))
    }

    /// The message, if it is of topic `T` and its author is obeyed.
    #[must_use]
    pub fn obeyed<T: Topic>(&self, message: &Bytes<'_>) -> Option<(Header, T::Meta, Vec<T::Item>)> {
        let (header, meta, items) = message.of::<T>()?;
        let id: Id = header.id();
        let seat = self.seats.iter().find(|seat| seat.role == header.role);
        let is_obeyed = seat.is_none_or(|seat| seat.obeys(id.epoch(), header.tick));
        is_obeyed.then_some((header, meta, items))
    }

    fn tell(&mut self, ns: u64, reason: Option<Reason>) -> Result<(), CdrError> {
        match reason {
            Some(reason) => self.make(RosTopic::Why, ns, &reason.message(ns)),
            None => Ok(()),
        }
    }

    fn make<T: Serialize>(
        &mut self,
        topic: RosTopic,
        log_ns: u64,
        message: &T,
    ) -> Result<(), CdrError> {
        let bytes = cdr(message)?;
        self.made.push(RosMessage {
            topic,
            log_ns,
            bytes,
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests;
