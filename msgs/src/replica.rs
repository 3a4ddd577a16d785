//! A reader's copy of the map, kept equal to the writer's by updates and keyframes.
//!
//! Updates are counted without gaps. After a gap, or when the writer starts again, the replica
//! keeps what it had, collects the updates that still arrive, and says that it needs a keyframe;
//! with the keyframe and the updates after it the copies are equal again. A map that has moved is
//! told by a keyframe with another geometry; it counts whether or not the replica is in step.

use crate::grid::{CellRect, GridGeometry};
use crate::header::Id;
use crate::map::{MapCell, MapInfo, MapTile, MapView, tiles_of};
use crate::obstacles::Obstacle;
use crate::stamp::Stamp;
use std::collections::VecDeque;

/// Updates that are kept while waiting for a keyframe; more and the wait restarts.
pub const PENDING_MAX: usize = 256;

/// What a message did to the replica.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// The map has a new revision.
    Applied,
    /// A part of a revision, or an update kept until the keyframe comes.
    Kept,
    /// Older than what is known.
    Ignored,
}

/// A copy of the map. See the module's description.
#[derive(Debug, Default)]
pub struct MapReplica {
    info: MapInfo,
    cells: Vec<MapCell>,
    /// Id of the last update message taken in, whole revision or not.
    last: Id,
    /// Revision whose cells are in `cells`.
    revision: Id,
    in_step: bool,
    pending: VecDeque<(Id, MapInfo, Vec<MapTile>)>,
    parts: Vec<MapTile>,
    /// Number of the part of the revision that comes next.
    next_part: u16,
    changed: Vec<CellRect>,
    /// Dynamic obstacles that lie over the cells.
    stamp: Stamp,
    gaps: u64,
}

impl MapReplica {
    /// An empty replica that waits for its first keyframe.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The map, once there is one.
    #[must_use]
    pub fn view(&self) -> Option<MapView<'_>> {
        self.revision.is_some().then_some(MapView {
            geometry: &self.info.geometry,
            cells: &self.cells,
        })
    }

    /// Fixed fields of the newest revision.
    #[must_use]
    pub fn info(&self) -> &MapInfo {
        &self.info
    }

    /// Revision of the cells; [`Id::NONE`] before the first.
    #[must_use]
    pub fn revision(&self) -> Id {
        self.revision
    }

    /// True when the replica can only go on with a keyframe.
    #[must_use]
    pub fn needs_keyframe(&self) -> bool {
        !self.in_step
    }

    /// How often the replica lost its step after it had been in step.
    #[must_use]
    pub fn gaps(&self) -> u64 {
        self.gaps
    }

    /// Takes dynamic obstacles, in the map frame, for static discs: writes them over the cells in
    /// place of those of the last call, by the map's cost model. To be called after every revision,
    /// which lifts them off. Unknown cells stay unknown where their clearance does not block the
    /// robot's centre.
    pub fn stamp(&mut self, obstacles: &[Obstacle]) {
        self.stamp.lift(&mut self.cells, &mut self.changed);
        if self.revision.is_some() {
            let (info, cells) = (&self.info, &mut self.cells);
            self.stamp.put(obstacles, info, cells, &mut self.changed);
        }
    }

    /// Rectangles around the cells that became others since the last call, at most one of each tile
    /// and obstacle; all of the map after a keyframe.
    pub fn take_changed(&mut self) -> Vec<CellRect> {
        core::mem::take(&mut self.changed)
    }

    /// Forgets the step, as when the obeyed writer changes.
    pub fn resync(&mut self) {
        self.in_step = false;
        self.pending.clear();
        self.parts.clear();
        self.next_part = 0;
    }

    /// Takes in one message of `map/update`.
    pub fn update(&mut self, id: Id, info: &MapInfo, tiles: &[MapTile]) -> Step {
        if id.epoch() == self.last.epoch() && id <= self.last {
            return Step::Ignored;
        }
        if self.in_step && id == self.last.next() && info.geometry == self.info.geometry {
            return self.take_in(id, info, tiles);
        }
        if self.in_step {
            self.gaps += 1;
            self.resync();
        }
        if let Some((last, ..)) = self.pending.back() {
            if last.epoch() != id.epoch() {
                // Another process writes the map now: after a rollback its ids are lower.
                self.pending.clear();
            } else if *last >= id {
                return Step::Ignored;
            }
        }
        if self.pending.len() == PENDING_MAX {
            self.pending.clear();
        }
        self.pending.push_back((id, *info, tiles.to_vec()));
        Step::Kept
    }

    /// Takes in one message of `map/keyframe`.
    pub fn keyframe(&mut self, info: &MapInfo, tiles: &[MapTile]) -> Step {
        let revision = Id(info.revision);
        let moved = info.geometry != self.info.geometry;
        if self.in_step && revision.epoch() == self.last.epoch() && !moved {
            return Step::Ignored;
        }
        let is_older = revision.epoch() == self.revision.epoch() && revision < self.revision;
        if is_older || !covers(info, tiles) {
            return Step::Ignored;
        }
        self.stamp.clear();
        self.cells.clear();
        self.cells.resize(info.geometry.len(), MapCell::unknown(0));
        for tile in tiles {
            tile.copy_to(&info.geometry, &mut self.cells);
        }
        self.info = *info;
        self.revision = revision;
        self.last = revision;
        self.in_step = true;
        self.parts.clear();
        self.next_part = 0;
        let (width, height) = info.geometry.size();
        self.changed = vec![CellRect {
            min: crate::Cell::new(0, 0),
            max: crate::Cell::new(width, height),
        }];
        for (id, info, tiles) in core::mem::take(&mut self.pending) {
            if id.epoch() == self.last.epoch() && id <= self.last {
                continue;
            }
            if !self.in_step || id != self.last.next() || info.geometry != self.info.geometry {
                self.in_step = false;
                self.pending.push_back((id, info, tiles));
                continue;
            }
            self.take_in(id, &info, &tiles);
        }
        Step::Applied
    }

    /// The next message in order: a whole revision, or one more part of it.
    fn take_in(&mut self, id: Id, info: &MapInfo, tiles: &[MapTile]) -> Step {
        if info.part == 0 {
            self.parts.clear();
            self.next_part = 0;
        }
        // What a revision holds is bounded by the map, whatever its author sends.
        let (columns, rows) = tiles_of(&info.geometry);
        let n_tiles = self.parts.len() + tiles.len();
        if info.part != self.next_part || n_tiles > columns as usize * rows as usize {
            self.gaps += 1;
            self.resync();
            return Step::Ignored;
        }
        self.last = id;
        if !info.is_last_part() {
            self.next_part += 1;
            self.parts.extend_from_slice(tiles);
            return Step::Kept;
        }
        self.next_part = 0;
        self.stamp.lift(&mut self.cells, &mut self.changed);
        let parts = core::mem::take(&mut self.parts);
        for tile in parts.iter().chain(tiles) {
            let changed = tile.copy_to(&info.geometry, &mut self.cells);
            self.changed.extend(changed);
        }
        self.info = *info;
        self.revision = id;
        Step::Applied
    }
}

/// True when the tiles of a keyframe are the whole map.
fn covers(info: &MapInfo, tiles: &[MapTile]) -> bool {
    let geometry: &GridGeometry = &info.geometry;
    let (columns, rows) = tiles_of(geometry);
    tiles.len() == columns as usize * rows as usize
        && tiles
            .iter()
            .zip(0..)
            .all(|(tile, n)| tile.tile_x == n % columns && tile.tile_y == n / columns)
}
