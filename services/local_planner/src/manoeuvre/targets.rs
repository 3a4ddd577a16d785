//! Where a manoeuvre may end: poses on the path from which the controller gets on, or the goal.

use super::space::{CELL_M, CELLS, HALF_M, Space, cell};
use crate::footprint::Footprint;
use core::cmp::Reverse;
use core::f64::consts::PI;
use std::collections::BinaryHeap;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;

/// Most targets.
pub(crate) const TARGETS_MAX: usize = 64;

/// A cell from which no target can be reached.
const UNREACHED: u32 = u32::MAX;

/// Steps of the cost-to-go in a metre.
const PER_M: f64 = 1000.0;

/// A pose, and how near to it is near enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Target {
    pub(crate) pose: Pose,
    /// [m]
    pub(crate) tolerance_m: f64,
    /// [rad] pi or more for any yaw.
    pub(crate) tolerance_rad: f64,
    /// Facing the other way will do, too.
    pub(crate) either_way: bool,
    /// [m] of clearance that there must be.
    pub(crate) clearance_m: f64,
}

impl Target {
    /// [rad] from a yaw to the nearest one that will do, >= 0.
    pub(crate) fn off_rad(&self, yaw_rad: f64) -> f64 {
        if self.tolerance_rad >= PI {
            return 0.0;
        }
        let off_rad = wrap_angle(yaw_rad - self.pose.yaw_rad).abs();
        if self.either_way {
            off_rad.min(PI - off_rad)
        } else {
            off_rad
        }
    }

    /// Its pose for a robot that comes straight from another one, ahead (+1) or back (-1): facing whichever way
    /// is nearer to how it comes.
    pub(crate) fn facing(&self, from: &Pose, direction: f64) -> Pose {
        let way = (self.pose.point() - from.point()) * direction;
        let off_rad = wrap_angle(way.y.atan2(way.x) - self.pose.yaw_rad);
        if self.either_way && off_rad.abs() > 0.5 * PI {
            let Pose { x_m, y_m, yaw_rad } = self.pose;
            return Pose::new(x_m, y_m, wrap_angle(yaw_rad + PI));
        }
        self.pose
    }

    /// True for a pose with a clearance that will do.
    pub(crate) fn holds(&self, pose: &Pose, clearance_m: f64) -> bool {
        pose.distance_m(&self.pose) <= self.tolerance_m
            && clearance_m >= self.clearance_m
            && self.off_rad(pose.yaw_rad) <= self.tolerance_rad
    }
}

/// The targets, and the way to the nearest of them for a point robot.
#[derive(Debug, Clone, Default)]
pub(crate) struct Targets {
    pub(crate) all: Vec<Target>,
    /// Of every coarse cell: cost to go, and the target that this leads to.
    to_go: Vec<u32>,
    leads_to: Vec<u8>,
    queue: BinaryHeap<Reverse<(u32, u16)>>,
}

impl Targets {
    /// Finds the ways over cells wide enough for the inscribed disc of the outline (Dijkstra).
    pub(crate) fn find_ways(&mut self, space: &Space, footprint: &Footprint) {
        self.to_go.clear();
        self.to_go.resize(CELLS * CELLS, UNREACHED);
        self.leads_to.clear();
        self.leads_to.resize(CELLS * CELLS, 0);
        self.queue.clear();
        for (i, target) in self.all.iter().enumerate().take(TARGETS_MAX) {
            let index = cell(target.pose.y_m) * CELLS + cell(target.pose.x_m);
            self.to_go[index] = 0;
            self.leads_to[index] = i.to_u8();
            self.queue.push(Reverse((0, index.to_u16())));
        }
        // A cell of the map may be larger than what is in it.
        let needed_m = footprint.inscribed_m - 0.75 * CELL_M;
        while let Some(Reverse((cost, index))) = self.queue.pop() {
            let index = usize::from(index);
            if cost > self.to_go[index] {
                continue;
            }
            let (x, y) = (index % CELLS, index / CELLS);
            for (to_x, to_y) in around(x, y) {
                let to = to_y * CELLS + to_x;
                let step = if to_x == x || to_y == y { 100 } else { 141 };
                let next = cost + step;
                if next < self.to_go[to] && space.coarse_m(to_x, to_y) >= needed_m {
                    self.to_go[to] = next;
                    self.leads_to[to] = self.leads_to[index];
                    self.queue.push(Reverse((next, to.to_u16())));
                }
            }
        }
    }

    /// [m] from a pose to the target that is nearest by a free way, and that target; `None` where there
    /// is no way.
    pub(crate) fn to_go(&self, pose: &Pose) -> Option<(f64, &Target)> {
        let index = cell(pose.y_m) * CELLS + cell(pose.x_m);
        let cost = *self.to_go.get(index)?;
        let target = self.all.get(usize::from(*self.leads_to.get(index)?))?;
        let straight_m = pose.distance_m(&target.pose);
        let way_m = f64::from(cost) / PER_M - 0.5 * CELL_M;
        (cost != UNREACHED).then(|| (way_m.max(straight_m), target))
    }

    /// True when one of them holds.
    pub(crate) fn hold(&self, pose: &Pose, clearance_m: f64) -> bool {
        self.all
            .iter()
            .any(|target| target.holds(pose, clearance_m))
    }
}

/// The cells around one, within the window.
fn around(x: usize, y: usize) -> impl Iterator<Item = (usize, usize)> {
    let near = |at: usize| at.saturating_sub(1)..=(at + 1).min(CELLS - 1);
    near(y)
        .flat_map(move |to_y| near(x).map(move |to_x| (to_x, to_y)))
        .filter(move |to| *to != (x, y))
}

/// True within the window, with room for the outline.
pub(crate) fn is_inside(pose: &Pose, footprint: &Footprint) -> bool {
    let inner_m = HALF_M - footprint.circumscribed_m - 2.0 * CELL_M;
    pose.x_m.abs() < inner_m && pose.y_m.abs() < inner_m
}
