//! What a scenario tells the companion.

use crate::network::NetworkConfig;
use zeronav_params::{choices, parameters};

choices! {
    /// A distribution of ROS 2, as far as the layouts of Nav2's actions differ.
    pub enum Distro {
        /// Humble Hawksbill: results are empty.
        Humble = "humble",
        /// Jazzy Jalisco: results have an error code and a message.
        #[default]
        Jazzy = "jazzy",
        /// Kilted Kaiju: several goals are a `nav_msgs/Goals`, and each has a status.
        Kilted = "kilted",
        /// Lyrical Luth: feedback has tracking errors.
        Lyrical = "lyrical",
    }
}

parameters! {
    /// The companion that shows the stack to tools of ROS 2 and takes their goals.
    pub struct BesideConfig {
        /// Distribution of those who send goals; it decides how Nav2's actions are laid out.
        distro: Distro = Distro::Jazzy;
        /// Name space of its topics, actions and services, such as `/robot_1`; empty for none.
        namespace: String = String::new();
        /// How close counts, of goals that come from ROS 2.
        tolerance_m: f64 = 0.25, [0.01, 10.0] "m";
        /// How close the yaw must be, of such goals.
        yaw_tolerance_rad: f64 = 0.25, [0.01, 3.2] "rad";
        /// Publish what the robot measures and is told, too: of a simulated robot.
        robot_topics: bool = false;
        /// Answer as the nodes of Nav2 do for which scripts wait: `bt_navigator`, `amcl`, `lifecycle_manager`.
        nav2_states: bool = true;
        /// Where they meet.
        network: NetworkConfig;
    }
}
