//! What the samples of a film are, and what each takes.

use super::thinned::Sample;
use serde::Serialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::grid::Cell;
use zeronav_msgs::map::{MapCell, MapTile, MapView, TILE_CELLS};
use zeronav_msgs::path::{Path, Waypoint};
use zeronav_msgs::scan::Scan;
use zeronav_viewer::scene::{
    Control, Grid, Rounded, SceneGoal, ScenePath, SceneScan, SceneZone, Tile, Tracked, robot,
};

/// Beams of a scan that are kept at most.
const BEAMS_MAX: usize = 180;

/// Where the robot was, as the stack took it to be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moving {
    /// Control tick.
    pub tick: u64,
    /// `map_from_base`.
    pub pose: Pose,
    /// Forward speed. [m/s]
    pub v_mps: f64,
    /// Yaw rate. [rad/s]
    pub w_radps: f64,
}

impl Moving {
    /// As the renderer takes it.
    pub(super) fn robot(&self) -> [Rounded; 5] {
        robot(&self.pose, self.v_mps, self.w_radps)
    }
}

/// A path.
#[derive(Debug, Clone)]
pub(crate) struct Planned {
    /// Its fixed fields.
    pub path: Path,
    /// Its corners.
    pub waypoints: Vec<Waypoint>,
}

impl Planned {
    /// As the renderer takes it.
    pub(super) fn scene(&self) -> ScenePath {
        ScenePath::of(&self.path, &self.waypoints)
    }
}

/// What changed on the map.
#[derive(Debug, Default)]
pub(super) struct Patch {
    pub(super) grid: Option<Grid>,
    pub(super) tiles: BTreeMap<(u32, u32), Tile>,
}

/// About what a sample takes in a file: its own text and the key before it. [bytes]
fn written(sample: &impl Serialize) -> usize {
    const KEY: usize = 12;
    serde_json::to_vec(sample).map_or(usize::MAX / 2, |text| text.len() + KEY)
}

impl Sample for Moving {
    fn bytes(&self) -> usize {
        written(&self.robot()) + "{\"time_s\":,\"tick\":,},".len() + 12
    }
}

impl Sample for [Rounded; 3] {
    fn bytes(&self) -> usize {
        written(self)
    }
}

impl Sample for Control {
    fn bytes(&self) -> usize {
        written(self)
    }
}

impl Sample for SceneScan {
    fn bytes(&self) -> usize {
        written(self)
    }
}

impl Sample for Vec<Tracked> {
    fn bytes(&self) -> usize {
        written(self)
    }
}

impl Sample for Vec<Vec<[Rounded; 2]>> {
    fn bytes(&self) -> usize {
        written(self)
    }
}

impl Sample for Planned {
    fn bytes(&self) -> usize {
        written(&self.scene())
    }

    fn join(_: (u64, Self), later: (u64, Self)) -> (u64, Self) {
        later
    }
}

impl Sample for Vec<SceneGoal> {
    fn bytes(&self) -> usize {
        written(self)
    }

    fn join(_: (u64, Self), later: (u64, Self)) -> (u64, Self) {
        later
    }
}

impl Sample for Vec<SceneZone> {
    fn bytes(&self) -> usize {
        written(self)
    }

    fn join(_: (u64, Self), later: (u64, Self)) -> (u64, Self) {
        later
    }
}

impl Sample for &'static str {
    fn bytes(&self) -> usize {
        written(self)
    }

    fn join(_: (u64, Self), later: (u64, Self)) -> (u64, Self) {
        later
    }
}

impl Sample for Patch {
    fn bytes(&self) -> usize {
        self.tiles.values().map(written).sum::<usize>() + 80
    }

    /// Nothing that changed is lost; it is only shown later.
    fn join(mut earlier: (u64, Self), later: (u64, Self)) -> (u64, Self) {
        if later.1.grid.is_some() {
            return later;
        }
        earlier.1.tiles.extend(later.1.tiles);
        (later.0, earlier.1)
    }
}

/// Every n-th beam of a scan with many.
pub(crate) fn beams_kept<'a>(scan: &Scan, ranges_m: &'a [f32]) -> (Scan, Cow<'a, [f32]>) {
    let step = ranges_m.len().div_ceil(BEAMS_MAX).max(1);
    if step == 1 {
        return (*scan, Cow::Borrowed(ranges_m));
    }
    let kept: Vec<f32> = ranges_m.iter().copied().step_by(step).collect();
    let angle_increment_rad = scan.angle_increment_rad * step.to_f32();
    let scan = Scan {
        n_beams: u32::try_from(kept.len()).unwrap_or(u32::MAX),
        angle_increment_rad,
        ..*scan
    };
    (scan, Cow::Owned(kept))
}

/// The flags of a tile; cells beyond the map's edge are unknown.
pub(super) fn flags(map: &MapView<'_>, (tile_x, tile_y): (u32, u32)) -> Tile {
    let mut tile = MapTile {
        tile_x,
        tile_y,
        cells: [MapCell::unknown(0); TILE_CELLS * TILE_CELLS],
    };
    let side = i32::try_from(TILE_CELLS).unwrap_or(i32::MAX);
    let first = |at: u32| at.cast_signed().saturating_mul(side);
    let (x, y) = (first(tile_x), first(tile_y));
    let cells = (0..side).flat_map(|row| (0..side).map(move |column| (column, row)));
    for (cell, (column, row)) in tile.cells.iter_mut().zip(cells) {
        if let Some(known) = map.get(Cell::new(x + column, y + row)) {
            *cell = known;
        }
    }
    Tile::of_flags(&tile)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_beams_are_thinned_evenly() {
        let ranges_m: Vec<f32> = (0..721_u16).map(f32::from).collect();
        let scan = Scan {
            n_beams: 721,
            angle_min_rad: -3.0,
            angle_increment_rad: 0.01,
            ..Scan::default()
        };
        let (thin, kept) = beams_kept(&scan, &ranges_m);
        assert_eq!(kept.len(), 145);
        assert_eq!(thin.n_beams, 145);
        for (at, range_m) in kept.iter().enumerate() {
            assert!((scan.angle_of(5 * at) - thin.angle_of(at)).abs() < 1e-5);
            assert!((range_m - ranges_m[5 * at]).abs() < 1e-6);
        }
        let (same, kept) = beams_kept(&scan, &ranges_m[..90]);
        assert_eq!((same, kept.len()), (scan, 90));
    }

    #[test]
    fn joined_patches_have_the_newest_of_every_tile() {
        let tile = |flags: u8| {
            let cell = MapCell {
                flags,
                ..MapCell::default()
            };
            Tile::of_flags(&MapTile {
                tile_x: 0,
                tile_y: 0,
                cells: [cell; 1024],
            })
        };
        let patch = |tiles: &[(u32, u8)]| Patch {
            grid: None,
            tiles: tiles
                .iter()
                .map(|(x, flags)| ((*x, 0), tile(*flags)))
                .collect(),
        };
        let (at, both) = Patch::join((5, patch(&[(0, 1), (1, 1)])), (7, patch(&[(1, 2), (2, 4)])));
        assert_eq!(at, 7);
        let expected = [((0, 0), tile(1)), ((1, 0), tile(2)), ((2, 0), tile(4))];
        assert_eq!(both.tiles, BTreeMap::from(expected));
    }
}
