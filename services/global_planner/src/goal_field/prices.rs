//! What it costs to enter the cells, a byte each, and a cell's neighbours in one number.
//!
//! Apart from what a search writes: an expansion looks at eight prices, which lie in three cache
//! lines, and touches only the nodes that it may improve.

use super::node::Spot;
pub(super) use crate::planner::BLOCKED;
use crate::planner::Unknown;
use zeronav_casts::low_u8;
use zeronav_msgs::MapView;

/// Bytes behind the last cell, so that a row of neighbours can be read as four.
const TAIL: usize = 4;

/// See the module's description. Blocked border of one cell.
#[derive(Debug, Default)]
pub(super) struct Prices {
    cells: Vec<u8>,
    width: u32,
}

impl Prices {
    /// Becomes those of `map`; `width` and the number of spots are padded.
    pub(super) fn reset(&mut self, map: &MapView<'_>, unknown: Unknown, width: u32, n: usize) {
        self.width = width;
        self.cells.clear();
        self.cells.resize(n + TAIL, BLOCKED);
        let rows = map.cells.chunks_exact(map.geometry.width.max(1) as usize);
        let padded = self.cells.chunks_exact_mut(width as usize).skip(1);
        for (row, prices) in rows.zip(padded) {
            for (cell, price) in row.iter().zip(&mut prices[1..]) {
                *price = unknown.cost(*cell);
            }
        }
    }

    #[inline]
    pub(super) fn at(&self, spot: Spot) -> u8 {
        self.cells[spot as usize]
    }

    /// None outside the array.
    #[inline]
    pub(super) fn get(&self, spot: Spot) -> Option<u8> {
        self.cells.get(spot as usize).copied()
    }

    pub(super) fn row_mut(&mut self, first: usize, n: usize) -> &mut [u8] {
        &mut self.cells[first..first + n]
    }

    /// The price of the cell itself, and those of its neighbours, a byte for each of
    /// [`crate::moves::STEPS`], the first lowest.
    #[inline]
    pub(super) fn around(&self, spot: Spot) -> (u8, u64) {
        let three = |spot: Spot| {
            let cells = &self.cells[spot as usize..];
            cells
                .first_chunk::<4>()
                .map_or(u32::MAX, |cells| u32::from_le_bytes(*cells))
        };
        let west = spot.wrapping_sub(1);
        let below = u64::from(three(west.wrapping_sub(self.width)));
        let here = u64::from(three(west));
        let above = three(west.wrapping_add(self.width));
        // Counter-clockwise from east: the row above runs against the bytes.
        let above = u64::from(above.swap_bytes() & 0xffff_ff00);
        let around = here >> 16 & 0xff | above | (here & 0xff) << 32 | below << 40;
        let own = low_u8(here >> 8);
        (own, around)
    }

    pub(super) fn bytes(&self) -> usize {
        self.cells.capacity()
    }
}

/// True for the neighbour in direction `step` of [`Prices::around`] when it may not be entered.
#[inline]
pub(super) const fn is_blocked(around: u64, step: u32) -> bool {
    around >> (8 * (step & 7)) & 0xff == BLOCKED as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moves::STEPS;
    use zeronav_msgs::{GridGeometry, MapCell};

    #[test]
    fn neighbours_stand_in_the_order_of_the_steps() {
        let geometry = GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 1.0,
            width: 5,
            height: 4,
        };
        let cells: Vec<MapCell> = (0..20)
            .map(|cost| MapCell {
                cost,
                flags: 0,
                clearance_mm: 1000,
            })
            .collect();
        let map = MapView {
            geometry: &geometry,
            cells: &cells,
        };
        let mut prices = Prices::default();
        prices.reset(&map, Unknown::Free, 7, 7 * 6);
        for y in 0..4_i32 {
            for x in 0..5_i32 {
                let spot = ((y + 1) * 7 + x + 1).cast_unsigned();
                let (own, around) = prices.around(spot);
                assert_eq!(i32::from(own), y * 5 + x);
                for (n, (dx, dy)) in STEPS.iter().enumerate() {
                    let (x, y) = (x + dx, y + dy);
                    let inside = (0..5).contains(&x) && (0..4).contains(&y);
                    let expected = if inside {
                        y * 5 + x
                    } else {
                        i32::from(BLOCKED)
                    };
                    assert_eq!((around >> (8 * n) & 0xff) as i32, expected, "{x}, {y}");
                }
            }
        }
    }
}
