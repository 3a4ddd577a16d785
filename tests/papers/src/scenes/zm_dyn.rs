//! ZM's dynamic scenes: an obstacle appears in one cell when the robot is four cells away.

use super::Scene;
use super::blocks::{Blocks, LIMIT_S, Plan, middle};
use zeronav_msgs::Cell;
use zeronav_world::generate::GenerateError;
use zeronav_world::spec::Family;

/// Cells along each side of the map.
const SIDE: u32 = 20;

/// Radius of the robot. [m]
const ROBOT_M: f64 = 0.25;

/// Where the obstacle appears, counted from 1 as printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ZmScene {
    /// Table 2: (12, 7).
    Table2,
    /// Table 3: (5, 5).
    Table3,
}

impl ZmScene {
    /// The cell, counted from 0.
    #[must_use]
    pub const fn cell(self) -> Cell {
        match self {
            Self::Table2 => Cell::new(11, 6),
            Self::Table3 => Cell::new(4, 4),
        }
    }
}

/// The scene of a seed; `None` when the cell of the obstacle is blocked anyway.
///
/// # Errors
/// When none of many maps can be crossed.
pub fn zm_dyn(scene: ZmScene, ratio: f64, seed: u64) -> Result<Option<Scene>, GenerateError> {
    let blocks = Blocks::new(Plan {
        family: Family::Blocky { side_cells_max: 4 },
        side: SIDE,
        ratio,
        start: [0, 0],
        goal: [SIDE - 1, SIDE - 1],
        seed,
        limit_s: LIMIT_S,
    })?;
    if !blocks.is_free(scene.cell()) {
        return Ok(None);
    }
    let text = blocks.text(&format!("ZM {scene:?} {seed}"), ROBOT_M, None);
    let [x, y] = middle(scene.cell());
    // As large as its cell, but for a crack that keeps it off its neighbours.
    let text = format!(
        "{text}[[world.obstacles]]\nname = \"obstacle\"\n\
         shape = {{ kind = \"box\", centre_m = [{x}, {y}], size_m = [0.98, 0.98] }}\n\
         appears = {{ robot_near = {{ point_m = [{x}, {y}], distance_m = 4.0 }} }}\n"
    );
    Ok(Some(Scene { text }))
}
