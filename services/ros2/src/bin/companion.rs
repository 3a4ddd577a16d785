//! The companion beside the stack.

use std::process::ExitCode;
use zeronav_ros2::beside::Beside;
use zeronav_shell::Companion;

fn main() -> ExitCode {
    Beside::run()
}
