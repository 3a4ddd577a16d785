//! Jump point search on a [`JumpMap`]; its source is named in `jps`.

use crate::ground::FreeCells as _;
use crate::jump_map::JumpMap;
use crate::limits::Limits;
use crate::moves::{DIAGONAL, STEPS, STRAIGHT, octile};
use crate::node_pool::NodePool;
use crate::padded::{padded, push_cell};
use crate::planner::{CellPath, PlanStats};
use crate::search::{COST_SO_FAR_MAX, Found};
use core::cmp::Reverse;
use std::collections::BinaryHeap;
use zeronav_casts::{Cast, low_u32};

/// Expansions between two looks at the budget; jumps can be long.
const BUDGET_EVERY: u64 = 256;

/// A padded position in the open list and in the nodes: `y * (width + 2) + x`.
type Spot = u32;

/// What the search knows about a cell.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    /// Cost of the best way found so far.
    so_far: u32,
    /// Where it came from.
    parent: Spot,
    /// `generation << 8 | directions done << 4 | directions to do`, a bit for each of east,
    /// north, west, south.
    meta: u32,
}

/// Bits of the generation in [`Node::meta`].
const GENERATION_BITS: u32 = 24;

/// Goes diagonally, then straight, and writes the way if it is free: none is shorter.
pub(crate) fn straight_way(
    map: &JumpMap,
    start: (u32, u32),
    goal: (u32, u32),
    path: &mut CellPath,
) -> bool {
    let (dx, dy) = (goal.0.abs_diff(start.0), goal.1.abs_diff(start.1));
    let (mut x, mut y) = start;
    let diagonal = direction(start, goal);
    for _ in 0..dx.min(dy) {
        match diagonal_step(map, x, y, diagonal) {
            Some(next) => (x, y) = next,
            None => return false,
        }
    }
    let turn = (x, y);
    while (x, y) != goal {
        // Towards the goal: what is found is the goal or something before it.
        match map.jump(x, y, direction((x, y), goal), goal) {
            Some(next) => (x, y) = next,
            None => return false,
        }
    }
    path.stats.expanded += 1;
    path.stats.generated += 1;
    path.stats.peak_open = path.stats.peak_open.max(1);
    for at in [start, turn, goal] {
        push_cell(&mut path.cells, at);
    }
    true
}

/// The step that leads from one position towards the other: diagonal when neither coordinate is
/// the same.
fn direction(from: (u32, u32), to: (u32, u32)) -> u32 {
    match (to.0.cmp(&from.0), to.1.cmp(&from.1)) {
        (core::cmp::Ordering::Greater, core::cmp::Ordering::Equal) => 0,
        (core::cmp::Ordering::Greater, core::cmp::Ordering::Greater) => 1,
        (core::cmp::Ordering::Equal, core::cmp::Ordering::Greater) => 2,
        (core::cmp::Ordering::Less, core::cmp::Ordering::Greater) => 3,
        (core::cmp::Ordering::Less, core::cmp::Ordering::Equal) => 4,
        (core::cmp::Ordering::Less, core::cmp::Ordering::Less) => 5,
        (core::cmp::Ordering::Greater, core::cmp::Ordering::Less) => 7,
        (core::cmp::Ordering::Equal, _) => 6,
    }
}

#[inline]
const fn beside(x: u32, y: u32, step: u32) -> (u32, u32) {
    let (dx, dy) = STEPS[(step & 7) as usize];
    (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy))
}

#[inline]
fn diagonal_step(map: &JumpMap, x: u32, y: u32, step: u32) -> Option<(u32, u32)> {
    let (to_x, to_y) = beside(x, y, step);
    let free = !map.is_blocked(to_x, y) && !map.is_blocked(x, to_y) && !map.is_blocked(to_x, to_y);
    free.then_some((to_x, to_y))
}

/// Memory of the search, reused from call to call.
#[derive(Debug, Default)]
pub(crate) struct Jumps {
    pool: NodePool<Node>,
    open: BinaryHeap<Reverse<u64>>,
    turns: Vec<Spot>,
}

impl Jumps {
    /// Searches from one padded position to the other; writes the corners of the path.
    pub(crate) fn run(
        &mut self,
        map: &JumpMap,
        start: (u32, u32),
        goal: (u32, u32),
        limits: &mut Limits<'_>,
        path: &mut CellPath,
    ) -> Found {
        let rows = map.bits().rows();
        let n_nodes = (rows.length() + 2) * (rows.count() + 2);
        self.pool.begin(n_nodes, GENERATION_BITS);
        self.open.clear();
        let width = (rows.length() + 2).to_u32();
        let mut run = Run {
            map,
            nodes: &mut self.pool.nodes,
            open: &mut self.open,
            generation: self.pool.generation,
            width,
            goal,
            generated: 0,
            evaluated: 0,
            overflow: false,
        };
        let found = run.search(start, limits, &mut path.stats);
        path.stats.generated += run.generated;
        path.stats.evaluated += run.evaluated;
        if found == Found::Path {
            self.trace(width, start, goal, path);
        }
        found
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.pool.bytes() + self.open.capacity() * size_of::<Reverse<u64>>()
    }

    /// Appends the ways from jump to jump: diagonal first, then straight.
    fn trace(&mut self, width: u32, start: (u32, u32), goal: (u32, u32), path: &mut CellPath) {
        let first = goal.1 * width + goal.0;
        let last = start.1 * width + start.0;
        self.turns.clear();
        let mut spot = first;
        self.turns.push(spot);
        while spot != last && self.turns.len() <= self.pool.nodes.len() {
            spot = self.pool.nodes[spot as usize].parent;
            self.turns.push(spot);
        }
        for n in (0..self.turns.len()).rev() {
            let at = (self.turns[n] % width, self.turns[n] / width);
            if let (Some(from), Some(before)) = (path.cells.last(), self.turns.get(n + 1)) {
                let from = padded(*from);
                let before = (before % width, before / width);
                if from == before {
                    let short = at.0.abs_diff(from.0).min(at.1.abs_diff(from.1));
                    let toward = |from: u32, to: u32| match to.cmp(&from) {
                        core::cmp::Ordering::Greater => from + short,
                        core::cmp::Ordering::Less => from - short,
                        core::cmp::Ordering::Equal => from,
                    };
                    push_cell(
                        &mut path.cells,
                        (toward(from.0, at.0), toward(from.1, at.1)),
                    );
                }
            }
            push_cell(&mut path.cells, at);
        }
    }
}

/// A search under way.
struct Run<'a> {
    map: &'a JumpMap,
    nodes: &'a mut [Node],
    open: &'a mut BinaryHeap<Reverse<u64>>,
    generation: u32,
    width: u32,
    goal: (u32, u32),
    generated: u64,
    /// Jumps and diagonal steps.
    evaluated: u64,
    overflow: bool,
}

impl Run<'_> {
    fn search(
        &mut self,
        start: (u32, u32),
        limits: &mut Limits<'_>,
        stats: &mut PlanStats,
    ) -> Found {
        let origin = start.1 * self.width + start.0;
        self.nodes[origin as usize] = Node {
            so_far: 0,
            parent: origin,
            // All directions done: no way leads back to the start.
            meta: self.generation << 8 | 0xf0,
        };
        stats.expanded += 1;
        let goal = self.goal.1 * self.width + self.goal.0;
        if origin == goal {
            return Found::Path;
        }
        for step in [0, 2, 4, 6] {
            self.straight(start, 0, origin, step);
            self.diagonal(start, 0, origin, step + 1);
        }
        while let Some(Reverse(item)) = self.open.pop() {
            stats.peak_open = stats.peak_open.max(self.open.len() as u64 + 1);
            let spot = low_u32(item);
            let node = &mut self.nodes[spot as usize];
            let directions = node.meta & 0xf;
            if directions == 0 {
                // A dearer way to a cell that has been expanded since.
                continue;
            }
            if spot == goal {
                stats.expanded += 1;
                return Found::Path;
            }
            node.meta = node.meta & !0xf | directions << 4;
            let so_far = node.so_far;
            stats.expanded += 1;
            if let Some(found) = limits.ended::<BUDGET_EVERY>(stats.expanded) {
                return found;
            }
            let at = (spot % self.width, spot / self.width);
            let mut left = directions;
            while left != 0 {
                let step = left.trailing_zeros() * 2;
                left &= left - 1;
                self.expand(at, so_far, spot, step);
            }
        }
        if self.overflow {
            Found::Stopped
        } else {
            Found::Nothing
        }
    }

    /// The successors of a cell that was entered by the straight `step`: on, and where an
    /// obstacle ends beside it also to that side.
    #[inline]
    fn expand(&mut self, at: (u32, u32), so_far: u32, spot: Spot, step: u32) {
        self.straight(at, so_far, spot, step);
        for (side, behind, ahead) in [
            (step + 2, step + 3, step + 1),
            (step + 6, step + 5, step + 7),
        ] {
            let (behind_x, behind_y) = beside(at.0, at.1, behind);
            let (side_x, side_y) = beside(at.0, at.1, side);
            if self.map.is_blocked(behind_x, behind_y) && !self.map.is_blocked(side_x, side_y) {
                self.straight(at, so_far, spot, side & 7);
                self.diagonal(at, so_far, spot, ahead & 7);
            }
        }
    }

    #[inline]
    fn straight(&mut self, at: (u32, u32), so_far: u32, parent: Spot, step: u32) {
        self.evaluated += 1;
        if let Some(to) = self.map.jump(at.0, at.1, step, self.goal) {
            let cells = to.0.abs_diff(at.0) + to.1.abs_diff(at.1);
            self.offer(to, so_far, cells * STRAIGHT, parent, step);
        }
    }

    /// Walks diagonally and offers what straight jumps from there find.
    #[inline]
    fn diagonal(&mut self, at: (u32, u32), so_far: u32, parent: Spot, step: u32) {
        let (mut x, mut y) = at;
        let mut way = 0;
        let (one, other) = (step - 1, (step + 1) & 7);
        while let Some(next) = diagonal_step(self.map, x, y, step) {
            (x, y) = next;
            way += DIAGONAL;
            self.evaluated += 1;
            if next == self.goal {
                self.offer(next, so_far, way, parent, one);
                return;
            }
            for step in [one, other] {
                if let Some(to) = self.map.jump(x, y, step, self.goal) {
                    let cells = to.0.abs_diff(x) + to.1.abs_diff(y);
                    self.offer(to, so_far, way + cells * STRAIGHT, parent, step);
                }
            }
        }
    }

    #[inline]
    fn offer(&mut self, to: (u32, u32), so_far: u32, way: u32, parent: Spot, step: u32) {
        let so_far = so_far.saturating_add(way);
        if so_far > COST_SO_FAR_MAX {
            self.overflow = true;
            return;
        }
        let spot = to.1 * self.width + to.0;
        let direction = 1 << (step / 2);
        let node = &mut self.nodes[spot as usize];
        let known = node.meta >> 8 == self.generation;
        if known && so_far > node.so_far {
            return;
        }
        if known && so_far == node.so_far {
            // As short, but it leads on elsewhere.
            let meta = node.meta;
            if (meta | meta >> 4) & direction != 0 {
                return;
            }
            node.meta |= direction;
            if meta & 0xf != 0 {
                return;
            }
        } else {
            *node = Node {
                so_far,
                parent,
                meta: self.generation << 8 | direction,
            };
        }
        self.generated += 1;
        let key = so_far + octile(to.0.abs_diff(self.goal.0), to.1.abs_diff(self.goal.1));
        self.open
            .push(Reverse(u64::from(key) << 32 | u64::from(spot)));
    }
}
