//! The program in the robot's seat: the robot's sensors in, velocity commands out. Of Humble.

use std::process::ExitCode;
use zeronav_ros2::seat::RosRobot;

fn main() -> ExitCode {
    zeronav_shell::run::<RosRobot>()
}
