//! Parameters of the beam search.

use super::visited::WIDTH_MAX;
use zeronav_params::parameters;

parameters! {
    /// Parameters of the beam search in time.
    #[derive(Copy)]
    pub struct BeamConfig {
        /// Nodes that are kept of every layer.
        width: u32 = 120, [1, WIDTH_MAX];
        /// Manoeuvres in sequence.
        layers: u32 = 8, [1, 16];
        /// Duration of a manoeuvre.
        manoeuvre_s: f64 = 0.4, [0.1, 1.0] "s";
        /// Time after which the search is repeated.
        replan_s: f64 = 0.1, [0.0, 1.0] "s";
        /// Time from a choice to its effect, for which the robot goes on as it does.
        delay_s: f64 = 0.04, [0.0, 0.5] "s";
        /// Distance that is kept from predicted obstacles.
        margin_m: f64 = 0.05, [0.0, 1.0] "m";
        /// Distance beyond that within which predicted obstacles cost.
        near_m: f64 = 0.4, [0.01, 2.0] "m";
    }
    relations |own| {
        replan_s: own.replan_s <= own.manoeuvre_s, "must be at most manoeuvre_s";
    }
}
