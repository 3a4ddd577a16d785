//! What the stack stands for in ROS 2, published.

use super::config::BesideConfig;
use super::taps::{Message, Taps};
use crate::anchor::{self, Anchor};
use ros2_client::qos::{Durability, History, QosProfile};
use ros2_client::{MessageTypeName, Name, Node, Publisher};
use serde::ser::{Serialize, SerializeTuple, Serializer};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunClock;
use zeronav_msgs::topics::{
    EVENT_NEED_KEYFRAME, MapUpdate, RobotCommand, RobotOdometry, RobotScan, Topic,
};
use zeronav_ros_messages::messages::{OccupancyGrid, PoseStamped, PoseWithCovariance, TfMessage};
use zeronav_ros_messages::times::TimeBase;
use zeronav_ros_messages::{Bytes, Qos, Ros, RosMessage, RosTopic, cdr, frame, view};
use zeronav_shell::doorbell::Bells;
use zeronav_shell::{Guest, StartError};

/// Half the side of the costs that are shown around the robot. [m]
const COSTS_HALF_M: f64 = 3.0;

/// Least time between two requests for the whole map.
const ASK_PAUSE: Duration = Duration::from_secs(1);

/// Time between two looks at where the robot's frames lie.
const ANCHOR_PAUSE: Duration = Duration::from_millis(500);

/// CDR begins with 4 bytes that name the byte order, which the middleware writes itself.
const HEAD: usize = 4;

/// A message whose fields are in CDR already.
struct Raw(Vec<u8>);

impl Serialize for Raw {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // A tuple has no length in CDR, and bytes need no alignment.
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        for byte in &self.0 {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

/// See the module's description.
pub(super) struct Outputs {
    taps: Taps,
    ros: Ros,
    bells: Bells,
    asked_at: Option<Instant>,
    publishers: BTreeMap<RosTopic, Publisher<Raw>>,
    /// What the robot measures and is told is published, too.
    robot_topics: bool,
    anchor: Option<Anchor>,
    looked_at: Option<Instant>,
    clock: RunClock,
    times: TimeBase,
    map_from_odom: Option<Pose>,
    odom_from_base: Option<Pose>,
    /// When the newest odometry was. [ns]
    stamp_ns: u64,
    failed: u64,
}

/// True of topics of the robot's own side.
fn is_robots(topic: RosTopic) -> bool {
    use RosTopic::{CmdVel, Odom, Scan, ScanPoints, TfStatic};
    matches!(topic, Scan | ScanPoints | Odom | TfStatic | CmdVel)
}

impl Outputs {
    pub(super) fn open(
        guest: &Guest,
        node: &mut Node,
        config: &BesideConfig,
    ) -> Result<Self, StartError> {
        let clock = guest.roster().clock;
        let times = times(&clock);
        let mut publishers = BTreeMap::new();
        for topic in RosTopic::ALL {
            let is_goal = *topic == RosTopic::GoalPose;
            if is_goal || (is_robots(*topic) && !config.robot_topics) {
                continue;
            }
            publishers.insert(*topic, publisher(node, &config.namespace, *topic)?);
        }
        Ok(Self {
            taps: Taps::open(guest.peer())?,
            ros: Ros::new(times),
            bells: Bells::open(guest.peer())?,
            asked_at: None,
            publishers,
            robot_topics: config.robot_topics,
            anchor: None,
            looked_at: None,
            clock,
            times,
            map_from_odom: None,
            odom_from_base: None,
            stamp_ns: 0,
            failed: 0,
        })
    }

    /// Where the robot is, in the map.
    pub(super) fn pose(&self) -> Option<PoseStamped> {
        let pose = self.map_from_odom?.then(&self.odom_from_base?);
        Some(view::pose_in_map(self.stamp_ns, &pose))
    }

    /// The costs around the robot.
    pub(super) fn costs(&self) -> Option<OccupancyGrid> {
        let pose = self.map_from_odom?.then(&self.odom_from_base?);
        self.ros.costs_around(self.stamp_ns, &pose, COSTS_HALF_M)
    }

    /// The same as `amcl` says it.
    pub(super) fn located(
        &self,
    ) -> Option<(zeronav_ros_messages::messages::Header, PoseWithCovariance)> {
        let it = self.pose()?;
        let pose = PoseWithCovariance {
            pose: it.pose,
            covariance: Default::default(),
        };
        Some((it.header, pose))
    }

    /// Publishes what has come of the stack.
    pub(super) fn look(&mut self, guest: &Guest) -> Result<(), StartError> {
        self.look_at_anchor(guest);
        let mut came = Vec::new();
        self.taps.drain(|message| came.push(message));
        for message in came {
            self.see(&message)?;
        }
        let is_due = (self.asked_at).is_none_or(|at| at.elapsed() >= ASK_PAUSE);
        if self.ros.needs_keyframe() && is_due {
            self.asked_at = Some(Instant::now());
            self.bells.ring(Role::Mapping, EVENT_NEED_KEYFRAME);
        }
        Ok(())
    }

    /// A robot of ROS 2 has frames and a run time of its own.
    fn look_at_anchor(&mut self, guest: &Guest) {
        if self.looked_at.is_some_and(|at| at.elapsed() < ANCHOR_PAUSE) {
            return;
        }
        self.looked_at = Some(Instant::now());
        let anchor = anchor::read(guest.peer().domain().folder());
        if anchor == self.anchor {
            return;
        }
        self.anchor = anchor;
        if let Some(anchor) = anchor {
            self.times = times(&RunClock {
                zero_ns: anchor.zero_ns,
                ..self.clock
            });
            self.ros.set_times(self.times);
        }
    }

    fn see(&mut self, message: &Message) -> Result<(), StartError> {
        let Message {
            row,
            envelope,
            items,
        } = message;
        let now_ns = zeronav_shell::clock::now_ns();
        let bytes = Bytes {
            row,
            log_ns: self.times.at_monotonic(now_ns).unwrap_or_default(),
            envelope,
            items,
        };
        let is = |of: &zeronav_msgs::topics::TopicRow| of.number == row.number;
        if let Some((header, odometry, _)) = self.ros.obeyed::<RobotOdometry>(&bytes) {
            self.odom_from_base = Some(odometry.pose);
            self.stamp_ns = self.times.at_run(header.run_ns);
        }
        if let Some((header, info, _)) = self.ros.obeyed::<MapUpdate>(&bytes)
            && info.is_last_part()
        {
            self.map_from_odom = Some(info.map_from_odom);
            self.publish_map_frame(self.times.at_run(header.run_ns))?;
        }
        // Nothing else comes of what the robot measures.
        if (is(RobotOdometry::ROW) || is(RobotScan::ROW)) && !self.robot_topics {
            return Ok(());
        }
        let made = (self.ros.see(&bytes)).map_err(|why| StartError::system("CDR", why))?;
        for RosMessage { topic, bytes, .. } in made {
            let is_map_frame = topic == RosTopic::Tf && is(MapUpdate::ROW);
            let is_hidden =
                topic == RosTopic::CmdVel && is(RobotCommand::ROW) && !self.robot_topics;
            if !(is_map_frame || is_hidden) {
                self.publish(topic, bytes);
            }
        }
        Ok(())
    }

    /// `map` to `odom`, of the odometry that ROS 2 knows.
    fn publish_map_frame(&mut self, ns: u64) -> Result<(), StartError> {
        let Some(map_from_stack) = self.map_from_odom else {
            return Ok(());
        };
        let map_from_odom = match &self.anchor {
            Some(anchor) => map_from_stack.then(&anchor.pose()),
            None => map_from_stack,
        };
        let message: TfMessage = view::transform(ns, frame::MAP, frame::ODOM, &map_from_odom);
        let bytes = cdr(&message).map_err(|why| StartError::system("CDR", why))?;
        self.publish(RosTopic::Tf, bytes);
        Ok(())
    }

    fn publish(&mut self, topic: RosTopic, mut bytes: Vec<u8>) {
        let Some(publisher) = self.publishers.get(&topic) else {
            return;
        };
        if publisher
            .publish(Raw(bytes.split_off(HEAD.min(bytes.len()))))
            .is_err()
        {
            self.failed += 1;
            if self.failed.is_power_of_two() {
                tracing::warn!(
                    topic = topic.name(),
                    n = self.failed,
                    "could not be published"
                );
            }
        }
    }
}

fn times(clock: &RunClock) -> TimeBase {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Realtime);
    let unix_ns = now.tv_sec.cast_unsigned() * 1_000_000_000 + now.tv_nsec.cast_unsigned();
    TimeBase::new(clock, unix_ns, zeronav_shell::clock::now_ns())
}

/// How a topic is offered.
pub(super) fn profile(qos: Qos) -> QosProfile {
    let reliable = QosProfile::publisher_default();
    match qos {
        Qos::Reliable => reliable.history(History::KeepLast { depth: 10 }),
        Qos::Sensor => reliable
            .reliability_best_effort()
            .history(History::KeepLast { depth: 5 }),
        Qos::Latched => reliable
            .durability(Durability::TransientLocal)
            .history(History::KeepLast { depth: 1 }),
    }
}

fn publisher(node: &mut Node, space: &str, topic: RosTopic) -> Result<Publisher<Raw>, StartError> {
    let failed = |why: &dyn core::fmt::Debug| {
        StartError::system(format!("publishing {}", topic.name()), format!("{why:?}"))
    };
    let name = Name::parse(&format!("{space}{}", topic.name())).map_err(|why| failed(&why))?;
    let (package, kind) = topic.type_name().split_once("/msg/").unwrap_or_default();
    let kind = MessageTypeName::new(package, kind);
    let made = node.create_topic(&name, kind, &profile(topic.qos()));
    let made = made.map_err(|why| failed(&why))?;
    node.create_publisher(&made, None)
        .map_err(|why| failed(&why))
}
