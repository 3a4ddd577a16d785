//! `ju_fusion` [JU]: the path's points around the robot attract as well as the goal does.

use super::law::{Law, LawInput, Push};
use super::options::JuFusionConfig;
use super::potential::{all_repulsions, attraction};
use super::route::{Nodes, Route};
use nalgebra::{Point2, Vector2};

/// The fused field: `F_att(goal) + sum over path points F_att + sum over obstacles F_rep`, the
/// sums restarted in every step, the goal's part included.
#[derive(Debug, Clone)]
pub struct JuFusion {
    config: JuFusionConfig,
    route: Route,
    nodes: Nodes,
}

impl JuFusion {
    /// The field with these gains.
    #[must_use]
    pub fn new(config: &JuFusionConfig) -> Self {
        Self {
            config: *config,
            route: Route::default(),
            nodes: Nodes::default(),
        }
    }

    fn pull(&self, from: Point2<f64>, to: Point2<f64>) -> Vector2<f64> {
        let gain = self.config.attract;
        let pull = attraction(gain, from, to);
        if self.config.normalised {
            pull.try_normalize(1.0e-9)
                .map_or_else(Vector2::zeros, |unit| unit * gain)
        } else {
            pull
        }
    }

    /// Sum of the attractions of the path's points that are near and ahead by the progress along
    /// the path (the printed `x_p > x_r` is right for goals to the right alone).
    #[must_use]
    pub fn path_pull(&mut self, input: &LawInput<'_>) -> Vector2<f64> {
        self.nodes.take(input, self.config.point_m);
        let Some(place) = self.route.place(input) else {
            return Vector2::zeros();
        };
        let near = |node: &Point2<f64>| (node - input.at).norm() < self.config.r1_m;
        let ahead = self.nodes.after(place.arc_m).filter(near);
        ahead.fold(Vector2::zeros(), |sum, node| {
            sum + self.pull(input.at, node)
        })
    }
}

impl Law for JuFusion {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let path = self.path_pull(input);
        let goal = self.pull(input.at, input.goal);
        Push::Along(path + goal + all_repulsions(&self.config.gains(), input))
    }
}
