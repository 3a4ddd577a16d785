//! What ends a search before it has an answer.

use crate::planner::{Control, Expansions};
use crate::search::Found;

/// The budget and the proof that there is no path.
pub(crate) struct Limits<'a> {
    pub(crate) budget: &'a mut dyn FnMut(Expansions) -> Control,
    /// False when it is proved that the goal cannot be reached.
    pub(crate) may_reach: &'a mut dyn FnMut(u64) -> bool,
}

impl Limits<'_> {
    /// How the search ends after this many expansions, if it does. Checks the budget every `EVERY`
    /// expansions.
    #[inline]
    pub(crate) fn ended<const EVERY: u64>(&mut self, expanded: u64) -> Option<Found> {
        if expanded.is_multiple_of(EVERY) && (self.budget)(Expansions(expanded)) == Control::Stop {
            Some(Found::Stopped)
        } else if (self.may_reach)(expanded) {
            None
        } else {
            Some(Found::Nothing)
        }
    }
}
