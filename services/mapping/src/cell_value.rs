//! From a distance to what the map says: clearance in millimetres and cost.
//!
//! Both are functions of the squared distance in half cells, which has few values: two tables.

use crate::clearance::FAR;
use crate::config::MappingConfig;
use zeronav_msgs::map::{COST_CIRCUMSCRIBED_MAX, COST_FREE, COST_INSCRIBED, COST_LETHAL};

/// What is lost in floating point must not cost a millimetre. [mm]
const ROUNDING_MM: f64 = 1.0e-6;

/// Clearance and cost of a known cell by its squared distance.
#[derive(Debug, Clone)]
pub(crate) struct ValueTable {
    /// `(clearance_mm, cost)`; the last entry stands for all larger squares.
    values: Vec<(u16, u8)>,
}

impl ValueTable {
    /// The table of a robot with this inscribed radius on cells of this size.
    ///
    /// Clearance is rounded down and ends at the limit. Cost is that of Nav2's inflation layer:
    /// 254 in obstacles, 253 where the clearance is at most the inscribed radius or less than that
    /// and the padding, then `252 exp(-k (clearance - inscribed - padding))` rounded down, 0 beyond
    /// the inflation radius. Nav2 measures from the obstacle's centre, we from its edge, so that
    /// costs reach half a cell further.
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "costs are 0 to 252, clearances at most the limit"
    )]
    pub(crate) fn new(config: &MappingConfig, inscribed_radius_m: f64, resolution_m: f64) -> Self {
        let limit_mm = clearance_limit_mm(config);
        let half_cells_max = 2.0 * config.clearance_limit_m / resolution_m;
        let last = (half_cells_max * half_cells_max).ceil().min(f64::from(FAR)) as i16;
        let value = |square: i16| {
            let clearance_m = f64::from(square).sqrt() / 2.0 * resolution_m;
            let clearance_mm = (clearance_m * 1000.0 + ROUNDING_MM) as u16;
            let beyond_m = clearance_m - inscribed_radius_m;
            let spare_m = beyond_m - config.padding_m;
            let cost = if square == 0 {
                COST_LETHAL
            } else if beyond_m * 1000.0 <= ROUNDING_MM || spare_m * 1000.0 < -ROUNDING_MM {
                COST_INSCRIBED
            } else if clearance_m * 1000.0 <= config.inflation_radius_m * 1000.0 + ROUNDING_MM {
                let fall = (-config.cost_scaling_factor * spare_m).exp();
                (f64::from(COST_CIRCUMSCRIBED_MAX) * fall) as u8
            } else {
                COST_FREE
            };
            (clearance_mm.min(limit_mm), cost)
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

/// Where clearance saturates. [mm]
#[must_use]
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "checked to be within 16 bits"
)]
pub(crate) fn clearance_limit_mm(config: &MappingConfig) -> u16 {
    (config.clearance_limit_m * 1000.0 + ROUNDING_MM) as u16
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
        ValueTable::new(&config, inscribed_radius_m, 0.05)
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
