//! Estimates of the way that is left, PAPERS 0.3.

use crate::moves::octile_cells;
use crate::papers::field::distance;
use zeronav_msgs::Cell;
use zeronav_params::choices;

choices! {
    /// An estimate of the cost between two cells. [cells]
    pub enum Heuristic {
        /// 0: Dijkstra's algorithm.
        Zero = "zero",
        /// Straight distance; admissible and consistent.
        #[default]
        Euclid = "euclid",
        /// Exact on an empty grid, [BAO] eq. (8); admissible and consistent.
        Octile = "octile",
        /// dx + dy: too large by up to sqrt 2 where diagonal steps are allowed, so not admissible.
        Manhattan = "manhattan",
    }
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
