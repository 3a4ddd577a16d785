//! `map_from_odom`: what odometry has drifted away by.

use crate::moved::{Basis, Moved};
use crate::pose_error::{CEILING, limit, swing, turned};
use crate::scan_match::{Match, Surfaces};
use crate::scan_odometry::ScanOdometry;
use crate::slip::Ends;
use nalgebra::{Matrix3, Point2, Vector3};
use zeronav_msgs::Pose;
use zeronav_msgs::certainty::{POSE_SIGMA_M_MAX, POSE_SIGMA_RAD_MAX, POSE_SIGMA_TOLD};
use zeronav_msgs::pose::wrap_angle;
use zeronav_params::{choices, parameters};

choices! {
    /// Whether the pose is corrected.
    pub enum CorrectionMode {
        /// When odometry states a variance above 0.
        #[default]
        Auto = "auto",
        /// Always.
        On = "on",
        /// Never: `odom` is `map`.
        Off = "off",
    }
}

parameters! {
    /// How the pose is corrected, and how far odometry is trusted.
    #[derive(Copy)]
    pub struct CorrectionConfig {
        /// Whether `map_from_odom` is corrected by scans.
        mode: CorrectionMode = CorrectionMode::Auto;
        /// Standard deviation of odometry's position after 1 m.
        noise_m_per_sqrt_m: f64 = 0.03, [0.0, 1.0] "m/sqrt(m)";
        /// Standard deviation of odometry's yaw after a turn of 1 rad.
        noise_rad_per_sqrt_rad: f64 = 0.04, [0.0, 1.0] "rad/sqrt(rad)";
        /// Standard deviation of odometry's yaw after 1 m.
        noise_rad_per_sqrt_m: f64 = 0.02, [0.0, 1.0] "rad/sqrt(m)";
    }
}

/// Times the deviation of the yaw that odometry claims by which it is trusted, when that is less than
/// the configuration's: with a gyro it knows the yaw better than scans do among those who walk.
const CLAIM: f64 = 2.0;

/// Motion of which nothing is known from which on the pose is uncertain. [m, rad]
const UNKNOWN: (f64, f64) = (0.1, 0.15);

/// Standard deviations of an uncertain pose beyond the motion of which nothing is known, as shares of
/// those from which on readers must not rely on it.
const UNCERTAIN: f64 = 1.01;

/// Deviations of the pose of a lost robot, which may be anywhere. [m, rad]
const LOST: (f64, f64) = (10.0, 3.2);

/// How far beyond the motion of which nothing is known the scan is looked for on the map. [m, rad]
const BEYOND: (f64, f64) = (0.3, 0.2);

/// Share of the fastest motion, and the slack, beyond which a step of odometry is no motion. [m, rad]
const JUMP: (f64, f64, f64) = (1.5, 0.05, 0.1);

/// How far a way from key scan to key scan leads away, as a share of it.
const DRIFT: f64 = 0.01;

/// Largest standard deviations against its own map of a pose that was known when the map was taken over. [m, rad]
const TAKEN_OVER: (f64, f64) = (0.05, 0.02);

/// Share of the points that must contradict odometry that claims to be exact.
const NOTICED_SHARE: f64 = 0.6;

/// Odometry at a scan.
#[derive(Debug, Clone, Copy)]
pub struct OdometryAt {
    /// `odom_from_base` at the last beam.
    pub odom_from_base: Pose,
    /// Variance of the yaw that it claims since it began. [rad^2]
    pub claimed_yaw: f64,
    /// Run time of the last beam. [s]
    pub run_s: f64,
}

/// Keeps `map_from_odom` right.
#[derive(Debug)]
pub struct Localiser {
    config: CorrectionConfig,
    map_from_odom: Pose,
    /// At the last scan.
    map_from_base: Pose,
    /// Against what the scan is laid on.
    covariance: Matrix3<f64>,
    /// Against where the map began: what was seen before on a map of its own making lies where the robot
    /// had drifted to by then, and lessens nothing.
    drift: Matrix3<f64>,
    /// Variance of the yaw that the last step added. [rad^2]
    step_yaw: f64,
    /// All that was added so far. [rad^2]
    yaw_variance: f64,
    last_odom_from_base: Option<Pose>,
    /// Variance of the yaw that odometry claims, at the first scan and now, and what the
    /// configuration makes of the way between them. [rad^2]
    claimed_yaw: [f64; 2],
    assumed_yaw: f64,
    scans: ScanOdometry,
    /// Run time of the last scan. [s]
    last_s: f64,
    /// Fastest motion. [m/s, rad/s] 0 = not known.
    fastest: (f64, f64),
    /// Odometry has moved by more than the robot can, at the last scan.
    has_jumped: bool,
    /// Motion of which nothing is known since the scan lay on the map. [m, rad]
    unknown: (f64, f64),
    /// The robot may be anywhere.
    lost: bool,
    active: bool,
}

impl Localiser {
    /// Odometry begins at `map_from_odom`, for a robot that drives and turns as fast as this [m/s, rad/s]; 0 = not
    /// known.
    #[must_use]
    pub fn new(config: &CorrectionConfig, fastest: (f64, f64), map_from_odom: Pose) -> Self {
        Self {
            config: *config,
            map_from_odom,
            map_from_base: Pose::default(),
            covariance: Matrix3::zeros(),
            drift: Matrix3::zeros(),
            step_yaw: 0.0,
            yaw_variance: 0.0,
            last_odom_from_base: None,
            claimed_yaw: [0.0; 2],
            assumed_yaw: 0.0,
            scans: ScanOdometry::default(),
            last_s: 0.0,
            fastest,
            has_jumped: false,
            unknown: (0.0, 0.0),
            lost: false,
            active: false,
        }
    }

    /// Goes on from where another mapping has come to: its `map_from_odom`, and the covariance of the
    /// robot's pose with it as [`Self::covariance`]. A pose that may be anywhere is looked for on the whole map where
    /// that `can_search`, and near by otherwise.
    pub fn resume(&mut self, map_from_odom: Pose, covariance: [f64; 6], can_search: bool) {
        let [xx, xy, xw, yy, yw, ww] = covariance;
        self.map_from_odom = map_from_odom;
        self.covariance = Matrix3::new(xx, xy, xw, xy, yy, yw, xw, yw, ww);
        self.unknown = (0.0, 0.0);
        self.lost = can_search && xx.max(yy) >= LOST.0.powi(2);
        if xx.max(yy) >= POSE_SIGMA_M_MAX.powi(2) || ww >= POSE_SIGMA_RAD_MAX.powi(2) {
            self.unknown = (xx.max(yy).sqrt(), ww.sqrt());
        }
        limit(&mut self.covariance, CEILING);
        self.drift = self.covariance;
        if !self.is_uncertain() {
            limit(&mut self.covariance, TAKEN_OVER);
        }
    }

    /// True when the pose is corrected, given the variances that odometry states of itself.
    pub fn is_active(&mut self, odometry_variance: &[f64; 3]) -> bool {
        self.active = match self.config.mode {
            CorrectionMode::Off => false,
            CorrectionMode::On => true,
            CorrectionMode::Auto => {
                self.active || odometry_variance.iter().any(|variance| *variance > 0.0)
            }
        };
        self.active
    }

    /// `map_from_odom`.
    #[must_use]
    pub fn map_from_odom(&self) -> Pose {
        self.map_from_odom
    }

    /// `map_from_base`; exactly `odom_from_base` as long as nothing was corrected.
    #[must_use]
    pub fn map_from_base(&self, odom_from_base: &Pose) -> Pose {
        if self.map_from_odom == Pose::default() {
            *odom_from_base
        } else {
            self.map_from_odom.then(odom_from_base)
        }
    }

    /// True while the robot does not know where it is: it is lost, or the scans have contradicted odometry, told no
    /// motion, and did not lie on the map since.
    #[must_use]
    pub fn is_uncertain(&self) -> bool {
        self.lost || self.unknown.0 > UNKNOWN.0 || self.unknown.1 > UNKNOWN.1
    }

    /// Covariance of the robot's pose in the map, upper triangle by rows. [m, m, rad] On a map of its own
    /// making that is against where the map began, and grows with the way. While it is uncertain its
    /// deviations are above those from which nobody may rely on it; until it `is_confirmed` they are at least
    /// [`POSE_SIGMA_TOLD`].
    #[must_use]
    pub fn covariance(&self, is_confirmed: bool) -> [f64; 6] {
        let mut c = self.drift;
        if self.lost {
            let most = Vector3::new(LOST.0, LOST.0, LOST.1);
            c = Matrix3::from_diagonal(&most.component_mul(&most));
        } else if self.is_uncertain() {
            let place_m = self.unknown.0 + UNCERTAIN * POSE_SIGMA_M_MAX;
            let yaw_rad = self.unknown.1 + UNCERTAIN * POSE_SIGMA_RAD_MAX;
            let most = Vector3::new(place_m, place_m, yaw_rad);
            c += Matrix3::from_diagonal(&most.component_mul(&most));
        } else if !is_confirmed {
            let (place_m, yaw_rad) = POSE_SIGMA_TOLD;
            for (axis, least) in [place_m, place_m, yaw_rad].into_iter().enumerate() {
                c[(axis, axis)] = c[(axis, axis)].max(least.powi(2));
            }
        }
        [
            c[(0, 0)],
            c[(0, 1)],
            c[(0, 2)],
            c[(1, 1)],
            c[(1, 2)],
            c[(2, 2)],
        ]
    }

    /// Variance of the yaw that steps have added so far which nothing but odometry speaks for: by
    /// how much the yaw may be off against what it was a while ago. Never falls. [rad^2]
    #[must_use]
    pub fn yaw_variance(&self) -> f64 {
        self.yaw_variance
    }

    /// The robot is where a person says: `map_from_odom` from now on, given where odometry says the
    /// robot is. It may be off by as much as the largest standard deviations, so the next scans are laid on the map.
    pub fn relocate(&mut self, map_from_odom: Pose, odom_from_base: &Pose) {
        self.map_from_odom = map_from_odom;
        self.map_from_base = map_from_odom.then(odom_from_base);
        // The motion until then does not matter: the next scan begins anew.
        self.last_odom_from_base = None;
        self.assumed_yaw = 0.0;
        // No person is exact: scans correct the pose from now on, whatever odometry claims.
        self.active |= self.config.mode != CorrectionMode::Off;
        if self.active {
            let (place, yaw) = (CEILING.0.powi(2), CEILING.1.powi(2));
            self.covariance = Matrix3::from_diagonal(&Vector3::new(place, place, yaw));
            self.drift = self.covariance;
        }
        self.unknown = (0.0, 0.0);
        self.lost = false;
    }

    /// The robot may be anywhere: until it is found its pose only tells how it has moved.
    pub(crate) fn lose(&mut self) {
        self.lost = true;
    }

    /// The robot may be elsewhere near by: it is looked for there until a scan lies on the map.
    pub(crate) fn doubt(&mut self) {
        if self.active {
            self.unknown = (POSE_SIGMA_M_MAX, POSE_SIGMA_RAD_MAX);
        }
    }

    /// The robot was found: where it is at the last scan, by `odom_from_base`.
    pub(crate) fn find(&mut self, found: &Match, odom_from_base: &Pose) {
        let base_from_odom = odom_from_base.isometry().inverse();
        let map_from_odom = Pose::from(found.pose.isometry() * base_from_odom);
        self.relocate(map_from_odom, odom_from_base);
        self.last_odom_from_base = Some(*odom_from_base);
        if self.active {
            self.covariance = found.covariance;
            limit(&mut self.covariance, CEILING);
            self.drift = self.covariance;
        }
    }

    /// Takes in where odometry says the robot is. The covariance of its step since the last scan; `None` at the
    /// first one.
    pub(crate) fn step(&mut self, odometry: &OdometryAt) -> Option<Matrix3<f64>> {
        let odom_from_base = &odometry.odom_from_base;
        self.claimed_yaw[1] = odometry.claimed_yaw;
        let elapsed_s = odometry.run_s - core::mem::replace(&mut self.last_s, odometry.run_s);
        let Some(last) = self.last_odom_from_base.replace(*odom_from_base) else {
            self.map_from_base = self.map_from_base(odom_from_base);
            self.claimed_yaw[0] = self.claimed_yaw[1];
            self.step_yaw = 0.0;
            return None;
        };
        self.has_jumped = self.is_jump(&last, odom_from_base, elapsed_s);
        Some(if self.has_jumped {
            self.scans.jumped(odom_from_base);
            let (v_mps, w_radps) = self.fastest;
            let (place_m, yaw_rad) = (v_mps * elapsed_s, w_radps * elapsed_s);
            Matrix3::from_diagonal(&Vector3::new(place_m, place_m, yaw_rad).map(|s| s * s))
        } else {
            self.noise(&last, odom_from_base)
        })
    }

    /// Takes in where beams ended on static obstacles, given the covariance of odometry's step since the last scan. The
    /// motion since then, as the scans and odometry tell it.
    pub(crate) fn predict(
        &mut self,
        noise: Option<&Matrix3<f64>>,
        standing: &Ends<'_>,
        something_moves: bool,
    ) -> Option<Moved> {
        let odom_from_base = &self.last_odom_from_base.unwrap_or_default();
        let Some(noise) = noise else {
            self.scans.begin(odom_from_base, standing.at);
            return None;
        };
        let moved = self
            .scans
            .follow(odom_from_base, noise, standing, something_moves);
        let predicted = self.map_from_base.then(&moved.last_from_base);
        let came = predicted.point() - self.map_from_base.point();
        let step = swing(&came);
        let left = turned(predicted.yaw_rad) * moved.left;
        let added = left * moved.noise * left.transpose();
        self.step_yaw = added[(2, 2)];
        for covariance in [&mut self.covariance, &mut self.drift] {
            *covariance = step * *covariance * step.transpose() + added;
            limit(covariance, CEILING);
        }
        self.drift_by(came.norm());
        if let Some((place_m, yaw_rad)) = moved.unknown() {
            self.unknown.0 += place_m;
            self.unknown.1 += yaw_rad;
        }
        self.map_from_base = predicted;
        Some(moved)
    }

    /// True when odometry that claims to be exact is held against the scans.
    #[must_use]
    pub fn watches(&self) -> bool {
        self.config.mode == CorrectionMode::Auto && !self.active
    }

    /// True when a few ends of the scan do not speak against odometry that claims to be exact, and is watched: it
    /// tells the pose. Otherwise nothing has changed. What moves would speak against it for nothing.
    pub(crate) fn goes_along(
        &mut self,
        noise: &Matrix3<f64>,
        few: &Ends<'_>,
        something_moves: bool,
    ) -> bool {
        let odom_from_base = self.last_odom_from_base.unwrap_or_default();
        let goes_along = !self.has_jumped
            && (self.scans).goes_along(&odom_from_base, noise, few, something_moves);
        if goes_along {
            self.believe(&odom_from_base);
        }
        goes_along
    }

    /// True when the next key scan is due, after [`Self::goes_along`].
    pub(crate) fn is_key_due(&self) -> bool {
        self.scans.is_key_due()
    }

    /// This scan is the next key scan: where its beams ended on static obstacles.
    pub(crate) fn next_key(&mut self, standing: &[Point2<f64>]) {
        let odom_from_base = self.last_odom_from_base.unwrap_or_default();
        self.scans.next_key(&odom_from_base, standing);
    }

    /// Odometry alone tells the pose.
    fn believe(&mut self, odom_from_base: &Pose) {
        self.map_from_base = self.map_from_base(odom_from_base);
        (self.covariance, self.drift) = (Matrix3::zeros(), Matrix3::zeros());
        self.unknown = (0.0, 0.0);
    }

    /// True when `moved`, of [`Self::predict`], shows that odometry which claims to be exact is not:
    /// the wheels have slipped, or it has jumped. The pose is corrected from now on. Otherwise odometry
    /// alone tells the pose.
    pub(crate) fn notices(
        &mut self,
        moved: Option<&Moved>,
        standing: &Ends<'_>,
        something_moves: bool,
    ) -> bool {
        let odom_from_base = self.last_odom_from_base.unwrap_or_default();
        self.active = moved.is_some_and(|moved| {
            (moved.basis == Basis::Scans || self.has_jumped)
                && moved.share > NOTICED_SHARE
                && !something_moves
        });
        if !self.active {
            if self.has_jumped {
                self.scans.begin(&odom_from_base, standing.at);
            }
            self.believe(&odom_from_base);
        }
        self.active
    }

    /// Lays the scan on the map, after [`Self::predict`]: where beams ended, in `base` [m], on static
    /// obstacles, and of these on what is on the map. `is_mapped` says of a point of the map whether
    /// anything is known there, `is_static` whether what is seen there belongs to the static map.
    pub(crate) fn lay(
        &mut self,
        standing: &[Point2<f64>],
        known: &[Point2<f64>],
        surfaces: &Surfaces,
        is_mapped: impl Fn(Point2<f64>) -> bool,
        is_static: impl Fn(Point2<f64>) -> bool,
    ) {
        let odom_from_base = self.last_odom_from_base.unwrap_or_default();
        let mut pose = self.map_from_base;
        let is_sure = self.unknown == (0.0, 0.0);
        let reach = (self.unknown.0 + BEYOND.0, self.unknown.1 + BEYOND.1);
        let matched = if self.lost {
            None
        } else if is_sure {
            surfaces.lay(known, &pose, &self.covariance, is_static)
        } else {
            surfaces.find(standing, &pose, reach, is_mapped)
        };
        if let Some(matched) = matched {
            self.covariance = matched.covariance;
            limit(&mut self.covariance, CEILING);
            // A robot that was found knows where it is on its map, not where that lies.
            if is_sure {
                self.learn(&matched.told);
            }
            pose = matched.pose;
            self.unknown = (0.0, 0.0);
        }
        self.yaw_variance += self.step_yaw.min(self.covariance[(2, 2)]);
        self.map_from_base = pose;
        let base_from_odom = odom_from_base.isometry().inverse();
        self.map_from_odom = Pose::from(pose.isometry() * base_from_odom);
    }

    /// `map_from_base` at the last scan.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.map_from_base
    }

    /// What a step of odometry may be off by.
    fn noise(&mut self, last: &Pose, odom_from_base: &Pose) -> Matrix3<f64> {
        let length_m = last.distance_m(odom_from_base);
        let turn_rad = wrap_angle(odom_from_base.yaw_rad - last.yaw_rad).abs();
        let config = &self.config;
        let place = config.noise_m_per_sqrt_m.powi(2) * length_m;
        let yaw = config.noise_rad_per_sqrt_rad.powi(2) * turn_rad
            + config.noise_rad_per_sqrt_m.powi(2) * length_m;
        let yaw = yaw * self.yaw_trust(yaw);
        Matrix3::from_diagonal(&Vector3::new(place, place, yaw))
    }

    /// True when odometry has moved by more than the robot can.
    fn is_jump(&self, last: &Pose, now: &Pose, elapsed_s: f64) -> bool {
        let (v_mps, w_radps) = self.fastest;
        let (share, slack_m, slack_rad) = JUMP;
        let turned_rad = wrap_angle(now.yaw_rad - last.yaw_rad).abs();
        v_mps > 0.0
            && w_radps > 0.0
            && elapsed_s > 0.0
            && (last.distance_m(now) > share * v_mps * elapsed_s + slack_m
                || turned_rad > share * w_radps * elapsed_s + slack_rad)
    }

    /// Share, 0 to 1, that is left of the variance `yaw` [rad^2] of a step by what odometry claims.
    /// The claim counts for the whole way: what jumps or slips has not claimed that it does.
    fn yaw_trust(&mut self, yaw: f64) -> f64 {
        self.assumed_yaw += yaw;
        let claimed = self.claimed_yaw[1] - self.claimed_yaw[0];
        if claimed > 0.0 && self.assumed_yaw > 0.0 {
            (CLAIM.powi(2) * claimed / self.assumed_yaw).min(1.0)
        } else {
            1.0
        }
    }

    /// A way from key scan to key scan leads away by a share of its length, always to the same side.
    fn drift_by(&mut self, way_m: f64) {
        let off_m = DRIFT * way_m;
        for axis in 0..2 {
            let sigma_m = self.drift[(axis, axis)].max(0.0).sqrt();
            self.drift[(axis, axis)] += (2.0 * sigma_m + off_m) * off_m;
        }
        limit(&mut self.drift, CEILING);
    }

    /// What the static map told about the pose lessens its drift. [information]
    fn learn(&mut self, told: &Matrix3<f64>) {
        let information = self.drift.try_inverse().map(|before| before + told);
        if let Some(drift) = information.and_then(Matrix3::try_inverse) {
            self.drift = drift;
            limit(&mut self.drift, CEILING);
        }
    }
}
