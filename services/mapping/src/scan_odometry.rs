//! How far the robot has come since a scan of a moment ago, judged by both scans.
//!
//! On an unknown map every cell is marked from a pose that has already drifted, so the map holds the
//! robot where odometry led it. Two scans of the same surfaces are better evidence: the current scan is matched
//! onto the lines between the neighbouring hits of a **key scan** (point to line, Censi, "An ICP
//! variant using a point-to-line metric", 2008), with the odometry since then as a prior and with
//! weights that let go of what has moved by itself (Geman, `McClure`, 1987). A key scan serves until
//! the robot has gone or turned some way or sees too little of it, so drift grows with their number.
//!
//! Wheels that slip lie about the motion by more than the prior allows, and a match that begins where
//! they say lets go of everything. What lies where the key scan did not look counts for nothing: the edge of the
//! view goes along with the robot, as if it stood. So what other motions explain is looked at in every scan
//! (`slip.rs`): none at all, none since the key scan, and that of the scan before. Where one of them explains more, the scans
//! carry the robot; where nothing explains a scan full of points, the motion is not known.
//!
//! Odometry that claims to be exact is only watched: a few points of each scan tell whether the rest is worth a look (`consistency.rs`).

mod consistency;

use crate::moved::{Basis, Moved, TOLD_M, deviations};
use crate::near_points::{NearPoints, is_linked};
use crate::pose_error::{swing, turned};
use crate::slip::{Ends, EndsOf, apart, is_share_of, motions};
use nalgebra::{Isometry2, Matrix3, Point2, Vector2, Vector3};
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;

/// Most points that are laid; of more, every n-th.
const POINTS_MAX: usize = 180;

/// Fewest that must find a line.
const FOUND_MIN: f64 = 20.0;

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

/// The same in standard deviations of what the lidar measures, where that is more.
const LETS_GO_SIGMAS: f64 = 2.5;

/// The same where a motion is looked for that odometry does not tell. [m]
const LETS_GO_FAR_M: f64 = 0.12;

/// Share of the points by which another motion must explain more for odometry to be doubted.
const EXPLAINS_MORE: f64 = 0.08;

/// Share of the points that a motion which contradicts odometry must explain; where something moves,
/// which may carry the robot along, or where wheels that slip do not explain the motion.
const SLIP_SHARE: (f64, f64) = (0.35, 0.6);

/// Fewest points of a scan that nothing explains by which the motion counts as unknown.
const LOST_POINTS_MIN: usize = 60;

/// How far a motion that contradicts odometry may be from where it was looked for, at least. [m, rad]
const WEAK: (f64, f64) = (0.05, 0.05);

/// Share of the points by which a motion must explain more than one that is nearer to odometry's.
const BETTER: f64 = 0.02;

/// Most motions that are followed up when odometry is contradicted.
const BEST: usize = 3;

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
    /// The last scan's `last_from_base`.
    last: Pose,
    /// Of `key_from_base` by odometry alone, x, y and yaw. [m^2, m rad, rad^2]
    drift: Matrix3<f64>,
    /// Share of the points that lay on lines when a scan was matched last.
    share: f64,
    /// Scratch: the ends that lie on a line.
    linked: EndsOf,
    /// Scratch: the ends as another motion than odometry's has them. [m]
    ends: Vec<Point2<f64>>,
}

impl ScanOdometry {
    /// The motion since the last scan, given where odometry says the robot is, the covariance of its
    /// step since then (x and y alike), and where beams ended that are not known to be on what moves.
    /// Where something moves, a scan that contradicts odometry is believed only when it says that the
    /// wheels have slipped; elsewhere they may well have.
    pub(crate) fn follow(
        &mut self,
        odom_from_base: &Pose,
        noise: &Matrix3<f64>,
        ends: &Ends<'_>,
        something_moves: bool,
    ) -> Moved {
        // What lies on no line itself cannot tell where it is on others.
        let mut linked = core::mem::take(&mut self.linked);
        let moved = self.follow_linked(
            odom_from_base,
            noise,
            &linked.of(ends, is_linked),
            something_moves,
        );
        self.linked = linked;
        moved
    }

    fn follow_linked(
        &mut self,
        odom_from_base: &Pose,
        noise: &Matrix3<f64>,
        ends: &Ends<'_>,
        something_moves: bool,
    ) -> Moved {
        let before = self.key_from_base;
        let by_odometry = between(&self.odom_from_key, odom_from_base);
        let step = swing(&(by_odometry.point() - self.odometry.point()));
        self.drift = step * self.drift * step.transpose() + noise;
        let step = between(&self.odometry, &by_odometry);
        // Those who walk would carry the robot along from scan to scan.
        let guess = if something_moves {
            by_odometry
        } else {
            before.then(&step)
        };
        self.odometry = by_odometry;
        let laid = self
            .lay(ends.at, (&by_odometry, &self.drift), &guess, LETS_GO_M)
            .filter(|laid| !(something_moves && laid.surprise > GATE));
        // What is left where most may move lies on the lines of many motions.
        let slip = if ends.are_most && self.is_contradicted(ends, laid.as_ref(), &step) {
            self.slip(ends, laid.as_ref(), &step, something_moves)
        } else {
            None
        };
        // That says nothing where the scans before were not matched, either.
        let contradicted = laid.is_none()
            && !something_moves
            && ends.are_most
            && ends.at.len() >= LOST_POINTS_MIN
            && self.key.len() >= LOST_POINTS_MIN
            && self.share > FOUND_SHARE.1;
        let (at, noise, left, basis) = match (&slip, &laid) {
            (Some((slip, weak)), _) => (slip.pose, *weak, slip.left, Basis::Scans),
            (None, Some(laid)) => (laid.pose, *noise, laid.left, Basis::Odometry),
            (None, None) if contradicted && apart(&step, &Pose::default()) => {
                let lost = Vector3::new(step.x_m, step.y_m, step.yaw_rad);
                let place = lost.xy().norm_squared();
                let all = Vector3::new(place, place, lost.z * lost.z);
                let all = Matrix3::from_diagonal(&all) + noise;
                (by_odometry, all, Matrix3::identity(), Basis::Nothing)
            }
            (None, None) => (by_odometry, *noise, Matrix3::identity(), Basis::Odometry),
        };
        self.key_from_base = at;
        self.last = between(&before, &at);
        let share = slip.map_or(laid.map(|laid| laid.share), |(slip, _)| Some(slip.share));
        let moved = Moved {
            last_from_base: self.last,
            noise,
            left: turned(-at.yaw_rad) * left,
            basis,
            share: share.unwrap_or(0.0),
        };
        self.share = share.unwrap_or(self.share);
        self.go_on(odom_from_base, (ends, &step), &moved, share);
        moved
    }

    /// Odometry says at once that the robot is somewhere else, by more than it can drive: until the
    /// scans tell more, it goes on as it did.
    pub(crate) fn jumped(&mut self, odom_from_base: &Pose) {
        let as_before = self.key_from_base.then(&self.last);
        self.rebase(odom_from_base, &as_before);
        self.odometry = self.key_from_base;
    }

    /// From now on odometry's motion counts from `at`, `key_from_base`.
    fn rebase(&mut self, odom_from_base: &Pose, at: &Pose) {
        let base_from_key = Pose::from(at.isometry().inverse());
        self.odom_from_key = odom_from_base.then(&base_from_key);
        self.odometry = *at;
    }

    /// What the next scan is judged by: the same key scan, or this scan as the next one.
    fn go_on(
        &mut self,
        odom_from_base: &Pose,
        (ends, step): (&Ends<'_>, &Pose),
        moved: &Moved,
        share: Option<f64>,
    ) {
        let at = self.key_from_base;
        if moved.basis == Basis::Scans {
            self.rebase(odom_from_base, &at);
            let left = turned(at.yaw_rad) * moved.left;
            self.drift = left * moved.noise * left.transpose();
        }
        // A scan that cannot be believed tells against the next key scan, too: those who walk have
        // come too far to be taken for static only after a while.
        let is_lost = moved.basis == Basis::Nothing;
        if self.is_key_due() || is_lost || share.is_some_and(|share| share < FOUND_SHARE.1) {
            let last = self.last;
            if moved.basis == Basis::Scans {
                ends.along(&mut self.ends, step, &last);
                let ends = core::mem::take(&mut self.ends);
                self.begin(odom_from_base, &ends);
                self.ends = ends;
            } else {
                self.begin(odom_from_base, ends.at);
            }
            self.last = last;
        }
    }

    /// True when the robot has come so far from the key scan that the next one is due.
    pub(crate) fn is_key_due(&self) -> bool {
        let at = self.key_from_base;
        at.x_m.hypot(at.y_m) > KEY.0 || at.yaw_rad.abs() > KEY.1
    }

    /// The next key scan.
    pub(crate) fn begin(&mut self, odom_from_base: &Pose, ends: &[Point2<f64>]) {
        self.key.fill(ends);
        self.odom_from_key = *odom_from_base;
        self.key_from_base = Pose::default();
        self.odometry = Pose::default();
        self.last = Pose::default();
        self.drift = Matrix3::zeros();
    }

    /// Distance at which a point lets go, with a lidar as noisy as this. [m]
    fn lets_go_m(&self, lets_go_m: f64) -> f64 {
        lets_go_m.max(LETS_GO_SIGMAS * self.key.noise_m())
    }

    /// The motion that explains the scan best although odometry's `step` says otherwise, with the
    /// covariance that it was looked for with; `None` where none explains enough.
    fn slip(
        &mut self,
        ends: &Ends<'_>,
        laid: Option<&Laid>,
        step: &Pose,
        something_moves: bool,
    ) -> Option<(Laid, Matrix3<f64>)> {
        let before = self.key_from_base;
        let found = laid.map(|laid| between(&before, &laid.pose));
        let mut best = [(0.0, Pose::default()); BEST];
        let others = [self.last, self.back_to_key()];
        for motion in motions(step).chain(others) {
            let share = self.explained(ends, (step, &motion), LETS_GO_FAR_M, best[BEST - 1].0);
            let mut row = (share, motion);
            for place in &mut best {
                if row.0 > place.0 {
                    core::mem::swap(place, &mut row);
                }
            }
        }
        let (place, yaw) = (
            step.x_m.hypot(step.y_m).max(WEAK.0).powi(2),
            step.yaw_rad.abs().max(WEAK.1).powi(2),
        );
        let weak = Matrix3::from_diagonal(&Vector3::new(place, place, yaw));
        // Where several motions explain as much, the one nearest to odometry's is taken.
        let mut winner: Option<Laid> = None;
        let rest = best.into_iter().filter(|(share, _)| *share > 0.0);
        for motion in found.into_iter().chain(rest.map(|(_, motion)| motion)) {
            let Some(laid) = self.refine(ends, step, &motion, &weak) else {
                continue;
            };
            let beats = |best: &Laid| laid.share > best.share + BETTER;
            if winner.as_ref().is_none_or(beats) {
                winner = Some(laid);
            }
        }
        let winner = winner?;
        let needed = if something_moves {
            SLIP_SHARE.1
        } else {
            SLIP_SHARE.0
        };
        let already = laid.map_or(0.0, |laid| {
            if laid.surprise > GATE {
                laid.share + BETTER
            } else {
                laid.share + 0.5 * EXPLAINS_MORE
            }
        });
        // Along a bare wall any motion explains the scan, and by chance another one than odometry's explains more:
        // there odometry tells, unless it does not explain a scan full of points.
        let is_told = || deviations(&winner.left, &weak).0 <= TOLD_M;
        let may_be_right = laid.is_some() || ends.at.len() < LOST_POINTS_MIN;
        if may_be_right && !is_told() {
            return None;
        }
        if winner.share < needed.max(already) {
            return None;
        }
        let motion = between(&before, &winner.pose);
        let slips = !something_moves && winner.share >= SLIP_SHARE.1
            || is_share_of(&motion, step)
            || is_share_of(&winner.pose, &self.odometry);
        slips.then_some((winner, weak))
    }

    /// A motion found about right, made exact, first with what lies farther off, and with beams that
    /// start from where it has the laser.
    fn refine(
        &mut self,
        ends: &Ends<'_>,
        step: &Pose,
        motion: &Pose,
        weak: &Matrix3<f64>,
    ) -> Option<Laid> {
        let before = self.key_from_base;
        let centre = before.then(motion);
        let mut laid: Option<Laid> = None;
        for lets_go_m in [LETS_GO_FAR_M, LETS_GO_M] {
            let guess = laid.as_ref().map_or(centre, |laid| laid.pose);
            ends.along(&mut self.ends, step, &between(&before, &guess));
            laid = Some(self.lay(&self.ends, (&centre, weak), &guess, lets_go_m)?);
        }
        laid
    }

    /// `key_from_base` near `guess`, where the prior says `predicted` with a covariance.
    fn lay(
        &self,
        ends: &[Point2<f64>],
        (predicted, covariance): (&Pose, &Matrix3<f64>),
        guess: &Pose,
        lets_go_m: f64,
    ) -> Option<Laid> {
        let prior =
            (covariance + Matrix3::from_diagonal(&Vector3::repeat(1.0e-8))).try_inverse()?;
        let start = Vector3::new(predicted.x_m, predicted.y_m, predicted.yaw_rad);
        let mut at = Vector3::new(guess.x_m, guess.y_m, guess.yaw_rad);
        let mut information = prior;
        let mut share = 0.0;
        let lets_go_m = self.lets_go_m(lets_go_m);
        let sigma_m = SIGMA_M.max(self.key.noise_m());
        for _ in 0..STEPS_MAX {
            let Sums {
                normal,
                right,
                all,
                found,
                near,
            } = self.sums(ends, &at, lets_go_m);
            if found < FOUND_MIN || near < FOUND_SHARE.0 * all {
                return None;
            }
            share = near / all;
            let worth = POINT_WORTH / (sigma_m * sigma_m);
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

    /// Of the ends, or every n-th, with `key_from_base` at x, y and yaw.
    fn sums(&self, ends: &[Point2<f64>], at: &Vector3<f64>, lets_go_m: f64) -> Sums {
        let every = ends.len().div_ceil(POINTS_MAX).max(1);
        let (sin, cos) = at.z.sin_cos();
        let mut sums = Sums::default();
        for end in ends.iter().step_by(every) {
            let turned = Vector2::new(cos * end.x - sin * end.y, sin * end.x + cos * end.y);
            let place = Point2::new(at.x + turned.x, at.y + turned.y);
            if !self.key.is_in_view(place) {
                continue;
            }
            sums.all += 1.0;
            let Some(line) = self.key.line_near(place) else {
                continue;
            };
            sums.found += 1.0;
            let distance_m = (place - line.at).dot(&line.normal);
            let weight = weight(distance_m, lets_go_m);
            sums.near += weight;
            let row = Vector3::new(
                line.normal.x,
                line.normal.y,
                line.normal.y * turned.x - line.normal.x * turned.y,
            );
            sums.normal += row * row.transpose() * weight;
            sums.right += row * (weight * distance_m);
        }
        sums
    }
}

/// Sums over the ends of a scan on a key scan.
#[derive(Debug, Default)]
struct Sums {
    /// Of the normal equations in x, y and yaw.
    normal: Matrix3<f64>,
    right: Vector3<f64>,
    /// Points that lie where the key scan looked, and those with a line.
    all: f64,
    found: f64,
    /// What they count.
    near: f64,
}

/// A scan on a key scan.
#[derive(Debug)]
struct Laid {
    /// `key_from_base`.
    pose: Pose,
    /// What is left of an error of the prior.
    left: Matrix3<f64>,
    /// Of the points that lie on lines.
    share: f64,
    /// By how much it contradicts the prior, squared, in standard deviations.
    surprise: f64,
}

/// What a point at a distance from its line counts.
fn weight(distance_m: f64, lets_go_m: f64) -> f64 {
    (1.0 + (distance_m / lets_go_m).powi(2)).powi(-2)
}

/// `a_from_b` of two poses in one frame.
fn between(a: &Pose, b: &Pose) -> Pose {
    let isometry: Isometry2<f64> = a.isometry().inverse() * b.isometry();
    Pose::from(isometry)
}

#[cfg(test)]
mod tests;
