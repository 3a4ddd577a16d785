//! `lwx_lsq` [LWX]: the global path, fitted by least squares, followed by a carrot.

use super::fit::{FitError, fit_literal, free_fit};
use super::law::{Law, LawInput, Push};
use super::options::{FitMode, LwxLsqConfig};
use super::potential::{all_repulsions, attraction};
use nalgebra::Point2;
use zeronav_msgs::command::RequestCause;

/// Between the path's points that are fitted. [m or cells]
const SPACING: f64 = 0.25;

/// A curve that is followed from its start to its end.
#[derive(Debug, Clone, Default)]
pub(super) struct Curve {
    pub(super) points: Vec<Point2<f64>>,
    next: usize,
}

impl Curve {
    pub(super) fn new(points: Vec<Point2<f64>>) -> Self {
        Self { points, next: 0 }
    }

    /// The point ahead of the nearest one; never back.
    pub(super) fn carrot(&mut self, at: Point2<f64>, lookahead: f64) -> Option<Point2<f64>> {
        let window = self.points.get(self.next..)?.iter().take(40);
        let nearest = window
            .enumerate()
            .min_by(|a, b| (a.1 - at).norm().total_cmp(&(b.1 - at).norm()))
            .map_or(0, |(i, _)| i);
        self.next += nearest;
        let ahead = self.points.get(self.next..)?;
        ahead
            .iter()
            .find(|point| (*point - at).norm() >= lookahead)
            .or(ahead.last())
            .copied()
    }

    /// True when the rest of the curve is free as far as anything is known now.
    pub(super) fn is_free(&self, input: &LawInput<'_>) -> bool {
        let rest = self.points.get(self.next..).unwrap_or_default();
        rest.windows(2).all(|pair| input.is_free(pair[0], pair[1]))
    }
}

/// The points of a path, densely.
pub(super) fn dense(input: &LawInput<'_>) -> Vec<Point2<f64>> {
    let mut points: Vec<Point2<f64>> = Vec::new();
    for pair in input.path.windows(2) {
        let from = Point2::new(pair[0].x_m, pair[0].y_m);
        let to = Point2::new(pair[1].x_m, pair[1].y_m);
        let mut along = 0.0;
        while along < (to - from).norm() {
            points.push(from + (to - from).normalize() * along);
            along += SPACING;
        }
    }
    points.extend(input.path.last().map(|end| Point2::new(end.x_m, end.y_m)));
    points
}

/// The field towards a carrot on the fitted path; on the path as it is where no fit is free, or the
/// fit is no longer.
#[derive(Debug, Clone)]
pub struct LwxLsq {
    config: LwxLsqConfig,
    geometry: u64,
    curve: Curve,
    /// The curve is a fit, or why there is none.
    fitted: Result<bool, FitError>,
}

impl LwxLsq {
    /// The field with these gains.
    #[must_use]
    pub fn new(config: &LwxLsqConfig) -> Self {
        Self {
            config: *config,
            geometry: 0,
            curve: Curve::default(),
            fitted: Ok(false),
        }
    }

    /// Whether the current curve is a fit: false when every fit collides.
    ///
    /// # Errors
    /// [`FitError`] when the path cannot be fitted at all.
    pub const fn is_fitted(&self) -> Result<bool, FitError> {
        self.fitted
    }

    fn take(&mut self, input: &LawInput<'_>) {
        self.geometry = input.geometry;
        let points = dense(input);
        let free = |from, to| input.is_free(from, to);
        let fit = match self.config.mode {
            FitMode::Parametric => Ok(free_fit(&points, free)),
            FitMode::YxLiteral => fit_literal(&points, (points.len() / 4).clamp(3, 7)).map(|fit| {
                let is_free = fit.windows(2).all(|pair| free(pair[0], pair[1]));
                is_free.then_some(fit)
            }),
        };
        self.fitted = fit.as_ref().map(Option::is_some).map_err(|error| *error);
        self.curve = Curve::new(fit.ok().flatten().unwrap_or(points));
    }
}

impl Law for LwxLsq {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        if self.geometry != input.geometry {
            self.take(input);
        } else if self.fitted == Ok(true) && !self.curve.is_free(input) {
            self.fitted = Ok(false);
            self.curve = Curve::new(dense(input));
        }
        let lookahead = self.config.lookahead_m;
        let carrot = self.curve.carrot(input.at, lookahead).unwrap_or(input.goal);
        let gains = self.config.gains();
        let pull = attraction(gains.attract, input.at, carrot);
        Push::Along(pull + all_repulsions(&gains, input))
    }

    fn remark(&self) -> Option<RequestCause> {
        (self.fitted != Ok(true)).then_some(RequestCause::NoFit)
    }
}
