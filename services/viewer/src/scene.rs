//! The format that the renderer draws, as `page/README.md` describes it. Numbers are rounded when
//! they are written: lengths to millimetres, angles to 0.1 mrad.

mod numbers;
mod placed;
mod rollouts;
mod zones;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
pub use numbers::{Rounded, point, pose};
pub use placed::outline;
pub use rollouts::SceneRollout;
use serde::Serialize;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::command::{Intervention, Validity, VelocityCommand, VelocityRequest};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::grid::GridGeometry;
use zeronav_msgs::header::Id;
use zeronav_msgs::map::{MapCell, MapTile};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::path::{Path, PathCause, PathStatus, Waypoint};
use zeronav_msgs::scan::Scan;
pub use zones::SceneZone;

/// Version of the format.
pub const FORMAT: u32 = 1;

/// What does not change during a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fixed {
    /// [`FORMAT`].
    pub format: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// `real_time` or `lockstep`.
    pub mode: String,
    /// The robot.
    pub robot: Robot,
}

/// The robot's shape and sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Robot {
    /// Corners, counter-clockwise in `base`; empty = a disc.
    pub footprint_m: Vec<[Rounded; 2]>,
    /// Of the smallest disc that holds it.
    pub radius_m: Rounded,
    /// Of the largest disc inside it.
    pub inscribed_m: Rounded,
    /// `base_from_laser`.
    pub laser: [Rounded; 3],
    /// Farthest valid range.
    pub range_m: Rounded,
}

impl Robot {
    /// The robot of a `robot/description`.
    #[must_use]
    pub fn of(description: &Description, corners: &[Corner]) -> Self {
        let corner = |corner: &Corner| point(corner.x_m, corner.y_m);
        Self {
            footprint_m: corners.iter().map(corner).collect(),
            radius_m: Rounded::thousandths(description.circumscribed_radius_m),
            inscribed_m: Rounded::thousandths(description.inscribed_radius_m),
            laser: pose(&description.base_from_laser),
            range_m: Rounded::thousandths(description.range_m_max),
        }
    }
}

/// One moment. What is `None` is as it was in the frame before.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct Frame {
    /// Run time. [s]
    pub time_s: Rounded,
    /// Control tick.
    pub tick: u64,
    /// `[x, y, yaw, v, w]`, see [`robot`].
    pub robot: [Rounded; 5],
    /// True pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<[Rounded; 3]>,
    /// The newest scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scan: Option<SceneScan>,
    /// Tracked obstacles: track, x, y, vx, vy, radius, time since it was seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub obstacles: Option<Vec<Tracked>>,
    /// True outlines of what was put into the world or moves by a script.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bodies: Option<Vec<Vec<[Rounded; 2]>>>,
    /// The path.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<ScenePath>,
    /// Motions that the local planner looked at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rollouts: Option<Vec<SceneRollout>>,
    /// Goals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goals: Option<Vec<SceneGoal>>,
    /// Zones, part by part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zones: Option<Vec<SceneZone>>,
    /// State of the task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task: Option<&'static str>,
    /// How far the robot knows where it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certainty: Option<&'static str>,
    /// What was asked for and what the wheels get.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub control: Option<Control>,
    /// What changed on the map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<MapPatch>,
    /// What happened since the frame before.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Event>,
}

/// `[x, y, yaw, v, w]`: a pose in the map frame, forward speed and yaw rate.
#[must_use]
pub fn robot(map_from_base: &Pose, v_mps: f64, w_radps: f64) -> [Rounded; 5] {
    let [x, y, yaw] = pose(map_from_base);
    [
        x,
        y,
        yaw,
        Rounded::thousandths(v_mps),
        Rounded::angle(w_radps),
    ]
}

/// A scan and where it was taken.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneScan {
    /// `map_from_laser` at the capture.
    pub laser: [Rounded; 3],
    /// Direction of beam 0 in `laser`.
    pub angle_min_rad: Rounded,
    /// Step from beam to beam, not rounded as far as the others: it counts once per beam.
    pub angle_increment_rad: f64,
    /// Range of each beam, -1 = no return, -2 = invalid. [mm]
    pub ranges_mm: Vec<i32>,
}

impl SceneScan {
    /// A scan that was taken at `map_from_laser`.
    #[must_use]
    pub fn of(scan: &Scan, ranges_m: &[f32], map_from_laser: &Pose) -> Self {
        let range = |range_m: &f32| match *range_m {
            range_m if scan.is_hit(range_m) => (f64::from(range_m) * 1.0e3).round().to_i32(),
            range_m if range_m.is_infinite() => -1,
            _ => -2,
        };
        Self {
            laser: pose(map_from_laser),
            angle_min_rad: Rounded::angle(f64::from(scan.angle_min_rad)),
            angle_increment_rad: (f64::from(scan.angle_increment_rad) * 1.0e7).round() / 1.0e7,
            ranges_mm: ranges_m.iter().map(range).collect(),
        }
    }
}

/// A tracked obstacle: track, x, y, vx, vy, radius, time since it was seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tracked(u64, Rounded, Rounded, Rounded, Rounded, Rounded, Rounded);

impl Tracked {
    /// One of `map/obstacles`.
    #[must_use]
    pub fn of(obstacle: &Obstacle) -> Self {
        let round = Rounded::thousandths;
        Self(
            obstacle.track,
            round(obstacle.x_m),
            round(obstacle.y_m),
            round(obstacle.vx_mps),
            round(obstacle.vy_mps),
            round(obstacle.radius_m),
            round(obstacle.unseen_s),
        )
    }
}

/// A path, or why there is none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScenePath {
    /// Identity of its geometry.
    pub id: String,
    /// Outcome.
    pub status: &'static str,
    /// Why it was planned.
    pub cause: &'static str,
    /// Key of the planner.
    pub planner: String,
    /// Length.
    pub length_m: Rounded,
    /// Nodes taken from the open list.
    pub expanded: u64,
    /// Its corners; empty when none was found.
    pub points_m: Vec<[Rounded; 2]>,
}

impl ScenePath {
    /// A message of `plan/path`.
    #[must_use]
    pub fn of(path: &Path, waypoints: &[Waypoint]) -> Self {
        let corner = |waypoint: &Waypoint| point(waypoint.x_m, waypoint.y_m);
        Self {
            id: Id(path.geometry).to_string(),
            status: path.status().map_or("unknown", PathStatus::label),
            cause: path.cause().map_or("unknown", PathCause::label),
            planner: path.planner().to_owned(),
            length_m: Rounded::thousandths(path.length_m),
            expanded: path.expanded,
            points_m: waypoints.iter().map(corner).collect(),
        }
    }
}

/// A goal: x, y, yaw, tolerance, state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SceneGoal(Rounded, Rounded, Rounded, Rounded, &'static str);

impl SceneGoal {
    /// A goal at a pose of the map frame.
    #[must_use]
    pub fn new(goal: &Pose, tolerance_m: f64, state: &'static str) -> Self {
        let [x, y, yaw] = pose(goal);
        Self(x, y, yaw, Rounded::thousandths(tolerance_m), state)
    }
}

/// What was asked for, and what the wheels get.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Control {
    /// Speed and yaw rate that the local planner asked for.
    pub request: [Rounded; 2],
    /// Speed and yaw rate that the guard lets through.
    pub command: [Rounded; 2],
    /// What the command means.
    pub validity: &'static str,
    /// What the guard did.
    pub intervention: &'static str,
    /// Length of the arc on which the robot can still stop.
    pub braking_m: Rounded,
}

impl Control {
    /// A request and the command that came of it.
    #[must_use]
    pub fn of(request: &VelocityRequest, command: &VelocityCommand) -> Self {
        let pair = |v_mps, w_radps| [Rounded::thousandths(v_mps), Rounded::angle(w_radps)];
        Self {
            request: pair(request.v_mps, request.w_radps),
            command: pair(command.v_mps, command.w_radps),
            validity: command.validity().map_or("unknown", Validity::label),
            intervention: command
                .intervention()
                .map_or("unknown", Intervention::label),
            braking_m: Rounded::thousandths(request.braking_arc_m),
        }
    }
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Event {
    /// Run time.
    pub time_s: Rounded,
    /// What kind.
    pub kind: &'static str,
    /// In words.
    pub text: String,
    /// Name and length [us] of each hop from a scan to the wheels, where it is about one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub hops_us: Vec<(&'static str, f64)>,
}

/// What changed on the map.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct MapPatch {
    /// The grid, when it is new: all cells are unknown then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<Grid>,
    /// The tiles that changed.
    pub tiles: Vec<Tile>,
}

/// x and y of the outer corner of cell (0, 0), side of a cell [m], columns, rows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Grid(f64, f64, f64, u32, u32);

impl Grid {
    /// A grid in the map frame.
    #[must_use]
    pub fn of(geometry: &GridGeometry) -> Self {
        Self(
            geometry.origin_x_m,
            geometry.origin_y_m,
            geometry.resolution_m,
            geometry.width,
            geometry.height,
        )
    }
}

/// 32 x 32 cells: column and row of the tile; flags, cost and clearance, packed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tile(u32, u32, String, String, String);

impl Tile {
    /// A tile with every layer.
    #[must_use]
    pub fn of(tile: &MapTile) -> Self {
        let layer = |value: fn(&MapCell) -> u8| {
            let bytes: Vec<u8> = tile.cells.iter().map(value).collect();
            packed(&bytes)
        };
        let clearance = |cell: &MapCell| u8::try_from(cell.clearance_mm / 10).unwrap_or(u8::MAX);
        Self(
            tile.tile_x,
            tile.tile_y,
            layer(|cell| cell.flags),
            layer(|cell| cell.cost),
            layer(clearance),
        )
    }

    /// A tile of flags alone.
    #[must_use]
    pub fn of_flags(tile: &MapTile) -> Self {
        let bytes: Vec<u8> = tile.cells.iter().map(|cell| cell.flags).collect();
        Self(
            tile.tile_x,
            tile.tile_y,
            packed(&bytes),
            String::new(),
            String::new(),
        )
    }
}

/// Longest run or literal of `PackBits`. [bytes]
const PIECE_MAX: usize = 128;

/// Bytes as base64 of their `PackBits`.
fn packed(bytes: &[u8]) -> String {
    let mut pieces = Vec::with_capacity(bytes.len() / 4);
    let mut literal: &[u8] = &[];
    let mut rest = bytes;
    while let Some(first) = rest.first() {
        let same = rest
            .iter()
            .take(PIECE_MAX)
            .take_while(|byte| *byte == first);
        let run = same.count();
        // A run of two inside a literal saves nothing.
        if run >= 3 {
            write_literal(&mut pieces, literal);
            pieces.extend([length_code(257 - run), *first]);
            rest = &rest[run..];
            literal = &[];
        } else {
            let start = bytes.len() - rest.len() - literal.len();
            rest = &rest[1..];
            literal = &bytes[start..bytes.len() - rest.len()];
        }
    }
    write_literal(&mut pieces, literal);
    STANDARD.encode(pieces)
}

fn write_literal(to: &mut Vec<u8>, literal: &[u8]) {
    for piece in literal.chunks(PIECE_MAX) {
        to.push(length_code(piece.len() - 1));
        to.extend_from_slice(piece);
    }
}

fn length_code(code: usize) -> u8 {
    u8::try_from(code).unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse, as the page does it.
    fn unpacked(text: &str) -> Vec<u8> {
        let bytes = STANDARD.decode(text).expect("base64");
        let (mut at, mut all) = (0, Vec::new());
        while at < bytes.len() {
            let n = usize::from(bytes[at]);
            if n < 128 {
                all.extend_from_slice(&bytes[at + 1..at + 2 + n]);
                at += n + 2;
            } else {
                all.extend(core::iter::repeat_n(bytes[at + 1], 257 - n));
                at += 2;
            }
        }
        all
    }

    #[test]
    fn layers_come_back_as_they_were() {
        let noise = |n: usize| (0..n).map(|i| u8::try_from(i * i * 7 % 251).unwrap());
        let mut mixed: Vec<u8> = noise(300).collect();
        mixed.extend([4; 700]);
        mixed.extend([9, 9, 1, 1, 1]);
        let single = vec![5];
        for bytes in [
            Vec::new(),
            single,
            vec![0; 1024],
            noise(1024).collect(),
            mixed,
        ] {
            assert_eq!(unpacked(&packed(&bytes)), bytes);
        }
        assert!(packed(&[0; 1024]).len() <= 24, "runs are short");
    }

    #[test]
    fn frames_are_compact_and_rounded() {
        let frame = Frame {
            time_s: Rounded::thousandths(1.234_567),
            tick: 61,
            robot: robot(&Pose::new(1.0, -2.000_4, 0.123_456), 0.5, f64::NAN),
            obstacles: Some(vec![Tracked::of(&Obstacle {
                track: 3,
                x_m: 1.25,
                ..Obstacle::default()
            })]),
            goals: Some(vec![SceneGoal::new(&Pose::default(), 0.25, "active")]),
            ..Frame::default()
        };
        let text = serde_json::to_string(&frame).expect("JSON");
        assert_eq!(
            text,
            r#"{"time_s":1.235,"tick":61,"robot":[1,-2,0.1235,0.5,0],"obstacles":[[3,1.25,0,0,0,0,0]],"goals":[[0,0,0,0.25,"active"]]}"#
        );
    }
}
