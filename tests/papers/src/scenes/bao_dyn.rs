//! BAO-DYN: three discs that no map shows on the path of the improved A*, and three that cross it
//! at 0.3 m/s again and again; the robot sees three metres.

use super::blocks::{Blocks, LIMIT_S, Plan};
use super::{Scene, disc};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use zeronav_world::generate::GenerateError;
use zeronav_world::spec::Family;

/// Cells along each side of the map.
const SIDE: u32 = 20;

/// Radius of a disc, and of the robot. [m]
const DISC_M: f64 = 0.3;
const ROBOT_M: f64 = 0.25;

/// Speed of a crossing disc, and top speed of the robot. [m/s]
const CROSSING_MPS: f64 = 0.3;
const V_MPS: f64 = 0.9;

/// How far a crossing disc goes to either side of the path. [m]
const ASIDE_M: f64 = 1.2;

/// Range of the lidar. [m]
const RANGE_M: f64 = 3.0;

/// What paths keep from obstacles besides the robot's radius. [m]
///
/// A path of the paper leads over the centres of cells, half a cell away from obstacles; the cells of the
/// scenes are a metre. On the map's cells of 5 cm the shortest way leads along the very edge of where the
/// robot fits, where no arc has any clearance and the window stands for ever. What is left of half a cell is a
/// cell of the map, for the middle of a passage lies between two of them.
pub const PADDING_M: f64 = 0.5 - ROBOT_M - 0.05;

/// A place on a path and the direction there.
type Along = [[f64; 2]; 2];

/// The map of a seed, before its discs are placed on the path.
#[derive(Debug, Clone)]
pub struct BaoMap {
    blocks: Blocks,
    seed: u64,
}

/// A scene with what is known of it.
#[derive(Debug, Clone)]
pub struct BaoDyn {
    /// The scenario.
    pub scene: Scene,
    /// The path on the static map. [m]
    pub path: Vec<[f64; 2]>,
    standing: Vec<[f64; 2]>,
    /// The two ends of each way across.
    crossing: Vec<Along>,
}

impl BaoMap {
    /// The map of a seed.
    ///
    /// # Errors
    /// When none of many maps can be crossed.
    pub fn new(seed: u64) -> Result<Self, GenerateError> {
        let blocks = Blocks::new(Plan {
            family: Family::Blocky { side_cells_max: 4 },
            side: SIDE,
            ratio: 0.08,
            start: [1, 1],
            goal: [SIDE - 2, SIDE - 2],
            seed: 0x0b_a000 + seed,
            limit_s: LIMIT_S,
        })?;
        Ok(Self { blocks, seed })
    }

    /// The scenario without any disc, whose first path the discs are placed on.
    #[must_use]
    pub fn empty(&self) -> Scene {
        let title = format!("BAO-DYN {}", self.seed);
        Scene {
            text: self.blocks.text(&title, ROBOT_M, Some(RANGE_M)),
        }
    }

    /// The scene with its discs; `None` when the path has no six places with room around them.
    #[must_use]
    pub fn with_discs(&self, path: Vec<[f64; 2]>) -> Option<BaoDyn> {
        let mut rng = Pcg64Mcg::seed_from_u64(0x000b_a000 + self.seed);
        // Past a disc on the path there shall be a way for the robot.
        let room_m = DISC_M + 2.0 * ROBOT_M + 0.3;
        let places: Vec<Along> = (1..)
            .map(|n| 0.25 * f64::from(n))
            .map_while(|at_m| at(&path, at_m))
            .collect();
        let mut chosen: Vec<Along> = Vec::new();
        for _ in 0..400 {
            let place = *places.get(rng.random_range(0..places.len().max(1)))?;
            let apart = |other: [f64; 2]| (other[0] - place[0][0]).hypot(other[1] - place[0][1]);
            let near_end = self.blocks.ends_m().into_iter().any(|end| apart(end) < 2.5);
            let near_other = chosen.iter().any(|other| apart(other[0]) < 2.0);
            let has_room = self.blocks.clearance_m(place[0]) > room_m;
            if chosen.len() < 6 && !near_end && !near_other && has_room {
                chosen.push(place);
            }
        }
        let (standing, crossed) = chosen
            .split_at_checked(3)
            .filter(|(_, rest)| rest.len() == 3)?;
        let standing: Vec<[f64; 2]> = standing.iter().map(|[place, _]| *place).collect();
        let mut text = self.empty().text;
        for (index, place) in standing.iter().enumerate() {
            text += &disc(&format!("load {}", index + 1), *place, DISC_M, "");
        }
        let mut crossing = Vec::new();
        for (index, [[x, y], [ax, ay]]) in crossed.iter().enumerate() {
            let end = |side: f64| [x - side * ay, y + side * ax];
            let ends = [end(ASIDE_M), end(-ASIDE_M)];
            let [[fx, fy], [tx, ty]] = ends;
            let script = format!(
                "waypoints_m = [[{tx:.4}, {ty:.4}], [{fx:.4}, {fy:.4}]]\n\
                 speed_mps = {CROSSING_MPS}\nrepeat = true"
            );
            text += &disc(&format!("walker {}", index + 1), ends[0], DISC_M, &script);
            crossing.push(ends);
        }
        Some(BaoDyn {
            scene: Scene { text },
            path,
            standing,
            crossing,
        })
    }
}

impl BaoDyn {
    /// True when a robot that follows the path at its top speed, whatever comes, touches a disc.
    #[must_use]
    pub fn blind_follower_collides(&self) -> bool {
        (0..)
            .map(|tick| 0.05 * f64::from(tick))
            .map_while(|t_s| Some((t_s, at(&self.path, V_MPS * t_s)?[0])))
            .any(|(t_s, [x, y])| {
                let crossing = self.crossing.iter().map(|ends| {
                    // To and fro from the first end.
                    let way_m = (CROSSING_MPS * t_s).rem_euclid(4.0 * ASIDE_M);
                    let share = 1.0 - (way_m / (2.0 * ASIDE_M) - 1.0).abs();
                    let [from, to] = *ends;
                    [
                        from[0] + share * (to[0] - from[0]),
                        from[1] + share * (to[1] - from[1]),
                    ]
                });
                let discs = self.standing.iter().copied().chain(crossing);
                discs
                    .map(|[dx, dy]| (dx - x).hypot(dy - y))
                    .any(|far_m| far_m < DISC_M + ROBOT_M)
            })
    }

    /// Length of the path on the static map. [m]
    #[must_use]
    pub fn path_m(&self) -> f64 {
        self.path
            .windows(2)
            .map(|ends| (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1]))
            .sum()
    }

    /// Largest distance of a track [m] from the path. [m]
    #[must_use]
    pub fn lateral_m(&self, track: &[[f64; 2]]) -> f64 {
        let dense: Vec<[f64; 2]> = (0..)
            .map(|n| 0.05 * f64::from(n))
            .map_while(|m| Some(at(&self.path, m)?[0]))
            .collect();
        let from_path = |[x, y]: &[f64; 2]| {
            let far = dense.iter().map(|[px, py]| (px - x).hypot(py - y));
            far.fold(f64::INFINITY, f64::min)
        };
        track.iter().map(from_path).fold(0.0, f64::max)
    }
}

/// The point of a path that is `way_m` along it, and the direction there; `None` behind its end.
fn at(path: &[[f64; 2]], way_m: f64) -> Option<Along> {
    let mut left_m = way_m;
    for ends in path.windows(2) {
        let ([ax, ay], [bx, by]) = (ends[0], ends[1]);
        let length_m = (bx - ax).hypot(by - ay);
        if left_m <= length_m && length_m > 0.0 {
            let (ux, uy) = ((bx - ax) / length_m, (by - ay) / length_m);
            return Some([[ax + ux * left_m, ay + uy * left_m], [ux, uy]]);
        }
        left_m -= length_m;
    }
    None
}
