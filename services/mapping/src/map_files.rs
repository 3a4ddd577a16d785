//! The files of a map: the static one that is read at the start, and where the map is saved.

use std::path::Path;
use zeronav_mapping::{Mapper, Mapping, MappingConfig, MappingError};
use zeronav_msgs::grid::GridGeometry;
use zeronav_msgs::topics::RobotDescription;
use zeronav_shell::{StartError, View};
use zeronav_world::StaticMap;
use zeronav_world_files::map_file::{self, LoadedMap};

/// Accepts a configuration whose static map can be read and whose folder for saving is there.
pub(crate) fn check(config: &MappingConfig) -> Result<(), StartError> {
    let (_, geometry) = load(config)?;
    config.check(geometry.resolution_m)?;
    match &config.save_to {
        Some(folder) if !folder.is_dir() => {
            let why = format!("there is no folder {}", folder.display());
            Err(StartError::config("save_to", why))
        }
        _ => Ok(()),
    }
}

/// The static map, if there is one, and the grid.
pub(crate) fn load(
    config: &MappingConfig,
) -> Result<(Option<LoadedMap>, GridGeometry), StartError> {
    let Some(file) = &config.static_map else {
        return Ok((None, config.geometry().map_err(unusable)?));
    };
    let loaded = map_file::load(file).map_err(|error| StartError::config("static_map", error))?;
    let geometry = loaded.map.geometry;
    geometry
        .check()
        .map_err(|refusal| StartError::config("static_map", refusal))?;
    Ok((Some(loaded), geometry))
}

/// Logs what is odd about the static map.
pub(crate) fn warn(loaded: Option<&LoadedMap>) {
    for warning in loaded.iter().flat_map(|loaded| &loaded.warnings) {
        tracing::warn!("{warning}");
    }
}

/// The map of a robot, before its first scan.
pub(crate) fn begin(
    config: &MappingConfig,
    static_map: Option<&StaticMap>,
    robot: &View<'_, RobotDescription>,
) -> Result<Mapping, StartError> {
    let mapping = Mapping::new(config, static_map, robot.meta, robot.items).map_err(unusable)?;
    let geometry = mapping.mapper().geometry();
    let (width, height) = (geometry.width, geometry.height);
    tracing::info!(width, height, geometry.resolution_m, "the map begins");
    Ok(mapping)
}

/// The field of the configuration that is wrong.
fn unusable(error: MappingError) -> StartError {
    match error {
        MappingError::NoArea => StartError::config("area_m", "required without static_map"),
        MappingError::Geometry(_) => StartError::config("area_m", error),
        MappingError::StaticMap { .. } => StartError::config("static_map", error),
        MappingError::Parameter(error) => error.into(),
    }
}

/// Saves a map as `map.yaml` and `map.pgm`; a failure is logged.
pub(crate) fn save(mapper: &Mapper, folder: &Path) {
    match map_file::save(&mapper.as_static_map(), folder, "map") {
        Ok(file) => tracing::info!(file = %file.display(), "map saved"),
        Err(error) => tracing::error!("the map could not be saved: {error}"),
    }
}
