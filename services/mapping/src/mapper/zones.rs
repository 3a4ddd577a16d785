//! Zones on the map: only the cells of zones that changed are looked at, of lanes all. Of a scan they cost nothing but
//! the search for a way out while the robot's centre is in a keepout zone.

use super::Mapper;
use crate::clearance::ClearanceField;
use crate::rows_around::cell_at;
use crate::zone_paint::cells_on;
use nalgebra::Point2;
use zeronav_msgs::way_out::WayOut;
use zeronav_msgs::{Cell, CellRect, ZoneSet};

impl Mapper {
    /// Takes in zones in place of those before.
    pub fn set_zones(&mut self, set: &ZoneSet) {
        let rects = self.zones.take(set, &self.geometry);
        let mut changed = Vec::new();
        for rect in &rects {
            self.zones
                .mark(rect, &self.geometry, |index| changed.push(index));
        }
        self.repaint(&changed);
        self.zones.clear_if_blank();
    }

    /// Opens the way out for a robot whose centre is in a keepout zone, and closes it when the robot
    /// has `room_m` around it again; the way is `radius_m` wide on either side. [m]
    pub fn let_out(&mut self, robot: Point2<f64>, room_m: f64, radius_m: f64) {
        if self.zones.is_blank() {
            return;
        }
        let belief = &self.belief;
        let is_free = |index| !belief.is_obstacle(index);
        let wanted = (self.zones).wanted(&self.geometry, robot, (room_m, radius_m), is_free);
        let open = self.zones.way_out();
        if wanted == open {
            return;
        }
        self.zones.open(wanted);
        let mut changed = Vec::new();
        for way in [open, wanted].into_iter().flatten() {
            let CellRect { min, max } = cells_on(&way, &self.geometry);
            for y in min.y..max.y {
                let cells = (min.x..max.x).map(|x| Cell::new(x, y));
                changed.extend(cells.filter_map(|cell| self.geometry.index_of(cell)));
            }
        }
        self.repaint(&changed);
    }

    /// Clearance of every cell to the obstacles of the world alone, row-major; `None` without zones, where it
    /// is that of the cells. [mm]
    pub(crate) fn clearance_without_zones(&self) -> Option<Vec<u16>> {
        if self.zones.is_blank() {
            return None;
        }
        let limit_cells = f64::from(self.clearance_limit_mm) / 1000.0 / self.geometry.resolution_m;
        let mut world = ClearanceField::new(&self.geometry, limit_cells);
        for index in 0..self.geometry.len() {
            world.set(index, self.belief.is_obstacle(index));
        }
        world.recompute_all();
        let squares = world.squares().iter();
        Some(squares.map(|square| self.values.get(*square).0).collect())
    }

    /// The way out of a keepout zone that is open.
    #[must_use]
    pub fn way_out(&self) -> Option<WayOut> {
        self.zones.way_out()
    }

    /// True for a cell that is an obstacle to planners: one of the world, or of a keepout zone.
    pub(super) fn is_closed(&self, index: usize) -> bool {
        self.belief.is_obstacle(index) || self.zones.closes(index, &self.geometry)
    }

    /// Brings clearance and cells up to date with the marks of these cells.
    fn repaint(&mut self, changed: &[usize]) {
        let (mut closed, mut opened) = (Vec::new(), Vec::new());
        for index in changed {
            let (is, was) = (self.is_closed(*index), self.clearance.is_obstacle(*index));
            if is == was {
                continue;
            }
            let cell = cell_at(&self.geometry, *index);
            self.clearance.set(*index, is);
            self.flipped.add(cell);
            // Many at once: whole windows are recomputed, whichever way they flipped.
            self.cleared.add(cell);
            if is { &mut closed } else { &mut opened }.push(*index);
        }
        if let Some(regulariser) = &mut self.regulariser {
            regulariser.changed(&closed, &opened);
        }
        self.follow_clearance(&[]);
        for index in changed {
            self.refresh_cell(*index, cell_at(&self.geometry, *index));
        }
    }
}
