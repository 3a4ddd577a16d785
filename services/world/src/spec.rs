//! The words of a scenario for the world. Metres, radians, seconds, `map` frame.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The world: a map file, or an area with shapes, or both; and what happens in it.
///
/// At most one of `map`, `barn`, `dynabarn` and `generated`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldSpec {
    /// ROS `map_server` YAML of the static world, or a file `.map`, see `zeronav_world_files`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<PathBuf>,
    /// CSV of a BARN world, see `zeronav_world_files`: its cylinders become shapes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub barn: Option<PathBuf>,
    /// A `DynaBARN` world: its walls become shapes, its cylinders obstacles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dynabarn: Option<DynabarnSpec>,
    /// Recorded people, who become obstacles; may be laid on any other world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pedestrians: Option<PedestriansSpec>,
    /// A random map, see [`crate::generate`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub generated: Option<GeneratedSpec>,
    /// Lower left corner `[x, y]` and upper right corner `[x, y]` of the area. [m] Required
    /// without a map file, refused with one or with a generated map. The worlds of data sets bring
    /// one, which this replaces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub area_m: Option<[[f64; 2]; 2]>,
    /// Cell size with which shapes are drawn into a map, and of a file `.map`. [m] Any other map
    /// file brings its own.
    #[serde(default = "default_resolution_m")]
    pub resolution_m: f64,
    /// Walls and other things that never move and stand on the static map.
    #[serde(default)]
    pub shapes: Vec<ShapeSpec>,
    /// Things that appear, move and vanish and stand on no map.
    #[serde(default)]
    pub obstacles: Vec<ObstacleSpec>,
}

fn default_resolution_m() -> f64 {
    0.05
}

impl WorldSpec {
    /// An empty area from `lower_m` to `upper_m`, cells of 5 cm.
    #[must_use]
    pub fn area(lower_m: [f64; 2], upper_m: [f64; 2]) -> Self {
        Self {
            area_m: Some([lower_m, upper_m]),
            ..Self::none()
        }
    }

    /// The world of a map file, with nothing on it.
    #[must_use]
    pub fn of_map(file: impl Into<PathBuf>) -> Self {
        Self {
            map: Some(file.into()),
            ..Self::none()
        }
    }

    fn none() -> Self {
        Self {
            map: None,
            barn: None,
            dynabarn: None,
            pedestrians: None,
            generated: None,
            area_m: None,
            resolution_m: default_resolution_m(),
            shapes: Vec::new(),
            obstacles: Vec::new(),
        }
    }
}

/// A world of `dynabarn`, see `zeronav_world_files`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DynabarnSpec {
    /// CSV of the world.
    pub file: PathBuf,
    /// Moment of the recorded rounds at which the run begins. [s] Every obstacle goes round with a
    /// period of its own, so any number is one.
    #[serde(default)]
    pub phase_s: f64,
}

/// Recorded people, see `zeronav_world_files`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PedestriansSpec {
    /// CSV of the scene.
    pub file: PathBuf,
    /// Moment of the recording at which the run begins. [s]
    #[serde(default)]
    pub from_s: f64,
    /// How much of the recording is played; without, all of it. [s]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// Radius of the disc that represents a person. [m]
    #[serde(default = "default_person_radius_m")]
    pub radius_m: f64,
}

/// Radii that represent a person. [m]
pub const PERSON_RADIUS_M: [f64; 2] = [1.0e-3, 10.0];

fn default_person_radius_m() -> f64 {
    0.3
}

/// A random map. Its origin is the lower left corner of cell (0, 0).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeneratedSpec {
    /// How obstacles are laid.
    pub family: Family,
    /// Columns and rows, 2 to 8192 each.
    pub size_cells: [u32; 2],
    /// Occupied cells / all cells, 0 to 1. Corridors have none.
    #[serde(default)]
    pub ratio: f64,
    /// Column and row of the cell that stays free for the start; without, the lower left one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_cell: Option<[u32; 2]>,
    /// The same for the goal; without, the upper right one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal_cell: Option<[u32; 2]>,
    /// Of everything random.
    #[serde(default)]
    pub seed: u64,
    /// Side of a cell. [m]
    #[serde(default = "default_generated_resolution_m")]
    pub resolution_m: f64,
}

fn default_generated_resolution_m() -> f64 {
    1.0
}

/// How a random map is laid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Family {
    /// Single cells, drawn without replacement.
    Iid,
    /// Rectangles with sides of 1 to `side_cells_max` cells.
    Blocky {
        /// Largest side. [cells]
        #[serde(default = "default_side_cells_max")]
        side_cells_max: u32,
    },
    /// U, L and spiral traps with arms of up to `side_cells_max` cells.
    Concave {
        /// Largest side of a trap. [cells]
        #[serde(default = "default_trap_cells_max")]
        side_cells_max: u32,
    },
    /// Corridors of `width_cells` along walls with one gap each, alternately left and right.
    Corridor {
        /// Width of a corridor and of a gap. [cells]
        #[serde(default = "default_corridor_cells")]
        width_cells: u32,
    },
}

fn default_side_cells_max() -> u32 {
    4
}

fn default_trap_cells_max() -> u32 {
    8
}

fn default_corridor_cells() -> u32 {
    2
}

/// A shape in its own frame; `centre_m` places it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ShapeSpec {
    /// A rectangle.
    Box {
        /// Centre `[x, y]`. [m]
        centre_m: [f64; 2],
        /// Full side lengths `[along x, along y]` before the turn. [m]
        size_m: [f64; 2],
        /// Turn, counter-clockwise. [rad]
        #[serde(default)]
        yaw_rad: f64,
    },
    /// A disc.
    Disc {
        /// Centre `[x, y]`. [m]
        centre_m: [f64; 2],
        /// Radius. [m]
        radius_m: f64,
    },
    /// A convex polygon.
    Polygon {
        /// Corners `[x, y]`, 3 to 256, either way around. [m]
        corners_m: Vec<[f64; 2]>,
    },
}

/// A scripted obstacle. Where its shape says is where it appears.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleSpec {
    /// For reports; unique.
    pub name: String,
    /// Its shape and where it appears.
    pub shape: ShapeSpec,
    /// When it appears; without, it is there from the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub appears: Option<Trigger>,
    /// How long it stays; without, to the end. [s]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lasts_s: Option<f64>,
    /// Points `[x, y]` that its centre (of a polygon: its centroid) visits in turn after it appeared, at `speed_mps`. [m]
    #[serde(default)]
    pub waypoints_m: Vec<[f64; 2]>,
    /// Speed along the waypoints. [m/s]
    #[serde(default)]
    pub speed_mps: f64,
    /// Start again at the first waypoint after the last instead of standing there. A track starts
    /// again at its first row, where the obstacle is at once.
    #[serde(default)]
    pub repeat: bool,
    /// When it begins to move; without, when it appears. A sliding door is beside its opening
    /// until then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub starts: Option<Trigger>,
    /// Velocity `[x, y]` of a disc that goes straight and bounces off everything static and off
    /// the edge of the map. [m/s] Instead of waypoints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounces_mps: Option<[f64; 2]>,
    /// Rows `[t, x, y]` that its centre passes, straight from row to row, instead of waypoints.
    /// [s, m, m] The times increase; it moves from the time of the first row.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub track: Vec<[f64; 3]>,
    /// Moment of the track at which it begins to move. [s]
    #[serde(default)]
    pub track_from_s: f64,
}

impl ObstacleSpec {
    /// An obstacle that is there from the start and static.
    #[must_use]
    pub fn standing(name: impl Into<String>, shape: ShapeSpec) -> Self {
        Self {
            name: name.into(),
            shape,
            appears: None,
            lasts_s: None,
            waypoints_m: Vec::new(),
            speed_mps: 0.0,
            repeat: false,
            starts: None,
            bounces_mps: None,
            track: Vec::new(),
            track_from_s: 0.0,
        }
    }
}

/// What makes an obstacle appear. Exactly one of the two.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trigger {
    /// Run time. [s]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_s: Option<f64>,
    /// The robot's centre comes near a point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot_near: Option<Near>,
}

/// Within `distance_m` of `point_m`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Near {
    /// `[x, y]`. [m]
    pub point_m: [f64; 2],
    /// Distance of the robot's centre. [m]
    pub distance_m: f64,
}
