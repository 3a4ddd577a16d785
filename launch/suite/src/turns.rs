//! The search on the exact outline for a way to a pose: of what stands, in place and yaw, without
//! dynamics.
//!
//! A search of the cheapest way first (hybrid A*, Dolgov et al., "Practical search techniques in path
//! planning for autonomous driving", 2008) over short arcs ahead, turns on the spot, and arcs back when the
//! robot drives backwards. Its time, at top speeds and without acceleration, is less than any robot of these
//! limits takes up to the resolution of the search. A way that is found can be driven at a crawl; that none
//! was found proves nothing, because the search is bounded and its steps are of one size.

use super::ground::Ground;
use super::oracle::robot::Abilities;
use core::f64::consts::TAU;
use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;
use zeronav_scenario::GoalSpec;
use zeronav_world::World;

/// Length of an arc where there is little room, and where there is plenty. [m]
const STEPS_M: [f64; 2] = [0.05, 0.2];

/// Angle of a turn on the spot. [rad]
const TURN_RAD: f64 = TAU / 72.0;

/// Turns of an arc, in shares of [`TURN_RAD`] per short step.
const BENDS: [f64; 7] = [0.0, 0.5, -0.5, 1.0, -1.0, 2.0, -2.0];

/// Sides of a cell: place where there is little room and where there is plenty [m], and yaw. [rad]
const CELLS_M: [f64; 2] = [0.025, 0.1];
const CELL_RAD: f64 = TURN_RAD;

/// States that are expanded at most.
const STATES_MAX: usize = 1_000_000;

/// A way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turns {
    /// Time at top speeds. [s]
    pub(crate) time_s: f64,
    /// Length of the way of the centre. [m]
    pub(crate) length_m: f64,
    /// `map_from_base` at its end.
    pub(crate) end: Pose,
}

/// What a case's search for a way came to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) enum OutlineWay {
    /// There was none.
    #[default]
    NotSearched,
    /// It found none.
    NotFound,
    /// It found this one.
    Found(Turns),
}

impl OutlineWay {
    /// The way that was found.
    pub(crate) const fn found(&self) -> Option<&Turns> {
        if let Self::Found(way) = self {
            Some(way)
        } else {
            None
        }
    }

    /// Whether a way was found, where one was searched for.
    pub(crate) const fn exists(&self) -> Option<bool> {
        match self {
            Self::NotSearched => None,
            Self::NotFound => Some(false),
            Self::Found(_) => Some(true),
        }
    }
}

impl Turns {
    /// None yet.
    pub(crate) const fn at(start: Pose) -> Self {
        Self {
            time_s: 0.0,
            length_m: 0.0,
            end: start,
        }
    }

    /// One after the other.
    pub(crate) fn and(&self, next: &Self) -> Self {
        Self {
            time_s: self.time_s + next.time_s,
            length_m: self.length_m + next.length_m,
            end: next.end,
        }
    }
}

/// A state that was reached.
#[derive(Clone, Copy)]
struct Node {
    at: Turns,
    /// With the least time from there. [s]
    total_s: f64,
}

/// A way from `start` to a goal that touches nothing that stands, if the search finds one.
pub(crate) fn find(
    world: &World,
    abilities: &Abilities,
    start: Pose,
    goal: &GoalSpec,
) -> Option<Turns> {
    let goal_m = [goal.pose.x_m, goal.pose.y_m];
    let ground = Ground::new(world, abilities, goal_m, goal.tolerance_m);
    let [_, fastest_mps] = abilities.v_mps;
    let total_s = |at: &Turns| {
        let way_s = ground.to_go_m([at.end.x_m, at.end.y_m]) / fastest_mps;
        let off_rad = (off_rad(&at.end, goal) - goal.yaw_tolerance_rad).max(0.0);
        at.time_s + way_s.max(off_rad / abilities.w_radps_max)
    };
    let first = Turns::at(start);
    let mut open = BinaryHeap::from([Node {
        at: first,
        total_s: total_s(&first),
    }]);
    let mut best_s: HashMap<[i64; 3], f64> = HashMap::new();
    let mut expanded = 0;
    while let Some(Node { at, .. }) = open.pop() {
        if is_at(&at.end, goal) {
            return Some(at);
        }
        let is_wide = ground.certain_room_m([at.end.x_m, at.end.y_m]) > STEPS_M[1];
        if best_s
            .get(&cell(&at.end, is_wide))
            .is_some_and(|best_s| *best_s < at.time_s)
        {
            continue;
        }
        expanded += 1;
        if expanded > STATES_MAX {
            return None;
        }
        for (way_m, turn_rad, limit) in steps(abilities, is_wide) {
            let end = moved(&at.end, way_m, turn_rad);
            let turn_s = turn_rad.abs() / abilities.w_radps_max;
            let time_s = at.time_s
                + if way_m == 0.0 {
                    turn_s
                } else {
                    turn_s.max(way_m.abs() / limit)
                };
            // Halfway as well: a turn of five degrees moves a corner by less than a short step.
            let is_free =
                |share: f64| ground.room_m(&moved(&at.end, share * way_m, share * turn_rad)) > 0.0;
            if !(is_wide || is_free(0.5) && is_free(1.0)) {
                continue;
            }
            let next = Turns {
                time_s,
                length_m: at.length_m + way_m.abs(),
                end,
            };
            let total_s = total_s(&next);
            let is_wide = ground.certain_room_m([end.x_m, end.y_m]) > STEPS_M[1];
            let known_s = best_s.entry(cell(&end, is_wide)).or_insert(f64::INFINITY);
            if total_s.is_finite() && time_s < *known_s {
                *known_s = time_s;
                open.push(Node { at: next, total_s });
            }
        }
    }
    None
}

/// The steps from a state: way [m], turn [rad], and the limit of speed that counts [m/s] (of a turn on the
/// spot the yaw rate [rad/s]).
fn steps(abilities: &Abilities, is_wide: bool) -> impl Iterator<Item = (f64, f64, f64)> {
    let step_m = STEPS_M[usize::from(is_wide)];
    let bend_rad = TURN_RAD * step_m / STEPS_M[0];
    let spins = [TURN_RAD, -TURN_RAD].map(|turn_rad| (0.0, turn_rad, abilities.w_radps_max));
    let speeds = abilities.v_mps.into_iter().filter(|mps| *mps != 0.0);
    let arcs = speeds
        .flat_map(move |mps| BENDS.map(|bend| (step_m.copysign(mps), bend * bend_rad, mps.abs())));
    spins.into_iter().chain(arcs)
}

/// True within the tolerances of a goal.
fn is_at(pose: &Pose, goal: &GoalSpec) -> bool {
    pose.distance_m(&goal.pose) <= goal.tolerance_m && off_rad(pose, goal) <= goal.yaw_tolerance_rad
}

/// By how much the yaw of a pose is not the goal's, 0 to pi. [rad]
fn off_rad(pose: &Pose, goal: &GoalSpec) -> f64 {
    wrap_angle(pose.yaw_rad - goal.pose.yaw_rad).abs()
}

/// The pose after an arc.
fn moved(from: &Pose, way_m: f64, turn_rad: f64) -> Pose {
    let middle_rad = from.yaw_rad + 0.5 * turn_rad;
    // The chord of the arc.
    let half_rad = 0.5 * turn_rad;
    let chord_m = if half_rad.abs() < 1.0e-9 {
        way_m
    } else {
        way_m * half_rad.sin() / half_rad
    };
    Pose::new(
        from.x_m + chord_m * middle_rad.cos(),
        from.y_m + chord_m * middle_rad.sin(),
        wrap_angle(from.yaw_rad + turn_rad),
    )
}

/// The cell of a pose; those of wide and narrow places differ.
fn cell(pose: &Pose, is_wide: bool) -> [i64; 3] {
    let side_m = CELLS_M[usize::from(is_wide)];
    let yaw = (pose.yaw_rad.rem_euclid(TAU) / CELL_RAD).round().to_i64();
    let x = (pose.x_m / side_m).round().to_i64();
    [
        2 * x + i64::from(is_wide),
        (pose.y_m / side_m).round().to_i64(),
        yaw,
    ]
}

impl PartialEq for Node {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Node {}

impl PartialOrd for Node {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Node {
    /// The least time is the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.total_s.total_cmp(&self.total_s)
    }
}
