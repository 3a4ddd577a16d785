//! JU with movers: fifty single cells of 15 m x 15 m and three discs that cross the map. The paper
//! says that its method avoids what moves and reports no experiment.

use super::blocks::{Blocks, LIMIT_S, Plan};
use super::{Scene, disc};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use zeronav_world::generate::GenerateError;
use zeronav_world::spec::Family;

/// Cells along each side of the map; start and goal are (1, 1) and (11, 11) of the paper.
const SIDE: u32 = 15;

/// Blocked cells of the paper.
const N_BLOCKED: f64 = 50.0;

/// Radius of the robot, and of a disc. [m]
const ROBOT_M: f64 = 0.25;
const DISC_M: f64 = 0.25;

/// Speed of a disc. [m/s]
const SPEED_MPS: f64 = 0.3;

/// The scene of a seed.
///
/// # Errors
/// When none of many maps can be crossed.
pub fn ju_dyn(seed: u64) -> Result<Scene, GenerateError> {
    let mut rng = Pcg64Mcg::seed_from_u64(0x0000_7000 + seed);
    let blocks = Blocks::new(Plan {
        family: Family::Iid,
        side: SIDE,
        ratio: N_BLOCKED / f64::from(SIDE * SIDE),
        start: [1, 1],
        goal: [11, 11],
        seed,
        limit_s: LIMIT_S,
    })?;
    let mut text = blocks.text(&format!("JU with movers {seed}"), ROBOT_M, None);
    let [start, goal] = blocks.ends_m();
    let free: Vec<[f64; 2]> = blocks
        .cells()
        .filter(|cell| blocks.is_free(*cell))
        .map(super::blocks::middle)
        .filter(|[x, y]| {
            [start, goal]
                .iter()
                .all(|[ex, ey]| (x - ex).hypot(y - ey) > 2.5)
        })
        .collect();
    for index in 1..=3 {
        let place = free[rng.random_range(0..free.len())];
        // Across the way from start to goal, to either side.
        let side = if rng.random::<bool>() { 1.0 } else { -1.0 };
        let along_mps = SPEED_MPS * side / core::f64::consts::SQRT_2;
        let script = format!("bounces_mps = [{along_mps:.4}, {:.4}]", -along_mps);
        text += &disc(&format!("disc {index}"), place, DISC_M, &script);
    }
    Ok(Scene { text })
}
