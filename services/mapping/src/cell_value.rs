//! From a distance to what the map says: clearance in millimetres and cost.
//!
//! Both are functions of the squared distance in half cells, which has few values: two tables.

use crate::clearance::FAR;
use crate::config::MappingConfig;
use zeronav_casts::Cast;
use zeronav_msgs::map::{CostModel, clearance_mm};

/// Clearance and cost of a known cell by its squared distance.
#[derive(Debug, Clone)]
pub(crate) struct ValueTable {
    /// `(clearance_mm, cost)`; the last entry holds for all larger squares.
    values: Vec<(u16, u8)>,
}

impl ValueTable {
    /// The table of a cost model on cells of this size, for clearances up to `limit_mm`.
    #[must_use]
    pub(crate) fn new(model: &CostModel, limit_mm: u16, resolution_m: f64) -> Self {
        let half_cells_max = 2.0 * f64::from(limit_mm) / 1000.0 / resolution_m;
        let last = (half_cells_max * half_cells_max)
            .ceil()
            .min(f64::from(FAR))
            .to_i16();
        let value = |square: i16| {
            let clearance_m = f64::from(square).sqrt() / 2.0 * resolution_m;
            (clearance_mm(clearance_m, limit_mm), model.cost(clearance_m))
        };
        Self {
            values: (0..=last).map(value).collect(),
        }
    }

    /// Clearance [mm] and cost of a known cell at this squared distance. [half cells^2]
    #[must_use]
    #[inline]
    pub(crate) fn get(&self, square: i16) -> (u16, u8) {
        let last = self.values.len() - 1;
        self.values[usize::from(square.unsigned_abs()).min(last)]
    }
}

/// The costs that a configuration asks for around a robot with this inscribed radius.
#[must_use]
pub(crate) fn cost_model(config: &MappingConfig, inscribed_radius_m: f64) -> CostModel {
    CostModel {
        inscribed_radius_m,
        padding_m: config.padding_m,
        inflation_radius_m: config.inflation_radius_m,
        scaling_per_m: config.cost_scaling_factor,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> ValueTable {
        padded(0.0, 0.2)
    }

    fn padded(padding_m: f64, inscribed_radius_m: f64) -> ValueTable {
        let config = MappingConfig {
            padding_m,
            ..MappingConfig::default()
        };
        ValueTable::new(&cost_model(&config, inscribed_radius_m), 1000, 0.05)
    }

    #[test]
    fn values_by_hand() {
        let table = table();
        assert_eq!(table.get(0), (0, 254));
        // Beside the obstacle, past a corner of it, four cells away.
        assert_eq!(table.get(1), (25, 253));
        assert_eq!(table.get(2), (35, 253));
        assert_eq!(table.get(7 * 7), (175, 253));
        // 0.225 m: 252 exp(-0.1) = 228.02.
        assert_eq!(table.get(9 * 9), (225, 228));
        // 0.575 m: 252 exp(-1.5) = 56.2; 0.625 m is beyond the inflation radius.
        assert_eq!(table.get(23 * 23), (575, 56));
        assert_eq!(table.get(25 * 25), (625, 0));
        assert_eq!(table.get(39 * 39), (975, 0));
        assert_eq!(table.get(41 * 41), (1000, 0));
        assert_eq!(table.get(FAR), (1000, 0));
    }

    #[test]
    fn a_clearance_equal_to_the_radius_is_inscribed() {
        let table = padded(0.0, 0.225);
        assert_eq!(table.get(9 * 9), (225, 253));
        // 0.275 m: 252 exp(-0.2) = 206.3.
        assert_eq!(table.get(11 * 11), (275, 206));
    }

    #[test]
    fn a_clearance_equal_to_radius_and_padding_is_of_use() {
        let table = padded(0.025, 0.2);
        assert_eq!(table.get(8 * 8), (200, 253));
        assert_eq!(table.get(8 * 8 + 1), (201, 253));
        assert_eq!(table.get(9 * 9), (225, 252));
        // 0.275 m: 252 exp(-0.2) = 206.3.
        assert_eq!(table.get(11 * 11), (275, 206));
    }

    #[test]
    fn cost_never_rises_with_clearance() {
        let table = table();
        for square in 0..2000 {
            assert!(table.get(square + 1).1 <= table.get(square).1);
            assert!(table.get(square + 1).0 >= table.get(square).0);
        }
    }
}
