//! `ju_fusion` [JU]: the path's points around the robot attract as well as the goal does.

use super::law::{Law, LawInput, Push};
use super::options::JuFusionConfig;
use super::potential::{all_repulsions, attraction};
use super::route::Route;
use nalgebra::{Point2, Vector2};

/// The fused field: `F_att(goal) + sum over path points F_att + sum over obstacles F_rep`, the
/// sums restarted in every step, the goal's part included.
#[derive(Debug, Clone)]
pub struct JuFusion {
    config: JuFusionConfig,
    route: Route,
    geometry: u64,
    /// The points of the path, with their places along it.
    points: Vec<(f64, Point2<f64>)>,
}

impl JuFusion {
    /// The field with these gains.
    #[must_use]
    pub fn new(config: &JuFusionConfig) -> Self {
        Self {
            config: *config,
            route: Route::default(),
            geometry: 0,
            points: Vec::new(),
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

    /// The points that A* would have given: a path comes as its corners, between which there is one
    /// point a cell.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cells of a path between two corners"
    )]
    fn take(&mut self, input: &LawInput<'_>) {
        self.geometry = input.geometry;
        self.points.clear();
        let mut arc = 0.0;
        for pair in input.path.windows(2) {
            let from = Point2::new(pair[0].x_m, pair[0].y_m);
            let along = Point2::new(pair[1].x_m, pair[1].y_m) - from;
            let cells = along.amax() / self.config.point_m;
            let n = cells.round().clamp(1.0, 1.0e4) as u32;
            for i in 1..=n {
                let share = f64::from(i) / f64::from(n);
                let place = arc + share * along.norm();
                self.points.push((place, from + along * share));
            }
            arc += along.norm();
        }
    }

    /// Sum of the attractions of the path's points that are near and ahead by the progress along
    /// the path (the printed `x_p > x_r` is right for goals to the right alone).
    #[must_use]
    pub fn path_pull(&mut self, input: &LawInput<'_>) -> Vector2<f64> {
        if self.geometry != input.geometry {
            self.take(input);
        }
        let Some(place) = self.route.place(input) else {
            return Vector2::zeros();
        };
        let ahead = self.points.iter().filter(|(arc, point)| {
            *arc > place.arc_m && (point - input.at).norm() < self.config.r1_m
        });
        ahead.fold(Vector2::zeros(), |sum, (_, point)| {
            sum + self.pull(input.at, *point)
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
