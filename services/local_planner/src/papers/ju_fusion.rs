//! `ju_fusion` [JU]: the path's points around the robot attract as well as the goal does.

use super::law::{Law, LawInput, Push};
use super::potential::{Gains, all_repulsions, attraction};
use super::route::Route;
use nalgebra::Vector2;

/// [m] between points of the path, the side of the paper's cells.
const POINT_M: f64 = 1.0;

/// [m] around the robot within which points attract (`r1`).
const R1_M: f64 = 1.5;

/// The fused field: `F_att(goal) + sum over path points F_att + sum over obstacles F_rep`, the
/// sums restarted in every step, the goal's part included.
#[derive(Debug, Clone)]
pub struct JuFusion {
    gains: Gains,
    route: Route,
    /// Every attraction is a unit vector times the gain, so that the far goal does not drown the
    /// path.
    normalised: bool,
}

impl JuFusion {
    /// The field with these gains.
    #[must_use]
    pub fn new(gains: Gains, normalised: bool) -> Self {
        Self {
            gains,
            route: Route::default(),
            normalised,
        }
    }

    fn pull(&self, from: nalgebra::Point2<f64>, to: nalgebra::Point2<f64>) -> Vector2<f64> {
        let pull = attraction(self.gains.attract, from, to);
        if self.normalised {
            pull.try_normalize(1.0e-9)
                .map_or_else(Vector2::zeros, |unit| unit * self.gains.attract)
        } else {
            pull
        }
    }

    /// Sum of the attractions of the path's points that are near and ahead by the progress along
    /// the path (the printed `x_p > x_r` is right for goals to the right alone).
    #[must_use]
    pub fn path_pull(&mut self, input: &LawInput<'_>) -> Vector2<f64> {
        let Some(place) = self.route.place(input) else {
            return Vector2::zeros();
        };
        let mut sum = Vector2::zeros();
        let mut arc_m = (place.arc_m / POINT_M).floor() * POINT_M + POINT_M;
        let until_m = place.arc_m + 2.0 * R1_M;
        while arc_m <= until_m.min(self.route.length()) {
            let point = self.route.at(input, arc_m);
            if (point - input.at).norm() < R1_M {
                sum += self.pull(input.at, point);
            }
            arc_m += POINT_M;
        }
        sum
    }
}

impl Law for JuFusion {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let path = self.path_pull(input);
        let goal = self.pull(input.at, input.goal);
        Push::Along(path + goal + all_repulsions(&self.gains, input))
    }
}
