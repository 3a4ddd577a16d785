//! `zm_rv` [ZM]: sideways repulsion from what approaches, on top of `zm_rep`.

use super::law::{Law, LawInput, Push};
use super::options::{ZmRepConfig, ZmRvConfig};
use super::potential::velocity_repulsion;
use super::zm_rep::ZmRep;
use nalgebra::Vector2;

/// `F = F_zm_rep + sum F_rv`.
#[derive(Debug, Clone)]
pub struct ZmRv {
    field: ZmRep,
    velocity: f64,
    reach: f64,
}

impl ZmRv {
    /// The field with these gains.
    #[must_use]
    pub const fn new(config: &ZmRvConfig) -> Self {
        let field = ZmRepConfig {
            attract: config.attract,
            repel: config.repel,
            reach_m: config.reach_m,
            n: config.n,
        };
        Self {
            field: ZmRep::new(&field),
            velocity: config.velocity,
            reach: config.reach_m,
        }
    }
}

impl Law for ZmRv {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let sideways = input.bodies.iter().fold(Vector2::zeros(), |sum, body| {
            sum + velocity_repulsion(self.velocity, self.reach, input.at, input.velocity, body)
        });
        match self.field.push(input) {
            Push::Along(force) => Push::Along(force + sideways),
            Push::Stuck => Push::Stuck,
        }
    }
}
