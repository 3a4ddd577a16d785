//! The topics of ROS 2 that a recording has.

use std::collections::BTreeMap;

/// How a topic is offered, as in Nav2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Qos {
    /// Reliable, volatile, depth 10.
    Reliable,
    /// Best effort, volatile, depth 5.
    Sensor,
    /// Reliable, transient local, depth 1: later subscribers get the last message, too.
    Latched,
}

macro_rules! ros_topics {
    ($($(#[$doc:meta])* $variant:ident = $name:literal $package:ident / $kind:ident $qos:ident),* $(,)?) => {
        /// A topic of ROS 2.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum RosTopic { $($(#[$doc])* $variant),* }

        impl RosTopic {
            /// Every topic.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// Its name.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }

            /// Name of the type of its messages.
            #[must_use]
            pub fn type_name(self) -> &'static str {
                match self {
                    $(Self::$variant => concat!(stringify!($package), "/msg/", stringify!($kind))),*
                }
            }

            /// Definition of that type, with those of its parts.
            #[must_use]
            pub fn definition(self) -> &'static str {
                match self {
                    $(Self::$variant => include_str!(
                        concat!("../msgs/", stringify!($kind), ".msg")
                    )),*
                }
            }

            /// How it is offered.
            #[must_use]
            pub fn qos(self) -> Qos {
                match self { $(Self::$variant => Qos::$qos),* }
            }
        }
    };
}

ros_topics! {
    /// The lidar.
    Scan = "/scan" sensor_msgs/LaserScan Sensor,
    /// The hits of a scan as points.
    ScanPoints = "/scan_points" sensor_msgs/PointCloud2 Sensor,
    /// The wheels' odometry.
    Odom = "/odom" nav_msgs/Odometry Reliable,
    /// `map` to `odom`, and `odom` to `base_link`.
    Tf = "/tf" tf2_msgs/TFMessage Reliable,
    /// `base_link` to `laser`.
    TfStatic = "/tf_static" tf2_msgs/TFMessage Latched,
    /// The whole map.
    Map = "/map" nav_msgs/OccupancyGrid Latched,
    /// What changed of it.
    MapUpdates = "/map_updates" map_msgs/OccupancyGridUpdate Reliable,
    /// The global planner's path.
    Plan = "/plan" nav_msgs/Path Reliable,
    /// Its waypoints as points.
    PlanPoints = "/plan_points" sensor_msgs/PointCloud2 Reliable,
    /// The local planner's choice, of runs in which its rollouts are recorded.
    LocalPlan = "/local_plan" nav_msgs/Path Reliable,
    /// What the wheels are told.
    CmdVel = "/cmd_vel" geometry_msgs/TwistStamped Reliable,
    /// The current goal.
    GoalPose = "/goal_pose" geometry_msgs/PoseStamped Reliable,
    /// How the services are.
    Diagnostics = "/diagnostics" diagnostic_msgs/DiagnosticArray Reliable,
    /// What services, companions and launch log.
    Rosout = "/rosout" rcl_interfaces/Log Reliable,
    /// Why the robot does what it does: what decided in each stage, when that changes.
    Why = "/why" rcl_interfaces/Log Reliable,
    /// Tracked dynamic obstacles.
    TrackedObstacles = "/tracked_obstacles" visualization_msgs/MarkerArray Reliable,
}

/// Names of frames, as in REP-105.
pub mod frame {
    /// The world.
    pub const MAP: &str = "map";
    /// Where the wheels began to count.
    pub const ODOM: &str = "odom";
    /// The robot: `base` of the contract.
    pub const BASE: &str = "base_link";
    /// The lidar.
    pub const LASER: &str = "laser";
}

impl Qos {
    /// As rosbag2 writes it since version 9 of its metadata: YAML, one profile.
    #[must_use]
    pub fn yaml(self) -> String {
        let (depth, reliability, durability) = match self {
            Self::Reliable => (10, "reliable", "volatile"),
            Self::Sensor => (5, "best_effort", "volatile"),
            Self::Latched => (1, "reliable", "transient_local"),
        };
        // The longest time of ROS stands for none.
        let never = "\n    sec: 9223372036\n    nsec: 854775807";
        format!(
            "- history: keep_last\n  depth: {depth}\n  reliability: {reliability}\n  \
             durability: {durability}\n  deadline:{never}\n  lifespan:{never}\n  \
             liveliness: automatic\n  liveliness_lease_duration:{never}\n  \
             avoid_ros_namespace_conventions: false\n"
        )
    }
}

impl RosTopic {
    /// What its channel says besides name and type.
    #[must_use]
    pub fn metadata(self) -> BTreeMap<String, String> {
        [("offered_qos_profiles".to_owned(), self.qos().yaml())].into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_definition_is_complete() {
        for topic in RosTopic::ALL {
            let text = topic.definition();
            let parts: Vec<&str> = text.split(&"=".repeat(80)).collect();
            let has = |name: &str| {
                parts[1..]
                    .iter()
                    .any(|part| part.trim_start().starts_with(&format!("MSG: {name}\n")))
            };
            for line in parts.iter().flat_map(|part| part.lines()) {
                let Some((kind, _)) = line.split_once(' ') else {
                    continue;
                };
                let kind = kind.split('[').next().unwrap_or(kind);
                if kind.contains('/') {
                    assert!(has(kind), "{}: {kind} is not defined", topic.name());
                }
            }
        }
    }
}
