//! The same map on another grid: where the robot has gone, or that of another mapping.

use super::Mapper;
use crate::config::MappingConfig;
use crate::rows_around::cell_at;
use crate::scan_match::Surfaces;
use zeronav_casts::Cast;
use zeronav_msgs::{Cell, GridGeometry, MapView};

impl Mapper {
    /// The same map on another grid of the same resolution whose origin lies `shift` cells from
    /// this one's. What lies on both is kept; every tile is dirty.
    #[must_use]
    pub fn moved(&self, geometry: &GridGeometry, shift: Cell, config: &MappingConfig) -> Self {
        let belief = self.belief.moved(geometry, shift);
        let mut mapper = Self::around(geometry, belief, (self.cost_model, &self.zones), config);
        mapper.run_ns = self.run_ns;
        if let Some(surfaces) = &self.surfaces {
            let belief = &mapper.belief;
            let mut moved = Surfaces::new(geometry, |index| belief.is_obstacle(index));
            moved.take_over(surfaces, shift);
            mapper.surfaces = Some(moved);
            for (index, since_ns) in self.candidates.iter() {
                let cell = cell_at(&self.geometry, index);
                let there = Cell::new(cell.x - shift.x, cell.y - shift.y);
                if let Some(index) = geometry.index_of(there) {
                    mapper.candidates.add(index, since_ns);
                    if let Some(surfaces) = &mut mapper.surfaces {
                        surfaces.set(index, false);
                    }
                }
            }
        }
        mapper
    }

    /// This map with what another mapping has learnt: its map, on a grid of the same resolution
    /// and raster. Every tile is dirty; `None` when the grids do not fit.
    #[must_use]
    pub fn learnt(&self, map: &MapView<'_>, config: &MappingConfig) -> Option<Self> {
        let (own, other) = (&self.geometry, map.geometry);
        let same = (own.resolution_m - other.resolution_m).abs() <= f64::EPSILON;
        let cells = |from_m: f64, to_m: f64| (to_m - from_m) / own.resolution_m;
        let x = cells(own.origin_x_m, other.origin_x_m);
        let y = cells(own.origin_y_m, other.origin_y_m);
        let is_whole = |n: f64| (n - n.round()).abs() < 1.0e-3 && n.abs() < 1.0e6;
        if !same || !is_whole(x) || !is_whole(y) || map.cells.len() != other.len() {
            return None;
        }
        let shift = Cell::new(x.round().to_i32(), y.round().to_i32());
        let mut belief = self.belief.moved(other, shift);
        belief.learn(map.cells);
        Some(Self::around(
            other,
            belief,
            (self.cost_model, &self.zones),
            config,
        ))
    }
}
