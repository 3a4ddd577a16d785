//! A* over the cells of a map: the part that takes the time.
//!
//! What makes it fast: 8 bytes a cell for everything the search knows about it, a generation
//! number in place of clearing them, costs read from the map on first touch only, integer keys
//! in a ring of buckets. Nothing is allocated once map and weight have been seen.

use crate::bucket_queue::BucketQueue;
use crate::moves::{DIAGONAL, STEPS, STRAIGHT, octile, price};
use crate::node_pool::NodePool;
use crate::planner::{Control, CornerRule, Expansions, PlanStats, Unknown};
use zeronav_casts::Cast;
use zeronav_msgs::map::COST_UNKNOWN;
use zeronav_msgs::{Cell, MapCell, MapView};

/// Expansions between two looks at the budget.
const BUDGET_EVERY: u64 = 2048;

/// Largest cost so far that may still grow by a step and a heuristic without wrapping: about four
/// million free cells.
pub(crate) const COST_SO_FAR_MAX: u32 = u32::MAX - (1 << 27);

/// In place of a price: the cell may not be entered.
const BLOCKED: u8 = u8::MAX;

/// What the search knows about a cell.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    /// Cost of the best way found so far.
    so_far: u32,
    /// `generation << 13 | price << 5 | step that led here << 1 | closed`; the step is
    /// [`NO_STEP`] at the start.
    meta: u32,
}

const CLOSED: u32 = 1;
const STEP_SHIFT: u32 = 1;
const STEP_MASK: u32 = 0b1_1110;
const NO_STEP: u32 = 8;
const PRICE_SHIFT: u32 = 5;
const GENERATION_SHIFT: u32 = 13;

impl Node {
    #[inline]
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the low eight bits are the price"
    )]
    const fn price(self) -> u8 {
        (self.meta >> PRICE_SHIFT) as u8
    }
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Found {
    /// The way is in the nodes, see [`Search::trace`].
    Path,
    /// Every reachable cell was closed.
    Nothing,
    /// The budget or the range of the numbers ended.
    Stopped,
}

/// One search's question, in cells. Both ends lie on the map; the start is free whatever it is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Task<'a> {
    pub(crate) map: MapView<'a>,
    pub(crate) start: Cell,
    pub(crate) goal: Cell,
    pub(crate) unknown: Unknown,
    pub(crate) corner_rule: CornerRule,
}

/// Memory of the search, reused from call to call.
#[derive(Debug)]
pub(crate) struct Search {
    pool: NodePool<Node>,
    open: BucketQueue,
    /// Integer cost of entering a cell of each cost, straight and diagonal.
    steps: [[u32; 256]; 2],
    span: u32,
}

impl Search {
    pub(crate) fn new(cost_weight: f64) -> Self {
        let mut steps = [[0; 256]; 2];
        for (cost, (straight, diagonal)) in (0..=u8::MAX).map(|cost| (cost, (STRAIGHT, DIAGONAL))) {
            let price = price(cost, cost_weight);
            steps[0][usize::from(cost)] = (f64::from(straight) * price).round().to_u32();
            steps[1][usize::from(cost)] = (f64::from(diagonal) * price).round().to_u32();
        }
        // A key exceeds that of the node it came from by the step and what the heuristic rises.
        let span = steps[1].iter().max().copied().unwrap_or(DIAGONAL) + DIAGONAL;
        Self {
            pool: NodePool::default(),
            open: BucketQueue::default(),
            steps,
            span,
        }
    }

    /// Searches, adding to the counters of `stats`.
    pub(crate) fn run(
        &mut self,
        task: &Task<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        stats: &mut PlanStats,
    ) -> Found {
        let n_cells = task.map.cells.len();
        assert_eq!(n_cells, task.map.geometry.len(), "map and geometry differ");
        self.pool.begin(n_cells, 32 - GENERATION_SHIFT);
        let mut run = Run::new(self, task);
        let found = run.search(budget, stats);
        stats.generated += run.generated;
        stats.peak_open = stats.peak_open.max(self.open.peak() as u64);
        found
    }

    /// Appends the way from the start to `goal` after [`Found::Path`], both ends included.
    pub(crate) fn trace(&self, task: &Task<'_>, cells: &mut Vec<Cell>) {
        let first = cells.len();
        let mut cell = task.goal;
        // Every cell is closed once, so the way back is no longer than the map is large.
        for _ in 0..self.pool.nodes.len() {
            cells.push(cell);
            let Some(index) = task.map.geometry.index_of(cell) else {
                break;
            };
            let step = (self.pool.nodes[index].meta & STEP_MASK) >> STEP_SHIFT;
            let Some((dx, dy)) = STEPS.get(step as usize) else {
                break;
            };
            cell = Cell::new(cell.x - dx, cell.y - dy);
        }
        cells[first..].reverse();
    }

    /// True when the last search closed the cell at `index`.
    pub(crate) fn has_closed(&self, index: usize) -> bool {
        self.pool.nodes.get(index).is_some_and(|node| {
            node.meta >> GENERATION_SHIFT == self.pool.generation && node.meta & CLOSED != 0
        })
    }
}

/// A search under way: slices and numbers in one place, so that the inner loop sees no `Vec`.
struct Run<'a> {
    nodes: &'a mut [Node],
    open: &'a mut BucketQueue,
    steps: &'a [[u32; 256]; 2],
    cells: &'a [MapCell],
    generation: u32,
    unknown: Unknown,
    corner_rule: CornerRule,
    width: u32,
    height: u32,
    goal: (u32, u32),
    generated: u64,
    overflow: bool,
}

impl<'a> Run<'a> {
    fn new(search: &'a mut Search, task: &Task<'a>) -> Self {
        let geometry = task.map.geometry;
        let start = (task.start.x.cast_unsigned(), task.start.y.cast_unsigned());
        let goal = (task.goal.x.cast_unsigned(), task.goal.y.cast_unsigned());
        let key = octile(start.0.abs_diff(goal.0), start.1.abs_diff(goal.1));
        search.open.reset(key, search.span);
        let run = Self {
            nodes: &mut search.pool.nodes,
            open: &mut search.open,
            steps: &search.steps,
            cells: task.map.cells,
            generation: search.pool.generation,
            unknown: task.unknown,
            corner_rule: task.corner_rule,
            width: geometry.width,
            height: geometry.height,
            goal,
            generated: 1,
            overflow: false,
        };
        let index = run.index(start.0, start.1);
        run.nodes[index] = Node {
            so_far: 0,
            meta: run.generation << GENERATION_SHIFT | NO_STEP << STEP_SHIFT,
        };
        run.open.push(key, pack(start.0, start.1));
        run
    }

    fn search(
        &mut self,
        budget: &mut dyn FnMut(Expansions) -> Control,
        stats: &mut PlanStats,
    ) -> Found {
        while let Some(item) = self.open.pop() {
            let (x, y) = unpack(item);
            let index = self.index(x, y);
            let node = &mut self.nodes[index];
            if node.meta & CLOSED != 0 {
                // A dearer way to a cell that has been closed since.
                continue;
            }
            node.meta |= CLOSED;
            let (so_far, step) = (node.so_far, (node.meta & STEP_MASK) >> STEP_SHIFT);
            stats.expanded += 1;
            if (x, y) == self.goal {
                return Found::Path;
            }
            if stats.expanded.is_multiple_of(BUDGET_EVERY)
                && budget(Expansions(stats.expanded)) == Control::Stop
            {
                return Found::Stopped;
            }
            stats.evaluated += if step == NO_STEP { 8 } else { 5 };
            self.expand(x, y, so_far, step);
        }
        if self.overflow {
            Found::Stopped
        } else {
            Found::Nothing
        }
    }

    /// Offers the way over `(x, y)` to the neighbours that it may improve.
    ///
    /// The three cells behind, seen in the direction of the step that led here, are left out: the
    /// cell before reaches them by a single step that costs less than this detour, whatever the
    /// costs are, and has offered it.
    #[inline]
    fn expand(&mut self, x: u32, y: u32, so_far: u32, step: u32) {
        let rule = self.corner_rule;
        if step == NO_STEP {
            let straight = [0, 2, 4, 6].map(|n| self.offer(x, y, so_far, n));
            for n in 0..4_u32 {
                let (one, other) = (straight[n as usize], straight[(n as usize + 1) % 4]);
                if rule.permits(!one, !other) {
                    self.offer(x, y, so_far, 2 * n + 1);
                }
            }
        } else if step.is_multiple_of(2) {
            let ahead = self.offer(x, y, so_far, step);
            let left = self.offer(x, y, so_far, step + 2);
            let right = self.offer(x, y, so_far, step + 6);
            if rule.permits(!ahead, !left) {
                self.offer(x, y, so_far, step + 1);
            }
            if rule.permits(!ahead, !right) {
                self.offer(x, y, so_far, step + 7);
            }
        } else {
            let left = self.offer(x, y, so_far, step + 1);
            let right = self.offer(x, y, so_far, step + 7);
            if rule.permits(!left, !right) {
                self.offer(x, y, so_far, step);
            }
            if rule.permits(!left, self.is_blocked_behind(x, y, step + 3)) {
                self.offer(x, y, so_far, step + 2);
            }
            if rule.permits(!right, self.is_blocked_behind(x, y, step + 5)) {
                self.offer(x, y, so_far, step + 6);
            }
        }
    }

    /// Whether a cell beside a diagonal step that was taken is blocked.
    #[inline]
    fn is_blocked_behind(&self, x: u32, y: u32, step: u32) -> bool {
        match self.corner_rule {
            // Not asked for, and not blocked, else the step would not have been legal.
            CornerRule::Allow | CornerRule::ForbidAny => false,
            CornerRule::ForbidBoth => {
                let (x, y) = neighbour(x, y, step);
                // Both coordinates are those of cells on the map.
                self.unknown.blocks(self.cells[self.index(x, y)])
            }
        }
    }

    /// Offers a way of cost `so_far` to `(x, y)` and one more step to the neighbour there. False
    /// when it is blocked or not on the map.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "six per cent of the search, measured")]
    fn offer(&mut self, x: u32, y: u32, so_far: u32, step: u32) -> bool {
        let step = step & 7;
        let (x, y) = neighbour(x, y, step);
        if x >= self.width || y >= self.height {
            return false;
        }
        let index = self.index(x, y);
        let node = &mut self.nodes[index];
        if node.meta >> GENERATION_SHIFT != self.generation {
            let cell = self.cells[index];
            let price = if self.unknown.blocks(cell) {
                BLOCKED
            } else if cell.cost == COST_UNKNOWN {
                0
            } else {
                cell.cost
            };
            *node = Node {
                so_far: u32::MAX,
                meta: self.generation << GENERATION_SHIFT | u32::from(price) << PRICE_SHIFT,
            };
        }
        let price = node.price();
        if price == BLOCKED {
            return false;
        }
        let so_far = so_far + self.steps[step as usize & 1][usize::from(price)];
        // Also refuses closed nodes: with a consistent heuristic theirs is the best way already.
        if so_far >= node.so_far {
            return true;
        }
        if so_far > COST_SO_FAR_MAX {
            self.overflow = true;
            return true;
        }
        node.so_far = so_far;
        node.meta = node.meta & !STEP_MASK | step << STEP_SHIFT;
        let key = so_far + octile(x.abs_diff(self.goal.0), y.abs_diff(self.goal.1));
        self.generated += 1;
        self.open.push(key, pack(x, y));
        true
    }

    #[inline]
    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }
}

/// The neighbour in direction `step`; beyond the lower edges the numbers wrap and are as good as
/// beyond the upper ones.
#[inline]
const fn neighbour(x: u32, y: u32, step: u32) -> (u32, u32) {
    let (dx, dy) = STEPS[(step & 7) as usize];
    (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy))
}

const fn pack(x: u32, y: u32) -> u32 {
    y << 16 | x
}

const fn unpack(item: u32) -> (u32, u32) {
    (item & 0xffff, item >> 16)
}
