//! The poses on a whole map at which a scan fits, best first, without a guess.
//!
//! Branch and bound (Hess, Kohler, Rapp, Andor, "Real-Time Loop Closure in 2D LIDAR SLAM", 2016, algorithm 3),
//! best first: a node is a cube of poses in x, y and yaw, its bound the sum over the beams of the best that any cell explains
//! in which one may end at any of these poses, and the cube with the highest bound is cut into eight. So the first single pose that
//! is taken is the best of all, and the others follow in order. The work is counted in beams and goes on
//! where it was left: the same in every run, however it is sliced.

use crate::search_map::SearchMap;
use core::f64::consts::TAU;
use nalgebra::Point2;
use std::collections::BinaryHeap;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;

/// Level of the first nodes: cubes of 16 cells a side and 16 steps of yaw.
const ROOT: u8 = 4;

/// Most beams that are laid on the map; of more, every n-th.
pub(crate) const BEAMS_MAX: usize = 72;

/// Poses after which no more are looked for.
pub(crate) const PLACES_MAX: usize = 32;

/// Within this of a better pose another one is not a place of its own. [m, rad]
const OWN: (f64, f64) = (0.4, 0.2);

/// Share of the beams that a pose must explain, and of what the best one explains.
const WORTH: (f64, f64) = (0.35, 0.82);

/// Nodes that are looked at, and that wait, at most. A scan that would take more lies nearly as well nearly everywhere.
const LOOKS_MAX: usize = 3_000_000;
const WAIT_MAX: usize = 1 << 20;

/// What it costs to take a node from those that wait, in beams that are laid on the map.
const TAKES: usize = 24;

/// A cube of poses: `bound` first, so that the best one comes first, and the rest makes the order whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Node {
    bound: u32,
    level: u8,
    /// First step of the yaw.
    yaw: u32,
    /// First column and row.
    x: i32,
    y: i32,
}

/// A place at which a scan fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// `map_from_base`, to half a cell.
    pub(crate) pose: Pose,
    /// How much of the scan it explains, 0 to 1.
    pub(crate) share: f64,
}

/// Looks for the places at which a scan fits.
#[derive(Debug)]
pub(crate) struct GlobalSearch {
    /// Where beams ended, in `base`. [cells]
    ends: Vec<Point2<f64>>,
    /// The same turned by a yaw, in cells from that of the robot.
    turned: Vec<(i32, i32)>,
    n_yaws: u32,
    /// Roots that were looked at.
    n_begun: u32,
    waiting: BinaryHeap<Node>,
    places: Vec<Place>,
    /// Nodes that were looked at.
    n_looks: usize,
    /// Beams that were laid on the map, and what else costs as much.
    n_beams: usize,
    /// Every pose was looked at or refused.
    complete: bool,
}

impl GlobalSearch {
    /// Begins with where beams ended, in `base` [m].
    pub(crate) fn new(map: &SearchMap, ends_m: &[Point2<f64>]) -> Self {
        let every = ends_m.len().div_ceil(BEAMS_MAX).max(1);
        let ends = ends_m.iter().step_by(every);
        let ends: Vec<_> = ends.map(|end| end / map.cell_m()).collect();
        // A step of yaw moves the farthest end by a cell.
        let farthest = ends.iter().map(|end| end.coords.norm()).fold(1.0, f64::max);
        let n_yaws = (TAU * farthest).ceil().to_u32();
        Self {
            turned: Vec::with_capacity(ends.len()),
            ends,
            n_yaws,
            n_begun: 0,
            waiting: BinaryHeap::new(),
            places: Vec::new(),
            n_looks: 0,
            n_beams: 0,
            complete: false,
        }
    }

    /// Goes on for about as long as it takes to lay so many beams on the map; true when the search has ended.
    pub(crate) fn advance(&mut self, map: &SearchMap, n_beams: usize) -> bool {
        let until = self.n_beams + n_beams;
        while self.n_beams < until {
            if !self.begin_root(map) {
                break;
            }
        }
        while self.n_beams < until {
            if self.n_looks > LOOKS_MAX || self.waiting.len() > WAIT_MAX {
                return true;
            }
            let Some(node) = self.waiting.pop().filter(|node| node.bound > self.least()) else {
                self.complete = true;
                return true;
            };
            self.n_beams += TAKES;
            if self.is_beside_a_place(map, &node) {
                continue;
            }
            if node.level > 0 {
                self.split(map, &node);
                continue;
            }
            let place = self.place(map, &node);
            self.places.push(place);
            if self.places.len() == PLACES_MAX {
                return true;
            }
        }
        false
    }

    /// The places that were found, best first.
    pub(crate) fn places(&self) -> &[Place] {
        &self.places
    }

    /// True when there is no other place that explains nearly as much as the best one: the search has ended, and
    /// neither for too many places nor for too much work.
    pub(crate) fn is_complete(&self) -> bool {
        self.complete
    }

    /// Looks at the next root; false when there is none.
    fn begin_root(&mut self, map: &SearchMap) -> bool {
        let side = 1 << ROOT;
        let (width, height) = map.size();
        let along = |cells: i32| u32::try_from((cells + side - 1) / side).unwrap_or(0);
        let (columns, rows) = (along(width), along(height));
        let turns = self.n_yaws.div_ceil(1 << ROOT);
        if columns == 0 || self.n_begun >= columns * rows * turns {
            return false;
        }
        let (turn, at) = (
            self.n_begun / (columns * rows),
            self.n_begun % (columns * rows),
        );
        self.n_begun += 1;
        if at == 0 {
            self.turn(ROOT, turn << ROOT);
        }
        let cells = |n: u32| i32::try_from(n).unwrap_or(0) * side;
        self.look(
            map,
            ROOT,
            (cells(at % columns), cells(at / columns)),
            turn << ROOT,
        );
        true
    }

    /// Looks at the eight parts of a node.
    fn split(&mut self, map: &SearchMap, node: &Node) {
        let level = node.level - 1;
        let half = 1 << level;
        for yaw in [node.yaw, node.yaw + half] {
            self.turn(level, yaw);
            for y in [0, 1] {
                for x in [0, 1] {
                    let at = (node.x + (x << level), node.y + (y << level));
                    self.look(map, level, at, yaw);
                }
            }
        }
    }

    /// Turns the ends by the yaw in the middle of a node.
    fn turn(&mut self, level: u8, yaw: u32) {
        let (sin, cos) = self.yaw_rad(level, yaw).sin_cos();
        self.turned.clear();
        self.turned.extend(self.ends.iter().map(|end| {
            let (x, y) = (cos * end.x - sin * end.y, sin * end.x + cos * end.y);
            ((x + 0.5).floor().to_i32(), (y + 0.5).floor().to_i32())
        }));
    }

    /// Keeps a node that is worth it, of the yaw that the ends are turned by.
    fn look(&mut self, map: &SearchMap, level: u8, (x, y): (i32, i32), yaw: u32) {
        let side = 1 << level;
        if yaw >= self.n_yaws || !map.has_room(x, y, side) {
            return;
        }
        self.n_looks += 1;
        // Beams turn by half the cube's steps at most, which moves no end by more than half its cells.
        let (grid, before) = if level == 0 {
            (0, 0)
        } else {
            (usize::from(level) + 1, side / 2)
        };
        let least = self.least();
        let (bound, n_beams) = map.sum(grid, (x - before, y - before), &self.turned, least);
        self.n_beams += n_beams;
        if bound > least {
            self.waiting.push(Node {
                bound,
                level,
                yaw,
                x,
                y,
            });
        }
    }

    /// What a node must be above to be looked at.
    fn least(&self) -> u32 {
        let best = self.places.first().map_or(0.0, |place| place.share);
        (WORTH.0.max(WORTH.1 * best) * self.all()).to_u32()
    }

    /// What a pose would come to that explains everything.
    fn all(&self) -> f64 {
        255.0 * self.ends.len().max(1).to_f64()
    }

    /// The yaw in the middle of a node. [rad]
    fn yaw_rad(&self, level: u8, yaw: u32) -> f64 {
        let middle = f64::from(yaw) + 0.5 * f64::from((1_u32 << level) - 1);
        middle * TAU / f64::from(self.n_yaws)
    }

    /// True when all poses of a node lie beside a place that explains more.
    fn is_beside_a_place(&self, map: &SearchMap, node: &Node) -> bool {
        let cells = f64::from((1_u32 << node.level) - 1);
        let half_m = 0.5 * cells * map.cell_m();
        let half_rad = 0.5 * cells * TAU / f64::from(self.n_yaws);
        let middle = self.place(map, node).pose;
        self.places.iter().any(|Place { pose, .. }| {
            let (x_m, y_m) = (middle.x_m - pose.x_m, middle.y_m - pose.y_m);
            x_m.abs().max(y_m.abs()) + half_m <= OWN.0
                && wrap_angle(middle.yaw_rad - pose.yaw_rad).abs() + half_rad <= OWN.1
        })
    }

    /// The middle of a node.
    fn place(&self, map: &SearchMap, node: &Node) -> Place {
        let half_m = 0.5 * f64::from((1_u32 << node.level) - 1) * map.cell_m();
        let at = map.centre_of(node.x, node.y);
        Place {
            pose: Pose::new(
                at.x + half_m,
                at.y + half_m,
                wrap_angle(self.yaw_rad(node.level, node.yaw)),
            ),
            share: f64::from(node.bound) / self.all(),
        }
    }
}
