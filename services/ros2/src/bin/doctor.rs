//! Looks at a robot of ROS 2, for `zeronav doctor --ros2`.

use std::process::ExitCode;

fn main() -> ExitCode {
    zeronav_ros2::doctor::run()
}
