//! Where a manoeuvre may end, and when it need not go on: poses on the path from which the controller gets on, and the
//! goal.

use super::targets::{TARGETS_MAX, Target, is_inside};
use super::view::REACH_M;
use super::{AIM, Manoeuvre, View};
use crate::footprint::Footprint;
use crate::progress::Place;
use core::f64::consts::PI;
use zeronav_msgs::pose::wrap_angle;

/// [m] of path ahead at which it may end first, and by how much more from attempt to attempt.
const FIRST_M: f64 = 0.3;
const FARTHER_M: f64 = 0.6;

/// [m] from one possible end to the next.
const EVERY_M: f64 = 0.1;

/// [m] of clearance from which a controller gets on: its margin, some more, and the share of the outline's
/// extent by which the discs that it takes the outline for stand out.
const FREE_M: f64 = 0.03;
const OVERHANG: f64 = 0.04;

/// [m] ahead of where a manoeuvre ends on the path that are free, too.
const AHEAD_M: [f64; 2] = [0.2, 0.4];

/// How near to a pose on the path it ends, and to the farthest one.
const ON_PATH: (f64, f64) = (0.12, 0.25);
const FARTHEST: (f64, f64) = (0.2, 0.35);

impl Manoeuvre {
    /// Adds the goal when the path ends there within reach.
    pub(super) fn add_goal(&mut self, view: &View<'_>, place: &Place) {
        let goal = view.situation.goal;
        let pose = view.relative_to_robot(&goal.pose);
        let footprint = &view.near.footprint;
        // A path may end where the way to the goal is cut off.
        let end = view.on_path(place.arc_m + place.remaining_m);
        let leads_there = end.distance_m(&pose) <= goal.tolerance_m + EVERY_M;
        let is_near = place.remaining_m <= REACH_M + goal.tolerance_m;
        if !leads_there || !is_near || !is_inside(&pose, footprint) {
            return;
        }
        let any_yaw = goal.yaw_tolerance_rad >= PI;
        self.search.targets.all.push(Target {
            pose,
            tolerance_m: AIM * goal.tolerance_m,
            tolerance_rad: if any_yaw {
                PI
            } else {
                AIM * goal.yaw_tolerance_rad
            },
            either_way: false,
            clearance_m: 0.0,
        });
    }

    /// Adds poses along the path: those with room around them, and the farthest, facing either way.
    pub(super) fn add_path(&mut self, view: &View<'_>, place: &Place) {
        let footprint = &view.near.footprint;
        let free_m = free_m(footprint);
        let reach_m = REACH_M.min(place.remaining_m);
        let first_m = self.first_m().min(reach_m);
        let mut along_m = FIRST_M;
        let mut farthest = None;
        while along_m <= reach_m && self.search.targets.all.len() + 1 < TARGETS_MAX {
            let pose = view.on_path(place.arc_m + along_m);
            if !is_inside(&pose, footprint) {
                break;
            }
            farthest = Some(pose);
            let ahead = AHEAD_M.map(|ahead_m| view.on_path(place.arc_m + along_m + ahead_m));
            let is_free = along_m >= first_m
                && core::iter::once(pose).chain(ahead).all(|pose| {
                    let space = &self.search.space;
                    space.clearance_m(footprint, &pose, free_m, free_m) >= free_m
                });
            if is_free {
                self.search.targets.all.push(Target {
                    pose,
                    tolerance_m: ON_PATH.0,
                    tolerance_rad: ON_PATH.1,
                    either_way: false,
                    clearance_m: free_m,
                });
            }
            along_m += EVERY_M;
        }
        self.search.targets.all.extend(farthest.map(|pose| Target {
            pose,
            tolerance_m: FARTHEST.0,
            tolerance_rad: FARTHEST.1,
            either_way: view.situation.robot.v_mps_min < 0.0,
            clearance_m: 0.0,
        }));
    }

    /// How far along the path a manoeuvre has to lead: farther after those that have not got on. [m]
    fn first_m(&self) -> f64 {
        FIRST_M + FARTHER_M * f64::from(self.times)
    }

    /// True when a path has come since the search on which the controller gets on from here: what the search was to
    /// lead to is no longer wanted, and turning round for it would take the way on away again.
    pub(super) fn stands_on_another_path(&mut self, view: &View<'_>) -> bool {
        let (situation, footprint) = (view.situation, &view.near.footprint);
        let is_another = situation.path_geometry != 0 && situation.path_geometry != self.geometry;
        let Some(place) = view
            .tracker
            .place()
            .filter(|_| is_another && !self.is_for_goal)
        else {
            return false;
        };
        let (here, on_path) = (view.here(), view.on_path(place.arc_m));
        let askew_rad = wrap_angle(here.yaw_rad - on_path.yaw_rad);
        if on_path.distance_m(&here) > ON_PATH.0 || askew_rad.abs() > ON_PATH.1 {
            return false;
        }
        self.fill(view);
        let free_m = free_m(footprint);
        // After manoeuvres that have not got on, as far as the next one would have to lead.
        let first_m = self.first_m().min(REACH_M).min(place.remaining_m);
        let farther = core::iter::successors(Some(AHEAD_M[1] + EVERY_M), |m| Some(m + EVERY_M));
        let farther = farther.take_while(|along_m| *along_m <= first_m);
        let ahead = AHEAD_M.into_iter().chain(farther);
        let ahead = ahead.map(|along_m| view.on_path(place.arc_m + along_m));
        core::iter::once(here).chain(ahead).all(|pose| {
            let space = &self.search.space;
            space.clearance_m(footprint, &pose, free_m, free_m) >= free_m
        })
    }
}

/// Clearance from which a controller gets on. [m]
fn free_m(footprint: &Footprint) -> f64 {
    let (low, high) = footprint.bounds();
    FREE_M + OVERHANG * (high - low).max()
}
