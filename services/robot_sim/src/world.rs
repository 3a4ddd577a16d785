//! The world of a configuration, with its files read.

use zeronav_robot_sim::SimConfig;
use zeronav_shell::StartError;
use zeronav_world::World;
use zeronav_world_files::WorldError;

/// The world; what is odd about its map file is logged.
pub(crate) fn world(config: &SimConfig) -> Result<World, StartError> {
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
