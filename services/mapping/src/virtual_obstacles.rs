//! Virtual obstacles: cells that are free and yet not to be used.
//!
//! *Full inflation* (BAO-FULL) puts a ring around every obstacle. The *corner rule* of the planners
//! (BAO-AAO) forbids a diagonal move past an obstacle; the cells that such moves would enter are
//! flagged for whoever shows or counts them, the rule itself stays in the planners.

use crate::error::{MappingError, ensure};
use serde::{Deserialize, Serialize};
use zeronav_msgs::{Cell, GridGeometry};

/// Largest radius of the ring. [cells]
pub const RING_CELLS_MAX: i32 = 8;

/// Which cells are virtual obstacles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VirtualKind {
    /// None.
    #[default]
    Off,
    /// Those near an obstacle.
    Ring,
    /// Those that a diagonal move past an obstacle would enter.
    Corners,
}

/// What near is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RingShape {
    /// Steps in eight directions.
    #[default]
    EightNeighbour,
    /// Steps in four directions.
    FourNeighbour,
}

/// Configuration of the virtual obstacles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VirtualConfig {
    /// Which cells.
    pub kind: VirtualKind,
    /// Radius of the ring, 1 to [`RING_CELLS_MAX`]. [cells]
    pub radius_cells: i32,
    /// Shape of the ring.
    pub shape: RingShape,
}

impl Default for VirtualConfig {
    fn default() -> Self {
        Self {
            kind: VirtualKind::Off,
            radius_cells: 1,
            shape: RingShape::EightNeighbour,
        }
    }
}

impl VirtualConfig {
    /// Accepts radii that can be.
    ///
    /// # Errors
    /// [`MappingError::OutOfRange`].
    pub fn check(&self) -> Result<(), MappingError> {
        ensure(
            (1..=RING_CELLS_MAX).contains(&self.radius_cells),
            "virtual_obstacles.radius_cells",
            f64::from(self.radius_cells),
            "must be 1 to 8",
        )
    }

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
