//! Weights of the heuristic: one, fixed, or by the distance to the nearest obstacle.

use crate::papers::field::Field;
use zeronav_msgs::Cell;
use zeronav_params::parameters;

/// Largest fixed weight of the heuristic.
pub(crate) const WEIGHT_MAX: f64 = 10.0;

/// Largest [`EtaOptions::p0_cells`].
pub(crate) const P0_CELLS_MAX: f64 = 12.0;

parameters! {
    /// `zm_im`: the weight of the heuristic by the distance to the nearest obstacle, [ZM] eq. (5).
    #[derive(Copy)]
    pub struct EtaOptions {
        /// Gain of the emergency zone.
        alpha: f64 = 2.0, [0.0, 5.0];
        /// Slope of the mild zone. Continuous with the emergency zone when it is
        /// `alpha^2 exp(-P0 (1 - 1/alpha)) / P0`.
        beta: f64 = 0.2975, [0.0, 5.0] "1/cell";
        /// Distance beyond which obstacles do not count.
        p0_cells: f64 = 3.0, [0.1, P0_CELLS_MAX] "cells";
        /// Side of a cell of the paper, where those of the map are finer: all distances are measured
        /// in it, by the clearance of the map, whose limit must then lie above P0
        /// (`mapping.clearance_limit_m`). 0 = cells are those of the map.
        cell_m: f64 = 0.0, [0.0, 10.0] "m";
        /// In place of eq. (5) `alpha (1 - x / P0)^2`, which decreases and is continuous.
        monotone: bool = false;
    }
}

/// The factor of the heuristic at a cell, >= 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Weight {
    /// 1: plain A*.
    One,
    /// The same everywhere (ZM-HW).
    Fixed(f64),
    /// `exp(eta)` of the distance to the nearest obstacle (ZM-IM).
    Eta(EtaOptions),
}

impl Weight {
    /// The weight at `cell`.
    #[must_use]
    pub(crate) fn at(&self, field: &Field<'_>, cell: Cell) -> f64 {
        match self {
            Self::One => 1.0,
            Self::Fixed(weight) => *weight,
            Self::Eta(options) => {
                let x = if options.cell_m > 0.0 {
                    let known = field.map.get(cell);
                    known.map(|cell| cell.clearance_m() / options.cell_m)
                } else {
                    obstacle_distance(field, cell, options.p0_cells)
                };
                x.map_or(1.0, |x| options.eta(x).exp())
            }
        }
    }

    /// Largest weight of any cell: the path costs at most this many times the optimum.
    #[must_use]
    #[cfg(test)]
    pub(crate) fn max(&self) -> f64 {
        match self {
            Self::One => 1.0,
            Self::Fixed(weight) => *weight,
            Self::Eta(options) => options.eta_max().exp(),
        }
    }
}

impl EtaOptions {
    /// \[ZM\] eq. (5) at the distance `x` > 0 to the nearest obstacle. [cells]
    #[must_use]
    pub fn eta(&self, x: f64) -> f64 {
        let p0 = self.p0_cells;
        if x > p0 {
            0.0
        } else if self.monotone {
            self.alpha * (1.0 - x / p0).powi(2)
        } else if x * self.alpha <= p0 {
            // The "emergency zone" ends at P0 / alpha.
            self.alpha * (-(x - p0).abs()).exp()
        } else {
            self.beta * x
        }
    }

    /// An upper bound of [`Self::eta`].
    #[must_use]
    pub fn eta_max(&self) -> f64 {
        if self.monotone {
            return self.alpha;
        }
        let (alpha, p0) = (self.alpha, self.p0_cells);
        let mild_zone = if alpha > 1.0 { self.beta * p0 } else { 0.0 };
        let end = if alpha > 1.0 { p0 / alpha } else { p0 };
        (alpha * (end - p0).exp()).max(mild_zone)
    }
}

/// Distance between the centres of `cell` and of the nearest obstacle, `None` beyond `limit`. The
/// edge of the map is no obstacle. [cells]
///
/// Only distances up to the limit matter, a few cells, so a window is looked at when a node asks;
/// a field over the whole map would cost more than the search it serves.
#[must_use]
pub(crate) fn obstacle_distance(field: &Field<'_>, cell: Cell, limit: f64) -> Option<f64> {
    let limit = limit.min(P0_CELLS_MAX);
    let mut nearest = f64::INFINITY;
    let mut ring = 1_i32;
    while f64::from(ring) <= limit.min(nearest) {
        for along in -ring..=ring {
            for (x, y) in [(along, ring), (along, -ring), (ring, along), (-ring, along)] {
                let at = Cell::new(cell.x + x, cell.y + y);
                if field.map.geometry.contains(at) && !field.is_free(at) {
                    nearest = nearest.min(f64::from(x).hypot(f64::from(y)));
                }
            }
        }
        ring += 1;
    }
    (nearest <= limit).then_some(nearest)
}
