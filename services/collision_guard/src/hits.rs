//! The hits that can matter, in runs of neighbours: most of them are settled together.

use crate::outline::Outline;
use nalgebra::Vector2;

/// Hits of one run.
const RUN: usize = 16;

/// [m] from a run's first hit to any other.
const RUN_REACH_M: f64 = 0.2;

/// Consecutive hits within a disc. Places that are left over repeat the last hit.
#[derive(Debug, Clone, Copy)]
struct Run {
    x_m: [f64; RUN],
    y_m: [f64; RUN],
    n: usize,
    middle: Vector2<f64>,
    radius_m: f64,
}

impl Run {
    fn of(first: Vector2<f64>) -> Self {
        Self {
            x_m: [first.x; RUN],
            y_m: [first.y; RUN],
            n: 1,
            middle: first,
            radius_m: 0.0,
        }
    }

    fn hit(&self, i: usize) -> Vector2<f64> {
        Vector2::new(self.x_m[i], self.y_m[i])
    }

    /// False when the hit belongs to the next run.
    fn takes(&mut self, hit: Vector2<f64>) -> bool {
        let fits = self.n < RUN && (hit - self.hit(0)).norm() <= RUN_REACH_M;
        if fits {
            self.x_m[self.n..].fill(hit.x);
            self.y_m[self.n..].fill(hit.y);
            self.n += 1;
        }
        fits
    }

    /// The disc, once all hits are in.
    fn close(&mut self) {
        self.middle = 0.5 * (self.hit(0) + self.hit(self.n - 1));
        self.radius_m = (0..self.n).fold(0.0, |most: f64, i| {
            most.max((self.hit(i) - self.middle).norm())
        });
    }
}

/// Hits in `base` of now [m], in the order of the beams.
#[derive(Debug, Clone, Default)]
pub(crate) struct Hits {
    runs: Vec<Run>,
}

impl Hits {
    /// Room for `n` hits.
    pub(crate) fn with_capacity(n: usize) -> Self {
        Self {
            runs: Vec::with_capacity(n),
        }
    }

    /// Nothing is there. Others follow with [`Self::push`], in their order, then [`Self::close`].
    pub(crate) fn clear(&mut self) {
        self.runs.clear();
    }

    /// Takes in another one.
    pub(crate) fn push(&mut self, hit: Vector2<f64>) {
        if !self.runs.last_mut().is_some_and(|run| run.takes(hit)) {
            self.runs.push(Run::of(hit));
        }
    }

    /// All are there.
    pub(crate) fn close(&mut self) {
        self.runs.iter_mut().for_each(Run::close);
    }

    /// Takes these instead of all that were there.
    #[cfg(test)]
    pub(crate) fn refill(&mut self, hits: impl Iterator<Item = Vector2<f64>>) {
        self.clear();
        hits.for_each(|hit| self.push(hit));
        self.close();
    }

    /// One by one.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Vector2<f64>> {
        self.runs
            .iter()
            .flat_map(|run| (0..run.n).map(|i| run.hit(i)))
    }

    /// Least signed distance to an outline that is placed in `base` of now, at most `enough_m`.
    /// [m]
    ///
    /// `nearest` is the run that decided last time and will do so again most likely: any number to
    /// begin with. It changes how long the answer takes, not what it is.
    pub(crate) fn nearest_m(&self, placed: &Outline, enough_m: f64, nearest: &mut usize) -> f64 {
        self.nearest(placed, enough_m, nearest).0
    }

    /// The same with the hit that has it, if any is nearer than `enough_m`.
    pub(crate) fn nearest(
        &self,
        placed: &Outline,
        enough_m: f64,
        nearest: &mut usize,
    ) -> (f64, Option<Vector2<f64>>) {
        let (mut least_m, mut hit) = (enough_m, None);
        let first = self.runs.get(*nearest).map(|run| (*nearest, run));
        for (n, run) in first.into_iter().chain(self.runs.iter().enumerate()) {
            if placed.circle_m(run.middle) - run.radius_m >= least_m {
                continue;
            }
            let at_least_m = placed.at_least_m(&run.x_m, &run.y_m);
            for (i, at_least_m) in at_least_m.into_iter().enumerate() {
                if at_least_m < least_m {
                    let here_m = placed.distance_m(run.hit(i), least_m);
                    if here_m < least_m {
                        (least_m, *nearest, hit) = (here_m, n, Some(run.hit(i)));
                    }
                }
            }
        }
        (least_m, hit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use zeronav_msgs::description::{Corner, Description};

    proptest! {
        #[test]
        fn runs_find_what_every_hit_by_itself_finds(
            points in prop::collection::vec((-2.0..2.0_f64, -2.0..2.0_f64), 0..200),
            spread in 0.0..1.0_f64,
            at in (-1.0..1.0_f64, -1.0..1.0_f64, -3.2..3.2_f64),
            enough_m in 0.0..1.0_f64,
            disc in any::<bool>(),
            mut nearest in 0_usize..30,
        ) {
            let corners = [(0.4, 0.0), (-0.2, 0.3), (-0.3, 0.0), (-0.2, -0.3)]
                .map(|(x_m, y_m)| Corner { x_m, y_m });
            let description = Description { circumscribed_radius_m: 0.3, ..Description::default() };
            let outline = Outline::new(&description, if disc { &[] } else { &corners });
            // Neighbours are near each other, but for a jump now and then.
            let mut last = Vector2::zeros();
            let points: Vec<Vector2<f64>> = points
                .iter()
                .enumerate()
                .map(|(i, &(x, y))| {
                    let share = if i % 37 == 0 { 1.0 } else { 0.1 * spread };
                    last = last * (1.0 - share) + Vector2::new(x, y) * share;
                    last
                })
                .collect();
            let mut hits = Hits::default();
            hits.refill(points.iter().copied());
            prop_assert_eq!(hits.iter().collect::<Vec<_>>(), points.clone());
            let mut placed = outline;
            placed.place(&outline, Vector2::new(at.0, at.1), at.2.sin_cos());
            let one_by_one = points.iter().fold(enough_m, |least: f64, point| {
                least.min(placed.distance_m(*point, f64::INFINITY))
            });
            let found = hits.nearest_m(&placed, enough_m, &mut nearest);
            prop_assert!((found - one_by_one).abs() < 1.0e-12, "{} {}", found, one_by_one);
            let (_, hit) = hits.nearest(&placed, enough_m, &mut 0);
            prop_assert_eq!(hit.is_some(), one_by_one < enough_m);
            if let Some(hit) = hit {
                let hit_m = placed.distance_m(hit, f64::INFINITY);
                prop_assert!((hit_m - one_by_one).abs() < 1.0e-12, "{} {}", hit_m, one_by_one);
            }
        }
    }

    #[test]
    fn neighbours_are_gathered_in_runs() {
        let mut hits = Hits::default();
        let x_m = |n: i32| 0.01 * f64::from(n);
        // 40 hits in a row, then one farther than a run reaches.
        let row = (0..40).map(|n| Vector2::new(x_m(n), 1.0));
        hits.refill(row.chain([Vector2::new(2.0, 1.0)]));
        let runs: Vec<(usize, f64, f64)> = hits
            .runs
            .iter()
            .map(|run| (run.n, run.middle.x, run.radius_m))
            .collect();
        let expected = [
            (16, 0.075, 0.075),
            (16, 0.235, 0.075),
            (8, 0.355, 0.035),
            (1, 2.0, 0.0),
        ];
        assert_eq!(runs.len(), expected.len(), "{runs:?}");
        for (found, expected) in runs.into_iter().zip(expected) {
            let off_m = (found.1 - expected.1)
                .abs()
                .max((found.2 - expected.2).abs());
            assert!(
                found.0 == expected.0 && off_m < 1e-9,
                "{found:?} not {expected:?}"
            );
        }
    }
}
