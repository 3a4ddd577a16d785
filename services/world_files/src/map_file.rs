//! Map files of the ROS `map_server`: a YAML file that names an image.
//!
//! Pixels mean what Nav2's `map_server` makes of them, read the way its costmap reads the result:
//! in `trinary` mode (the default) an occupancy of `occupied_thresh` or more is occupied, of
//! `free_thresh` or less free, between them unknown; in `scale` mode what lies between is known and
//! passable, unless it rounds to 100 percent of the way. In both a pixel that is not opaque is
//! unknown, whatever its colour. In `raw` mode a pixel is an occupancy in percent (the thresholds
//! sort it as in `trinary`, `negate` and opacity do not count), and pixels above 100 are unknown. The
//! first row of the image has the largest y. The origin is the lower left corner of the lower left
//! pixel; a turned map is laid onto an upright grid.

use crate::map_file_error::MapFileError;
use crate::map_image;
use crate::pixels::Pixels;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer};
use std::path::{Path, PathBuf};
use zeronav_files::{Folder, Replace, read};
use zeronav_msgs::grid::SIDE_CELLS_MAX;
use zeronav_msgs::message::COORDINATE_M_MAX;
use zeronav_msgs::{Cell, Pose};
use zeronav_world::static_map::{Occupancy, StaticMap, covering_geometry, upright};

/// Pixel that `map_saver` writes for unknown cells.
const PIXEL_UNKNOWN: u8 = 205;
/// Pixel for occupied cells.
const PIXEL_OCCUPIED: u8 = 0;
/// Pixel for free cells.
const PIXEL_FREE: u8 = 254;

/// Part of the way between the thresholds that `scale` rounds to 100 percent, which a costmap takes for
/// an obstacle.
const SCALE_LETHAL: f64 = 0.995;

/// Largest YAML file. [bytes]
const YAML_BYTES_MAX: u64 = 65_536;

/// A warning about a map file: something that is probably not intended.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MapWarning {
    /// Pixels of value 205, with which map savers mean "unknown", load as free.
    #[error(
        "{}: free_thresh {free_thresh} is above 0.196, so its {n_pixels} pixels of value 205 \
         (unknown) load as free",
        file.display()
    )]
    UnknownLoadsAsFree {
        /// The YAML file.
        file: PathBuf,
        /// Its threshold.
        free_thresh: f64,
        /// How many pixels it concerns.
        n_pixels: usize,
    },
    /// The map is turned by more than a full turn: its yaw was probably meant in degrees.
    #[error(
        "{}: the yaw of origin is in radians, and {yaw_rad} is more than a full turn: if degrees are \
         meant, write {:.6}",
        file.display(),
        yaw_rad.to_radians()
    )]
    YawInDegrees {
        /// The YAML file.
        file: PathBuf,
        /// Its yaw. [rad]
        yaw_rad: f64,
    },
}

/// A map and what is odd about its file.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedMap {
    /// The map.
    pub map: StaticMap,
    /// What the user should hear about.
    pub warnings: Vec<MapWarning>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct MapYaml {
    pub(crate) image: PathBuf,
    pub(crate) resolution: f64,
    pub(crate) origin: [f64; 3],
    #[serde(deserialize_with = "zero_or_one")]
    negate: bool,
    occupied_thresh: f64,
    free_thresh: f64,
    #[serde(default)]
    mode: Mode,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Mode {
    #[default]
    Trinary,
    Scale,
    Raw,
}

fn zero_or_one<'de, D: Deserializer<'de>>(deserializer: D) -> Result<bool, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Either {
        Bool(bool),
        Number(u8),
    }
    match Either::deserialize(deserializer)? {
        Either::Bool(value) => Ok(value),
        Either::Number(0) => Ok(false),
        Either::Number(1) => Ok(true),
        Either::Number(_) => Err(serde::de::Error::custom("negate must be 0 or 1")),
    }
}

/// Reads the map that the YAML file `file` describes. The image's path is relative to it; when
/// the image is absent and `IMAGE.gz` exists, that is unpacked and read.
///
/// # Errors
/// See [`MapFileError`]; each names the file.
pub fn load(file: &Path) -> Result<LoadedMap, MapFileError> {
    let yaml: MapYaml = parse(file, &text_of(file)?)?;
    check(file, &yaml)?;
    let image_file = file.parent().unwrap_or(Path::new("")).join(&yaml.image);
    let pixels = map_image::read(&image_file)?;
    let size = (pixels.width, pixels.height);
    let corner = Pose::new(yaml.origin[0], yaml.origin[1], yaml.origin[2]);
    let geometry = covering_geometry(&corner, yaml.resolution, size)
        .filter(|geometry| geometry.check().is_ok())
        .ok_or_else(|| MapFileError::Field {
            file: file.to_path_buf(),
            field: "origin",
            why: format!("turned, the map has more than {SIDE_CELLS_MAX} cells along a side"),
        })?;
    let cells = cells_of(&yaml, &pixels);
    Ok(LoadedMap {
        map: upright(geometry, &corner, size, cells),
        warnings: warnings(file, &yaml, &pixels),
    })
}

fn warnings(file: &Path, yaml: &MapYaml, pixels: &Pixels) -> Vec<MapWarning> {
    let n_pixels = unknown_that_loads_as_free(yaml, pixels);
    let frees = (n_pixels > 0).then(|| MapWarning::UnknownLoadsAsFree {
        file: file.to_path_buf(),
        free_thresh: yaml.free_thresh,
        n_pixels,
    });
    let yaw_rad = yaml.origin[2];
    let turns = (yaw_rad.abs() > core::f64::consts::TAU).then(|| MapWarning::YawInDegrees {
        file: file.to_path_buf(),
        yaw_rad,
    });
    frees.into_iter().chain(turns).collect()
}

/// Writes `NAME.yaml` and `NAME.pgm` into the existing folder `dir`; [`load`] reads the same map
/// from them. Each file is there whole or not at all, the image before the YAML file that names it.
/// What was there is replaced. Returns the path of the YAML file.
///
/// # Errors
/// [`MapFileError::Write`], naming the file.
pub fn save(map: &StaticMap, dir: &Path, name: &str) -> Result<PathBuf, MapFileError> {
    let folder = Folder::open(dir).map_err(|source| MapFileError::Write {
        file: dir.to_path_buf(),
        source,
    })?;
    save_in(map, &folder, name, Replace::Yes)
}

/// As [`save`], in a folder that is open; when either file is there and shall stay, none is written.
///
/// # Errors
/// [`MapFileError::Write`], naming the file.
pub fn save_in(
    map: &StaticMap,
    folder: &Folder,
    name: &str,
    replace: Replace,
) -> Result<PathBuf, MapFileError> {
    let geometry = &map.geometry;
    let mut bytes = format!("P5\n{} {}\n255\n", geometry.width, geometry.height).into_bytes();
    let (width, height) = geometry.size();
    for y in (0..height).rev() {
        for x in 0..width {
            bytes.push(match map.get(Cell::new(x, y)) {
                Some(Occupancy::Free) => PIXEL_FREE,
                Some(Occupancy::Occupied) => PIXEL_OCCUPIED,
                Some(Occupancy::Unknown) | None => PIXEL_UNKNOWN,
            });
        }
    }
    let image = format!("{name}.pgm");
    let yaml = format!(
        "image: {}\nmode: trinary\nresolution: {:?}\norigin: [{:?}, {:?}, 0.0]\n\
         negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
        scalar(&image),
        geometry.resolution_m,
        geometry.origin_x_m,
        geometry.origin_y_m
    );
    let files = [(image, bytes), (format!("{name}.yaml"), yaml.into_bytes())];
    let failed = |name: &str| {
        let file = folder.path().join(name);
        |source| MapFileError::Write { file, source }
    };
    for (name, _) in &files {
        folder.check_free(name, replace).map_err(failed(name))?;
    }
    for (name, bytes) in &files {
        folder.write(name, bytes, replace).map_err(failed(name))?;
    }
    Ok(folder.path().join(format!("{name}.yaml")))
}

/// A file name as YAML reads it back.
fn scalar(name: &str) -> String {
    let plain = |character: char| character.is_ascii_alphanumeric() || "._-/".contains(character);
    if name.chars().all(plain) && name.starts_with(|first: char| first.is_ascii_alphabetic()) {
        name.to_owned()
    } else {
        format!("'{}'", name.replace('\'', "''"))
    }
}

pub(crate) fn text_of(file: &Path) -> Result<String, MapFileError> {
    read::text(file, YAML_BYTES_MAX).map_err(|source| MapFileError::Read {
        file: file.to_path_buf(),
        source,
    })
}

/// Reads the keys of `T` from a YAML text; other keys are left.
pub(crate) fn parse<T: DeserializeOwned>(file: &Path, text: &str) -> Result<T, MapFileError> {
    let options = serde_saphyr::options! { with_snippet: false };
    serde_saphyr::from_str_with_options(text, options).map_err(|error| MapFileError::Yaml {
        file: file.to_path_buf(),
        why: error.to_string().replace('\n', " "),
    })
}

/// Accepts numbers that a map can have.
pub(crate) fn check(file: &Path, yaml: &MapYaml) -> Result<(), MapFileError> {
    let wrong = |field: &'static str, why: String| {
        Err(MapFileError::Field {
            file: file.to_path_buf(),
            field,
            why,
        })
    };
    if !(1.0e-3..=10.0).contains(&yaml.resolution) {
        let why = format!("must be 0.001 to 10 m per pixel, not {}", yaml.resolution);
        return wrong("resolution", why);
    }
    let in_range = |value: f64| value.abs() <= COORDINATE_M_MAX;
    if !yaml.origin.iter().copied().all(in_range) {
        let why = format!(
            "must be [x, y, yaw] in metres and radians, not {:?}",
            yaml.origin
        );
        return wrong("origin", why);
    }
    for (field, value) in [
        ("occupied_thresh", yaml.occupied_thresh),
        ("free_thresh", yaml.free_thresh),
    ] {
        if !(0.0..=1.0).contains(&value) {
            return wrong(field, format!("must be 0 to 1, not {value}"));
        }
    }
    if yaml.free_thresh > yaml.occupied_thresh {
        let why = format!(
            "{} is above occupied_thresh {}",
            yaml.free_thresh, yaml.occupied_thresh
        );
        return wrong("free_thresh", why);
    }
    Ok(())
}

/// Cells row-major from the lower left.
fn cells_of(yaml: &MapYaml, pixels: &Pixels) -> Vec<Occupancy> {
    let table: [Occupancy; 256] = core::array::from_fn(|pixel| {
        let pixel = u8::try_from(pixel).unwrap_or(u8::MAX);
        occupancy_of(yaml, pixel)
    });
    let width = pixels.width as usize;
    let mut cells = Vec::with_capacity(pixels.grey.len());
    for row in (0..pixels.height as usize).rev() {
        for index in row * width..(row + 1) * width {
            let transparent = yaml.mode != Mode::Raw && pixels.alpha_at(index) < u8::MAX;
            cells.push(if transparent {
                Occupancy::Unknown
            } else {
                table[usize::from(pixels.grey[index])]
            });
        }
    }
    cells
}

impl MapYaml {
    pub(crate) fn is_raw(&self) -> bool {
        self.mode == Mode::Raw
    }
}

/// How occupied a pixel is, 0 to 1, before the thresholds sort it; `None` = unknown.
fn ratio_of(yaml: &MapYaml, pixel: u8) -> Option<f64> {
    let shade = if yaml.negate { pixel } else { u8::MAX - pixel };
    match yaml.mode {
        Mode::Trinary | Mode::Scale => Some(f64::from(shade) / 255.0),
        Mode::Raw if pixel > 100 => None,
        Mode::Raw => Some(f64::from(pixel) / 100.0),
    }
}

/// Occupancy of an opaque pixel as a map server publishes it; `None` = unknown. [%]
pub(crate) fn shade_of(yaml: &MapYaml, pixel: u8) -> Option<f64> {
    let ratio = ratio_of(yaml, pixel)?;
    let (least, most) = (yaml.free_thresh, yaml.occupied_thresh);
    match yaml.mode {
        Mode::Raw => Some(f64::from(pixel)),
        _ if ratio <= least => Some(0.0),
        _ if ratio >= most => Some(100.0),
        Mode::Scale => Some(((ratio - least) / (most - least) * 100.0).round()),
        Mode::Trinary => None,
    }
}

fn occupancy_of(yaml: &MapYaml, pixel: u8) -> Occupancy {
    let Some(ratio) = ratio_of(yaml, pixel) else {
        return Occupancy::Unknown;
    };
    let (least, most) = (yaml.free_thresh, yaml.occupied_thresh);
    if ratio <= least {
        // At both, when they are the same, it is free.
        Occupancy::Free
    } else if ratio >= most {
        Occupancy::Occupied
    } else if yaml.mode != Mode::Scale {
        Occupancy::Unknown
    } else if (ratio - least) / (most - least) >= SCALE_LETHAL {
        Occupancy::Occupied
    } else {
        Occupancy::Free
    }
}

fn unknown_that_loads_as_free(yaml: &MapYaml, pixels: &Pixels) -> usize {
    let free = occupancy_of(yaml, PIXEL_UNKNOWN) == Occupancy::Free;
    if yaml.mode != Mode::Trinary || yaml.negate || !free {
        return 0;
    }
    let unknown = |pixel: &&u8| **pixel == PIXEL_UNKNOWN;
    pixels.grey.iter().filter(unknown).count()
}
