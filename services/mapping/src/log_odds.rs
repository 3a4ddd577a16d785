//! How scans change the belief in a cell.

use zeronav_params::parameters;

parameters! {
    /// Belief in a cell, in hundredths of the natural logarithm of the odds that it is occupied. A
    /// scan changes a cell at most once, whatever the number of its beams.
    ///
    /// With the defaults one hit marks a cell in the open, whatever was believed before, because the
    /// belief in free space is limited; a cell that was hit once is free again after two scans that
    /// saw through it, one that was hit for long after four: 0.4 s at 10 Hz. A cell that is hit in
    /// more than a third of the scans stays marked.
    #[derive(Copy, Eq)]
    pub struct LogOdds {
        /// Added by a hit. 85 is a probability of 0.70.
        hit: i16 = 85, [1, 10_000];
        /// Added by a beam that passed. -40 is a probability of 0.40.
        miss: i16 = -40, [-10_000, -1];
        /// Lowest belief, below the threshold by less than a hit, so that a single hit marks.
        min: i16 = -40, [-10_000, 10_000];
        /// Highest belief. It decides how long a vanished obstacle stays.
        max: i16 = 150, [-10_000, 10_000];
        /// A belief above it makes an obstacle.
        occupied_above: i16 = 0, [-10_000, 10_000];
    }
    relations |own| {
        min: own.min < own.occupied_above
            && i32::from(own.min) + i32::from(own.hit) > i32::from(own.occupied_above),
            "must be below occupied_above by less than one hit";
        max: own.max > own.occupied_above, "must be above occupied_above";
    }
}
