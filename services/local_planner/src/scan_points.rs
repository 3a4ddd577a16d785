//! From a scan to points in `base` as it is now.
//!
//! Lidars report things that are not there: single beams that dust or rain throws back, and beams
//! that hit an edge and give a range between what is before and behind it. A hit that neither a
//! neighbouring beam nor the scan before saw at about the same place is left out until the next
//! scan confirms it; one on something thin, before what beams on both sides show, until it has been there for some
//! time. A real thing is wider than one beam wherever it is near enough to matter, or it
//! is there again; the guard has a rule of its own.

use crate::thin::is_before;
use nalgebra::{Isometry2, Point2, Vector2};
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::scan::{BEAMS_MAX, BeamDirections, Scan};
use zeronav_msgs::time::seconds;

/// Beams to either side that can confirm a hit.
const NEIGHBOURS: usize = 2;

/// [m] within which two hits are of one thing, besides the distance between beams.
const TOGETHER_M: f64 = 0.06;

/// Distances between neighbouring beams, square to them, that hits on one surface may lie apart:
/// surfaces are met at an angle.
const TOGETHER_BEAMS: f64 = 4.0;

/// Of the drops in two scans some are near each other: what is there again is where it was, off by so much at most
/// along its beam [m], across it [m] and across it besides, in distances between beams.
const AGAIN_ALONG_M: f64 = 0.03;
const AGAIN_ACROSS_M: f64 = 0.01;
const AGAIN_BEAMS: f64 = 2.0;

/// [s] for which every scan has to show it there; one scan at least.
const AGAIN_S: f64 = 0.09;

/// Pairs of beams whose ranges are averaged with the one between them.
const PAIRS: usize = 4;

/// [m] from a hit within which its surface counts as flat, square to the beam.
const FLAT_M: f64 = 0.02;

/// [m] by which ranges of one surface may differ.
const ROUGH_M: f64 = 0.06;

/// A hit.
#[derive(Debug, Clone, Copy)]
struct Hit {
    at: Point2<f64>,
    beam: usize,
    /// [m] how near a confirming hit must be, and distance of neighbouring beams. [m]
    together_m: f64,
    apart_m: f64,
    /// It is on something thin; beams on both sides went on far behind it.
    is_before: bool,
    /// [s] for which every scan has shown it; infinite for what the beams beside it confirm.
    shown_s: f64,
}

impl Hit {
    /// True when a hit of the scan before shows what this one shows; `at` is its place and `along` its beam's
    /// direction in the frame of the other.
    fn is_again(&self, was: &Self, at: Point2<f64>, along: Vector2<f64>) -> bool {
        let off = was.at - at;
        if !self.is_before {
            return off.norm_squared() <= self.together_m * self.together_m;
        }
        let across_m = AGAIN_ACROSS_M + AGAIN_BEAMS * self.apart_m;
        off.dot(&along).abs() <= AGAIN_ALONG_M && off.perp(&along).abs() <= across_m
    }

    fn is_confirmed(&self) -> bool {
        let enough_s = if self.is_before { AGAIN_S } else { 0.0 };
        self.shown_s > enough_s
    }
}

/// Hits of the newest scan. Deskewed once when the scan comes, carried forward in every period.
#[derive(Debug, Clone)]
pub struct ScanPoints {
    /// All hits of the newest scan and of the one before it, in `base` at their captures.
    hits: Vec<Hit>,
    before: Vec<Hit>,
    /// `odom_from_base` at the capture of the scan before, now of the newest, and its run time. [ns]
    captured: Option<(Pose, u64)>,
    /// Confirmed ones.
    at_capture: Vec<Point2<f64>>,
    now: Vec<Point2<f64>>,
    directions: BeamDirections,
}

impl Default for ScanPoints {
    fn default() -> Self {
        Self {
            hits: Vec::with_capacity(BEAMS_MAX),
            before: Vec::with_capacity(BEAMS_MAX),
            captured: None,
            at_capture: Vec::with_capacity(BEAMS_MAX),
            now: Vec::with_capacity(BEAMS_MAX),
            directions: BeamDirections::with_capacity(),
        }
    }
}

impl ScanPoints {
    /// Takes in a scan. `odom_from_base` holds at its capture, at run time `run_ns`, `twist` is the robot's while the
    /// lidar turned; beam `i` was captured `(n - 1 - i) * time_increment_s` before the last one,
    /// which is the scan's capture. Ranges that are no hits (no return, invalid, outside the
    /// sensor's limits) give no point, nor do hits that nothing confirms. Linear in the beams, and
    /// linear in them once more for every hit that no neighbour confirms.
    pub fn take(
        &mut self,
        scan: &Scan,
        ranges: &[f32],
        base_from_laser: &Pose,
        (odom_from_base, run_ns): (&Pose, u64),
        twist: Twist,
    ) {
        core::mem::swap(&mut self.hits, &mut self.before);
        let before = self.captured.replace((*odom_from_base, run_ns));
        self.hits.clear();
        let beam_s = f64::from(scan.time_increment_s);
        let last = f64::from(scan.n_beams.saturating_sub(1));
        let mut elapsed_s = -last * beam_s;
        let step_rad = f64::from(scan.angle_increment_rad).abs();
        let (sin, cos) = base_from_laser.yaw_rad.sin_cos();
        let laser = base_from_laser.point();
        let directions = self.directions.of(scan).iter();
        for (beam, (&range, direction)) in ranges.iter().zip(directions).enumerate() {
            if scan.is_hit(range) {
                let range_m = smoothed_m(scan, ranges, beam);
                let (x_m, y_m) = (range_m * direction.x, range_m * direction.y);
                let in_base = Point2::new(
                    laser.x + cos * x_m - sin * y_m,
                    laser.y + sin * x_m + cos * y_m,
                );
                let at = if beam_s > 0.0 {
                    twist.arc(elapsed_s).transform(in_base)
                } else {
                    in_base
                };
                let apart_m = step_rad * range_m;
                self.hits.push(Hit {
                    at,
                    beam,
                    together_m: TOGETHER_M + TOGETHER_BEAMS * apart_m,
                    apart_m,
                    is_before: is_before(ranges, beam, apart_m),
                    shown_s: 0.0,
                });
            }
            elapsed_s += beam_s;
        }
        self.confirm_beside();
        if let Some((pose, before_ns)) = before {
            let before_from_capture = pose.isometry().inv_mul(&odom_from_base.isometry());
            let since_s = seconds(run_ns.saturating_sub(before_ns));
            self.confirm_again(&before_from_capture, since_s, laser);
        }
        let confirmed = self.hits.iter().filter(|hit| hit.is_confirmed());
        self.at_capture.clear();
        self.at_capture.extend(confirmed.map(|hit| hit.at));
    }

    /// Confirms the hits that a beam beside them shares.
    fn confirm_beside(&mut self) {
        for i in 0..self.hits.len() {
            let hit = self.hits[i];
            let from = i.saturating_sub(NEIGHBOURS);
            let to = (i + NEIGHBOURS + 1).min(self.hits.len());
            let beside = self.hits[from..to].iter().any(|other| {
                other.beam != hit.beam
                    && other.beam.abs_diff(hit.beam) <= NEIGHBOURS
                    && (other.at - hit.at).norm_squared() <= hit.together_m * hit.together_m
            });
            if beside && !hit.is_before {
                self.hits[i].shown_s = f64::INFINITY;
            }
        }
    }

    /// Tells how long the other hits have been there. `before_from_capture` leads to the scan before, `since_s`
    /// ago [s]; `laser` is the lidar's place in `base`.
    fn confirm_again(
        &mut self,
        before_from_capture: &Isometry2<f64>,
        since_s: f64,
        laser: Point2<f64>,
    ) {
        for hit in self.hits.iter_mut().filter(|hit| hit.shown_s == 0.0) {
            let along = (hit.at - laser).try_normalize(0.0).unwrap_or_default();
            let (at, along) = (before_from_capture * hit.at, before_from_capture * along);
            let again = self
                .before
                .iter()
                .filter(|was| hit.is_again(was, at, along));
            let longest_s = again.map(|was| was.shown_s).reduce(f64::max);
            hit.shown_s = longest_s.map_or(0.0, |shown_s| shown_s + since_s);
        }
    }

    /// Forgets the scans.
    pub fn clear(&mut self) {
        self.hits.clear();
        self.before.clear();
        self.captured = None;
        self.at_capture.clear();
        self.now.clear();
    }

    /// The points in `base` of now. [m] Both poses are `odom_from_base`: at the scan's capture and
    /// now.
    pub fn carry(&mut self, at_capture: &Pose, now: &Pose) -> &[Point2<f64>] {
        let now_from_capture: Isometry2<f64> = now.isometry().inv_mul(&at_capture.isometry());
        self.now.clear();
        self.now
            .extend(self.at_capture.iter().map(|point| now_from_capture * point));
        &self.now
    }
}

/// The range of a beam that hit something, averaged over pairs of beams beside it as far as they hit
/// the same surface near by. The nearest of a hundred points with a centimetre of noise is some three
/// centimetres too near, and that is all the room there is in a narrow gap. Pairs keep a slanted
/// surface where it is; where it ends nothing is averaged. [m]
fn smoothed_m(scan: &Scan, ranges: &[f32], beam: usize) -> f64 {
    let own_m = f64::from(ranges[beam]);
    let beside_m = own_m * f64::from(scan.angle_increment_rad).abs();
    let (mut sum_m, mut n) = (own_m, 1.0);
    let mut aside_m = 0.0;
    for step in 1..=PAIRS {
        aside_m += beside_m;
        let Some((&left, &right)) = beam
            .checked_sub(step)
            .and_then(|left| ranges.get(left).zip(ranges.get(beam + step)))
        else {
            break;
        };
        let (left_m, right_m) = (f64::from(left), f64::from(right));
        let same = |range_m: f64| (range_m - own_m).abs() <= ROUGH_M + 2.0 * aside_m;
        // A pair that bends is no flat surface.
        let bent_m = (0.5 * (left_m + right_m) - own_m).abs();
        if aside_m > FLAT_M
            || !(scan.is_hit(left) && scan.is_hit(right) && same(left_m) && same(right_m))
            || bent_m > ROUGH_M
        {
            break;
        }
        sum_m += left_m + right_m;
        n += 2.0;
    }
    sum_m / n
}

#[cfg(test)]
mod tests {
    #![allow(clippy::print_stdout, reason = "the numbers of a failed run")]

    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;
    use zeronav_casts::Cast;

    fn scan(time_increment_s: f32) -> Scan {
        Scan {
            n_beams: 4,
            angle_increment_rad: core::f32::consts::FRAC_PI_2,
            time_increment_s,
            range_m_min: 0.1,
            range_m_max: 10.0,
            ..Scan::default()
        }
    }

    /// Everything in one place, so that all hits confirm each other.
    fn beams(n: u32, step_rad: f32) -> Scan {
        Scan {
            n_beams: n,
            angle_increment_rad: step_rad,
            range_m_min: 0.1,
            range_m_max: 10.0,
            ..Scan::default()
        }
    }

    fn still(points: &mut ScanPoints, scan: &Scan, ranges: &[f32], laser: &Pose) -> usize {
        let before_ns = points.captured.map_or(0, |(_, run_ns)| run_ns);
        let captured = (&Pose::default(), before_ns + 100_000_000);
        points.take(scan, ranges, laser, captured, Twist::REST);
        points.carry(&Pose::default(), &Pose::default()).len()
    }

    #[test]
    fn hits_become_points_and_the_rest_does_not() {
        let mut points = ScanPoints::default();
        let ranges = [1.0, f32::INFINITY, f32::NAN, 2.0];
        let laser = Pose::new(0.2, 0.0, 0.0);
        still(&mut points, &scan(0.0), &ranges, &laser);
        assert_eq!(still(&mut points, &scan(0.0), &ranges, &laser), 2);
        let found = points.carry(&Pose::default(), &Pose::default());
        assert!((found[0] - Point2::new(1.2, 0.0)).norm() < 1e-6);
        assert!((found[1] - Point2::new(0.2, -2.0)).norm() < 1e-6);
    }

    #[test]
    fn points_stand_still_while_the_robot_moves() {
        let mut points = ScanPoints::default();
        still(&mut points, &scan(0.0), &[1.0; 4], &Pose::default());
        assert_eq!(
            still(&mut points, &scan(0.0), &[1.0; 4], &Pose::default()),
            4
        );
        let now = Pose::new(0.5, 0.0, core::f64::consts::FRAC_PI_2);
        let found = points.carry(&Pose::default(), &now);
        assert!((found[0] - Point2::new(0.0, -0.5)).norm() < 1e-6);
    }

    #[test]
    fn early_beams_are_moved_to_the_capture() {
        let mut points = ScanPoints::default();
        // 1 m/s ahead, 0.1 s per beam: beam 0 was seen 0.3 m further back.
        let twist = Twist::new(1.0, 0.0);
        let here = Pose::default();
        for run_ns in [0, 100_000_000] {
            points.take(&scan(0.1), &[2.0; 4], &here, (&here, run_ns), twist);
        }
        let found = points.carry(&here, &here);
        assert!((found[0] - Point2::new(1.7, 0.0)).norm() < 1e-6);
        assert!((found[3] - Point2::new(0.0, -2.0)).norm() < 1e-6);
    }

    #[test]
    fn a_lone_hit_counts_once_the_next_scan_confirms_it() {
        let none = f32::INFINITY;
        let mut points = ScanPoints::default();
        let one = beams(9, 0.01);
        let fly = [none, none, none, none, 1.0, none, none, none, none];
        let here = Pose::default();
        assert_eq!(
            still(&mut points, &one, &fly, &here),
            0,
            "nobody else saw it"
        );
        assert_eq!(still(&mut points, &one, &[none; 9], &here), 0);
        assert_eq!(
            still(&mut points, &one, &fly, &here),
            0,
            "the last scan did not"
        );
        assert_eq!(still(&mut points, &one, &fly, &here), 1, "there twice");
        // A leg as wide as two beams is there at once, two flies at two ranges are not.
        let leg = [none, none, none, 1.0, 1.01, none, none, none, none];
        assert_eq!(still(&mut ScanPoints::default(), &one, &leg, &here), 2);
        let flies = [none, none, none, 1.0, 1.5, none, none, none, none];
        assert_eq!(still(&mut ScanPoints::default(), &one, &flies, &here), 0);
        // Confirmed where it was, although the robot has moved since: 0.3 m ahead and turned.
        let mut points = ScanPoints::default();
        points.take(&one, &fly, &here, (&here, 0), Twist::REST);
        let there = Pose::new(0.3, 0.0, 0.02);
        let mut nearer = fly;
        nearer[4] = 1.0;
        nearer.swap(4, 3);
        let at = Point2::new(0.04_f64.cos(), 0.04_f64.sin());
        let seen = there.isometry().inverse() * at;
        nearer[3] = seen.coords.norm().to_f32();
        points.take(&one, &nearer, &here, (&there, 100_000_000), Twist::REST);
        assert_eq!(points.carry(&there, &there).len(), 1);
    }

    #[test]
    fn two_drops_of_rain_near_each_other_do_not_confirm_each_other() {
        let none = f32::INFINITY;
        let (one, here) = (beams(9, 0.01), Pose::default());
        let drop = |range_m| [none, none, none, none, range_m, none, none, none, none];
        let after = |range_m| {
            let mut points = ScanPoints::default();
            still(&mut points, &one, &drop(1.0), &here);
            still(&mut points, &one, &drop(range_m), &here)
        };
        assert_eq!(after(1.06), 0, "another drop");
        assert_eq!(after(1.02), 1, "a wire");
        // Of many scans in a short time all have to show it, and as long.
        let mut points = ScanPoints::default();
        for n in 0..6 {
            let captured = (&here, n * 25_000_000);
            points.take(&one, &drop(1.0), &here, captured, Twist::REST);
            assert_eq!(points.carry(&here, &here).len(), usize::from(n >= 4));
        }
    }

    /// In a narrow passage every drop lies close before a wall, and where beams lie close some hit neighbouring ones.
    #[test]
    fn drops_on_neighbouring_beams_and_close_before_a_wall_are_drops() {
        let (wall, here) = (1.2, Pose::default());
        let seen = |drops: &[usize]| {
            let mut ranges = [wall; 15];
            for beam in drops {
                ranges[*beam] = 1.0;
            }
            // 4 mm apart: two are thin, three are not.
            still(
                &mut ScanPoints::default(),
                &beams(15, 0.004),
                &ranges,
                &here,
            )
        };
        assert_eq!(seen(&[7]), 14);
        assert_eq!(seen(&[7, 8]), 13);
        assert_eq!(seen(&[6, 7, 8]), 15);
        // With a drop of its own beside.
        assert_eq!(seen(&[5, 7]), 13);
    }

    #[test]
    fn a_beam_that_hits_an_edge_and_something_behind_it_is_not_there() {
        let (post, wall) = (1.0, 3.0);
        let mut points = ScanPoints::default();
        let mixed = [post, post, post, 1.9, wall, wall, wall, wall, wall];
        assert_eq!(
            still(&mut points, &beams(9, 0.01), &mixed, &Pose::default()),
            8
        );
    }

    #[test]
    fn noise_is_averaged_and_surfaces_stay_where_they_are() {
        let step_rad = 0.25_f32.to_radians();
        let mut random = Pcg32::seed_from_u64(4);
        let n = 361;
        let scan = Scan {
            angle_min_rad: -180.0 * step_rad,
            ..beams(n, step_rad)
        };
        // A wall half a metre ahead, at an angle, with 4 cm of noise at most.
        let slope = 0.6;
        let truth: Vec<f64> = (0..361)
            .map(|i| {
                let (sin, cos) = scan.angle_of(i).sin_cos();
                0.5 / (cos - slope * sin)
            })
            .collect();
        let (mut raw_m, mut kept_m, mut bias_m) = (0.0_f64, 0.0_f64, 0.0_f64);
        for _ in 0..20 {
            let noise: Vec<f64> = (0..361).map(|_| random.random_range(-0.02..0.02)).collect();
            let ranges: Vec<f32> = truth
                .iter()
                .zip(&noise)
                .map(|(r, e)| (r + e).to_f32())
                .collect();
            let mut points = ScanPoints::default();
            assert_eq!(still(&mut points, &scan, &ranges, &Pose::default()), 361);
            let found = points.carry(&Pose::default(), &Pose::default());
            // All but the ends.
            for i in 10..351 {
                let off_m = found[i].coords.norm() - truth[i];
                raw_m += noise[i].powi(2);
                kept_m += off_m.powi(2);
                bias_m += off_m - noise[i];
            }
        }
        let n = 20.0 * 341.0;
        let (raw_m, kept_m, bias_m) = ((raw_m / n).sqrt(), (kept_m / n).sqrt(), bias_m / n);
        println!("noise {raw_m:.4} m, then {kept_m:.4} m, bias {bias_m:.5} m");
        assert!(kept_m < 0.5 * raw_m, "{kept_m} of {raw_m}");
        assert!(bias_m.abs() < 5e-4, "{bias_m}");
    }
}
