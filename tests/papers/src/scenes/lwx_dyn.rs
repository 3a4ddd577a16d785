//! LWX-DYN: twenty discs, none within two cells of start or goal, in blocks over 15 % of the map.

use super::blocks::{Blocks, LIMIT_S, Plan, middle};
use super::{Scene, disc};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use zeronav_msgs::Cell;
use zeronav_world::generate::GenerateError;
use zeronav_world::spec::Family;

/// Cells along each side of the map.
const SIDE: u32 = 20;

/// Radius of the robot and of a disc. [m]
const RADIUS_M: f64 = 0.3;

/// Top speed of the robot, which those of the discs are a share of. [m/s]
const V_MPS: f64 = 0.9;

/// How the discs come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coming {
    /// Each at a random time within the first 30 s, to stay.
    Appear,
    /// There from the start; they move straight at 0.2 to 0.8 times the robot's speed and bounce
    /// off static obstacles.
    Move,
}

/// The scene of a seed.
///
/// # Errors
/// When none of many maps can be crossed.
pub fn lwx_dyn(coming: Coming, seed: u64) -> Result<Scene, GenerateError> {
    let mut rng = Pcg64Mcg::seed_from_u64(0x001b_d000 + seed);
    let blocks = Blocks::new(Plan {
        family: Family::Blocky { side_cells_max: 4 },
        side: SIDE,
        ratio: 0.15,
        start: [1, 1],
        goal: [SIDE - 2, SIDE - 2],
        seed,
        limit_s: LIMIT_S,
    })?;
    let title = format!("LWX-DYN {coming:?} {seed}");
    let mut text = blocks.text(&title, RADIUS_M, None);
    let ends = blocks.ends_m();
    let far = |cell: &Cell| {
        let [x, y] = middle(*cell);
        ends.iter()
            .all(|[ex, ey]| (x - ex).abs().max((y - ey).abs()) > 2.0)
    };
    let mut cells: Vec<Cell> = blocks.cells().collect();
    cells.retain(|cell| blocks.is_free(*cell) && far(cell));
    for index in 1..=20.min(cells.len()) {
        let cell = cells.swap_remove(rng.random_range(0..cells.len()));
        let script = match coming {
            Coming::Appear => {
                format!("appears = {{ at_s = {:.2} }}", rng.random_range(0.0..30.0))
            }
            Coming::Move => {
                let speed_mps: f64 = V_MPS * rng.random_range(0.2..0.8);
                let (sin, cos) = rng.random_range(0.0..core::f64::consts::TAU).sin_cos();
                format!(
                    "bounces_mps = [{:.4}, {:.4}]",
                    speed_mps * cos,
                    speed_mps * sin
                )
            }
        };
        text += &disc(&format!("disc {index}"), middle(cell), RADIUS_M, &script);
    }
    Ok(Scene { text })
}
