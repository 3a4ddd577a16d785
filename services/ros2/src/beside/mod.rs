//! The companion: the stack in the tools of ROS 2, and their goals in the stack.
//!
//! `outputs` publishes what the stack stands for, `navigator` takes goals to launch, `actions` are Nav2's
//! actions in the `layouts` of the distributions, `states` what scripts wait for.

mod actions;
mod config;
mod launch;
mod layouts;
mod navigator;
mod outputs;
mod states;
mod taps;

pub use config::{BesideConfig, Distro};

use crate::config::whole_name;
use crate::inbox::subscribe;
use crate::network::Network;
use launch::Tolerance;
use layouts::Kind;
use navigator::{Navigator, in_map};
use outputs::{Outputs, profile};
use ros2_client::qos::{History, QosProfile};
use ros2_client::{MessageTypeName, Name, Node, Publisher, Subscription};
use serde::Serialize;
use serde::de::DeserializeOwned;
use states::States;
use std::time::{Duration, Instant};
use zeronav_params::{Parameter, describe};
use zeronav_ros_messages::Qos;
use zeronav_ros_messages::messages::{OccupancyGrid, PoseStamped, PoseWithCovarianceStamped};
use zeronav_shell::{Companion, Domain, Guest, StartError};

/// Name of the node.
const NODE: &str = "zeronav";

/// Time between two poses on `/amcl_pose`, and between two costmaps.
const POSE_PAUSE: Duration = Duration::from_millis(500);

/// Messages of a topic that are taken in at a look: of a flood, the newest of these counts.
const TURN: usize = 64;

/// See the module's description.
pub struct Beside {
    outputs: Outputs,
    navigator: Navigator,
    states: Option<States>,
    goals: Subscription<PoseStamped>,
    estimates: Subscription<PoseWithCovarianceStamped>,
    located: Publisher<PoseWithCovarianceStamped>,
    costs: Publisher<OccupancyGrid>,
    located_at: Option<Instant>,
    rejected: u64,
    // Behind what belongs to it.
    _node: Node,
}

impl Companion for Beside {
    type Config = BesideConfig;

    fn parameters() -> Vec<Parameter> {
        describe::<BesideConfig>()
    }

    fn check(config: &BesideConfig) -> Result<(), StartError> {
        Network::new(&config.network).map_err(StartError::Usage)?;
        zeronav_params::check(config)
            .map_err(|it| StartError::config(it.path.clone(), it.to_string()))?;
        let space = &config.namespace;
        let map = whole_name(&format!("{space}/map"));
        map.map(|_| ())
            .map_err(|why| StartError::config("namespace", why))
    }

    fn open(guest: &Guest, config: BesideConfig) -> Result<Self, StartError> {
        let failed = |why: String| StartError::system("ROS 2", why);
        let network = Network::new(&config.network).map_err(StartError::Usage)?;
        let (_, mut node) = network.node(NODE).map_err(failed)?;
        let space = config.namespace.as_str();
        let mut actions = Vec::new();
        for kind in [Kind::ToPose, Kind::ThroughPoses, Kind::Waypoints] {
            actions.push(actions::open(&mut node, space, config.distro, kind).map_err(failed)?);
        }
        let states = (config.nav2_states).then(|| States::open(&mut node, space));
        let tolerance = Tolerance {
            distance_m: config.tolerance_m,
            yaw_rad: config.yaw_tolerance_rad,
        };
        let reliable = QosProfile::subscription_default().history(History::KeepLast { depth: 10 });
        let goal = ["geometry_msgs", "PoseStamped"];
        let estimate = ["geometry_msgs", "PoseWithCovarianceStamped"];
        let name = format!("{space}/goal_pose");
        let goals = subscribe(&mut node, &name, goal, &reliable).map_err(failed)?;
        let name = format!("{space}/initialpose");
        let estimates = subscribe(&mut node, &name, estimate, &reliable).map_err(failed)?;
        let name = format!("{space}/amcl_pose");
        let located = latched(&mut node, &name, estimate).map_err(failed)?;
        let name = format!("{space}/local_costmap/costmap");
        let costs = latched(&mut node, &name, ["nav_msgs", "OccupancyGrid"]).map_err(failed)?;
        let outputs = Outputs::open(guest, &mut node, &config)?;
        tracing::info!(
            domain_id = network.domain_id,
            range = ?network.range,
            distro = ?config.distro,
            "in ROS 2"
        );
        Ok(Self {
            outputs,
            navigator: Navigator::new(actions, tolerance),
            states: states.transpose().map_err(failed)?,
            goals,
            estimates,
            located,
            costs,
            located_at: None,
            rejected: 0,
            _node: node,
        })
    }

    fn look(&mut self, guest: &Guest) -> Result<(), StartError> {
        self.outputs.look(guest)?;
        let domain = guest.peer().domain();
        if let Some(goal) = newest(&self.goals) {
            self.navigator.go(domain, &goal);
        }
        if let Some(estimate) = newest(&self.estimates) {
            self.put(domain, &estimate);
        }
        self.navigator.look(domain, self.outputs.pose().as_ref());
        if let Some(states) = &mut self.states {
            states.look(|| launch::is_ready(domain).unwrap_or(false));
        }
        self.publish_pose();
        Ok(())
    }
}

impl Beside {
    /// The robot is where somebody says.
    fn put(&mut self, domain: &Domain, estimate: &PoseWithCovarianceStamped) {
        let stamped = PoseStamped {
            header: estimate.header.clone(),
            pose: estimate.pose.pose,
        };
        let done = in_map(&stamped)
            .map_err(str::to_owned)
            .and_then(|pose| launch::put(domain, pose));
        match done {
            Ok(()) => self.located_at = None,
            Err(why) => {
                self.rejected += 1;
                if self.rejected.is_power_of_two() {
                    tracing::warn!(n = self.rejected, "rejected: /initialpose: {why}");
                }
            }
        }
    }

    fn publish_pose(&mut self) {
        if self.located_at.is_some_and(|at| at.elapsed() < POSE_PAUSE) {
            return;
        }
        if let Some((header, pose)) = self.outputs.located() {
            self.located_at = Some(Instant::now());
            let _ = (self.located).publish(PoseWithCovarianceStamped { header, pose });
            if let Some(costs) = self.outputs.costs() {
                let _ = self.costs.publish(costs);
            }
        }
    }
}

/// The newest of what has come.
fn newest<M: DeserializeOwned + 'static>(from: &Subscription<M>) -> Option<M> {
    let mut newest = None;
    for _ in 0..TURN {
        match from.take() {
            Ok(Some((message, _))) => newest = Some(message),
            Ok(None) => break,
            Err(_) => {}
        }
    }
    newest
}

/// Publishes what later subscribers get, too.
fn latched<M: Serialize>(
    node: &mut Node,
    name: &str,
    [package, kind]: [&str; 2],
) -> Result<Publisher<M>, String> {
    let failed = |why: &dyn core::fmt::Debug| format!("publishing {name}: {why:?}");
    let name = Name::parse(name).map_err(|why| failed(&why))?;
    let kind = MessageTypeName::new(package, kind);
    let topic = node.create_topic(&name, kind, &profile(Qos::Latched));
    let topic = topic.map_err(|why| failed(&why))?;
    node.create_publisher(&topic, None)
        .map_err(|why| failed(&why))
}
