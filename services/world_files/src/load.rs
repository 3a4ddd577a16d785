//! The world of a scenario's words: its files are read, its random map is drawn.

use crate::barn::BarnWorld;
use crate::dynabarn::DynabarnWorld;
use crate::map_file::{self, MapWarning};
use crate::map_file_error::MapFileError;
use crate::movingai_map;
use crate::pedestrians::{Playback, Scene};
use crate::table::DataError;
use zeronav_msgs::grid::RESOLUTION_M;
use zeronav_msgs::truth::TRUTH_OBSTACLES_MAX;
use zeronav_world::error::{SpecError, number};
use zeronav_world::generate::{GenerateError, generate};
use zeronav_world::spec::PERSON_RADIUS_M;
use zeronav_world::world::TIME_S_MAX;
use zeronav_world::{StaticMap, World, WorldSpec};

/// Why there is no such world.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// Its map file cannot be read.
    #[error("map: {0}")]
    Map(#[from] MapFileError),
    /// The file of a data set, named by the word `field`, cannot be used.
    #[error("{field}: {error}")]
    Data {
        /// `map`, `barn`, `dynabarn.file` or `pedestrians.file`.
        field: &'static str,
        /// What is wrong.
        error: DataError,
    },
    /// A value cannot be.
    #[error(transparent)]
    Spec(#[from] SpecError),
}

/// The world of `spec` and what is odd about its map file. A relative path of the map file counts
/// from the working directory.
///
/// # Errors
/// See [`WorldError`].
pub fn load(spec: &WorldSpec) -> Result<(World, Vec<MapWarning>), WorldError> {
    let (spec, generated) = resolved(spec)?;
    let (map, warnings) = match (&spec.map, generated) {
        (Some(file), _) if movingai_map::is_one(file) => {
            let loaded = movingai_map::load(file, spec.resolution_m);
            let field = "map";
            let map = loaded.map_err(|error| WorldError::Data { field, error })?;
            (Some(map), Vec::new())
        }
        (Some(file), _) => {
            let loaded = map_file::load(file)?;
            (Some(loaded.map), loaded.warnings)
        }
        (None, generated) => (generated, Vec::new()),
    };
    Ok((World::new(&spec, map)?, warnings))
}

/// The same world without words that stand for files of data sets and for random maps, and the
/// random map. Reads the files.
fn resolved(spec: &WorldSpec) -> Result<(WorldSpec, Option<StaticMap>), WorldError> {
    let sources = [
        (spec.map.is_some(), "map"),
        (spec.barn.is_some(), "barn"),
        (spec.dynabarn.is_some(), "dynabarn"),
        (spec.generated.is_some(), "generated"),
    ];
    let mut given = sources.iter().filter(|(given, _)| *given);
    if let (Some((_, first)), Some((_, second))) = (given.next(), given.next()) {
        let why = format!("a world comes from one place, and there is {first} too");
        return Err(SpecError::new(*second, why).into());
    }
    let [least_m, most_m] = RESOLUTION_M;
    number(spec.resolution_m, least_m, most_m, "resolution_m")?;
    let mut own = spec.clone();
    // Things of the data set come first: their places in the lists are those of its file.
    let mut add = |from: WorldSpec| {
        own.area_m = own.area_m.or(from.area_m);
        own.shapes.splice(0..0, from.shapes);
        own.obstacles.splice(0..0, from.obstacles);
    };
    let failed = |field| move |error| WorldError::Data { field, error };
    if let Some(file) = &spec.barn {
        add(BarnWorld::load(file).map_err(failed("barn"))?.spec());
    }
    if let Some(dynabarn) = &spec.dynabarn {
        let field = "dynabarn.phase_s";
        number(dynabarn.phase_s, -TIME_S_MAX, TIME_S_MAX, field)?;
        let world = DynabarnWorld::load(&dynabarn.file).map_err(failed("dynabarn.file"))?;
        add(world.spec(dynabarn.phase_s));
    }
    if let Some(people) = &spec.pedestrians {
        number(people.from_s, -TIME_S_MAX, TIME_S_MAX, "pedestrians.from_s")?;
        if let Some(duration_s) = people.duration_s {
            let field = "pedestrians.duration_s";
            number(duration_s, 0.0, TIME_S_MAX, field)?;
        }
        let [least_m, most_m] = PERSON_RADIUS_M;
        number(people.radius_m, least_m, most_m, "pedestrians.radius_m")?;
        let scene = Scene::load(&people.file).map_err(failed("pedestrians.file"))?;
        let brings_area = spec.map.is_none() && spec.generated.is_none();
        let people = scene.spec(&Playback {
            from_s: people.from_s,
            duration_s: people.duration_s,
            radius_m: people.radius_m,
        });
        if people.obstacles.len() > TRUTH_OBSTACLES_MAX {
            let why = format!(
                "{} people come in that time, at most {TRUTH_OBSTACLES_MAX}: make it shorter",
                people.obstacles.len()
            );
            return Err(SpecError::new("pedestrians.duration_s", why).into());
        }
        add(WorldSpec {
            area_m: people.area_m.filter(|_| brings_area),
            ..people
        });
    }
    (own.barn, own.dynabarn, own.pedestrians) = (None, None, None);
    let generated = match &spec.generated {
        Some(recipe) => {
            let generated = generate(recipe).map_err(|error| match error {
                GenerateError::Spec(error) => error.within("generated"),
                GenerateError::NoWay { .. } => SpecError::new("generated", error.to_string()),
            });
            Some(generated?.map)
        }
        None => None,
    };
    Ok((own, generated))
}
