//! The hits of a scan, to be found by place, with the lines that they lie on.

use core::f64::consts::PI;
use nalgebra::{Point2, Vector2};
use zeronav_casts::Cast;

/// Side of a bucket, and how far from a hit its line is found at least. [m]
const BUCKET_M: f64 = 0.15;

/// Buckets along a side: 24 m.
const BUCKETS: usize = 160;

/// Neighbours on either side that a line is drawn through at most.
const BESIDE: usize = 3;

/// Farthest that neighbouring hits of one surface lie apart, and least length of a line. [m]
const GAP_M: f64 = 0.15;
const LENGTH_M_MIN: f64 = 0.03;

/// Half of the directions without hits from which on they are behind the view. [rad]
const BLIND_RAD_MIN: f64 = 0.1;

/// No hit.
const NONE: u16 = u16::MAX;

/// A hit with the line through it and its neighbours.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    /// The hit. [m]
    pub(crate) at: Point2<f64>,
    /// Unit vector across the line.
    pub(crate) normal: Vector2<f64>,
}

/// See the module's description. Buffers are reused.
#[derive(Debug, Default)]
pub(crate) struct NearPoints {
    lines: Vec<Line>,
    /// The next line of the same bucket.
    next: Vec<u16>,
    /// The first line of every bucket.
    first: Vec<u16>,
    /// Standard deviation of the hits across their surfaces. [m]
    noise_m: f64,
    /// Distance of the farthest hit. [m]
    reach_m: f64,
    /// Middle of the directions in which nothing was hit behind the view, and the cosine of half of them.
    blind: (Vector2<f64>, f64),
}

/// Standard deviations per mean of absolute values of a normal variable, and of a hit beside the middle of
/// its neighbours per one of a hit.
const SIGMAS: f64 = 1.2533 / 1.2247;

impl NearPoints {
    /// Takes in hits in the order of their beams. [m]
    pub(crate) fn fill(&mut self, hits: &[Point2<f64>]) {
        self.first.resize(BUCKETS * BUCKETS, NONE);
        for line in self.lines.drain(..) {
            if let Some(bucket) = bucket(line.at) {
                self.first[bucket] = NONE;
            }
        }
        self.next.clear();
        self.noise_m = noise_m(hits);
        let far_m = hits.iter().map(|hit| hit.coords.norm());
        self.reach_m = far_m.fold(0.0, f64::max);
        self.blind = blind(hits);
        for n in 0..hits.len() {
            let Some(line) = line_through(hits, n) else {
                continue;
            };
            let (Some(bucket), Ok(index)) = (bucket(line.at), u16::try_from(self.lines.len()))
            else {
                continue;
            };
            self.lines.push(line);
            self.next.push(self.first[bucket]);
            self.first[bucket] = index;
        }
    }

    /// Number of lines.
    pub(crate) fn len(&self) -> usize {
        self.lines.len()
    }

    /// Standard deviation of the hits across their surfaces; 0 where none has neighbours. [m]
    pub(crate) fn noise_m(&self) -> f64 {
        self.noise_m
    }

    /// True where the scan that was taken in looked: no farther than its farthest hit, and not behind its view.
    pub(crate) fn is_in_view(&self, place: Point2<f64>) -> bool {
        let (behind, cos) = &self.blind;
        let far_m = place.coords.norm();
        far_m <= self.reach_m && place.coords.dot(behind) <= cos * far_m
    }

    /// The line of the hit that is nearest to a place; `None` where none is within [`BUCKET_M`].
    pub(crate) fn line_near(&self, place: Point2<f64>) -> Option<&Line> {
        let middle = bucket(place)?;
        let mut least = BUCKET_M * BUCKET_M;
        let mut nearest = None;
        for row in [
            middle.checked_sub(BUCKETS),
            Some(middle),
            Some(middle + BUCKETS),
        ] {
            for bucket in row.into_iter().flat_map(|at| at.saturating_sub(1)..=at + 1) {
                let mut index = self.first.get(bucket).copied().unwrap_or(NONE);
                while let Some(line) = self.lines.get(usize::from(index)) {
                    let squared = (line.at - place).norm_squared();
                    if squared < least {
                        least = squared;
                        nearest = Some(line);
                    }
                    index = self.next[usize::from(index)];
                }
            }
        }
        nearest
    }
}

/// Standard deviation of hits, in the order of their beams, across their surfaces, by how far they lie beside the
/// middle of their neighbours. [m]
pub(crate) fn noise_m(hits: &[Point2<f64>]) -> f64 {
    let (mut sum_m, mut n) = (0.0, 0.0_f64);
    for three in hits.windows(3) {
        let along = three[2] - three[0];
        if (three[1] - three[0]).norm() < GAP_M && (three[2] - three[1]).norm() < GAP_M {
            let across = Vector2::new(-along.y, along.x) / along.norm().max(1.0e-9);
            let middle = three[0] + 0.5 * along;
            sum_m += (three[1] - middle).dot(&across).abs();
            n += 1.0;
        }
    }
    SIGMAS * sum_m / n.max(1.0)
}

/// Middle of the directions beyond the outermost hits, behind a scan that looks ahead, and the cosine of half of
/// them; above 1 where there are hits all around.
fn blind(hits: &[Point2<f64>]) -> (Vector2<f64>, f64) {
    let bearings = hits.iter().map(|hit| hit.y.atan2(hit.x));
    let (right, left) = bearings.fold((PI, -PI), |(right, left), bearing| {
        (bearing.min(right), bearing.max(left))
    });
    let half_rad = PI - 0.5 * (left - right);
    if half_rad < BLIND_RAD_MIN {
        return (Vector2::x(), 2.0);
    }
    let (sin, cos) = (0.5 * (left + right) + PI).sin_cos();
    (Vector2::new(cos, sin), half_rad.min(PI).cos())
}

/// True when a hit lies on one surface with the one before or after it.
pub(crate) fn is_linked(hits: &[Point2<f64>], n: usize) -> bool {
    let joins =
        |other: Option<&Point2<f64>>| other.is_some_and(|other| (hits[n] - other).norm() < GAP_M);
    joins(n.checked_sub(1).and_then(|before| hits.get(before))) || joins(hits.get(n + 1))
}

/// The line through a hit and its neighbours on the same surface; `None` when it has none.
fn line_through(hits: &[Point2<f64>], n: usize) -> Option<Line> {
    let joins = |pair: &[Point2<f64>]| (pair[1] - pair[0]).norm() < GAP_M;
    let after = hits[n..]
        .windows(2)
        .take(BESIDE)
        .take_while(|pair| joins(pair))
        .count();
    let before = hits[..=n]
        .windows(2)
        .rev()
        .take(BESIDE)
        .take_while(|pair| joins(pair))
        .count();
    let along = hits[n + after] - hits[n - before];
    let length_m = along.norm();
    (length_m >= LENGTH_M_MIN).then(|| Line {
        at: hits[n],
        normal: Vector2::new(-along.y, along.x) / length_m,
    })
}

/// Index of the bucket of a place; `None` farther away than buckets reach.
fn bucket(place: Point2<f64>) -> Option<usize> {
    let index = |m: f64| {
        let cells = m / BUCKET_M + BUCKETS.to_f64() / 2.0;
        (0.0..BUCKETS.to_f64())
            .contains(&cells)
            .then_some(cells.to_usize())
    };
    Some(index(place.y)? * BUCKETS + index(place.x)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall() -> Vec<Point2<f64>> {
        (0..100)
            .map(|n| Point2::new(2.0, -1.0 + 0.02 * f64::from(n)))
            .collect()
    }

    #[test]
    fn the_line_of_the_nearest_hit_lies_along_its_surface() {
        let mut points = NearPoints::default();
        for _ in 0..2 {
            points.fill(&wall());
        }
        let line = points.line_near(Point2::new(2.1, 0.503)).unwrap();
        assert!((line.at - Point2::new(2.0, 0.5)).norm() < 1e-9);
        assert!(line.normal.x.abs() > 1.0 - 1e-12);
        assert!(points.line_near(Point2::new(2.2, 0.5)).is_none(), "too far");
        assert!(points.line_near(Point2::new(-1.0e9, f64::NAN)).is_none());
    }

    #[test]
    fn hits_that_stand_alone_and_far_ones_have_no_line() {
        let mut hits = wall();
        hits.push(Point2::new(-1.0, 0.0));
        hits.push(Point2::new(-1.0, 1.0));
        hits.extend((0..10).map(|n| Point2::new(50.0, 0.02 * f64::from(n))));
        let mut points = NearPoints::default();
        points.fill(&hits);
        assert_eq!(points.lines.len(), 100);
        assert!(points.line_near(Point2::new(-1.0, 0.0)).is_none());
        points.fill(&[]);
        assert!(
            points.line_near(Point2::new(2.0, 0.5)).is_none(),
            "forgotten"
        );
    }

    #[test]
    fn in_view_is_what_lies_between_the_outermost_hits_and_no_farther_than_the_farthest() {
        // Walls on both sides, seen as far back as 135 degrees, and up to 4 m ahead.
        let side = |y: f64| (0..200).map(move |n| Point2::new(0.02 * f64::from(n) - 0.3, y));
        let hits: Vec<Point2<f64>> = side(-0.3).chain(side(0.3)).collect();
        let mut points = NearPoints::default();
        points.fill(&hits);
        let sees = |x: f64, y: f64| points.is_in_view(Point2::new(x, y));
        assert!(sees(-0.28, 0.3) && sees(-0.28, -0.3) && sees(3.5, 0.0));
        assert!(!sees(-0.4, 0.3) && !sees(-0.4, -0.3) && !sees(-1.0, 0.0));
        assert!(!sees(4.0, 0.0), "too far");
        points.fill(
            &(0..360)
                .map(|n| {
                    let (sin, cos) = f64::from(n).to_radians().sin_cos();
                    Point2::new(2.0 * cos, 2.0 * sin)
                })
                .collect::<Vec<_>>(),
        );
        for n in 0..720 {
            let (sin, cos) = (0.5 * f64::from(n)).to_radians().sin_cos();
            assert!(points.is_in_view(Point2::new(1.9 * cos, 1.9 * sin)), "{n}");
        }
    }

    /// The nearest of all hits, looked for one by one.
    #[test]
    fn no_hit_is_nearer_than_the_one_found() {
        let hits: Vec<Point2<f64>> = (0..600)
            .map(|n| {
                let (turn, n) = (0.01 * f64::from(n), f64::from(n));
                let range_m = 1.0 + 0.5 * (0.37 * n).sin().abs().sqrt();
                Point2::new(range_m * turn.cos(), range_m * turn.sin())
            })
            .collect();
        let mut points = NearPoints::default();
        points.fill(&hits);
        for n in 0..400 {
            let place = Point2::new(
                -2.0 + 0.2 * f64::from(n % 20),
                -2.0 + 0.2 * f64::from(n / 20),
            );
            let away_m = |line: &Line| (line.at - place).norm();
            let least_m = points
                .lines
                .iter()
                .map(away_m)
                .fold(f64::INFINITY, f64::min);
            match points.line_near(place) {
                Some(line) => assert!((away_m(line) - least_m).abs() < 1e-12, "{place}"),
                None => assert!(least_m >= BUCKET_M, "{place} {least_m}"),
            }
        }
    }
}
