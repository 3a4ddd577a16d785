//! `ju_r6` [JU, its reference 6]: the path's inflection points in order as sub-goals of a field
//! whose repulsion fades at the sub-goal (`ZM-REP`, n = 2).

use super::law::{Law, LawInput, Push};
use super::options::JuR6Config;
use super::potential::{all_goal_repulsions, attraction};
use super::route::turning_points;
use nalgebra::Point2;

/// The field towards one sub-goal after the other.
#[derive(Debug, Clone)]
pub struct JuR6 {
    config: JuR6Config,
    geometry: u64,
    subgoals: Vec<Point2<f64>>,
    next: usize,
}

impl JuR6 {
    /// The field with these gains.
    #[must_use]
    pub const fn new(config: &JuR6Config) -> Self {
        Self {
            config: *config,
            geometry: 0,
            subgoals: Vec::new(),
            next: 0,
        }
    }

    /// Index of the current sub-goal, from 1.
    #[must_use]
    pub const fn subgoal(&self) -> usize {
        self.next
    }

    /// The current sub-goal; the next one when it is near or its half plane is passed.
    fn advance(&mut self, input: &LawInput<'_>) -> Point2<f64> {
        if self.geometry != input.geometry {
            self.geometry = input.geometry;
            self.subgoals = turning_points(input.path);
            self.next = 1;
        }
        while let (Some(&before), Some(&here)) = (
            self.subgoals.get(self.next.wrapping_sub(1)),
            self.subgoals.get(self.next),
        ) {
            let near = (input.at - here).norm() < self.config.sub_tolerance_m;
            let passed = (input.at - here).dot(&(here - before)) > 0.0;
            let last = self.next + 1 >= self.subgoals.len();
            if last || !(near || passed) {
                return here;
            }
            self.next += 1;
        }
        input.goal
    }
}

impl Law for JuR6 {
    fn push(&mut self, input: &LawInput<'_>) -> Push {
        let goal = self.advance(input);
        let gains = self.config.gains();
        let pull = attraction(gains.attract, input.at, goal);
        Push::Along(pull + all_goal_repulsions(&gains, self.config.n, input, goal))
    }
}
