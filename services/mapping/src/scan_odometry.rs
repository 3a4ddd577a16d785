//! How far the robot has come since a scan of a moment ago, judged by both scans.
//!
//! On an unknown map every cell is marked from a pose that has already drifted, so the map holds the
//! robot where odometry led it. Two scans of the same surfaces are better evidence: the current scan is matched
//! onto the lines between the neighbouring hits of a **key scan** (point to line, Censi, "An ICP
//! variant using a point-to-line metric", 2008), with the odometry since then as a prior and with
//! weights that let go of what has moved by itself (Geman, `McClure`, 1987). A key scan serves until
//! the robot has gone or turned some way or sees too little of it, so drift grows with their number.

use crate::near_points::NearPoints;
use crate::pose_error::{swing, turned};
use nalgebra::{Isometry2, Matrix3, Point2, Vector2, Vector3};
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;

/// Most points that are laid; of more, every n-th.
const POINTS_MAX: usize = 180;

/// Fewest that must find a line.
const FOUND_MIN: usize = 20;

/// Share of the points that must find a line, and below which the next key scan is due.
const FOUND_SHARE: (f64, f64) = (0.3, 0.6);

/// Standard deviation of a point's distance from its line. [m]
const SIGMA_M: f64 = 0.015;

/// What a point is worth, in independent ones: neighbours share their errors.
const POINT_WORTH: f64 = 0.2;

/// 99 % of a chi-squared variable with three degrees of freedom lie below.
const GATE: f64 = 11.34;

/// Distance at which a point's weight is a quarter. [m]
const LETS_GO_M: f64 = 0.05;

/// Motion after which the next key scan is due. [m, rad]
const KEY: (f64, f64) = (0.3, 0.4);

/// Steps of Gauss and Newton.
const STEPS_MAX: usize = 8;

/// Follows the robot from key scan to key scan.
#[derive(Debug, Default)]
pub(crate) struct ScanOdometry {
    key: NearPoints,
    /// `odom_from_base` at the key scan.
    odom_from_key: Pose,
    /// `key_from_base` at the last scan.
    key_from_base: Pose,
    /// The same by odometry alone.
    odometry: Pose,
    /// Of `key_from_base` by odometry alone, x, y and yaw. [m^2, m rad, rad^2]
    drift: Matrix3<f64>,
}

/// What two scans say about the motion between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moved {
    /// `last_from_base`.
    pub(crate) last_from_base: Pose,
    /// What is left of an error of the odometry's step, in the axes of `base`.
    pub(crate) left: Matrix3<f64>,
}

impl ScanOdometry {
    /// The motion since the last scan, given where odometry says the robot is, the covariance of its
    /// step since then (x and y alike), and where beams ended that are not known to be on what moves, in
    /// `base`. [m] Where something moves, a scan that contradicts odometry is not believed; elsewhere the
    /// wheels may well have slipped.
    pub(crate) fn follow(
        &mut self,
        odom_from_base: &Pose,
        noise: &Matrix3<f64>,
        ends: &[Point2<f64>],
        something_moves: bool,
    ) -> Moved {
        let before = self.key_from_base;
        let by_odometry = between(&self.odom_from_key, odom_from_base);
        let step = swing(&(by_odometry.point() - self.odometry.point()));
        self.drift = step * self.drift * step.transpose() + noise;
        // Those who walk would carry the robot along from scan to scan.
        let guess = if something_moves {
            by_odometry
        } else {
            before.then(&between(&self.odometry, &by_odometry))
        };
        self.odometry = by_odometry;
        let laid = self
            .lay(ends, (&by_odometry, &guess))
            .filter(|laid| !(something_moves && laid.surprise > GATE));
        let (at, left) = laid
            .as_ref()
            .map_or((by_odometry, Matrix3::identity()), |laid| {
                (laid.pose, laid.left)
            });
        self.key_from_base = at;
        let moved = Moved {
            last_from_base: between(&before, &at),
            left: turned(-at.yaw_rad) * left,
        };
        let is_far = at.x_m.hypot(at.y_m) > KEY.0 || at.yaw_rad.abs() > KEY.1;
        // A scan that cannot be believed tells against the next key scan, too: those who walk have
        // come too far to be taken for static only after a while.
        if is_far || laid.is_some_and(|laid| laid.share < FOUND_SHARE.1) {
            self.begin(odom_from_base, ends);
        }
        moved
    }

    /// The next key scan.
    pub(crate) fn begin(&mut self, odom_from_base: &Pose, ends: &[Point2<f64>]) {
        self.key.fill(ends);
        self.odom_from_key = *odom_from_base;
        self.key_from_base = Pose::default();
        self.odometry = Pose::default();
        self.drift = Matrix3::zeros();
    }

    /// `key_from_base` near `guess`, where odometry says `predicted`.
    fn lay(&self, ends: &[Point2<f64>], (predicted, guess): (&Pose, &Pose)) -> Option<Laid> {
        let every = ends.len().div_ceil(POINTS_MAX).max(1);
        let prior =
            (self.drift + Matrix3::from_diagonal(&Vector3::repeat(1.0e-8))).try_inverse()?;
        let start = Vector3::new(predicted.x_m, predicted.y_m, predicted.yaw_rad);
        let mut at = Vector3::new(guess.x_m, guess.y_m, guess.yaw_rad);
        let mut information = prior;
        let mut share = 0.0;
        for _ in 0..STEPS_MAX {
            let (sin, cos) = at.z.sin_cos();
            let mut normal = Matrix3::zeros();
            let mut right = Vector3::zeros();
            let (mut n, mut found, mut near) = (0_usize, 0_usize, 0.0);
            for end in ends.iter().step_by(every) {
                n += 1;
                let turned = Vector2::new(cos * end.x - sin * end.y, sin * end.x + cos * end.y);
                let place = Point2::new(at.x + turned.x, at.y + turned.y);
                let Some(line) = self.key.line_near(place) else {
                    continue;
                };
                found += 1;
                let distance_m = (place - line.at).dot(&line.normal);
                let weight = (1.0 + (distance_m / LETS_GO_M).powi(2)).powi(-2);
                near += weight;
                let row = Vector3::new(
                    line.normal.x,
                    line.normal.y,
                    line.normal.y * turned.x - line.normal.x * turned.y,
                );
                normal += row * row.transpose() * weight;
                right += row * (weight * distance_m);
            }
            #[allow(clippy::cast_precision_loss, reason = "a scan's points")]
            let all = n as f64;
            if found < FOUND_MIN || near < FOUND_SHARE.0 * all {
                return None;
            }
            share = near / all;
            let worth = POINT_WORTH / (SIGMA_M * SIGMA_M);
            information = prior + normal * worth;
            let step = information.try_inverse()? * (prior * (at - start) + right * worth);
            at -= step;
            if step.norm() < 1.0e-5 {
                break;
            }
        }
        let off = at - start;
        Some(Laid {
            pose: Pose::new(at.x, at.y, wrap_angle(at.z)),
            left: information.try_inverse()? * prior,
            share,
            surprise: (off.transpose() * prior * off).x,
        })
    }
}

/// A scan on a key scan.
struct Laid {
    /// `key_from_base`.
    pose: Pose,
    /// What is left of an error of the prior.
    left: Matrix3<f64>,
    /// Of the points that lie on lines.
    share: f64,
    /// By how much it contradicts odometry, squared, in standard deviations.
    surprise: f64,
}

/// `a_from_b` of two poses in one frame.
fn between(a: &Pose, b: &Pose) -> Pose {
    let isometry: Isometry2<f64> = a.isometry().inverse() * b.isometry();
    Pose::from(isometry)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ends of the beams, in `base`, in a hall of 6 m x 4 m with a pillar, seen from a pose.
    fn hall(from: &Pose) -> Vec<Point2<f64>> {
        let into_base = from.isometry().inverse();
        let edge = |n: i32, from: [f64; 2], to: [f64; 2]| {
            (0..n).map(move |k| {
                let share = f64::from(k) / f64::from(n);
                Point2::new(
                    from[0] + share * (to[0] - from[0]),
                    from[1] + share * (to[1] - from[1]),
                )
            })
        };
        edge(200, [-3.0, -2.0], [3.0, -2.0])
            .chain(edge(140, [3.0, -2.0], [3.0, 2.0]))
            .chain(edge(200, [3.0, 2.0], [-3.0, 2.0]))
            .chain(edge(140, [-3.0, 2.0], [-3.0, -2.0]))
            .chain(edge(20, [1.0, 0.5], [1.0, 0.9]))
            .map(|point| into_base * point)
            .collect()
    }

    fn noise(length_m: f64, turn_rad: f64) -> Matrix3<f64> {
        let place = 0.03_f64.powi(2) * length_m;
        let yaw = 0.04_f64.powi(2) * turn_rad + 0.02_f64.powi(2) * length_m;
        Matrix3::from_diagonal(&Vector3::new(place, place, yaw))
    }

    /// An arc of 3 m in steps of 4 cm, with odometry that reads lengths 4 % and turns 8 % too long.
    fn arc(moves: bool, mut see: impl FnMut(f64, &Pose) -> Vec<Point2<f64>>) -> (Pose, Pose, Pose) {
        let (mut truth, mut odometry) = (Pose::new(-1.5, -1.0, 0.0), Pose::default());
        let mut judged = truth;
        let mut scans = ScanOdometry::default();
        scans.begin(&odometry, &see(0.0, &truth));
        let step = Pose::new(0.04, 0.0, 0.015);
        for n in 1..=75 {
            truth = truth.then(&step);
            odometry = odometry.then(&Pose::new(1.04 * 0.04, 0.0, 1.08 * 0.015));
            let moved = scans.follow(
                &odometry,
                &noise(0.04, 0.015),
                &see(f64::from(n), &truth),
                moves,
            );
            judged = judged.then(&moved.last_from_base);
        }
        (truth, judged, Pose::new(-1.5, -1.0, 0.0).then(&odometry))
    }

    #[test]
    fn two_scans_of_a_hall_know_better_than_odometry() {
        let (truth, judged, by_odometry) = arc(false, |_, from| hall(from));
        assert!(by_odometry.distance_m(&truth) > 0.15);
        assert!(judged.distance_m(&truth) < 0.02, "{judged:?} {truth:?}");
        assert!(wrap_angle(judged.yaw_rad - truth.yaw_rad).abs() < 0.01);
    }

    /// Without anything to see, and where all that is seen walks, the robot is where odometry says.
    #[test]
    fn nothing_and_those_who_walk_are_not_believed() {
        let (_, judged, by_odometry) = arc(true, |_, _| Vec::new());
        assert!(judged.distance_m(&by_odometry) < 1e-9);
        // 40 Hz, 1.2 m/s sideways.
        let (_, judged, by_odometry) = arc(true, |n, from| {
            let walked = Pose::new(from.x_m, from.y_m - 0.03 * n, from.yaw_rad);
            hall(&walked)
        });
        let off_m = judged.distance_m(&by_odometry);
        assert!(off_m < 0.25, "{off_m} of 2.25 m");
    }

    /// Wheels that slip: odometry says twice what was driven. Nothing moves, so the scans decide.
    #[test]
    fn slip_is_seen() {
        let (mut truth, mut odometry) = (Pose::new(-1.5, -1.0, 0.0), Pose::default());
        let mut judged = truth;
        let mut scans = ScanOdometry::default();
        scans.begin(&odometry, &hall(&truth));
        for _ in 0..60 {
            truth = truth.then(&Pose::new(0.02, 0.0, 0.005));
            odometry = odometry.then(&Pose::new(0.04, 0.0, 0.01));
            let moved = scans.follow(&odometry, &noise(0.04, 0.01), &hall(&truth), false);
            judged = judged.then(&moved.last_from_base);
        }
        assert!(judged.distance_m(&truth) < 0.1, "{judged:?} {truth:?}");
    }

    #[test]
    fn what_scans_tell_is_what_odometry_does_not_err_by() {
        let mut scans = ScanOdometry::default();
        scans.begin(&Pose::default(), &hall(&Pose::default()));
        let odometry = Pose::new(0.05, 0.0, 0.0);
        let moved = scans.follow(&odometry, &noise(0.05, 0.0), &hall(&odometry), true);
        let left = moved.left.diagonal();
        assert!(left.iter().all(|left| (0.0..0.9).contains(left)), "{left}");
        let moved = scans.follow(&odometry, &noise(0.05, 0.0), &[], true);
        assert_eq!(moved.left, Matrix3::identity());
    }
}
