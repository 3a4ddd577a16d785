//! Virtual obstacles: cells that are free and yet not to be used.
//!
//! *Full inflation* (BAO-FULL) puts a ring around every obstacle. The *corner rule* of the planners
//! (BAO-AAO) forbids a diagonal move past an obstacle; the cells that such moves would enter are
//! flagged for display and counting; the rule itself stays in the planners.

use zeronav_msgs::{Cell, GridGeometry};
use zeronav_params::{choices, parameters};

/// Largest radius of the ring. [cells]
pub const RING_CELLS_MAX: i32 = 8;

choices! {
    /// Which cells are virtual obstacles.
    pub enum VirtualKind {
        /// None.
        #[default]
        Off = "off",
        /// Those near an obstacle.
        Ring = "ring",
        /// Those that a diagonal move past an obstacle would enter.
        Corners = "corners",
    }
}

choices! {
    /// Which cells are near.
    pub enum RingShape {
        /// Steps in eight directions.
        #[default]
        EightNeighbour = "eight_neighbour",
        /// Steps in four directions.
        FourNeighbour = "four_neighbour",
    }
}

parameters! {
    /// Configuration of the virtual obstacles.
    #[derive(Copy, Eq)]
    pub struct VirtualConfig {
        /// Which cells are virtual obstacles.
        kind: VirtualKind = VirtualKind::Off;
        /// Radius of the ring.
        radius_cells: i32 = 1, [1, RING_CELLS_MAX] "cells";
        /// Shape of the ring.
        shape: RingShape = RingShape::EightNeighbour;
    }
}

impl VirtualConfig {
    /// How far away an obstacle can make a cell virtual. [cells]
    #[must_use]
    pub fn reach(&self) -> i32 {
        match self.kind {
            VirtualKind::Off => 0,
            VirtualKind::Ring => self.radius_cells,
            // The obstacle beside the cell, and whether the one beside that is free.
            VirtualKind::Corners => 2,
        }
    }

    /// True when the cell is a virtual obstacle. Obstacles themselves are not.
    #[must_use]
    pub fn is_virtual(
        &self,
        geometry: &GridGeometry,
        cell: Cell,
        is_obstacle: impl Fn(usize) -> bool,
    ) -> bool {
        let at = |x: i32, y: i32| geometry.index_of(Cell::new(x, y));
        let blocked = |x: i32, y: i32| at(x, y).is_some_and(&is_obstacle);
        if self.kind == VirtualKind::Off || blocked(cell.x, cell.y) {
            return false;
        }
        if self.kind == VirtualKind::Corners {
            // From u = v + (a, b) to v: past u + (-a, 0) or u + (0, -b).
            let free = |x: i32, y: i32| at(x, y).is_some_and(|index| !is_obstacle(index));
            return [(1, 1), (1, -1), (-1, 1), (-1, -1)].iter().any(|(a, b)| {
                free(cell.x + a, cell.y + b)
                    && (blocked(cell.x, cell.y + b) || blocked(cell.x + a, cell.y))
            });
        }
        let r = self.radius_cells;
        (-r..=r).any(|dy| {
            let wide = match self.shape {
                RingShape::EightNeighbour => r,
                RingShape::FourNeighbour => r - dy.abs(),
            };
            (-wide..=wide).any(|dx| blocked(cell.x + dx, cell.y + dy))
        })
    }
}
