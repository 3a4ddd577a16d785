//! What a user may set about where the robot begins, and when it counts as lost.

use zeronav_params::{choices, parameters};

choices! {
    /// Whether the pose is known at the start.
    pub enum StartPose {
        /// `map_from_odom` is as configured.
        #[default]
        Given = "given",
        /// The robot may be anywhere on the static map: it stands until it has found itself by its lidar.
        Unknown = "unknown",
    }
}

parameters! {
    /// Where the robot begins, and when it counts as lost.
    #[derive(Copy)]
    pub struct LocalisationConfig {
        /// Whether the pose is known at the start; `unknown` needs a static map whose window is fixed and a pose that
        /// is corrected.
        start: StartPose = StartPose::Given;
        /// `map_from_odom` at the start as `[x, y, yaw]`: where odometry begins. Other than 0 it is doubted, on a fixed
        /// static map, until the map explains what is seen.
        map_from_odom: [f64; 3] = [0.0; 3], [-1.0e4, 1.0e4] "m, m, rad";
        /// Share of the beams that a fixed static map must explain: below it, and contradicted by walls, for 2 s the robot is
        /// lost, stands, and is looked for on the whole map; at or above it a pose that was told is confirmed. 0 = the robot
        /// is never lost, and its pose never doubted.
        lost_below: f64 = 0.6, [0.0, 0.9];
    }
}
