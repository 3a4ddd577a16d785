//! Why a newcomer fails, and whether the next run finds the same.

/// Why a newcomer fails.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Failure {
    /// In words.
    pub why: String,
    /// True when that is no question of what it sends: it died, took too long or had no room. Two lockstep
    /// runs may find that at different ticks, or one of them not at all.
    pub by_clock: bool,
}

impl Failure {
    /// For what the newcomer sends: every lockstep run finds it at the same tick.
    pub(crate) fn by_content(why: String) -> Self {
        Self {
            why,
            by_clock: false,
        }
    }

    /// For anything else.
    pub(crate) fn by_clock(why: String) -> Self {
        Self {
            why,
            by_clock: true,
        }
    }
}
