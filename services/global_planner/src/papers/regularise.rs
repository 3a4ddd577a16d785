//! TN-REG: obstacles on the line to the target are replaced by their bounding rectangles, so that
//! a walk never enters a pocket of theirs. TN-SW: where the walk takes over.

use crate::moves::STEPS;
use crate::papers::field::{Field, Meter};
use crate::papers::sight::first_hit;
use crate::papers::tn_3n::{SWITCH_MARGIN_MAX, WalkOptions};
use crate::planner::PlanError;
use zeronav_msgs::{Cell, CellRect};

/// The obstacles that were met so far, and the rectangles in their place.
#[derive(Debug, Default)]
pub(crate) struct Regions {
    /// Row-major: cells of obstacles that were met.
    met: Vec<bool>,
    /// Row-major: free cells that rectangles turned into obstacles.
    walls: Vec<bool>,
    rectangles: Vec<CellRect>,
    stack: Vec<Cell>,
}

impl Regions {
    /// Forgets every obstacle.
    pub(crate) fn begin(&mut self, n_cells: usize) {
        for cells in [&mut self.met, &mut self.walls] {
            cells.clear();
            cells.resize(n_cells, false);
        }
        self.rectangles.clear();
    }

    /// Row-major: the cells that are virtual obstacles.
    #[must_use]
    pub(crate) fn walls(&self) -> &[bool] {
        &self.walls
    }

    /// The rectangles that were filled, in the order in which they were met.
    #[must_use]
    pub(crate) fn rectangles(&self) -> &[CellRect] {
        &self.rectangles
    }

    /// Looks along the line from `at` to `target`. The first obstacle on it, when it was not met
    /// before, is flooded and its bounding rectangle filled; not when the rectangle is larger than
    /// allowed, or holds one of `spared`, `at` or the target. Later obstacles come when the line
    /// is looked along again. Gives whether the line is free of obstacles of the map.
    ///
    /// `field` is the map without virtual obstacles; it is not changed.
    ///
    /// # Errors
    /// [`PlanError::OutOfBudget`].
    pub(crate) fn regularise(
        &mut self,
        field: &Field<'_>,
        at: Cell,
        target: Cell,
        spared: &[Cell],
        options: &WalkOptions,
        meter: &mut Meter<'_>,
    ) -> Result<bool, PlanError> {
        let Some(hit) = first_hit(field, at, target, meter)? else {
            return Ok(true);
        };
        if self.met[field.index(hit)] {
            return Ok(false);
        }
        let rectangle = self.flood(field, hit, options, meter)?;
        let remarks = &mut meter.stats.remarks;
        let (width, height) = (
            rectangle.max.x - rectangle.min.x,
            rectangle.max.y - rectangle.min.y,
        );
        let (map_width, map_height) = field.map.geometry.size();
        let area = f64::from(width) * f64::from(height);
        let map_area = f64::from(map_width) * f64::from(map_height);
        let holds_end = spared
            .iter()
            .chain([&at, &target])
            .any(|cell| rectangle.contains(*cell));
        if holds_end || area > options.rectangle_share_max * map_area {
            remarks.rectangles_skipped += 1;
            return Ok(false);
        }
        remarks.rectangles += 1;
        self.rectangles.push(rectangle);
        for y in rectangle.min.y..rectangle.max.y {
            for x in rectangle.min.x..rectangle.max.x {
                let cell = Cell::new(x, y);
                if field.is_free(cell) {
                    self.walls[field.index(cell)] = true;
                }
            }
        }
        Ok(false)
    }

    /// Marks the obstacle that `hit` belongs to as met and gives its bounding rectangle.
    fn flood(
        &mut self,
        field: &Field<'_>,
        hit: Cell,
        options: &WalkOptions,
        meter: &mut Meter<'_>,
    ) -> Result<CellRect, PlanError> {
        let mut rectangle = CellRect {
            min: hit,
            max: Cell::new(hit.x + 1, hit.y + 1),
        };
        self.stack.clear();
        self.stack.push(hit);
        self.met[field.index(hit)] = true;
        while let Some(cell) = self.stack.pop() {
            meter.aux(1)?;
            let CellRect { min, max } = rectangle;
            rectangle.min = Cell::new(min.x.min(cell.x), min.y.min(cell.y));
            rectangle.max = Cell::new(max.x.max(cell.x + 1), max.y.max(cell.y + 1));
            for (n, (dx, dy)) in STEPS.iter().enumerate() {
                let beside = Cell::new(cell.x + dx, cell.y + dy);
                if options.components.has(n)
                    && field.map.geometry.contains(beside)
                    && !field.is_free(beside)
                    && !core::mem::replace(&mut self.met[field.index(beside)], true)
                {
                    self.stack.push(beside);
                }
            }
        }
        Ok(rectangle)
    }

    /// TN-SW: true within `margin` cells (Chebyshev distance) of an obstacle that was met, its
    /// rectangle included.
    #[must_use]
    pub(crate) fn is_switching(&self, field: &Field<'_>, cell: Cell, margin: u32) -> bool {
        let margin = margin.min(SWITCH_MARGIN_MAX).cast_signed();
        (-margin..=margin).any(|dy| {
            (-margin..=margin).any(|dx| {
                let at = Cell::new(cell.x + dx, cell.y + dy);
                field.map.geometry.index_of(at).is_some_and(|index| {
                    self.met.get(index) == Some(&true) || self.walls.get(index) == Some(&true)
                })
            })
        })
    }
}
