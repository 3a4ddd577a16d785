//! What every planner is told about the map: the price of cost, and how far the robot may be led
//! out of the inflation.

/// Largest cost weight.
pub(crate) const COST_WEIGHT_MAX: f64 = 20.0;

/// Largest distance over which the robot is led out of the inflation. [m]
pub(crate) const ESCAPE_M_MAX: f64 = 5.0;

/// Both numbers, within their ranges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapOptions {
    cost_weight: f64,
    escape_m: f64,
}

impl MapOptions {
    /// Clamps both numbers to their ranges; NaN becomes 0.
    #[must_use]
    pub const fn new(cost_weight: f64, escape_m: f64) -> Self {
        Self {
            cost_weight: cost_weight.max(0.0).min(COST_WEIGHT_MAX),
            escape_m: escape_m.max(0.0).min(ESCAPE_M_MAX),
        }
    }

    /// A step costs its length times `1 + cost_weight * cost / 252`; 0 to 20.
    #[must_use]
    pub const fn cost_weight(self) -> f64 {
        self.cost_weight
    }

    /// How far a start inside the inflation may be led out of it, 0 to 5. [m]
    #[must_use]
    pub const fn escape_m(self) -> f64 {
        self.escape_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_clamped_and_nan_is_zero() {
        assert_eq!(MapOptions::new(f64::NAN, -1.0), MapOptions::new(0.0, 0.0));
        let most = MapOptions::new(f64::INFINITY, 1.0e9);
        assert!((most.cost_weight() - COST_WEIGHT_MAX).abs() < f64::EPSILON);
        assert!((most.escape_m() - ESCAPE_M_MAX).abs() < f64::EPSILON);
        let within = MapOptions::new(3.0, 0.6);
        assert!((within.cost_weight() - 3.0).abs() < f64::EPSILON);
        assert!((within.escape_m() - 0.6).abs() < f64::EPSILON);
    }
}
