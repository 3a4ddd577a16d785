//! Velocity commands to the robot.

use crate::config::SeatConfig;
use ros2_client::qos::{History, QosProfile};
use ros2_client::{MessageTypeName, Name, Node, Publisher};
use rustix::time::{ClockId, clock_gettime};
use std::time::Duration;
use zeronav_msgs::command::Validity;
use zeronav_msgs::header::Parents;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::time::nanoseconds;
use zeronav_msgs::topics::RobotCommand;
use zeronav_ros_messages::messages::{Header, Time, Twist, TwistStamped, Vector3};
use zeronav_shell::clock::both_ns;
use zeronav_shell::{Due, Input, Latest, Peer, Shell, StartError};

/// Time between two stops while there is a reason for them. [ns]
const REPEAT_NS: u64 = 50_000_000;

/// For how long a last stop may travel before the process ends.
const LAST_WORDS: Duration = Duration::from_millis(50);

enum Wheels {
    Plain(Publisher<Twist>),
    Stamped(Publisher<TwistStamped>),
}

/// Reads `robot/velocity_command` and publishes it.
pub(super) struct Commands {
    command: Latest<RobotCommand>,
    wheels: Wheels,
    base_frame: String,
    timeout_ns: u64,
    /// When the newest command came, and when the newest stop was sent. [ns]
    came_ns: Option<u64>,
    stopped_ns: u64,
    /// A stop takes the place of commands.
    holds: bool,
}

impl Commands {
    pub(super) fn open(
        peer: &Peer,
        node: &mut Node,
        config: &SeatConfig,
    ) -> Result<Self, StartError> {
        let ros = &config.ros;
        let failed = |why: &dyn core::fmt::Debug| {
            StartError::system(
                format!("publishing {}", ros.cmd_vel_topic),
                format!("{why:?}"),
            )
        };
        let name = Name::parse(&ros.cmd_vel_topic).map_err(|why| failed(&why))?;
        let kind = if ros.cmd_vel_stamped {
            "TwistStamped"
        } else {
            "Twist"
        };
        let qos = QosProfile::publisher_default().history(History::KeepLast { depth: 1 });
        let topic = node.create_topic(&name, MessageTypeName::new("geometry_msgs", kind), &qos);
        let topic = topic.map_err(|why| failed(&why))?;
        let wheels = if ros.cmd_vel_stamped {
            Wheels::Stamped(
                node.create_publisher(&topic, None)
                    .map_err(|why| failed(&why))?,
            )
        } else {
            Wheels::Plain(
                node.create_publisher(&topic, None)
                    .map_err(|why| failed(&why))?,
            )
        };
        Ok(Self {
            command: peer.latest()?,
            wheels,
            base_frame: ros.base_frame.clone(),
            timeout_ns: nanoseconds(config.robot.command_timeout_s),
            came_ns: None,
            stopped_ns: 0,
            holds: true,
        })
    }

    /// What it reads.
    pub(super) fn input(&self) -> &dyn Input {
        &self.command
    }

    /// Passes the newest command on.
    pub(super) fn poll(&mut self, shell: &mut Shell) {
        if !self.command.poll(shell.roster()) {
            return;
        }
        let Some(command) = self.command.get() else {
            return;
        };
        self.came_ns = Some(shell.woken_ns());
        let is_one = command.meta.validity() != Some(Validity::NoRequest);
        let (v_mps, w_radps) = if is_one && !self.holds {
            (command.meta.v_mps, command.meta.w_radps)
        } else {
            (0.0, 0.0)
        };
        let header = command.header;
        let parents = Parents {
            request: header.id,
            ..Parents::default()
        };
        let due = Due {
            tick: header.tick,
            kind: SpanKind::Applied,
        };
        let mut draft = shell.begin(due, header.run_ns, header.capture_ns, parents);
        self.publish(v_mps, w_radps);
        // The draft's start is the moment at which the command was on its way.
        (draft.started_ns, draft.raw_ns) = both_ns();
        shell.finish(&draft, None, 0);
    }

    /// Stops the robot while there is a reason, or while commands are late. [ns]
    pub(super) fn watch(&mut self, holds: bool, now_ns: u64) {
        self.holds = holds;
        let is_late = |came_ns| now_ns.saturating_sub(came_ns) > self.timeout_ns;
        let must_stop = holds || self.came_ns.is_none_or(is_late);
        if must_stop && now_ns.saturating_sub(self.stopped_ns) >= REPEAT_NS {
            self.stopped_ns = now_ns;
            self.publish(0.0, 0.0);
        }
    }

    fn publish(&self, v_mps: f64, w_radps: f64) {
        let along = |x, z| Vector3 { x, y: 0.0, z };
        let twist = Twist {
            linear: along(v_mps, 0.0),
            angular: along(0.0, w_radps),
        };
        let is_sent = match &self.wheels {
            Wheels::Plain(publisher) => publisher.publish(twist).is_ok(),
            Wheels::Stamped(publisher) => {
                let header = Header {
                    stamp: system_time(),
                    frame_id: self.base_frame.clone().into(),
                };
                publisher.publish(TwistStamped { header, twist }).is_ok()
            }
        };
        if !is_sent {
            tracing::warn!("a velocity command could not be sent");
        }
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        self.publish(0.0, 0.0);
        std::thread::sleep(LAST_WORDS);
    }
}

fn system_time() -> Time {
    let now = clock_gettime(ClockId::Realtime);
    Time {
        sec: i32::try_from(now.tv_sec).unwrap_or(i32::MAX),
        nanosec: u32::try_from(now.tv_nsec).unwrap_or(0),
    }
}
