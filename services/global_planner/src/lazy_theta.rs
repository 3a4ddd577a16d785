//! `lazy_theta`: ways at any angle, for the shortest way whatever the cells cost.
//!
//! Nash, Koenig, Tovey, "Lazy Theta*: Any-Angle Path Planning and Path Length Analysis in 3D",
//! AAAI 2010: a cell is offered with its parent's parent as its own, and the line between them is
//! looked at only when the cell is taken from the open list. Not always the shortest of all ways,
//! but rarely more than a percent longer.

use crate::ground::Ground;
use crate::map_options::MapOptions;
use crate::moves::STEPS;
use crate::padded::{padded, push_cell};
use crate::planner::{
    CellPath, Control, CornerRule, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats,
};
use crate::search::Found;
use crate::sight::sees;
use core::cmp::Reverse;
use std::collections::BinaryHeap;
use zeronav_msgs::{Cell, CellRect, MapView};

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

const GENERATION_MAX: u32 = (1 << 31) - 1;

/// See the module's description.
#[derive(Debug)]
pub struct LazyTheta {
    ground: Ground,
    nodes: Vec<Node>,
    generation: u32,
    open: BinaryHeap<Reverse<u64>>,
    corners: Vec<u32>,
}

impl LazyTheta {
    /// A planner with empty memory.
    #[must_use]
    pub fn new(options: MapOptions) -> Self {
        Self {
            ground: Ground::new(options),
            nodes: Vec::new(),
            generation: 0,
            open: BinaryHeap::new(),
            corners: Vec::new(),
        }
    }

    fn search(
        &mut self,
        (start, goal): (Cell, Cell),
        rule: CornerRule,
        budget: &mut dyn FnMut(Expansions) -> Control,
        stats: &mut PlanStats,
    ) -> Found {
        let rows = self.ground.bits.rows();
        let width = rows.length() + 2;
        let n_nodes = width * (rows.count() + 2);
        if self.nodes.len() != n_nodes || self.generation == GENERATION_MAX {
            self.nodes = vec![Node::default(); n_nodes];
            self.generation = 0;
        }
        self.generation += 1;
        self.open.clear();
        let (from, to) = (padded(start), padded(goal));
        let index = |(x, y): (u32, u32)| y as usize * width + x as usize;
        let left = |at: (u32, u32)| apart(at, to);
        self.nodes[index(from)] = Node {
            so_far: 0.0,
            parent: pack(from),
            meta: self.generation << 1,
        };
        self.open.push(item(left(from), from));
        stats.generated += 1;
        while let Some(Reverse(next)) = self.open.pop() {
            stats.peak_open = stats.peak_open.max(self.open.len() as u64 + 1);
            #[allow(
                clippy::cast_possible_truncation,
                reason = "the low half is the position, as pushed"
            )]
            let at = unpack(next as u32);
            let node = self.nodes[index(at)];
            if node.meta & 1 != 0 {
                continue;
            }
            self.nodes[index(at)].meta |= 1;
            let mut node = node;
            let blocked = |x: u32, y: u32| rows.is_blocked(y as usize, x as usize);
            let legal = |x: u32, y: u32, dx: i32, dy: i32| {
                let (to_x, to_y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
                let free = !blocked(to_x, to_y)
                    && (dx == 0 || dy == 0 || rule.permits(blocked(to_x, y), blocked(x, to_y)));
                free.then_some((to_x, to_y))
            };
            if !sees(rows, rule, unpack(node.parent), at) {
                // The line was taken for free and is not: the best closed neighbour leads here.
                node.so_far = f32::INFINITY;
                for (dx, dy) in STEPS {
                    if let Some(beside) = legal(at.0, at.1, dx, dy) {
                        let other = self.nodes[index(beside)];
                        let closed = other.meta == self.generation << 1 | 1;
                        let so_far = other.so_far + apart(beside, at);
                        if closed && so_far < node.so_far {
                            node.so_far = so_far;
                            node.parent = pack(beside);
                        }
                    }
                }
                let slot = &mut self.nodes[index(at)];
                (slot.so_far, slot.parent) = (node.so_far, node.parent);
            }
            stats.expanded += 1;
            if at == to {
                return Found::Path;
            }
            if stats.expanded.is_multiple_of(BUDGET_EVERY)
                && budget(Expansions(stats.expanded)) == Control::Stop
            {
                return Found::Stopped;
            }
            if !self
                .ground
                .reach
                .may(&self.ground.bits, rule, (start, goal), stats.expanded)
            {
                return Found::Nothing;
            }
            let parent = unpack(node.parent);
            let parent_so_far = self.nodes[index(parent)].so_far;
            for (dx, dy) in STEPS {
                let Some(beside) = legal(at.0, at.1, dx, dy) else {
                    continue;
                };
                stats.evaluated += 1;
                let so_far = parent_so_far + apart(parent, beside);
                let other = &mut self.nodes[index(beside)];
                let known = other.meta >> 1 == self.generation;
                if known && (other.meta & 1 != 0 || so_far >= other.so_far) {
                    continue;
                }
                *other = Node {
                    so_far,
                    parent: node.parent,
                    meta: self.generation << 1,
                };
                stats.generated += 1;
                self.open.push(item(so_far + left(beside), beside));
            }
        }
        Found::Nothing
    }

    fn trace(&mut self, goal: Cell, path: &mut CellPath) {
        let width = self.ground.bits.rows().length() + 2;
        self.corners.clear();
        let mut at = pack(padded(goal));
        for _ in 0..self.nodes.len() {
            self.corners.push(at);
            let (x, y) = unpack(at);
            let parent = self.nodes[y as usize * width + x as usize].parent;
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

impl GlobalPlanner for LazyTheta {
    fn plan(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError> {
        path.clear();
        let ends = self.ground.ends(query)?;
        let start = self.ground.start(query.corner_rule, &ends);
        let ways = (start, ends.goal);
        let found = if self.ground.may(query.corner_rule, ways, 0) {
            self.search(ways, query.corner_rule, budget, &mut path.stats)
        } else {
            Found::Nothing
        };
        match found {
            Found::Path => {
                self.ground.lead(&mut path.cells);
                self.trace(ends.goal, path);
                path.stats.cost = path.length_cells() * query.map.geometry.resolution_m;
                Ok(path.stats)
            }
            Found::Stopped => Err(PlanError::OutOfBudget),
            Found::Nothing => Err(self.ground.no_way(query.corner_rule, &ends)),
        }
    }

    fn map_changed(&mut self, map: &MapView<'_>, changed: &[CellRect]) {
        self.ground.change(map, changed);
    }
}

#[allow(clippy::cast_precision_loss, reason = "positions lie within a side")]
fn apart(one: (u32, u32), other: (u32, u32)) -> f32 {
    let (dx, dy) = (one.0.abs_diff(other.0), one.1.abs_diff(other.1));
    ((dx * dx + dy * dy) as f32).sqrt()
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates, and no way is that long"
)]
fn item(key: f32, at: (u32, u32)) -> Reverse<u64> {
    Reverse(((key * KEY_PARTS) as u64) << 32 | u64::from(pack(at)))
}

const fn pack((x, y): (u32, u32)) -> u32 {
    y << 16 | x
}

const fn unpack(at: u32) -> (u32, u32) {
    (at & 0xffff, at >> 16)
}
