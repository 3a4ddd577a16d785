//! Points of a scan that belong together: neighbours in angle and in space.

use crate::beams::{Beams, End};
use nalgebra::Point2;
use zeronav_msgs::Pose;

/// Most beams without a point between two points of one cluster.
const BEAMS_APART_MAX: usize = 3;

/// How far beside the line through the two points before it a point may lie and continue it. [m]
const LINE_MARGIN_M: f64 = 0.06;

/// How much longer than the step before it such a step may be, and how long at most. [m]
const LINE_STEP_MAX: (f64, f64) = (3.0, 1.0);

/// A point of a scan that the map does not explain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ScanPoint {
    /// In the map. [m]
    pub at: Point2<f64>,
    /// Index of its beam.
    pub beam: usize,
    /// Its range. [m]
    pub range_m: f64,
}

/// Neighbouring points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cluster {
    /// Its first point in [`Clusters::points`].
    first: usize,
    /// First point behind it.
    end: usize,
    /// Something nearer hides what may lie beyond one of its ends.
    pub hidden: bool,
}

/// The clusters of a scan. Memory is reused.
#[derive(Debug, Default)]
pub(crate) struct Clusters {
    points: Vec<ScanPoint>,
    clusters: Vec<Cluster>,
}

impl Clusters {
    /// Finds the clusters of a scan seen from `map_from_frame`. Points beyond `range_m_max` or for
    /// which `is_background` holds belong to none. Two neighbours belong together when they are at
    /// most `gap_m` and twice the distance of neighbouring beams apart, or when the second goes on
    /// along the line of those before it: a wall seen at a slant is not many small things. What is
    /// hollow by `gap_m` is parted at its deepest point: two people who walk side by side are two.
    pub(crate) fn find(
        &mut self,
        beams: &Beams,
        map_from_frame: &Pose,
        (gap_m, range_m_max): (f64, f64),
        is_background: impl Fn(Point2<f64>) -> bool,
    ) {
        self.points.clear();
        self.clusters.clear();
        let (sin, cos) = map_from_frame.yaw_rad.sin_cos();
        for (beam, seen) in beams.as_slice().iter().enumerate() {
            let (Some(point), End::Hit(range_m)) = (seen.point(), seen.end) else {
                continue;
            };
            let at = Point2::new(
                map_from_frame.x_m + cos * point.x - sin * point.y,
                map_from_frame.y_m + sin * point.x + cos * point.y,
            );
            if range_m <= range_m_max && !is_background(at) {
                self.points.push(ScanPoint { at, beam, range_m });
            }
        }
        let n_beams = beams.as_slice().len();
        let together = |a: &ScanPoint, b: &ScanPoint| {
            let apart = (b.beam + n_beams - a.beam) % n_beams;
            let far_m = a.range_m.max(b.range_m);
            let spread_m = 2.0 * far_m * beams.increment_rad();
            apart <= BEAMS_APART_MAX && (a.at - b.at).norm() <= gap_m + spread_m
        };
        // A full turn begins where two points do not belong together, so that none is cut in two.
        if let (true, Some(first), Some(last)) = (
            beams.full_turn(),
            self.points.first().copied(),
            self.points.last().copied(),
        ) && together(&last, &first)
            && let Some(cut) = self
                .points
                .windows(2)
                .position(|pair| !together(&pair[0], &pair[1]))
        {
            self.points.rotate_left(cut + 1);
        }
        let mut first = 0;
        for end in 1..=self.points.len() {
            let goes_on = end < self.points.len()
                && (together(&self.points[end - 1], &self.points[end])
                    || continues_line(&self.points[first..=end], n_beams));
            if !goes_on {
                while let Some(n) = hollow(&self.points[first..end], gap_m) {
                    self.push(beams, first, first + n, gap_m);
                    first += n;
                }
                self.push(beams, first, end, gap_m);
                first = end;
            }
        }
    }

    fn push(&mut self, beams: &Beams, first: usize, end: usize, gap_m: f64) {
        let hidden = self.is_hidden(beams, first, end, gap_m);
        self.clusters.push(Cluster { first, end, hidden });
    }

    /// The clusters, in the order of the beams.
    #[must_use]
    pub(crate) fn as_slice(&self) -> &[Cluster] {
        &self.clusters
    }

    /// The points of a cluster, in the order of the beams.
    #[must_use]
    pub(crate) fn points(&self, cluster: &Cluster) -> &[ScanPoint] {
        &self.points[cluster.first..cluster.end]
    }

    /// True when beside the points `first..end` a beam ended nearer, or there is no beam.
    fn is_hidden(&self, beams: &Beams, first: usize, end: usize, gap_m: f64) -> bool {
        let n_beams = beams.as_slice().len();
        let hides = |point: &ScanPoint, beside: Option<usize>| {
            let beside = match beside {
                Some(beside) if beside < n_beams => beside,
                _ if beams.full_turn() => beside.map_or(n_beams - 1, |beside| beside % n_beams),
                _ => return true,
            };
            match beams.as_slice()[beside].end {
                End::Hit(range_m) => range_m < point.range_m - gap_m,
                End::NoReturn(_) | End::Invalid => false,
            }
        };
        let (from, to) = (&self.points[first], &self.points[end - 1]);
        hides(from, from.beam.checked_sub(1)) || hides(to, Some(to.beam + 1))
    }
}

/// The first point that is farther than some before and some behind it by `depth_m`.
fn hollow(points: &[ScanPoint], depth_m: f64) -> Option<usize> {
    let mut nearest_m = f64::INFINITY;
    // Farthest behind that one.
    let mut deepest = (f64::INFINITY, 0);
    for (n, point) in points.iter().enumerate() {
        let (deepest_m, at) = deepest;
        if deepest_m - nearest_m >= depth_m && deepest_m - point.range_m >= depth_m {
            return Some(at);
        }
        if point.range_m < nearest_m {
            nearest_m = point.range_m;
            deepest = (nearest_m, n);
        } else if point.range_m > deepest_m {
            deepest = (point.range_m, n);
        }
    }
    None
}

/// True when the last of `points` goes on along the line through the two before it.
fn continues_line(points: &[ScanPoint], n_beams: usize) -> bool {
    let [.., a, b, c] = points else {
        return false;
    };
    let apart = (c.beam + n_beams - b.beam) % n_beams;
    let (step, next) = (b.at - a.at, c.at - b.at);
    let (step_m, next_m) = (step.norm(), next.norm());
    let (times, at_most_m) = LINE_STEP_MAX;
    apart <= BEAMS_APART_MAX
        && step_m > LINE_MARGIN_M
        && next_m <= (times * step_m).min(at_most_m)
        && step.dot(&next) > 0.0
        && step.perp(&next).abs() <= LINE_MARGIN_M * step_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beams::Sweep;
    use zeronav_casts::Cast;
    use zeronav_msgs::scan::Scan;

    fn find(ranges: &[f32], full_turn: bool) -> Vec<(Vec<usize>, bool)> {
        let turn = std::f32::consts::TAU / ranges.len().to_f32();
        let scan = Scan {
            n_beams: u32::try_from(ranges.len()).unwrap(),
            angle_increment_rad: if full_turn { turn } else { 0.02 },
            range_m_min: 0.1,
            range_m_max: 10.0,
            ..Scan::default()
        };
        let mut beams = Beams::default();
        beams.cast(&scan, ranges, &Sweep::still(Pose::default()));
        let mut clusters = Clusters::default();
        clusters.find(&beams, &Pose::default(), (0.1, 10.0), |_| false);
        let of = |cluster: &Cluster| {
            let beams = clusters.points(cluster).iter().map(|point| point.beam);
            (beams.collect(), cluster.hidden)
        };
        clusters.as_slice().iter().map(of).collect()
    }

    #[test]
    fn a_step_in_range_parts_and_the_nearer_hides() {
        let ranges = [9.0, 4.0, 4.02, 4.01, 2.0, 2.0, 2.0, 9.0];
        let found = find(&ranges, false);
        assert_eq!(
            found,
            [
                (vec![0], true),
                (vec![1, 2, 3], true),
                (vec![4, 5, 6], false),
                (vec![7], true)
            ]
        );
    }

    #[test]
    fn a_wall_at_a_slant_is_one_and_what_stands_off_it_is_not() {
        // The wall y = 1, from beside to 13 degrees.
        let range = |n: i32| 1.0 / (1.57 + 0.02 * n.to_f32()).sin();
        let wall: Vec<f32> = (0..68).map(range).collect();
        let mut beams = Beams::default();
        let mut count = |ranges: &[f32]| {
            let scan = Scan {
                n_beams: u32::try_from(ranges.len()).unwrap(),
                angle_min_rad: 1.57,
                angle_increment_rad: 0.02,
                range_m_min: 0.1,
                range_m_max: 20.0,
                ..Scan::default()
            };
            beams.cast(&scan, ranges, &Sweep::still(Pose::default()));
            let mut clusters = Clusters::default();
            clusters.find(&beams, &Pose::default(), (0.1, 12.0), |_| false);
            clusters.as_slice().len()
        };
        assert_eq!(count(&wall), 1);
        let mut with_post = wall;
        with_post[55..58].fill(1.5);
        assert_eq!(count(&with_post), 3);
    }

    #[test]
    fn two_who_stand_side_by_side_are_two() {
        // Discs of 0.3 m, 0.62 m apart.
        let range = |angle: f32, x: f32, y: f32| {
            let along = x * angle.cos() + y * angle.sin();
            let beside = x * angle.sin() - y * angle.cos();
            let half = (0.09 - beside * beside).sqrt();
            if half.is_nan() {
                f32::NAN
            } else {
                along - half
            }
        };
        let pair = |x: f32| -> Vec<f32> {
            (0..100_u16)
                .map(|n| 0.02 * f32::from(n) - 1.0)
                .map(|angle| range(angle, x, 0.31).min(range(angle, x, -0.31)))
                .collect()
        };
        let mut beams = Beams::default();
        let mut sizes = |ranges: &[f32]| -> Vec<usize> {
            let scan = Scan {
                n_beams: 100,
                angle_min_rad: -1.0,
                angle_increment_rad: 0.02,
                range_m_min: 0.1,
                range_m_max: 10.0,
                ..Scan::default()
            };
            beams.cast(&scan, ranges, &Sweep::still(Pose::default()));
            let mut clusters = Clusters::default();
            clusters.find(&beams, &Pose::default(), (0.1, 10.0), |_| false);
            let found = clusters.as_slice().iter();
            found
                .map(|cluster| clusters.points(cluster).len())
                .collect()
        };
        let pair = sizes(&pair(2.0));
        assert_eq!(pair.len(), 2, "{pair:?}");
        assert!(pair[0].abs_diff(pair[1]) <= 2, "{pair:?}");
        // One disc is one, a room's corner is two walls.
        let one: Vec<f32> = (0..100_u16)
            .map(|n| range(0.02 * f32::from(n) - 1.0, 2.0, 0.0))
            .collect();
        assert_eq!(sizes(&one).len(), 1);
        let corner: Vec<f32> = (0..100_u16)
            .map(|n| 0.02 * f32::from(n) - 1.0)
            .map(|angle| 2.0 / (angle.cos() + angle.sin().abs()))
            .collect();
        assert_eq!(sizes(&corner).len(), 2);
    }

    #[test]
    fn a_cluster_across_the_seam_is_one() {
        let mut ranges = [f32::INFINITY; 360];
        for beam in [358, 359, 0, 1, 2] {
            ranges[beam] = 3.0;
        }
        ranges[100] = 3.0;
        ranges[101] = f32::NAN;
        ranges[102] = 3.0;
        let found = find(&ranges, true);
        assert_eq!(
            found,
            [(vec![100, 102], false), (vec![358, 359, 0, 1, 2], false)]
        );
        assert_eq!(find(&[f32::NAN; 360], true), []);
    }
}
