//! How scans change the belief in a cell.

use crate::error::{MappingError, ensure};
use serde::{Deserialize, Serialize};

/// Belief in a cell, in hundredths of the natural logarithm of the odds that it is occupied. A
/// scan changes a cell at most once, whatever the number of its beams.
///
/// With the defaults one hit marks a cell in the open, whatever was believed before, because the
/// belief in free space is limited; a cell that was hit once is free again after two scans that saw
/// through it, one that was hit for long after four: 0.4 s at 10 Hz. A cell that is hit in more
/// than a third of the scans stays marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LogOdds {
    /// Added by a hit, > 0. 85 is a probability of 0.70.
    pub hit: i16,
    /// Added by a beam that passed, < 0. -40 is a probability of 0.40.
    pub miss: i16,
    /// Lowest belief, below the threshold by less than a hit, so that a single hit marks.
    pub min: i16,
    /// Highest belief, above the threshold. It decides how long a vanished obstacle stays.
    pub max: i16,
    /// A belief above it makes an obstacle.
    pub occupied_above: i16,
}

impl Default for LogOdds {
    fn default() -> Self {
        Self {
            hit: 85,
            miss: -40,
            min: -40,
            max: 150,
            occupied_above: 0,
        }
    }
}

impl LogOdds {
    /// Accepts steps and limits that agree with each other.
    ///
    /// # Errors
    /// [`MappingError::OutOfRange`].
    pub(crate) fn check(&self) -> Result<(), MappingError> {
        let field = |field, value: i16, ok, rule| ensure(ok, field, f64::from(value), rule);
        let range = -10_000..=10_000;
        field(
            "log_odds.hit",
            self.hit,
            self.hit > 0 && range.contains(&self.hit),
            "must be 1 to 10000",
        )?;
        field(
            "log_odds.miss",
            self.miss,
            self.miss < 0 && range.contains(&self.miss),
            "must be -10000 to -1",
        )?;
        field(
            "log_odds.occupied_above",
            self.occupied_above,
            range.contains(&self.occupied_above),
            "must be -10000 to 10000",
        )?;
        field(
            "log_odds.min",
            self.min,
            range.contains(&self.min)
                && self.min < self.occupied_above
                && self.min + self.hit > self.occupied_above,
            "must be below occupied_above by less than one hit",
        )?;
        field(
            "log_odds.max",
            self.max,
            range.contains(&self.max) && self.max > self.occupied_above,
            "must be above occupied_above and at most 10000",
        )
    }
}
