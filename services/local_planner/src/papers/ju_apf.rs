//! `ju_apf` [JU]: the plain artificial potential field, and `lwx_apf` [LWX], the same with the
//! gains of that paper.

use super::law::{Law, LawInput, Push};
use super::potential::{Gains, all_repulsions, attraction};

/// `F = F_att + sum F_rep`.
#[derive(Debug, Clone)]
pub struct JuApf {
    gains: Gains,
}

impl JuApf {
    /// The field with these gains.
    #[must_use]
    pub const fn new(gains: Gains) -> Self {
        Self { gains }
    }
}

impl Law for JuApf {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let pull = attraction(self.gains.attract, input.at, input.goal);
        Push::Along(pull + all_repulsions(&self.gains, input))
    }
}
