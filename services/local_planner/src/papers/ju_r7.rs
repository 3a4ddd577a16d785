//! `ju_r7` [JU, its reference 7]: the plain field towards a carrot on the path.

use super::law::{Law, LawInput, Push};
use super::options::JuR7Config;
use super::potential::{all_repulsions, attraction};
use super::route::Route;

/// The field towards the carrot, in the end towards the goal.
#[derive(Debug, Clone)]
pub struct JuR7 {
    config: JuR7Config,
    route: Route,
    /// [m] along the path, never falling.
    pub(crate) arc_m: f64,
}

impl JuR7 {
    /// The field with these gains.
    #[must_use]
    pub fn new(config: &JuR7Config) -> Self {
        Self {
            config: *config,
            route: Route::default(),
            arc_m: 0.0,
        }
    }

    /// Place along the path. [m]
    #[must_use]
    pub const fn arc_m(&self) -> f64 {
        self.arc_m
    }
}

impl Law for JuR7 {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let carrot = self.route.place(input).map_or(input.goal, |place| {
            self.arc_m = place.arc_m;
            self.route.ahead(input, &place, self.config.lookahead_m)
        });
        let gains = self.config.gains();
        let pull = attraction(gains.attract, input.at, carrot);
        Push::Along(pull + all_repulsions(&gains, input))
    }
}
