//! Zones on the grid: which cells the robot must keep out of, what others cost at least, and the way
//! by which a robot that is inside is let out.
//!
//! Nothing of this is belief: scans neither mark nor clear it, and localisation does not see it.

use nalgebra::{Point2, Vector2};
use zeronav_msgs::way_out::WayOut;
use zeronav_msgs::zone_marks::MARK_KEEPOUT;
use zeronav_msgs::zones::ZoneKind;
use zeronav_msgs::{Cell, CellRect, GridGeometry, ZoneSet};

/// Directions in which a way out is looked for.
const WAYS: u32 = 32;

/// The cells that may lie on a way out.
pub(crate) fn cells_on(way: &WayOut, geometry: &GridGeometry) -> CellRect {
    let (from, until) = (Point2::from(way.from_m), Point2::from(way.until_m));
    let aside = Vector2::repeat(way.radius_m);
    cells_between(geometry, from.inf(&until) - aside, from.sup(&until) + aside)
}

/// The cells of the grid in an upright rectangle, and those beside it.
fn cells_between(geometry: &GridGeometry, least: Point2<f64>, most: Point2<f64>) -> CellRect {
    let (width, height) = geometry.size();
    let min = geometry.unbounded_cell_at(least);
    let max = geometry.unbounded_cell_at(most);
    let inside = |cell: i32, size: i32| cell.clamp(0, size);
    CellRect {
        min: Cell::new(
            inside(min.x.saturating_sub(1), width),
            inside(min.y.saturating_sub(1), height),
        ),
        max: Cell::new(
            inside(max.x.saturating_add(2), width),
            inside(max.y.saturating_add(2), height),
        ),
    }
}

/// True for zones that mark cells.
const fn is_painted(kind: Option<ZoneKind>) -> bool {
    matches!(
        kind,
        Some(ZoneKind::Keepout | ZoneKind::Cost | ZoneKind::Lane)
    )
}

/// The zones and what they make of the cells of a grid. Without any it holds no memory.
#[derive(Debug, Clone, Default)]
pub(crate) struct ZonePaint {
    set: ZoneSet,
    /// Mark of each cell, row-major; empty without zones that mark any.
    marks: Vec<u8>,
    way_out: Option<WayOut>,
}

impl ZonePaint {
    /// The same zones on another grid.
    pub(crate) fn on(&self, geometry: &GridGeometry) -> Self {
        let mut paint = Self::default();
        let whole = paint.take(&self.set, geometry);
        for rect in &whole {
            paint.mark(rect, geometry, |_| ());
        }
        paint.way_out = self.way_out;
        paint
    }

    /// Takes in other zones; which cells may be marked otherwise now.
    pub(crate) fn take(&mut self, set: &ZoneSet, geometry: &GridGeometry) -> Vec<CellRect> {
        let before = core::mem::replace(&mut self.set, set.clone());
        if self.marks.is_empty() && !set.parts().any(|part| is_painted(part.kind())) {
            return Vec::new();
        }
        self.marks.resize(geometry.len(), 0);
        let mut changed = Vec::new();
        for (of, other) in [(&before, set), (set, &before)] {
            for (part, min, max) in of.bounds() {
                let is_lane = part.kind() == Some(ZoneKind::Lane);
                if !is_painted(part.kind()) || other.parts().any(|it| it == part) {
                    continue;
                }
                if is_lane {
                    // It is said of the cells beside it.
                    let (width, height) = geometry.size();
                    return vec![CellRect {
                        min: Cell::new(0, 0),
                        max: Cell::new(width, height),
                    }];
                }
                changed.push(cells_between(geometry, min, max));
            }
        }
        changed
    }

    /// Marks the cells of a rectangle anew and names those that have another mark now, with their index.
    pub(crate) fn mark(
        &mut self,
        rect: &CellRect,
        geometry: &GridGeometry,
        mut changed: impl FnMut(usize),
    ) {
        let rect = rect.grown(0, geometry);
        let cells = (rect.min.y..rect.max.y)
            .flat_map(|y| (rect.min.x..rect.max.x).map(move |x| Cell::new(x, y)));
        for (cell, mark) in cells.zip(self.set.marks(geometry, &rect)) {
            if let Some(index) = geometry.index_of(cell)
                && core::mem::replace(&mut self.marks[index], mark) != mark
            {
                changed(index);
            }
        }
    }

    /// Forgets the marks when no zone makes any.
    pub(crate) fn clear_if_blank(&mut self) {
        if !self.set.parts().any(|part| is_painted(part.kind())) {
            self.marks = Vec::new();
        }
    }

    /// Mark of a cell.
    #[inline]
    pub(crate) fn mark_of(&self, index: usize) -> u8 {
        if self.marks.is_empty() {
            0
        } else {
            self.marks[index]
        }
    }

    /// True for a cell of a keepout zone that is not on the way out.
    #[inline]
    pub(crate) fn closes(&self, index: usize, geometry: &GridGeometry) -> bool {
        self.mark_of(index) == MARK_KEEPOUT
            && self.way_out.is_none_or(|way| {
                let cell = crate::rows_around::cell_at(geometry, index);
                way.distance_m(geometry.centre_of(cell)) > way.radius_m
            })
    }

    /// True when no cell is in a zone.
    pub(crate) fn is_blank(&self) -> bool {
        self.marks.is_empty()
    }

    /// The way out that is open.
    pub(crate) fn way_out(&self) -> Option<WayOut> {
        self.way_out
    }

    /// Opens a way out, or closes it.
    pub(crate) fn open(&mut self, way_out: Option<WayOut>) {
        self.way_out = way_out;
    }

    /// The way out that a robot needs while its centre is in a keepout zone, or on its way out nearer to one than
    /// `room_m`: the one that is open, as long as it leads out and nothing has come to stand on it; else the shortest
    /// one. It goes straight to where there is that much room, `radius_m` wide on either side. `is_free` says
    /// where no obstacle is.
    pub(crate) fn wanted(
        &self,
        geometry: &GridGeometry,
        robot: Point2<f64>,
        (room_m, radius_m): (f64, f64),
        is_free: impl Fn(usize) -> bool,
    ) -> Option<WayOut> {
        let straight = Straight {
            paint: self,
            geometry,
            robot,
            room_m,
            is_free,
        };
        let is_on = |way: &WayOut| way.distance_m(robot) <= 0.5 * way.radius_m;
        let open = self.way_out.filter(is_on);
        let is_leaving = open.is_some() && self.is_near(geometry, robot, room_m);
        if !is_leaving && (open.is_some() || !straight.keeps_out(robot)) {
            return None;
        }
        open.filter(|way| straight.leads_out(way)).or_else(|| {
            let until = straight.shortest()?;
            Some(WayOut {
                from_m: robot.into(),
                until_m: until.into(),
                radius_m,
            })
        })
    }

    /// True when a cell of a keepout zone lies within `reach_m` of a point.
    fn is_near(&self, geometry: &GridGeometry, at: Point2<f64>, reach_m: f64) -> bool {
        let reach = Vector2::repeat(reach_m);
        let rect = cells_between(geometry, at - reach, at + reach);
        (rect.min.y..rect.max.y).any(|y| {
            (rect.min.x..rect.max.x).any(|x| {
                let cell = Cell::new(x, y);
                let index = geometry.index_of(cell);
                index.is_some_and(|index| self.mark_of(index) == MARK_KEEPOUT)
                    && (geometry.centre_of(cell) - at).norm() <= reach_m
            })
        })
    }
}

/// Straight ways of a robot with room beside it.
struct Straight<'a, F> {
    paint: &'a ZonePaint,
    geometry: &'a GridGeometry,
    robot: Point2<f64>,
    room_m: f64,
    /// True for the index of a cell without an obstacle.
    is_free: F,
}

impl<F: Fn(usize) -> bool> Straight<'_, F> {
    fn step_m(&self) -> f64 {
        0.5 * self.geometry.resolution_m
    }

    fn index_at(&self, at: Point2<f64>) -> Option<usize> {
        self.geometry.index_of(self.geometry.unbounded_cell_at(at))
    }

    fn keeps_out(&self, at: Point2<f64>) -> bool {
        let index = self.index_at(at);
        index.is_some_and(|index| self.paint.mark_of(index) == MARK_KEEPOUT)
    }

    /// So far along a way, and on either side of it.
    fn across(&self, towards: Vector2<f64>, along_m: f64) -> [Point2<f64>; 3] {
        let at = self.robot + towards * along_m;
        let aside = Vector2::new(-towards.y, towards.x) * (0.7 * self.room_m);
        [at, at + aside, at - aside]
    }

    fn is_passable(&self, towards: Vector2<f64>, along_m: f64) -> bool {
        let mut across = self.across(towards, along_m).into_iter();
        across.all(|at| self.index_at(at).is_some_and(&self.is_free))
    }

    fn is_out(&self, towards: Vector2<f64>, along_m: f64) -> bool {
        let mut across = self.across(towards, along_m).into_iter();
        !across.any(|at| self.keeps_out(at))
    }

    /// True when what is left of a way is free and ends outside.
    fn leads_out(&self, way: &WayOut) -> bool {
        let left = Point2::from(way.until_m) - self.robot;
        let Some(towards) = left.try_normalize(self.step_m()) else {
            return true;
        };
        let steps = core::iter::successors(Some(0.0), |along_m| Some(along_m + self.step_m()));
        let mut steps = steps.take_while(|along_m| *along_m < left.norm());
        steps.all(|along_m| self.is_passable(towards, along_m)) && self.is_out(towards, left.norm())
    }

    /// Where the shortest one ends that leads out.
    fn shortest(&self) -> Option<Point2<f64>> {
        let (width, height) = self.geometry.size();
        let most_m = f64::from(width).hypot(f64::from(height)) * self.geometry.resolution_m;
        let ways = (0..WAYS).filter_map(|n| {
            let (sin, cos) = (core::f64::consts::TAU * f64::from(n) / f64::from(WAYS)).sin_cos();
            let towards = Vector2::new(cos, sin);
            let (mut along_m, mut out_m) = (0.0, 0.0);
            while out_m < self.room_m {
                if !self.is_passable(towards, along_m) || along_m > most_m {
                    return None;
                }
                let is_out = self.is_out(towards, along_m);
                out_m = if is_out { out_m + self.step_m() } else { 0.0 };
                along_m += self.step_m();
            }
            Some((along_m, self.robot + towards * along_m))
        });
        let shortest = ways.min_by(|one, other| one.0.total_cmp(&other.0));
        shortest.map(|(_, until)| until)
    }
}
