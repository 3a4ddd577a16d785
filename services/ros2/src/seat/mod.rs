//! The robot's seat as a service: a robot of ROS 2 instead of a simulated one.
//!
//! Ticks are those of the robot's odometry. When commands are late, when what it sends cannot be relied on, and at the
//! end, the robot is told to stop; when it sends nothing, the stack sees its inputs age and stops.

mod commands;
mod describe;
mod sensors;

use crate::anchor::{self, Anchor};
use crate::config::SeatConfig;
use crate::inbox::{Inbox, host_offset_ns};
use crate::inputs::{Inputs, Trouble};
use crate::network::Network;
use crate::stamps::Stamps;
use crate::timeline::Timeline;
use commands::Commands;
use sensors::Sensors;
use zeronav_msgs::health::{
    REASON_CLOCK, REASON_ODOMETRY, REASON_PUBLISHERS, REASON_SCAN, REASON_TRANSFORM,
};
use zeronav_msgs::role::Role;
use zeronav_params::Parameter;
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Service, Shell, StartError};

/// Time without scans or odometry after which it is said. [ns]
const SILENT_NS: u64 = 500_000_000;

/// Time between two looks when nothing comes. [ns]
const LOOK_NS: u64 = 20_000_000;

/// Name of the node.
pub const NODE: &str = "zeronav_robot";

/// See the module's description.
pub struct RosRobot {
    // Before the node that they belong to is dropped.
    commands: Commands,
    inbox: Inbox,
    _node: ros2_client::Node,
    inputs: Inputs,
    timeline: Timeline,
    sensors: Sensors,
    /// What lies in the run's folder.
    kept: Option<Anchor>,
    /// What the robot's clock was said to be ahead. [s]
    said_ahead_s: Option<i64>,
}

impl Service for RosRobot {
    const ROLE: Role = Role::Robot;
    type Config = SeatConfig;

    fn parameters() -> Vec<Parameter> {
        SeatConfig::parameters()
    }

    fn check(config: &SeatConfig) -> Result<(), StartError> {
        config.check()?;
        Network::new(&config.ros.network).map_err(StartError::Usage)?;
        describe::footprint(&config.robot).map(|_| ())
    }

    fn open(shell: &mut Shell, config: SeatConfig) -> Result<Self, StartError> {
        let kept = anchor::read(shell.peer().domain().folder());
        let failed = |why| StartError::system("ROS 2", why);
        let network = Network::new(&config.ros.network).map_err(StartError::Usage)?;
        let (_, mut node) = network.node(NODE).map_err(failed)?;
        let commands = Commands::open(shell.peer(), &mut node, &config)?;
        let waker = shell.waker()?;
        let inbox = Inbox::open(&mut node, &config.ros, move || waker.wake()).map_err(failed)?;
        let ros = &config.ros;
        tracing::info!(
            domain_id = network.domain_id,
            range = ?network.range,
            scan = ros.scan_topic,
            odometry = ros.odom_topic,
            commands = ros.cmd_vel_topic,
            "waits for the robot"
        );
        let stamps = Stamps::new(ros.use_sim_time, host_offset_ns());
        Ok(Self {
            commands,
            inbox,
            _node: node,
            inputs: Inputs::new(config.expected(), stamps, kept.map(|it| it.pose())),
            timeline: Timeline::from_zero(kept.map(|it| it.zero_ns)),
            sensors: Sensors::open(shell.peer(), &config)?,
            kept,
            said_ahead_s: None,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        if shell.roster().lockstep() {
            let why = "a robot of ROS 2 keeps real time: run without --lockstep";
            return Err(StartError::Usage(why.to_owned()));
        }
        self.sensors.begin(shell);
        let (now, control) = (shell.woken_ns(), shell.roster().control);
        self.timeline.pause(control.paused == 1, now);
        // Commands first: they are the shortest way, and nothing that comes in holds them up.
        self.commands.poll(shell);
        self.ingest(shell)?;
        let is_troubled = self.say_trouble(shell, now);
        let holds = self.timeline.is_paused() || is_troubled || shell.is_orphaned();
        self.commands.watch(holds, now_ns());
        shell.count(&[
            self.commands.input(),
            &sensors::Counts {
                rejected: self.inputs.rejected() + self.inbox.broken(),
                dropped: self.inbox.dropped(),
            },
        ]);
        shell.wake_by(now + LOOK_NS);
        Ok(())
    }

    fn is_at_rest(&self) -> bool {
        self.sensors.is_at_rest()
    }
}

impl RosRobot {
    /// Takes in what has come, and sends it on.
    fn ingest(&mut self, shell: &mut Shell) -> Result<(), StartError> {
        while let Some(arrived) = self
            .inbox
            .next()
            .map_err(|why| StartError::system("ROS 2", why))?
        {
            self.inputs.take(arrived);
            while let Some(measured) = self.inputs.next_measured() {
                self.sensors.send(shell, &mut self.timeline, measured);
            }
        }
        self.keep(shell);
        Ok(())
    }

    /// Leaves in the run's folder what a successor needs, when that has changed.
    fn keep(&mut self, shell: &Shell) {
        let (Some(pose), Some(zero_ns)) = (self.inputs.anchor(), self.timeline.zero_ns()) else {
            return;
        };
        let anchor = Anchor {
            stack_from_odom: [pose.x_m, pose.y_m, pose.yaw_rad],
            zero_ns,
        };
        if self.kept == Some(anchor) {
            return;
        }
        if let Err(error) = anchor::write(shell.peer().domain().folder(), &anchor) {
            tracing::warn!(%error, "a successor in this seat cannot go on from here");
        }
        self.kept = Some(anchor);
    }

    /// Says in the heartbeat what is wrong; true when the robot has to stand for it. [ns]
    fn say_trouble(&mut self, shell: &mut Shell, now_ns: u64) -> bool {
        let [scan, odometry] = self.sensors.came_ns();
        let is_silent = |came_ns: Option<u64>| {
            came_ns.is_none_or(|came_ns| now_ns.saturating_sub(came_ns) > SILENT_NS)
        };
        shell.reason(REASON_SCAN, is_silent(scan));
        shell.reason(REASON_ODOMETRY, is_silent(odometry));
        let bits = [REASON_TRANSFORM, REASON_CLOCK, REASON_PUBLISHERS];
        let mut is_troubled = false;
        for (trouble, bit) in Trouble::ALL.into_iter().zip(bits) {
            let holds = self.inputs.holds(trouble, now_ns).is_some();
            shell.reason(bit, holds);
            is_troubled |= holds;
        }
        let ahead_s = self.inputs.stamps().ahead_ns().map(|it| it / 1_000_000_000);
        if ahead_s != self.said_ahead_s {
            self.said_ahead_s = ahead_s;
            let same_clock = self.inputs.stamps().is_same_clock();
            tracing::info!(same_clock, ahead_s, "the clock of the robot");
        }
        is_troubled || is_silent(scan) || is_silent(odometry)
    }
}
