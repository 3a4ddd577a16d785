//! `zm_rv` [ZM]: sideways repulsion from what approaches, on top of `zm_rep`.

use super::law::{Law, LawInput, Push};
use super::potential::{Gains, velocity_repulsion};
use super::zm_rep::ZmRep;
use nalgebra::Vector2;

/// `F = F_zm_rep + sum F_rv`.
#[derive(Debug, Clone)]
pub struct ZmRv {
    field: ZmRep,
    /// Gain of the relative velocity (`eta_v`).
    gain: f64,
    reach: f64,
}

impl ZmRv {
    /// The field with these gains and the gain `eta_v`.
    #[must_use]
    pub const fn new(gains: Gains, gain: f64) -> Self {
        Self {
            field: ZmRep::new(gains),
            gain,
            reach: gains.reach,
        }
    }
}

impl Law for ZmRv {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let sideways = input.bodies.iter().fold(Vector2::zeros(), |sum, body| {
            sum + velocity_repulsion(self.gain, self.reach, input.at, input.velocity, body)
        });
        match self.field.push(input) {
            Push::Along(force) => Push::Along(force + sideways),
            Push::Stuck => Push::Stuck,
        }
    }
}
