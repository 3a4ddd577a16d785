//! The simulator of a configuration, with the files of its world read.

use zeronav_robot_sim::{SimConfig, SimError, Simulator};
use zeronav_shell::StartError;
use zeronav_world::World;
use zeronav_world_files::WorldError;

/// The simulator; its ticks are `tick_ns` long.
pub(crate) fn simulator(
    config: &SimConfig,
    seed: u64,
    tick_ns: u64,
) -> Result<Simulator, StartError> {
    Simulator::new(config, world(config)?, seed, tick_ns).map_err(unusable)
}

/// The world; what is odd about its map file is logged.
fn world(config: &SimConfig) -> Result<World, StartError> {
    let loaded = zeronav_world_files::load(&config.world);
    let (world, warnings) = loaded.map_err(|error| match error {
        WorldError::Spec(error) => {
            let error = error.within("world");
            StartError::config(error.field, error.why)
        }
        WorldError::Map(error) => StartError::config("world.map", error),
        WorldError::Data { field, error } => StartError::config(format!("world.{field}"), error),
    })?;
    for warning in warnings {
        tracing::warn!("{warning}");
    }
    Ok(world)
}

/// The field of the configuration that is wrong.
fn unusable(error: SimError) -> StartError {
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
