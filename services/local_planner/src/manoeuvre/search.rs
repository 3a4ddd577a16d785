//! The search for a manoeuvre: A* over the robot's poses (x, y, yaw) with motions of constant curvature,
//! ahead, back and on the spot.
//!
//! It goes from where the robot stands to a target or, `undone`, from the goal to where the robot stands:
//! the tight end first, where few poses are free. From poses on the way it tries to get to the other end
//! by a turn, a straight piece and a turn.
//!
//! Poses are exact, cells only tell which of them are alike (Dolgov, Thrun, Montemerlo, Diebel, "Path
//! planning for autonomous vehicles in unknown semi-structured environments", IJRR 2010, its first
//! stage). Every pose of a motion is checked with the true outline. The remaining cost is that of the
//! way of a point robot, weighted, so the first manoeuvre found is a good one, not the best.

use super::motions::{Motion, TURN, motions, straight};
use super::space::{HALF_M, Space};
use super::targets::Targets;
use crate::footprint::Footprint;
use core::cmp::Ordering;
use core::f64::consts::{PI, TAU};
use std::collections::BinaryHeap;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::description::Description;

/// Most poses kept.
const NODES: usize = 60_000;

/// Poses checked in one period at most, give or take those of a node.
const CHECKS: u32 = 3_000;

/// Poses checked in one search at most.
const CHECKS_MAX: u32 = 400_000;

/// Cells of the search along a side of the window, 5 cm, and of the yaw, 3.75 degrees.
const SIDE: usize = 128;
const YAWS: usize = 96;

/// Cost of a change between driving ahead, back and turning, in metres ahead.
const CHANGE: f64 = 0.25;

/// Of so many poses from which the search goes on, one is tried for a straight way to a target; of
/// those within [m] of it each.
const EVERY: u32 = 8;
const NEAR_M: f64 = 0.4;

/// [m] of clearance below which a motion costs more, up to so much more.
const SOFT_M: f64 = 0.12;
const TIGHT: f64 = 2.0;

/// [m] of clearance below which a robot stands in a tight place, and [m] more that are worth a manoeuvre.
const TIGHT_M: f64 = 0.07;
const MORE_M: f64 = 0.03;

/// By how much the remaining cost counts.
const WEIGHT: f64 = 1.4;

/// [m] from a target within which the yaw that it asks for counts.
const ALIGN_M: f64 = 1.5;

/// [m] by which a robot that begins inside the margin may come nearer.
const NEARER_M: f64 = 0.003;

/// A pose that can be reached.
#[derive(Debug, Clone, Copy)]
struct Node {
    pose: Pose,
    cost: f64,
    /// Of the motion that led here. [m]
    clearance_m: f64,
    parent: u32,
    motion: u8,
    direction: i8,
    /// All poses up to here have been inside the margin.
    inside: bool,
}

/// An entry of the queue, cheapest first, of equal ones the newest.
#[derive(Debug, Clone, Copy)]
struct Open {
    cost: f64,
    node: u32,
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_cost = other.cost.total_cmp(&self.cost);
        by_cost.then(self.node.cmp(&other.node))
    }
}

/// How a search stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Progress {
    /// It goes on.
    Searching,
    /// A manoeuvre has been found.
    Found,
    /// There is none, or none within the bounds of the search.
    NotFound,
}

/// A search, over several periods.
#[derive(Debug, Clone, Default)]
pub(crate) struct Search {
    pub(crate) space: Space,
    pub(crate) targets: Targets,
    /// Inside the margin only flat motions are free: what the search sees there is noise, and whoever checks
    /// the commands sees another one.
    pub(crate) careful: bool,
    motions: Vec<Motion>,
    /// The search goes from where the robot is to arrive to where it stands.
    undone: bool,
    /// From the last node to the target.
    last: [Option<Motion>; 3],
    directions: [f64; 2],
    popped: u32,
    nodes: Vec<Node>,
    open: BinaryHeap<Open>,
    /// Index of the cheapest pose in each cell, plus one; 0 = none.
    cells: Vec<u32>,
    /// Cells that are not 0.
    used: Vec<u32>,
    margin_m: f64,
    /// Least clearance of a robot that begins inside the margin. [m]
    floor_m: f64,
    /// The node with the most room so far, and how much that is. [m]
    roomiest: (u32, f64),
    checks: u32,
}

impl Search {
    pub(crate) fn new() -> Self {
        Self {
            nodes: Vec::with_capacity(NODES),
            open: BinaryHeap::with_capacity(NODES),
            cells: vec![0; SIDE * SIDE * YAWS],
            used: Vec::with_capacity(NODES),
            ..Self::default()
        }
    }

    /// Begins at a pose towards `targets`, in `space`; both are ready. `margin_m` is kept throughout, or
    /// as much of it as there is where the robot stands.
    pub(crate) fn begin(
        &mut self,
        robot: &Description,
        footprint: &Footprint,
        (pose, undone): (Pose, bool),
        margin_m: f64,
    ) {
        let reach_m = footprint.circumscribed_m;
        motions(robot, reach_m, undone, &mut self.motions);
        self.undone = undone;
        self.last = [None; 3];
        self.popped = 0;
        let backwards = if robot.v_mps_min < 0.0 { -1.0 } else { 1.0 };
        self.directions = [1.0, backwards];
        for cell in self.used.drain(..) {
            self.cells[cell as usize] = 0;
        }
        self.nodes.clear();
        self.open.clear();
        self.margin_m = margin_m;
        self.checks = 0;
        let clearance_m = self
            .space
            .clearance_m(footprint, &pose, f64::NEG_INFINITY, SOFT_M);
        self.floor_m = clearance_m - NEARER_M;
        self.roomiest = (0, clearance_m);
        self.push(
            Node {
                pose,
                cost: 0.0,
                clearance_m,
                parent: 0,
                motion: 0,
                direction: 0,
                inside: clearance_m < margin_m,
            },
            0.0,
        );
    }

    /// Goes on for a period.
    pub(crate) fn advance(&mut self, footprint: &Footprint) -> Progress {
        let until = self.checks + CHECKS;
        while let Some(Open { node, .. }) = self.open.pop() {
            let from = self.nodes[node as usize];
            if self.cells[cell_of(&from.pose)] != node + 1 {
                continue;
            }
            let there = self.targets.hold(&from.pose, from.clearance_m);
            if there && !self.undone || self.connects(footprint, &from) {
                self.open.clear();
                self.nodes.push(from);
                return Progress::Found;
            }
            self.expand(footprint, node, &from);
            if self.checks > CHECKS_MAX || self.nodes.len() + self.motions.len() >= NODES {
                break;
            }
            if self.checks > until {
                return Progress::Searching;
            }
        }
        Progress::NotFound
    }

    /// After a search without a result from where the robot stands in a tight place: makes the way to the
    /// place with the most room the manoeuvre. False when it stands in none, or there is not much more.
    pub(crate) fn find_room(&mut self) -> bool {
        let (node, room_m) = self.roomiest;
        let from_m = self.nodes.first().map_or(SOFT_M, |first| first.clearance_m);
        let found = from_m < TIGHT_M && room_m > from_m + MORE_M;
        if found {
            self.last = [None; 3];
            self.nodes.push(self.nodes[node as usize]);
        }
        found
    }

    /// The motions of the manoeuvre, each with its clearance [m], in the order in which they are driven.
    pub(crate) fn found(&self, motions: &mut Vec<(Motion, f64)>) {
        motions.clear();
        let mut at = self.nodes.last().copied();
        while let Some(node) = at.filter(|node| node.cost > 0.0) {
            at = self.nodes.get(node.parent as usize).copied();
            motions.push((self.motions[usize::from(node.motion)], node.clearance_m));
        }
        let clearance_m = self.nodes.last().map_or(0.0, |node| node.clearance_m);
        let last = self
            .last
            .iter()
            .flatten()
            .map(|motion| (*motion, clearance_m));
        if self.undone {
            for (motion, _) in motions.iter_mut() {
                *motion = motion.undone();
            }
            motions.splice(0..0, last);
        } else {
            motions.reverse();
            motions.extend(last);
        }
    }

    /// True when a turn, a straight piece and a turn lead from a pose to a target, or undone from the
    /// target to the pose.
    fn connects(&mut self, footprint: &Footprint, from: &Node) -> bool {
        self.popped += 1;
        let Some((to_go_m, target)) = self.targets.to_go(&from.pose) else {
            return false;
        };
        let target = *target;
        if to_go_m > NEAR_M && self.popped % EVERY != 1 {
            return false;
        }
        for direction in self.directions {
            let reach_m = footprint.circumscribed_m;
            let (begin, way) = if self.undone {
                let begin = target.pose;
                (
                    begin,
                    straight(&begin, &from.pose, (false, reach_m), direction),
                )
            } else {
                let end = target.facing(&from.pose, direction);
                let how = (target.tolerance_rad >= PI, reach_m);
                (from.pose, straight(&from.pose, &end, how, direction))
            };
            let mut at = Node {
                pose: begin,
                ..*from
            };
            let is_free = way.iter().flatten().all(|motion| {
                let free = self.check(footprint, &at, (motion, motion.direction < 0.0));
                at.pose = at.pose.then(&motion.at(1.0));
                at.inside &= free.is_some_and(|(_, inside)| inside);
                free.is_some()
            });
            if is_free {
                self.last = way;
                return true;
            }
        }
        false
    }

    fn expand(&mut self, footprint: &Footprint, node: u32, from: &Node) {
        for index in 0..self.motions.len() {
            let motion = self.motions[index];
            let direction = motion.direction.to_i8();
            let driven = if self.undone { motion.undone() } else { motion };
            let own = driven.cost();
            let mut cost = from.cost + own;
            if direction != from.direction && node > 0 {
                cost += CHANGE;
            }
            let pose = from.pose.then(&motion.at(1.0));
            if pose.x_m.abs() >= HALF_M || pose.y_m.abs() >= HALF_M {
                continue;
            }
            let known = self.cells[cell_of(&pose)] as usize;
            if known > 0 && self.nodes[known - 1].cost <= cost {
                continue;
            }
            let Some((to_go_m, off_rad)) = self.to_go(&pose) else {
                continue;
            };
            let Some((clearance_m, inside)) =
                self.check(footprint, from, (&motion, driven.direction < 0.0))
            else {
                continue;
            };
            let tight = ((SOFT_M - clearance_m) / SOFT_M).clamp(0.0, 1.0);
            cost += TIGHT * tight * own;
            if known > 0 && self.nodes[known - 1].cost <= cost {
                continue;
            }
            let next = Node {
                pose,
                cost,
                clearance_m,
                parent: node,
                motion: index.to_u8(),
                direction,
                inside,
            };
            let align = (1.0 - to_go_m / ALIGN_M).max(0.0);
            self.push(next, WEIGHT * (to_go_m + TURN * align * off_rad));
        }
    }

    /// [m] to a target, and [rad] from the yaw that it asks for.
    fn to_go(&self, pose: &Pose) -> Option<(f64, f64)> {
        let (to_go_m, target) = self.targets.to_go(pose)?;
        Some((to_go_m, target.off_rad(pose.yaw_rad)))
    }

    /// The least clearance of a motion [m], driven backwards or not, and whether it ends inside the margin
    /// still; `None` when it is not free.
    fn check(
        &mut self,
        footprint: &Footprint,
        from: &Node,
        (motion, backwards): (&Motion, bool),
    ) -> Option<(f64, bool)> {
        let mut least_m = f64::INFINITY;
        let mut inside = from.inside;
        if inside && self.careful && !motion.is_flat() {
            return None;
        }
        if !inside {
            // What is not free is mostly not free at its end.
            self.checks += 1;
            let end = from.pose.then(&motion.at(1.0));
            let (space, need_m) = (&self.space, self.margin_m);
            if space.clearance_m(footprint, &end, need_m, need_m) < need_m {
                return None;
            }
        }
        for step in 1..=motion.steps {
            self.checks += 1;
            let at = motion.at(f64::from(step) / f64::from(motion.steps));
            let pose = from.pose.then(&at);
            let need_m = if inside {
                self.margin_m.min(self.floor_m)
            } else {
                self.margin_m
            };
            let clearance_m = self.space.clearance_m(footprint, &pose, need_m, SOFT_M);
            if clearance_m < need_m || backwards && self.space.backs_unseen(&pose) {
                return None;
            }
            inside &= clearance_m < self.margin_m;
            least_m = least_m.min(clearance_m);
        }
        Some((least_m, inside))
    }

    fn push(&mut self, node: Node, to_go: f64) {
        let index = self.nodes.len().to_u32();
        let cell = cell_of(&node.pose);
        if node.clearance_m > self.roomiest.1 {
            self.roomiest = (index, node.clearance_m);
        }
        if self.cells[cell] == 0 {
            self.used.push(cell.to_u32());
        }
        self.cells[cell] = index + 1;
        self.nodes.push(node);
        self.open.push(Open {
            cost: node.cost + to_go,
            node: index,
        });
    }
}

fn cell_of(pose: &Pose) -> usize {
    let side = SIDE.to_f64();
    let along = |at_m: f64| {
        ((at_m / HALF_M + 1.0) * 0.5 * side)
            .clamp(0.0, side - 1.0)
            .to_usize()
    };
    let yaw = (pose.yaw_rad.rem_euclid(TAU) / TAU * YAWS.to_f64()).to_usize();
    (yaw.min(YAWS - 1) * SIDE + along(pose.y_m)) * SIDE + along(pose.x_m)
}
