//! `zm_full` [ZM]: the whole local method, repulsion with the gain eta (eq. 5 to 8), escape (eq. 9)
//! and relative velocity (eq. 10, 11), each as its own part restates it.

use super::escape::Escape;
use super::law::{Law, LawInput, Push};
use super::options::ZmFullConfig;
use super::potential::{Eta, attraction, eta_repulsion, velocity_repulsion};
use nalgebra::Vector2;

/// `F = F_att + sum (F_rep1 + F_rep2) + sum F_rv`, with `F_esp = R(+-90 deg) F_rep + F_att` in place of
/// the first two where they cancel.
#[derive(Debug, Clone)]
pub struct ZmFull {
    config: ZmFullConfig,
    escape: Escape,
}

impl ZmFull {
    /// The method with these gains.
    #[must_use]
    pub fn new(config: &ZmFullConfig) -> Self {
        Self {
            config: *config,
            escape: Escape::new(config.escape_m, config.tries),
        }
    }

    /// Escapes begun towards this goal.
    #[must_use]
    pub const fn escapes(&self) -> u32 {
        self.escape.escapes()
    }
}

impl Law for ZmFull {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let config = &self.config;
        let eta = Eta {
            alpha: config.alpha,
            beta: config.beta,
            p0: config.p0_m,
            is_differentiated: config.full_gradient,
        };
        let mut repel = Vector2::zeros();
        let mut sideways = Vector2::zeros();
        for body in input.bodies {
            let from = body.nearest(input.at, input.literal);
            repel += eta_repulsion(&eta, config.n, input.at, from, input.goal);
            sideways +=
                velocity_repulsion(config.velocity, config.p0_m, input.at, input.velocity, body);
        }
        let pull = attraction(config.attract, input.at, input.goal);
        match self
            .escape
            .push(input, (pull, repel), 1.0e-3 * config.attract)
        {
            Push::Along(force) => Push::Along(force + sideways),
            Push::Stuck => Push::Stuck,
        }
    }

    fn escapes_minima(&self) -> bool {
        true
    }
}
