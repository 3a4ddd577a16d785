//! What clients make of run time: held, or at a speed.

use super::pace::Speed;

/// Whether run time is held, and how fast lockstep goes otherwise.
#[derive(Debug, Default)]
pub(super) struct RunTime {
    pub(super) is_paused: bool,
    /// The tick at which a paused lockstep robot waits.
    pub(super) hold_tick: u64,
    pub(super) speed: Speed,
}

impl RunTime {
    /// Held before this tick from the start on, if there is one.
    pub(super) fn held_before(tick: Option<u64>) -> Self {
        Self {
            is_paused: tick.is_some(),
            hold_tick: tick.map_or(0, |tick| tick.saturating_sub(1)),
            speed: Speed::default(),
        }
    }
}
