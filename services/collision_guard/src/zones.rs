//! Zones as the guard holds a motion to them: the speed limit where the robot is, and no way into a
//! keepout zone.
//!
//! The pose comes from the map of mapping; while that does not know where the robot is, odometry goes on
//! from the last pose that was known, and a speed limit that held then is not lifted. Before any pose was
//! known the lowest limit of all zones holds; of keepout zones nothing can be said then.
//!
//! A robot whose outline is in a keepout zone is let out: its centre may go where the way out is no
//! longer, and turn; what it has gained on its way it does not lose again, in another zone neither.

use crate::limits::Limits;
use core::f64::consts::TAU;
use nalgebra::Point2;
use zeronav_motion::Twist;
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::{Pose, ZoneSet};

/// Largest distance of two points of the outline that are looked at. [m]
const SPACING_M: f64 = 0.05;

/// Between two poses on the way. [s]
const STEP_S: f64 = 0.02;

/// Most poses on the way: a way that is longer is not free.
const STEPS_MAX: u32 = 400;

/// Shares of the reaction time after which braking may begin, and at which stops are looked at.
const STARTS: [f64; 2] = [1.0, 0.25];

/// Most points of the outline.
const POINTS_MAX: usize = 256;

/// By how much the way out may get longer, in all, while the robot is inside: the noise of its pose. [m]
const NOISE_M: f64 = 0.02;

/// Halvings in the search for a speed from which the robot stops outside.
const HALVINGS: u32 = 5;

/// [s] of braking by which a command may be slower than the robot, so that it brakes down to a limit.
const LEAD_S: f64 = 0.06;

/// What zones make of a motion that is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Held {
    /// It may go on as it is.
    Free(Twist),
    /// Slowed down to the limit of a zone.
    Slowed(Twist),
    /// Slowed down before a keepout zone.
    Short(Twist),
    /// No speed on that arc keeps the robot out of a keepout zone, or leads out of one.
    Stop,
}

/// The zones and where the robot is among them.
#[derive(Debug, Clone, Default)]
pub(crate) struct ZoneRules {
    set: ZoneSet,
    /// `map_from_odom` when mapping knew the pose last.
    known: Option<Pose>,
    /// It knows it now.
    is_known: bool,
    /// Limit that held when it was known last. [m/s]
    limit_mps: Option<f64>,
    /// Points of the outline in `base`. [m]
    outline: Vec<Point2<f64>>,
    /// While the outline is in a keepout zone: the shortest way out that the centre has had, below 0. [m]
    least_m: Option<f64>,
}

impl ZoneRules {
    /// Takes in zones in place of those before.
    pub(crate) fn set(&mut self, set: &ZoneSet) {
        self.set.clone_from(set);
        // What is around the robot is another zone now.
        self.least_m = None;
    }

    /// Takes in how the map lies to odometry, and whether the robot knows where it is on it.
    pub(crate) fn locate(&mut self, map_from_odom: Pose, is_known: bool) {
        self.is_known = is_known;
        if is_known {
            self.known = Some(map_from_odom);
        }
    }

    /// Takes in another robot.
    pub(crate) fn describe(&mut self, description: &Description, corners: &[Corner]) {
        self.outline.clear();
        if corners.is_empty() {
            let radius_m = description.circumscribed_radius_m;
            let n = count((TAU * radius_m / SPACING_M).ceil().clamp(8.0, 128.0));
            self.outline.extend((0..n).map(|at| {
                let (sin, cos) = (TAU * f64::from(at) / f64::from(n)).sin_cos();
                Point2::new(radius_m * cos, radius_m * sin)
            }));
            return;
        }
        let next = corners.iter().cycle().skip(1);
        for (from, to) in corners.iter().zip(next) {
            let (from, to) = (Point2::new(from.x_m, from.y_m), Point2::new(to.x_m, to.y_m));
            let n = count(((to - from).norm() / SPACING_M).ceil().clamp(1.0, 64.0));
            let points = (0..n).map(|at| from + (to - from) * (f64::from(at) / f64::from(n)));
            self.outline.extend(points);
        }
        self.outline.truncate(POINTS_MAX);
    }

    /// What becomes of a motion that is asked for, when braking begins after `reaction_s` at the latest.
    pub(crate) fn hold(
        &mut self,
        asked: Twist,
        odometry: &Odometry,
        (description, limits): (&Description, &Limits),
        reaction_s: f64,
    ) -> Held {
        if self.set.is_empty() {
            return Held::Free(asked);
        }
        let measured = Twist::measured(odometry);
        let Some(known) = self.known else {
            let limit = self.set.limit_anywhere(description.v_mps_max);
            return slowed(asked, measured, limits, limit.map(|limit| limit.limit_mps));
        };
        let pose = known.then(&odometry.pose);
        let held = slowed(
            asked,
            measured,
            limits,
            self.limit(&pose, measured, description, reaction_s),
        );
        let (Held::Free(twist) | Held::Slowed(twist)) = held else {
            return held;
        };
        let way = Way {
            zones: &self.set,
            outline: &self.outline,
            radius_m: description.circumscribed_radius_m,
            pose,
            measured,
            limits,
            reaction_s,
        };
        let reach_m = description.circumscribed_radius_m + way.reach_m(twist);
        if self.set.is_far(pose.point(), reach_m) {
            self.least_m = None;
            return held;
        }
        let least_m = way
            .is_inside(&pose)
            .then(|| self.set.keepout_margin_m(pose.point()));
        // It may not creep in: what counts is the shortest way out so far.
        self.least_m = least_m.map(|now_m| now_m.max(self.least_m.unwrap_or(now_m)));
        let floor_m = least_m
            .zip(self.least_m)
            .map(|(now_m, best_m)| now_m.min(best_m - NOISE_M));
        if way.is_free(twist, floor_m) {
            return held;
        }
        let (mut best, mut low, mut high) = (None, 0.0, 1.0);
        for _ in 0..HALVINGS {
            let share = 0.5 * (low + high);
            if way.is_free(twist.scaled(share), floor_m) {
                best = Some(twist.scaled(share));
                low = share;
            } else {
                high = share;
            }
        }
        best.map_or(Held::Stop, Held::Short)
    }

    /// The speed limit that holds here, or where the robot is by the time that braking begins. [m/s]
    fn limit(
        &mut self,
        pose: &Pose,
        measured: Twist,
        description: &Description,
        reaction_s: f64,
    ) -> Option<f64> {
        let soon = pose.transform(Point2::new(measured.v_mps * reaction_s, 0.0));
        let at = |at| {
            self.set
                .limit_at(at, description.v_mps_max)
                .map(|zone| zone.limit_mps)
        };
        let here = least(at(pose.point()), at(soon));
        if self.is_known {
            self.limit_mps = here;
            return here;
        }
        least(here, self.limit_mps)
    }
}

fn least(one: Option<f64>, other: Option<f64>) -> Option<f64> {
    match (one, other) {
        (Some(one), Some(other)) => Some(one.min(other)),
        (one, other) => one.or(other),
    }
}

/// A motion no faster than a limit, on its arc; a robot that is faster brakes down to it.
fn slowed(asked: Twist, measured: Twist, limits: &Limits, limit_mps: Option<f64>) -> Held {
    let Some(limit_mps) = limit_mps else {
        return Held::Free(asked);
    };
    let soon_mps = measured.v_mps.abs() - limits.brake_mps2 * LEAD_S;
    let most_mps = limit_mps.max(soon_mps);
    if asked.v_mps.abs() <= most_mps {
        return Held::Free(asked);
    }
    Held::Slowed(asked.scaled(most_mps / asked.v_mps.abs()))
}

/// The way of a robot that obeys a motion for the reaction time and then brakes.
struct Way<'a> {
    zones: &'a ZoneSet,
    outline: &'a [Point2<f64>],
    radius_m: f64,
    pose: Pose,
    measured: Twist,
    limits: &'a Limits,
    reaction_s: f64,
}

impl Way<'_> {
    /// How far it leads at most. [m]
    fn reach_m(&self, twist: Twist) -> f64 {
        let fastest = twist.v_mps.abs().max(self.measured.v_mps.abs());
        fastest * (self.reaction_s + fastest / (2.0 * self.limits.brake_mps2))
    }

    /// True when the outline touches a keepout zone at a pose.
    fn is_inside(&self, pose: &Pose) -> bool {
        if self.zones.is_far(pose.point(), self.radius_m) {
            return false;
        }
        let inside = |at: Point2<f64>| self.zones.keepout_at(at).is_some();
        let mut points = self.outline.iter();
        inside(pose.point()) || points.any(|point| inside(pose.transform(*point)))
    }

    /// True when a robot may go on to a pose: outside of all keepout zones; one that is in one also where the margin of its
    /// centre is `floor_m`, so that it may turn. From there on the way may lead no farther in again.
    fn may_go_on(&self, pose: &Pose, floor_m: &mut Option<f64>) -> bool {
        if !self.is_inside(pose) {
            *floor_m = None;
            return true;
        }
        let margin_m = self.zones.keepout_margin_m(pose.point());
        let is_free = floor_m.is_some_and(|floor_m| margin_m >= floor_m);
        *floor_m = floor_m.map(|floor_m| floor_m.max(margin_m - NOISE_M));
        is_free
    }

    /// True when it may be everywhere on the way, whenever braking begins.
    fn is_free(&self, twist: Twist, floor_m: Option<f64>) -> bool {
        STARTS.iter().all(|share| {
            let obeyed_s = share * self.reaction_s;
            let (mut pose, mut now, mut elapsed_s) = (self.pose, self.measured, 0.0);
            let mut floor_m = floor_m;
            for _ in 0..STEPS_MAX {
                let next = if elapsed_s < obeyed_s {
                    self.limits.towards(now, twist, STEP_S)
                } else {
                    self.limits.towards_rest(now, STEP_S)
                };
                pose = pose.then(&now.mean(next).arc(STEP_S));
                if !self.may_go_on(&pose, &mut floor_m) {
                    return false;
                }
                (now, elapsed_s) = (next, elapsed_s + STEP_S);
                if now == Twist::REST && elapsed_s >= obeyed_s {
                    return true;
                }
            }
            false
        })
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to small positive numbers"
)]
fn count(n: f64) -> u32 {
    n as u32
}
