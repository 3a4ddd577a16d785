//! `zm_rep` [ZM]: repulsion that fades at the goal, so that a goal beside an obstacle is reached.

use super::law::{Law, LawInput, Push};
use super::options::ZmRepConfig;
use super::potential::{Gains, all_goal_repulsions, attraction};

/// `F = F_att + sum (F_rep1 + F_rep2)`, with a constant gain.
#[derive(Debug, Clone)]
pub struct ZmRep {
    gains: Gains,
    n: i32,
}

impl ZmRep {
    /// The field with these gains.
    #[must_use]
    pub const fn new(config: &ZmRepConfig) -> Self {
        Self {
            gains: config.gains(),
            n: config.n,
        }
    }
}

impl Law for ZmRep {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let pull = attraction(self.gains.attract, input.at, input.goal);
        Push::Along(pull + all_goal_repulsions(&self.gains, self.n, input, input.goal))
    }
}
