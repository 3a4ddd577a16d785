//! Which field of the configuration an error is about.

use zeronav_robot_sim::SimError;
use zeronav_shell::StartError;
use zeronav_world::{SpecError, WorldError};

pub(crate) fn unusable(error: SimError) -> StartError {
    let of = |error: SpecError| StartError::config(error.field, error.why);
    match error {
        SimError::World(WorldError::Spec(error)) => of(error.within("world")),
        SimError::World(WorldError::Map(error)) => StartError::config("world.map", error),
        SimError::World(WorldError::Data { field, error }) => {
            StartError::config(format!("world.{field}"), error)
        }
        SimError::Robot(error) => of(error.within("robot")),
        SimError::Description(refusal) => StartError::config("robot", refusal),
        SimError::Start(refusal) => StartError::config("start", refusal),
        SimError::StartBlocked(what) => {
            StartError::config("start", format!("the robot touches {what} there"))
        }
        SimError::ScanRate { .. } => StartError::config("robot.lidar.rate_hz", error),
        SimError::Tick(_) => StartError::Usage(error.to_string()),
    }
}
