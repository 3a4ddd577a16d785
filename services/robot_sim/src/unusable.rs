//! Which field of the configuration an error is about.

use zeronav_robot_sim::SimError;
use zeronav_shell::StartError;

pub(crate) fn unusable(error: SimError) -> StartError {
    match error {
        SimError::Robot(error) => {
            let error = error.within("robot");
            StartError::config(error.field, error.why)
        }
        SimError::Description(refusal) => StartError::config("robot", refusal),
        SimError::Start(refusal) => StartError::config("start", refusal),
        SimError::StartBlocked(what) => {
            StartError::config("start", format!("the robot touches {what} there"))
        }
        SimError::ScanRate { .. } => StartError::config("robot.lidar.rate_hz", error),
        SimError::Tick(_) => StartError::Usage(error.to_string()),
    }
}
