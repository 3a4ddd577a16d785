//! Estimates of the way that is left, PAPERS 0.3.

use crate::moves::octile_cells;
use crate::papers::field::distance;
use serde::{Deserialize, Serialize};
use zeronav_msgs::Cell;

/// An estimate of the cost between two cells. [cells]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Heuristic {
    /// 0: Dijkstra's algorithm.
    Zero,
    /// Straight distance; admissible and consistent.
    #[default]
    Euclid,
    /// Exact on an empty grid, [BAO] eq. (8); admissible and consistent.
    Octile,
    /// dx + dy: too large by up to sqrt 2 where diagonal steps are allowed, so not admissible.
    Manhattan,
}

impl Heuristic {
    /// The estimate.
    #[must_use]
    #[inline]
    pub fn between(self, one: Cell, other: Cell) -> f64 {
        let (dx, dy) = (one.x.abs_diff(other.x), one.y.abs_diff(other.y));
        match self {
            Self::Zero => 0.0,
            Self::Euclid => distance(one, other),
            Self::Octile => octile_cells(dx, dy),
            Self::Manhattan => f64::from(dx) + f64::from(dy),
        }
    }
}
