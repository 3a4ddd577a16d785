//! The search for a way: all that the robot can do, manoeuvre after manoeuvre, and of that the states
//! from which the goal is nearest.
//!
//! A layer holds states of one moment (a beam search). Its successor is what is free of their
//! manoeuvres, the most promising first, one for each cell of place, yaw and speed, until there are
//! enough. What is worth more than others is the time to the goal over an empty ground. A search
//! that finds nothing begins again with larger layers.

use super::super::ground::Ground;
use super::crowd::{self, Passage};
use super::velocity_pairs::{MANOEUVRE_S, Manoeuvre, VelocityPairs};
use super::way::{Route, Task};
use core::f64::consts::TAU;
use core::ops::Range;
use nalgebra::Point2;
use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, Ordering};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;

/// States of a layer, at most: of the first search, of the second and so on.
const WIDTHS: [usize; 3] = [2_000, 10_000, 50_000];

/// Side of a cell [m], and how many there are of yaws and of forward speeds.
const CELL_M: f64 = 0.25;
const YAWS: f64 = 16.0;
const SPEEDS: f64 = 3.0;

/// Room that a robot keeps to what moves, at least. [m] It forgives what is between two moments.
const ROOM_M: f64 = 0.01;

/// How far before the robot the ground tells whether it heads for the goal. [m]
const AHEAD_M: f64 = 0.4;

/// Ways over the ground are at most this share longer than the shortest: nothing is given up that
/// could still arrive in time.
const GROUND_ERROR: f64 = 0.05;

/// A state of a layer.
struct Node {
    at_m: [f64; 2],
    yaw_rad: f64,
    /// Cosine and sine of it.
    heading: [f64; 2],
    pair: usize,
}

/// How a state was reached.
#[derive(Clone, Copy)]
struct Trace {
    /// Index in the layer before.
    parent: usize,
    /// The pair in which its last manoeuvre ended.
    pair: usize,
}

/// A state that may be of the next layer.
struct Child {
    /// Time to the goal over an empty ground. [s]
    rank_s: f64,
    /// Its cell.
    cell: u64,
    parent: usize,
    /// Index among the manoeuvres of the parent's pair.
    manoeuvre: usize,
}

/// What comes of a manoeuvre.
#[derive(PartialEq, Eq)]
enum Outcome {
    Touches,
    Free,
    /// At the goal after so many moments.
    Arrives(usize),
}

/// A layer and how it was reached, and the ways that end in it by the moment of their end.
#[derive(Default)]
struct Layer {
    nodes: Vec<Node>,
    traces: Vec<Trace>,
    arrivals: Vec<(usize, Trace)>,
}

struct Search<'a> {
    task: &'a Task<'a>,
    pairs: &'a VelocityPairs,
    ground: &'a Ground<'a>,
    interrupted: &'a AtomicBool,
}

/// A way that touches nothing, if one was found before an interruption: `None` says nothing about
/// whether there is one. The same task always has the same answer.
pub(super) fn find(task: &Task<'_>, interrupted: &AtomicBool) -> Option<Route> {
    let pairs = VelocityPairs::new(task.abilities);
    let ground = Ground::new(task.world, task.abilities, task.goal_m, task.tolerance_m);
    let search = Search {
        task,
        pairs: &pairs,
        ground: &ground,
        interrupted,
    };
    WIDTHS.into_iter().find_map(|width| search.run(width))
}

impl Search<'_> {
    /// The search with at most `width` states in a layer.
    fn run(&self, width: usize) -> Option<Route> {
        let first = self.task.first();
        let mut nodes = vec![Node::new(first.at_m, first.yaw_rad, self.pairs.rest)];
        let mut traces: Vec<Vec<Trace>> = Vec::new();
        for n in 0.. {
            let left_s = self.task.time_limit_s - count(n) * MANOEUVRE_S;
            if left_s <= 0.0 || nodes.is_empty() || self.interrupted.load(Ordering::Relaxed) {
                break;
            }
            let crowd = crowd::during(self.task.movers, n);
            let mut layer = self.next(&nodes, &crowd, width, left_s);
            layer.arrivals.sort_by_key(|(moment, _)| *moment);
            for (_, last) in &layer.arrivals {
                let sequence = sequence(&traces, *last);
                if let Some(way) = Route::drive(self.task, self.pairs, &sequence) {
                    return Some(way);
                }
            }
            nodes = layer.nodes;
            traces.push(layer.traces);
        }
        None
    }

    /// The layer after `nodes`.
    fn next(&self, nodes: &[Node], crowd: &[Passage], width: usize, left_s: f64) -> Layer {
        let children = self.children(nodes, left_s);
        let (near, ranges) = self.near(nodes, crowd);
        let mut taken = HashSet::with_capacity(width);
        let mut layer = Layer::default();
        for child in &children {
            if layer.nodes.len() >= width {
                break;
            }
            if taken.contains(&child.cell) {
                continue;
            }
            let node = &nodes[child.parent];
            let manoeuvre = &self.pairs.from(node.pair)[child.manoeuvre];
            let around = near[ranges[child.parent].clone()].iter();
            let outcome = self.outcome(node, manoeuvre, &around.map(|index| &crowd[*index]));
            let trace = Trace {
                parent: child.parent,
                pair: manoeuvre.to,
            };
            match outcome {
                Outcome::Touches => continue,
                Outcome::Free => {}
                Outcome::Arrives(moment) => layer.arrivals.push((moment, trace)),
            }
            taken.insert(child.cell);
            layer.nodes.push(node.after(manoeuvre));
            layer.traces.push(trace);
        }
        layer
    }

    /// Where the manoeuvres of all states end, the most promising first.
    fn children(&self, nodes: &[Node], left_s: f64) -> Vec<Child> {
        let [_, fastest_mps] = self.task.abilities.v_mps;
        let most_s = (left_s - MANOEUVRE_S) * (1.0 + GROUND_ERROR);
        let mut children = Vec::new();
        for (parent, node) in nodes.iter().enumerate() {
            for (index, manoeuvre) in self.pairs.from(node.pair).iter().enumerate() {
                let end = node.after(manoeuvre);
                let to_go_m = self.ground.to_go_m(end.at_m);
                // What is infinite is beyond every limit, too.
                if to_go_m > most_s.max(0.0) * fastest_mps {
                    continue;
                }
                let v_mps = self.pairs.pair(manoeuvre.to).v_mps;
                children.push(Child {
                    rank_s: self.rank_s(&end, to_go_m, v_mps),
                    cell: self.cell(&end, v_mps),
                    parent,
                    manoeuvre: index,
                });
            }
        }
        children.sort_unstable_by(|a, b| {
            let by_rank = a.rank_s.total_cmp(&b.rank_s);
            by_rank
                .then(a.parent.cmp(&b.parent))
                .then(a.manoeuvre.cmp(&b.manoeuvre))
        });
        children
    }

    /// Time to the goal at top speed, and what it takes to reach that and to turn to the way. [s]
    fn rank_s(&self, end: &Node, to_go_m: f64, v_mps: f64) -> f64 {
        let [_, fastest_mps] = self.task.abilities.v_mps;
        let along_m = if v_mps < 0.0 { -AHEAD_M } else { AHEAD_M };
        let ahead_m = [
            end.at_m[0] + along_m * end.heading[0],
            end.at_m[1] + along_m * end.heading[1],
        ];
        // Nothing when it heads for the goal, twice the way when it heads away or for a wall.
        let from_there_m = self.ground.to_go_m(ahead_m).min(to_go_m + AHEAD_M);
        let off_m = from_there_m - to_go_m + AHEAD_M;
        let slower_mps = fastest_mps - v_mps.abs();
        let lost_m = slower_mps * slower_mps / (2.0 * self.task.abilities.speed_up_mps2);
        (to_go_m + 0.5 * off_m + lost_m) / fastest_mps
    }

    /// The cell of a state.
    fn cell(&self, end: &Node, v_mps: f64) -> u64 {
        let geometry = self.task.world.geometry();
        let side = |value_m: f64, from_m: f64| ((value_m - from_m) / CELL_M).max(0.0).to_u64();
        let x = side(end.at_m[0], geometry.origin_x_m);
        let y = side(end.at_m[1], geometry.origin_y_m);
        let yaw = (end.yaw_rad.rem_euclid(TAU) / TAU * YAWS)
            .min(YAWS - 1.0)
            .to_u64();
        let [slowest_mps, fastest_mps] = self.task.abilities.v_mps;
        let class_mps = fastest_mps / SPEEDS;
        let speed = ((v_mps - slowest_mps) / class_mps).round().to_u64();
        (x << 42) | (y << 20) | (yaw << 12) | speed.min(0xfff)
    }

    /// Whom each state may meet: indices into `crowd` and where those of each state lie.
    fn near(&self, nodes: &[Node], crowd: &[Passage]) -> (Vec<usize>, Vec<Range<usize>>) {
        let abilities = self.task.abilities;
        let fastest_mps = abilities.v_mps[1].max(-abilities.v_mps[0]);
        let within_m = fastest_mps * MANOEUVRE_S + abilities.reach_m + 2.0 * ROOM_M;
        let mut near = Vec::new();
        let ranges = nodes.iter().map(|node| {
            let begin = near.len();
            let all = crowd.iter().enumerate();
            let meets = all.filter(|(_, passage)| passage.apart_m(node.at_m) <= within_m);
            near.extend(meets.map(|(index, _)| index));
            begin..near.len()
        });
        let ranges = ranges.collect();
        (near, ranges)
    }

    /// What comes of a manoeuvre among these discs.
    fn outcome<'c>(
        &self,
        node: &Node,
        manoeuvre: &Manoeuvre,
        near: &(impl Iterator<Item = &'c Passage> + Clone),
    ) -> Outcome {
        let abilities = self.task.abilities;
        let fastest_mps = abilities.v_mps[1].max(-abilities.v_mps[0]);
        let way_m = self.task.to_goal_m(node.at_m) - self.task.tolerance_m;
        let may_arrive = way_m <= fastest_mps * MANOEUVRE_S;
        // How far it may still move before it can touch something static.
        let mut room_m = 0.0;
        for (n, moment) in manoeuvre.moments.iter().enumerate() {
            let at_m = node.placed(moment.at_m);
            let heading = turned(node.heading, moment.turned);
            for passage in near.clone() {
                let Some(centre_m) = passage.at_m[n] else {
                    continue;
                };
                let (dx, dy) = (centre_m[0] - at_m[0], centre_m[1] - at_m[1]);
                let apart_m = dx.hypot(dy);
                let least_m = passage.radius_m + ROOM_M;
                if apart_m > least_m + abilities.reach_m {
                    continue;
                }
                let [cos, sin] = heading;
                let in_base = Point2::new(cos * dx + sin * dy, cos * dy - sin * dx);
                if apart_m <= least_m + abilities.radius_m
                    || abilities.outline.distance_to_point_m(in_base) <= least_m
                {
                    return Outcome::Touches;
                }
            }
            room_m -= moment.moved_m;
            if room_m <= 0.0 {
                room_m = self.ground.certain_room_m(at_m);
            }
            if room_m <= 0.0 {
                let yaw_rad = heading[1].atan2(heading[0]);
                room_m = self.ground.room_m(&Pose::new(at_m[0], at_m[1], yaw_rad));
                if room_m <= 0.0 {
                    return Outcome::Touches;
                }
            }
            if may_arrive && self.task.is_there(at_m) {
                return Outcome::Arrives(n + 1);
            }
        }
        Outcome::Free
    }
}

impl Node {
    fn new(at_m: [f64; 2], yaw_rad: f64, pair: usize) -> Self {
        let (sin, cos) = yaw_rad.sin_cos();
        Self {
            at_m,
            yaw_rad,
            heading: [cos, sin],
            pair,
        }
    }

    /// A point of its frame. [m]
    fn placed(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = self.heading;
        [
            self.at_m[0] + cos * x - sin * y,
            self.at_m[1] + sin * x + cos * y,
        ]
    }

    /// The state after a manoeuvre.
    fn after(&self, manoeuvre: &Manoeuvre) -> Self {
        let end = manoeuvre.end();
        Self {
            at_m: self.placed(end.at_m),
            yaw_rad: self.yaw_rad + manoeuvre.turned_rad,
            heading: turned(self.heading, end.turned),
            pair: manoeuvre.to,
        }
    }
}

/// Cosine and sine of the sum of two angles.
fn turned([cos, sin]: [f64; 2], [by_cos, by_sin]: [f64; 2]) -> [f64; 2] {
    [cos * by_cos - sin * by_sin, sin * by_cos + cos * by_sin]
}

/// The pairs that lead to `last`, which comes after the layers of `traces`.
fn sequence(traces: &[Vec<Trace>], last: Trace) -> Vec<usize> {
    let mut pairs = vec![last.pair];
    let mut parent = last.parent;
    for layer in traces.iter().rev() {
        let trace = layer[parent];
        pairs.push(trace.pair);
        parent = trace.parent;
    }
    pairs.reverse();
    pairs
}

fn count(n: usize) -> f64 {
    n.to_f64()
}
