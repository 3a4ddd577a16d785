//! The eight steps from a cell to its neighbours.

use zeronav_params::choices;

/// Offsets `(x, y)` of the steps; even numbers are straight, odd ones diagonal, counter-clockwise
/// from +x. `STEPS[(n + 4) % 8]` is the way back.
pub const STEPS: [(i32, i32); 8] = [
    (1, 0),
    (1, 1),
    (0, 1),
    (-1, 1),
    (-1, 0),
    (-1, -1),
    (0, -1),
    (1, -1),
];

choices! {
    /// Which cells are neighbours.
    pub enum Neighbours {
        /// Those that share an edge or a corner.
        #[default]
        Eight = "eight",
        /// Those that share an edge.
        Four = "four",
    }
}

impl Neighbours {
    /// True when step `n` of [`STEPS`] leads to one.
    #[must_use]
    pub const fn has(self, n: usize) -> bool {
        matches!(self, Self::Eight) || n.is_multiple_of(2)
    }
}

/// Integer cost of a straight step over free cells.
pub const STRAIGHT: u32 = 985;

/// Integer cost of a diagonal step. 1393 / 985 is sqrt 2 with a relative error of 3e-7, the best
/// of all fractions of this size.
pub const DIAGONAL: u32 = 1393;

/// Cost of the shortest way between two cells `dx` and `dy` apart when all cells are free. The
/// octile distance: admissible and consistent for every map.
#[must_use]
#[inline]
pub const fn octile(dx: u32, dy: u32) -> u32 {
    let (long, short) = if dx > dy { (dx, dy) } else { (dy, dx) };
    long * STRAIGHT + short * (DIAGONAL - STRAIGHT)
}

/// Length of the same way. [cells]
#[must_use]
pub fn octile_cells(dx: u32, dy: u32) -> f64 {
    let (long, short) = if dx > dy { (dx, dy) } else { (dy, dx) };
    f64::from(long - short) + core::f64::consts::SQRT_2 * f64::from(short)
}

/// Factor by which entering a cell of this cost is dearer than entering a free one.
/// Unknown cells that may be crossed count as free, blocked ones as the dearest.
#[must_use]
pub fn price(cost: u8, cost_weight: f64) -> f64 {
    match cost {
        u8::MAX => 1.0,
        cost => 1.0 + cost_weight * f64::from(cost.min(252)) / 252.0,
    }
}
