//! The map as an occupancy grid: which of its cells changed, and when it is shown as a whole.

use super::view::{UNKNOWN, cost, occupancy};
use zeronav_casts::Cast;
use zeronav_msgs::grid::{Cell, CellRect, GridGeometry};
use zeronav_msgs::header::Id;
use zeronav_msgs::map::{MapInfo, MapTile};
use zeronav_msgs::pose::Pose;
use zeronav_msgs::replica::MapReplica;

/// Least time between two whole maps of the same geometry, in the file's time. [ns]
const WHOLE_NS: u64 = 5_000_000_000;

/// What is to be shown.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct News {
    /// Where the grid lies.
    pub geometry: GridGeometry,
    /// Rectangles around cells that became others.
    pub changed: Vec<CellRect>,
    /// The whole map is due.
    pub whole: bool,
}

/// The grid.
#[derive(Debug, Default)]
pub(super) struct Grid {
    replica: MapReplica,
    geometry: GridGeometry,
    cells: Vec<i8>,
    /// When the whole map was shown last.
    whole_ns: Option<u64>,
    /// Cells have changed since.
    has_changed: bool,
}

impl Grid {
    pub(super) fn needs_keyframe(&self) -> bool {
        self.replica.needs_keyframe()
    }

    /// The cells of the geometry of the last [`News`].
    pub(super) fn cells(&self) -> &[i8] {
        &self.cells
    }

    /// Costs within `half_m` of a pose in the map along both axes, and where they lie; `None` off the map and
    /// before it is known. [m]
    pub(super) fn costs_around(&self, at: &Pose, half_m: f64) -> Option<(GridGeometry, Vec<i8>)> {
        let view = self.replica.view()?;
        let centre = view.geometry.cell_at(at.point())?;
        let half = (half_m / view.geometry.resolution_m).ceil().to_i32();
        let next = Cell::new(centre.x + 1, centre.y + 1);
        let (min, max) = (centre, next);
        let rect = CellRect { min, max }.grown(half, view.geometry);
        let mut costs = Vec::new();
        for y in rect.min.y..rect.max.y {
            for x in rect.min.x..rect.max.x {
                let index = view.geometry.index_of(Cell::new(x, y))?;
                costs.push(cost(view.cells[index]));
            }
        }
        let offset_m = |cells: i32| f64::from(cells) * view.geometry.resolution_m;
        let size = |from: i32, to: i32| u32::try_from(to - from).unwrap_or(0);
        let geometry = GridGeometry {
            origin_x_m: view.geometry.origin_x_m + offset_m(rect.min.x),
            origin_y_m: view.geometry.origin_y_m + offset_m(rect.min.y),
            width: size(rect.min.x, rect.max.x),
            height: size(rect.min.y, rect.max.y),
            ..*view.geometry
        };
        Some((geometry, costs))
    }

    pub(super) fn update(&mut self, id: Id, info: &MapInfo, tiles: &[MapTile]) {
        self.replica.update(id, info, tiles);
    }

    pub(super) fn keyframe(&mut self, info: &MapInfo, tiles: &[MapTile]) {
        self.replica.keyframe(info, tiles);
    }

    /// What has changed since the last call, at the moment `ns`.
    pub(super) fn take_news(&mut self, ns: u64) -> News {
        let rects = self.replica.take_changed();
        let Some(view) = self.replica.view() else {
            return News::default();
        };
        let geometry = *view.geometry;
        if geometry != self.geometry {
            self.geometry = geometry;
            self.cells.clear();
            self.cells.resize(geometry.len(), UNKNOWN);
            self.whole_ns = None;
        }
        let mut changed = Vec::new();
        for rect in rects {
            let mut found: Option<CellRect> = None;
            for y in rect.min.y..rect.max.y {
                for x in rect.min.x..rect.max.x {
                    let cell = Cell::new(x, y);
                    let Some(index) = geometry.index_of(cell) else {
                        continue;
                    };
                    let new = occupancy(view.cells[index]);
                    if core::mem::replace(&mut self.cells[index], new) != new {
                        grow(&mut found, cell);
                    }
                }
            }
            changed.extend(found);
        }
        self.has_changed |= !changed.is_empty();
        let whole = match self.whole_ns {
            None => true,
            Some(before_ns) => self.has_changed && ns.saturating_sub(before_ns) >= WHOLE_NS,
        };
        if whole {
            // The first one says all of it.
            if self.whole_ns.is_none() {
                changed.clear();
            }
            self.whole_ns = Some(ns);
            self.has_changed = false;
        }
        News {
            geometry,
            changed,
            whole,
        }
    }
}

/// Makes `rect` hold `cell`, too.
fn grow(rect: &mut Option<CellRect>, cell: Cell) {
    let next = Cell::new(cell.x + 1, cell.y + 1);
    let rect = rect.get_or_insert(CellRect {
        min: cell,
        max: next,
    });
    rect.min = Cell::new(rect.min.x.min(cell.x), rect.min.y.min(cell.y));
    rect.max = Cell::new(rect.max.x.max(next.x), rect.max.y.max(next.y));
}
