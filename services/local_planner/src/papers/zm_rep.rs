//! `zm_rep` [ZM]: repulsion that fades at the goal, so that a goal beside an obstacle is reached.

use super::law::{Law, LawInput, Push};
use super::potential::{Gains, all_goal_repulsions, attraction};

/// Exponent of the goal's distance in the repulsion; 1 in the paper.
const N: i32 = 1;

/// `F = F_att + sum (F_rep1 + F_rep2)`.
#[derive(Debug, Clone)]
pub struct ZmRep {
    gains: Gains,
}

impl ZmRep {
    /// The field with these gains.
    #[must_use]
    pub const fn new(gains: Gains) -> Self {
        Self { gains }
    }
}

impl Law for ZmRep {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let pull = attraction(self.gains.attract, input.at, input.goal);
        Push::Along(pull + all_goal_repulsions(&self.gains, N, input, input.goal))
    }
}
