//! `lazy_theta`: ways at any angle, for the shortest way whatever the cells cost.
//!
//! Nash, Koenig, Tovey, "Lazy Theta*: Any-Angle Path Planning and Path Length Analysis in 3D",
//! AAAI 2010: a cell is offered with its parent's parent as its own, and the line between them is
//! looked at only when the cell is taken from the open list. Not always the shortest of all ways,
//! but rarely more than a percent longer.

use crate::bits::Lines;
use crate::ground::Ground;
use crate::limits::Limits;
use crate::map_options::MapOptions;
use crate::moves::STEPS;
use crate::node_pool::NodePool;
use crate::padded::{padded, push_cell};
use crate::planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};
use crate::search::Found;
use crate::sight::sees;
use core::cmp::Reverse;
use std::collections::BinaryHeap;
use zeronav_casts::{Cast, low_u32};
use zeronav_msgs::{CellRect, MapView};

/// Expansions between two looks at the budget; lines of sight can be long.
const BUDGET_EVERY: u64 = 1024;

/// Parts of a cell in the keys of the open list.
const KEY_PARTS: f32 = 1024.0;

/// What the search knows about a cell.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    /// Length of the best way found so far. [cells]
    so_far: f32,
    /// Corner before, padded: `y << 16 | x`.
    parent: u32,
    /// `generation << 1 | closed`.
    meta: u32,
}

/// Bits of the generation in [`Node::meta`].
const GENERATION_BITS: u32 = 31;

/// See the module's description.
#[derive(Debug)]
pub(crate) struct LazyTheta {
    ground: Ground,
    search: Search,
}

/// Memory of the search, reused from call to call.
#[derive(Debug, Default)]
struct Search {
    pool: NodePool<Node>,
    open: BinaryHeap<Reverse<u64>>,
    corners: Vec<u32>,
}

impl LazyTheta {
    /// A planner with empty memory.
    #[must_use]
    pub(crate) fn new(options: MapOptions) -> Self {
        Self {
            ground: Ground::new(options),
            search: Search::default(),
        }
    }
}

/// A running search.
struct Run<'a> {
    rows: &'a Lines,
    rule: CornerRule,
    goal: (u32, u32),
    nodes: &'a mut [Node],
    generation: u32,
    open: &'a mut BinaryHeap<Reverse<u64>>,
    width: usize,
}

impl Search {
    fn run(
        &mut self,
        rows: &Lines,
        rule: CornerRule,
        (start, goal): ((u32, u32), (u32, u32)),
        limits: &mut Limits<'_>,
        path: &mut CellPath,
    ) -> Found {
        let width = rows.length() + 2;
        self.pool.begin(width * (rows.count() + 2), GENERATION_BITS);
        self.open.clear();
        let mut run = Run {
            rows,
            rule,
            goal,
            nodes: &mut self.pool.nodes,
            generation: self.pool.generation,
            open: &mut self.open,
            width,
        };
        let found = run.search(start, limits, &mut path.stats);
        if found == Found::Path {
            self.trace(width, goal, path);
        }
        found
    }

    /// Appends the corners of the path.
    fn trace(&mut self, width: usize, goal: (u32, u32), path: &mut CellPath) {
        let nodes = &self.pool.nodes;
        self.corners.clear();
        let mut at = pack(goal);
        for _ in 0..nodes.len() {
            self.corners.push(at);
            let (x, y) = unpack(at);
            let parent = nodes[y as usize * width + x as usize].parent;
            if parent == at {
                break;
            }
            at = parent;
        }
        for at in self.corners.iter().rev() {
            push_cell(&mut path.cells, unpack(*at));
        }
    }
}

impl Run<'_> {
    fn search(
        &mut self,
        start: (u32, u32),
        limits: &mut Limits<'_>,
        stats: &mut PlanStats,
    ) -> Found {
        let first = self.index(start);
        self.nodes[first] = Node {
            so_far: 0.0,
            parent: pack(start),
            meta: self.generation << 1,
        };
        self.open.push(item(apart(start, self.goal), start));
        stats.generated += 1;
        while let Some(Reverse(next)) = self.open.pop() {
            stats.peak_open = stats.peak_open.max(self.open.len() as u64 + 1);
            let at = unpack(low_u32(next));
            let index = self.index(at);
            if self.nodes[index].meta & 1 != 0 {
                continue;
            }
            self.nodes[index].meta |= 1;
            let parent = unpack(self.nodes[index].parent);
            if !sees(self.rows, self.rule, parent, at) {
                self.choose_parent_beside(at);
            }
            stats.expanded += 1;
            if at == self.goal {
                return Found::Path;
            }
            if let Some(found) = limits.ended::<BUDGET_EVERY>(stats.expanded) {
                return found;
            }
            self.expand(at, stats);
        }
        Found::Nothing
    }

    /// The line of sight that was assumed does not exist: the best closed neighbour leads here.
    fn choose_parent_beside(&mut self, at: (u32, u32)) {
        let (mut so_far, mut parent) = (f32::INFINITY, self.nodes[self.index(at)].parent);
        for step in STEPS {
            let Some(beside) = self.legal(at, step) else {
                continue;
            };
            let other = self.nodes[self.index(beside)];
            let closed = other.meta == self.generation << 1 | 1;
            let over_it = other.so_far + apart(beside, at);
            if closed && over_it < so_far {
                (so_far, parent) = (over_it, pack(beside));
            }
        }
        let index = self.index(at);
        let node = &mut self.nodes[index];
        (node.so_far, node.parent) = (so_far, parent);
    }

    /// Offers the parent of a cell to its neighbours.
    fn expand(&mut self, at: (u32, u32), stats: &mut PlanStats) {
        let parent = unpack(self.nodes[self.index(at)].parent);
        let parent_so_far = self.nodes[self.index(parent)].so_far;
        for step in STEPS {
            let Some(beside) = self.legal(at, step) else {
                continue;
            };
            stats.evaluated += 1;
            let so_far = parent_so_far + apart(parent, beside);
            let index = self.index(beside);
            let node = &mut self.nodes[index];
            let known = node.meta >> 1 == self.generation;
            if known && (node.meta & 1 != 0 || so_far >= node.so_far) {
                continue;
            }
            *node = Node {
                so_far,
                parent: pack(parent),
                meta: self.generation << 1,
            };
            stats.generated += 1;
            let key = so_far + apart(beside, self.goal);
            self.open.push(item(key, beside));
        }
    }

    /// The neighbour that a step leads to, if the step is legal.
    #[inline]
    fn legal(&self, (x, y): (u32, u32), (dx, dy): (i32, i32)) -> Option<(u32, u32)> {
        let blocked = |x: u32, y: u32| self.rows.is_blocked(y as usize, x as usize);
        let (to_x, to_y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
        let free = !blocked(to_x, to_y)
            && (dx == 0 || dy == 0 || self.rule.permits(blocked(to_x, y), blocked(x, to_y)));
        free.then_some((to_x, to_y))
    }

    #[inline]
    const fn index(&self, (x, y): (u32, u32)) -> usize {
        y as usize * self.width + x as usize
    }
}

impl GlobalPlanner for LazyTheta {
    fn plan(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        let ends = self.ground.open(query, path)?;
        let rule = query.corner_rule;
        self.ground
            .answer(query, &ends, path, |ground, between, path| {
                let (bits, mut may_reach) = ground.parts(rule, between);
                let mut limits = Limits {
                    budget,
                    may_reach: &mut may_reach,
                };
                let between = (padded(between.0), padded(between.1));
                self.search
                    .run(bits.rows(), rule, between, &mut limits, path)
            })?;
        path.stats.cost = path.length_cells() * query.map.geometry.resolution_m;
        Ok(path.stats)
    }

    fn map_changed(&mut self, map: &MapView<'_>, changed: &[CellRect]) {
        self.ground.change(map, changed);
    }
}

fn apart(one: (u32, u32), other: (u32, u32)) -> f32 {
    let (dx, dy) = (one.0.abs_diff(other.0), one.1.abs_diff(other.1));
    (dx * dx + dy * dy).to_f32().sqrt()
}

fn item(key: f32, at: (u32, u32)) -> Reverse<u64> {
    Reverse((key * KEY_PARTS).to_u64() << 32 | u64::from(pack(at)))
}

const fn pack((x, y): (u32, u32)) -> u32 {
    y << 16 | x
}

const fn unpack(at: u32) -> (u32, u32) {
    (at & 0xffff, at >> 16)
}
