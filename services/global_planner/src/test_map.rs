//! What tests of modules that are not public share: drawn numbers and a small map.

use zeronav_msgs::{GridGeometry, MapCell, MapView};

/// Numbers drawn from a seed.
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 33) % n
    }

    /// A coordinate of [`GEOMETRY`].
    pub(crate) fn coordinate(&mut self) -> i32 {
        i32::try_from(self.below(u64::from(SIDE))).unwrap()
    }
}

pub(crate) const SIDE: u32 = 40;

pub(crate) const GEOMETRY: GridGeometry = GridGeometry {
    origin_x_m: 0.0,
    origin_y_m: 0.0,
    resolution_m: 0.05,
    width: SIDE,
    height: SIDE,
};

pub(crate) const FREE: MapCell = MapCell {
    cost: 0,
    flags: 0,
    clearance_mm: 1000,
};

pub(crate) fn view(cells: &[MapCell]) -> MapView<'_> {
    MapView {
        geometry: &GEOMETRY,
        cells,
    }
}
