//! What launch reads of a running stack.

use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{
    ControlRequest, GroundTruth, HealthTopic, MapKeyframe, MapObstacles, MapUpdate, PlanPath,
    RobotCommand, RobotDescription, RobotOdometry, RobotScan, TaskState, health_of,
};
use zeronav_shell::records::SpanReader;
use zeronav_shell::{Latest, Peer, StartError, Stream};

/// What launch reads.
#[derive(Debug)]
pub struct Taps {
    /// One record per cycle and process.
    pub spans: SpanReader,
    /// Ground truth.
    pub truth: Stream<GroundTruth>,
    /// What the lidar sees; for the film alone.
    pub scans: Stream<RobotScan>,
    /// What the local planner asks for; for the film alone.
    pub requests: Stream<ControlRequest>,
    /// What the guard lets the wheels do.
    pub commands: Stream<RobotCommand>,
    /// Where the wheels say the robot is.
    pub odometry: Stream<RobotOdometry>,
    /// What mapping has seen moving.
    pub moving: Stream<MapObstacles>,
    /// The map as it changes.
    pub updates: Stream<MapUpdate>,
    /// The whole map.
    pub keyframe: Latest<MapKeyframe>,
    /// Every path.
    pub paths: Stream<PlanPath>,
    /// What became of the task.
    pub status: Latest<TaskState>,
    /// The robot.
    pub description: Latest<RobotDescription>,
    /// The heartbeats.
    pub health: Vec<(Role, Latest<HealthTopic>)>,
}

impl Taps {
    /// Opens the topics.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub(super) fn open(peer: &Peer) -> Result<Self, StartError> {
        let mut health = Vec::new();
        for role in Role::SERVICES {
            if let Some(row) = health_of(role) {
                health.push((role, peer.latest_on(row)?));
            }
        }
        Ok(Self {
            spans: peer.span_reader()?,
            truth: peer.stream()?,
            scans: peer.stream()?,
            requests: peer.stream()?,
            commands: peer.stream()?,
            odometry: peer.stream()?,
            moving: peer.stream()?,
            updates: peer.stream()?,
            keyframe: peer.latest()?,
            paths: peer.stream()?,
            status: peer.latest()?,
            description: peer.latest()?,
            health,
        })
    }
}
