//! Zones as the guard holds a motion to them: the speed limit where the robot is, and no way into a
//! keepout zone.
//!
//! The pose comes from the map of mapping; while that does not know where the robot is, odometry goes on
//! from the last pose that was known, and a speed limit that held then is not lifted. Without such a pose, before
//! the first one and after odometry has jumped, the lowest limit of all zones holds, and where there are keepout
//! zones the robot may only turn.
//!
//! A robot whose outline is in a keepout zone is let out: its centre may go where it is no farther to the zones' edge,
//! or along the way out that mapping has opened, which knows the walls; and it may turn. What it has gained on either
//! it does not lose again, in another zone neither.

use crate::limits::Limits;
use crate::verdict::{LEAD_S, STARTS, fastest_free};
use core::f64::consts::TAU;
use nalgebra::Point2;
use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::map::MapInfo;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::way_out::WayOut;
use zeronav_msgs::zone_set::Keepouts;
use zeronav_msgs::zones::ZoneKind;
use zeronav_msgs::{Pose, ZoneSet};

/// Largest distance of two points of the outline that are looked at. [m]
const SPACING_M: f64 = 0.05;

/// Between two poses on the way. [s]
const STEP_S: f64 = 0.02;

/// Most poses on the way: a way that is longer is not free.
const STEPS_MAX: u32 = 400;

/// Most points of the outline: of a longer one they lie farther apart.
const POINTS_MAX: f64 = 256.0;

/// By how much the way out may get longer, in all, while the robot is inside: the noise of its pose. [m]
const NOISE_M: f64 = 0.02;

/// How far into the keepout zones a robot that is inside may go: what its centre has gained. [m]
#[derive(Debug, Clone, Copy, PartialEq)]
struct Gained {
    /// How far it may lie in them, below 0.
    margin_m: f64,
    /// How far it may be from the end of the way out.
    left_m: f64,
}

impl Gained {
    /// At a place.
    fn at(zones: &ZoneSet, way_out: Option<&WayOut>, at: Point2<f64>) -> Self {
        Self {
            margin_m: zones.keepout_margin_m(at),
            left_m: way_out.map_or(f64::NEG_INFINITY, |way| way.left_m(at)),
        }
    }

    /// The better one of both.
    fn or(self, other: Self) -> Self {
        Self {
            margin_m: self.margin_m.max(other.margin_m),
            left_m: self.left_m.min(other.left_m),
        }
    }

    /// With room for the noise of a pose, but no less than here.
    fn with_noise(self, here: Self) -> Self {
        Self {
            margin_m: here.margin_m.min(self.margin_m - NOISE_M),
            left_m: here.left_m.max(self.left_m + NOISE_M),
        }
    }
}

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
    /// Points of the outline in `base`, and the farthest of it. [m]
    outline: Vec<Point2<f64>>,
    radius_m: f64,
    way_out: Option<WayOut>,
    /// While the outline is in a keepout zone: the best that the centre has come to.
    gained: Option<Gained>,
}

impl ZoneRules {
    /// Takes in zones in place of those before.
    pub(crate) fn set(&mut self, set: &ZoneSet) {
        self.set.clone_from(set);
        // What is around the robot is another zone now.
        self.gained = None;
    }

    /// Takes in how the map lies to odometry, whether the robot knows where it is on it, and the way out.
    pub(crate) fn locate(&mut self, map: &MapInfo) {
        self.is_known = map.certainty().is_known();
        if self.is_known {
            self.known = Some(map.map_from_odom);
        }
        let way_out = Some(map.way_out).filter(WayOut::is_open);
        if way_out != self.way_out {
            self.way_out = way_out;
            // How far it is to the end of another way is another length.
            if let Some(gained) = &mut self.gained {
                gained.left_m = f64::INFINITY;
            }
        }
    }

    /// Odometry does not go on from where it was: the last pose that was known says nothing.
    pub(crate) fn forget_pose(&mut self) {
        self.known = None;
        self.gained = None;
    }

    /// Takes in another robot.
    pub(crate) fn describe(&mut self, description: &Description, corners: &[Corner]) {
        self.outline.clear();
        if corners.is_empty() {
            self.radius_m = description.circumscribed_radius_m;
            let n = count(
                (TAU * self.radius_m / SPACING_M)
                    .ceil()
                    .clamp(8.0, POINTS_MAX),
            );
            self.outline.extend((0..n).map(|at| {
                let (sin, cos) = (TAU * f64::from(at) / f64::from(n)).sin_cos();
                Point2::new(self.radius_m * cos, self.radius_m * sin)
            }));
            return;
        }
        let points = corners.iter().map(|at| Point2::new(at.x_m, at.y_m));
        let edges = points.clone().zip(points.clone().cycle().skip(1));
        self.radius_m = points.map(|at| at.coords.norm()).fold(0.0, f64::max);
        let around_m: f64 = edges.clone().map(|(from, to)| (to - from).norm()).sum();
        let spacing_m = SPACING_M.max(around_m / POINTS_MAX);
        for (from, to) in edges {
            let n = count(((to - from).norm() / spacing_m).ceil().max(1.0));
            let points = (0..n).map(|at| from + (to - from) * (f64::from(at) / f64::from(n)));
            self.outline.extend(points);
        }
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
            if self.set.has(ZoneKind::Keepout) && asked.v_mps.abs() > 0.0 {
                return Held::Stop;
            }
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
        let mut way = Way {
            zones: &self.set,
            near: Keepouts::default(),
            outline: &self.outline,
            radius_m: self.radius_m,
            pose,
            measured,
            limits,
            reaction_s,
            out: self.way_out.as_ref(),
        };
        let reach_m = self.radius_m + way.reach_m(twist);
        way.near = self.set.keepouts_near(pose.point(), reach_m);
        if way.near.is_empty() {
            self.gained = None;
            return held;
        }
        let here = (way.is_inside(&pose)).then(|| Gained::at(&self.set, way.out, pose.point()));
        // It may not creep in: what counts is the best so far.
        self.gained = here.map(|here| self.gained.map_or(here, |best| best.or(here)));
        let floor = here
            .zip(self.gained)
            .map(|(here, best)| best.with_noise(here));
        if way.is_free(twist, floor) {
            return held;
        }
        let slower = fastest_free(twist, |slower| way.is_free(slower, floor).then_some(0.0));
        slower.map_or(Held::Stop, |(slower, _)| Held::Short(slower))
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
    // It brakes down to the limit.
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
    /// The keepout zones that it can come to.
    near: Keepouts<'a>,
    outline: &'a [Point2<f64>],
    radius_m: f64,
    pose: Pose,
    measured: Twist,
    limits: &'a Limits,
    reaction_s: f64,
    out: Option<&'a WayOut>,
}

impl Way<'_> {
    /// How far it leads at most. [m]
    fn reach_m(&self, twist: Twist) -> f64 {
        let fastest = twist.v_mps.abs().max(self.measured.v_mps.abs());
        fastest * (self.reaction_s + fastest / (2.0 * self.limits.brake_mps2))
    }

    /// True when the outline touches a keepout zone at a pose.
    fn is_inside(&self, pose: &Pose) -> bool {
        if self.near.are_far(pose.point(), self.radius_m) {
            return false;
        }
        let mut points = self.outline.iter();
        self.near.hold(pose.point()) || points.any(|point| self.near.hold(pose.transform(*point)))
    }

    /// True when a robot may go on to a pose: outside of all keepout zones; one that is in one also where its centre
    /// has come at least as far as `floor` on one of the ways out, so that it may turn. From there on the way may
    /// lead no farther in again.
    fn may_go_on(&self, pose: &Pose, floor: &mut Option<Gained>) -> bool {
        if !self.is_inside(pose) {
            *floor = None;
            return true;
        }
        let Some(least) = floor else {
            return false;
        };
        let at = pose.point();
        let here = Gained::at(self.zones, self.out, at);
        let is_on_way = self
            .out
            .is_some_and(|way| way.distance_m(at) <= way.radius_m);
        let is_free = here.margin_m >= least.margin_m || is_on_way && here.left_m <= least.left_m;
        *least = least.or(here.with_noise(here));
        is_free
    }

    /// True when it may be everywhere on the way, whenever braking begins.
    fn is_free(&self, twist: Twist, floor: Option<Gained>) -> bool {
        STARTS.iter().all(|share| {
            let obeyed_s = share * self.reaction_s;
            let (mut pose, mut now, mut elapsed_s) = (self.pose, self.measured, 0.0);
            let mut floor = floor;
            for _ in 0..STEPS_MAX {
                let next = if elapsed_s < obeyed_s {
                    self.limits.towards(now, twist, STEP_S)
                } else {
                    self.limits.towards_rest(now, STEP_S)
                };
                pose = pose.then(&now.mean(next).arc(STEP_S));
                if !self.may_go_on(&pose, &mut floor) {
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

fn count(n: f64) -> u32 {
    n.to_u32()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_side_of_a_large_outline_is_left_out() {
        let mut rules = ZoneRules::default();
        let corners: Vec<Corner> = (0..32)
            .map(|n| {
                let (sin, cos) = (TAU * f64::from(n) / 32.0).sin_cos();
                Corner {
                    x_m: 2.5 * cos,
                    y_m: 1.5 * sin,
                }
            })
            .collect();
        // A description may understate it.
        let description = Description {
            circumscribed_radius_m: 0.4,
            ..Description::default()
        };
        rules.describe(&description, &corners);
        assert!((rules.radius_m - 2.5).abs() < 1e-9);
        assert!(rules.outline.len() <= 256 + 32, "{}", rules.outline.len());
        let next = rules.outline.iter().cycle().skip(1);
        let gaps = rules.outline.iter().zip(next).map(|(a, b)| (b - a).norm());
        let widest_m = gaps.fold(0.0, f64::max);
        assert!((0.03..0.06).contains(&widest_m), "{widest_m}");
    }
}
