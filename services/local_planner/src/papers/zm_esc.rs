//! `zm_esc` [ZM]: leaves local minima of the plain field.

use super::escape::Escape;
use super::law::{Law, LawInput, Push};
use super::options::ZmEscConfig;
use super::potential::{Gains, all_repulsions, attraction};

/// The plain field with escapes.
#[derive(Debug, Clone)]
pub struct ZmEsc {
    gains: Gains,
    escape: Escape,
}

impl ZmEsc {
    /// The field with these gains.
    #[must_use]
    pub fn new(config: &ZmEscConfig) -> Self {
        Self {
            gains: config.gains(),
            escape: Escape::new(config.escape_m, config.tries),
        }
    }

    /// Escapes begun towards this goal.
    #[must_use]
    pub const fn escapes(&self) -> u32 {
        self.escape.escapes()
    }

    /// True while an escape is under way.
    #[must_use]
    pub const fn is_escaping(&self) -> bool {
        self.escape.is_running()
    }
}

impl Law for ZmEsc {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let pull = attraction(self.gains.attract, input.at, input.goal);
        let repel = all_repulsions(&self.gains, input);
        self.escape
            .push(input, (pull, repel), 1.0e-3 * self.gains.attract)
    }

    fn escapes_minima(&self) -> bool {
        true
    }
}
