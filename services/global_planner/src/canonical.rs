//! Canonical A* on a bit map: A* that looks at a cell once where plain A* looks eight times.
//!
//! Sturtevant, Rabin, "Canonical Orderings on Grids", IJCAI 2016: of all shortest ways between
//! two cells only the one that goes diagonally first is followed; what lies beside an obstacle's
//! end is looked at as well. Which neighbours these are is in a table over the direction of
//! arrival and the eight cells around. Nodes are 8 bytes, never cleared; integer keys in a ring of
//! buckets. Without jumps it is the faster one where jumps would be short.

use crate::bits::Lines;
use crate::bucket_queue::BucketQueue;
use crate::limits::Limits;
use crate::moves::{DIAGONAL, STEPS, STRAIGHT, octile};
use crate::node_pool::NodePool;
use crate::padded::push_cell;
use crate::planner::{CellPath, PlanStats};
use crate::search::{COST_SO_FAR_MAX, Found};

/// Expansions between two looks at the budget.
const BUDGET_EVERY: u64 = 2048;

/// Direction of arrival at the start.
const NO_STEP: u32 = 8;

/// Steps to take, a bit each, by direction of arrival and blocked neighbours in the order of
/// [`STEPS`].
static SUCCESSORS: [[u8; 256]; 9] = successors();

#[allow(clippy::cast_possible_truncation, reason = "numbers below 256")]
const fn successors() -> [[u8; 256]; 9] {
    let mut table = [[0; 256]; 9];
    let mut step = 0;
    while step < 9 {
        let mut blocked = 0;
        while blocked < 256 {
            table[step][blocked] = successors_of(step as u32, blocked as u32);
            blocked += 1;
        }
        step += 1;
    }
    table
}

const fn successors_of(step: u32, blocked: u32) -> u8 {
    let mut wanted = 0_u32;
    if step == NO_STEP {
        wanted = 0xff;
    } else if step % 2 == 1 {
        wanted |= 1 << step | 1 << (step - 1) | 1 << ((step + 1) & 7);
    } else {
        wanted |= 1 << step;
        // Behind to a side is blocked: the side and what lies ahead of it have no other way.
        if blocked >> ((step + 3) & 7) & 1 == 1 {
            wanted |= 1 << ((step + 2) & 7) | 1 << ((step + 1) & 7);
        }
        if blocked >> ((step + 5) & 7) & 1 == 1 {
            wanted |= 1 << ((step + 6) & 7) | 1 << ((step + 7) & 7);
        }
    }
    let mut legal = 0;
    let mut n = 0;
    while n < 8 {
        let corner_free =
            n % 2 == 0 || (blocked >> (n - 1) & 1 == 0 && blocked >> ((n + 1) & 7) & 1 == 0);
        if wanted >> n & 1 == 1 && blocked >> n & 1 == 0 && corner_free {
            legal |= 1 << n;
        }
        n += 1;
    }
    legal
}

/// What the search knows about a cell.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    /// Cost of the best way found so far.
    so_far: u32,
    /// `generation << 5 | direction of arrival << 1 | closed`.
    meta: u32,
}

/// Bits of the generation in [`Node::meta`].
const GENERATION_BITS: u32 = 27;

/// Memory of the search, reused from call to call.
#[derive(Debug, Default)]
pub(crate) struct Canonical {
    pool: NodePool<Node>,
    open: BucketQueue,
    turns: Vec<(u32, u32)>,
}

impl Canonical {
    /// Searches from one padded position to the other; writes the corners of the way.
    pub(crate) fn run(
        &mut self,
        rows: &Lines,
        start: (u32, u32),
        goal: (u32, u32),
        limits: &mut Limits<'_>,
        path: &mut CellPath,
    ) -> Found {
        let n_nodes = (rows.length() + 2) * (rows.count() + 2);
        self.pool.begin(n_nodes, GENERATION_BITS);
        let found = self.search(rows, start, goal, limits, &mut path.stats);
        path.stats.peak_open = path.stats.peak_open.max(self.open.peak() as u64);
        if found == Found::Path {
            self.trace(rows.length() + 2, goal, path);
        }
        found
    }

    pub(crate) fn bytes(&self) -> usize {
        self.pool.bytes() + self.open.bytes()
    }

    fn search(
        &mut self,
        rows: &Lines,
        start: (u32, u32),
        goal: (u32, u32),
        limits: &mut Limits<'_>,
        stats: &mut PlanStats,
    ) -> Found {
        let width = rows.length() + 2;
        let Self { pool, open, .. } = self;
        let generation = pool.generation;
        let nodes = pool.nodes.as_mut_slice();
        let key = octile(start.0.abs_diff(goal.0), start.1.abs_diff(goal.1));
        open.reset(key, 2 * DIAGONAL);
        nodes[start.1 as usize * width + start.0 as usize] = Node {
            so_far: 0,
            meta: generation << 5 | NO_STEP << 1,
        };
        open.push(key, start.1 << 16 | start.0);
        stats.generated += 1;
        let mut overflow = false;
        while let Some(item) = open.pop() {
            let (x, y) = (item & 0xffff, item >> 16);
            let node = &mut nodes[y as usize * width + x as usize];
            if node.meta & 1 != 0 {
                continue;
            }
            node.meta |= 1;
            let Node { so_far, meta } = *node;
            stats.expanded += 1;
            if (x, y) == goal {
                return Found::Path;
            }
            if let Some(found) = limits.ended::<BUDGET_EVERY>(stats.expanded) {
                return found;
            }
            let around = around(rows, x as usize, y as usize);
            let mut steps = u32::from(SUCCESSORS[(meta >> 1 & 0xf) as usize][around]);
            while steps != 0 {
                let step = steps.trailing_zeros();
                steps &= steps - 1;
                stats.evaluated += 1;
                let (dx, dy) = STEPS[step as usize];
                let (x, y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
                let so_far = so_far + if step & 1 == 0 { STRAIGHT } else { DIAGONAL };
                let node = &mut nodes[y as usize * width + x as usize];
                if node.meta >> 5 == generation && so_far >= node.so_far {
                    continue;
                }
                if so_far > COST_SO_FAR_MAX {
                    overflow = true;
                    continue;
                }
                *node = Node {
                    so_far,
                    meta: generation << 5 | step << 1,
                };
                stats.generated += 1;
                let key = so_far + octile(x.abs_diff(goal.0), y.abs_diff(goal.1));
                open.push(key, y << 16 | x);
            }
        }
        if overflow {
            Found::Stopped
        } else {
            Found::Nothing
        }
    }

    /// Appends the corners of the way.
    fn trace(&mut self, width: usize, goal: (u32, u32), path: &mut CellPath) {
        self.turns.clear();
        let (mut x, mut y) = goal;
        let mut last = NO_STEP;
        for _ in 0..self.pool.nodes.len() {
            let step = self.pool.nodes[y as usize * width + x as usize].meta >> 1 & 0xf;
            if step != last {
                self.turns.push((x, y));
                last = step;
            }
            let Some((dx, dy)) = STEPS.get(step as usize) else {
                break;
            };
            x = x.wrapping_add_signed(-dx);
            y = y.wrapping_add_signed(-dy);
        }
        self.turns.push((x, y));
        for at in self.turns.iter().rev() {
            push_cell(&mut path.cells, *at);
        }
    }
}

/// The blocked neighbours of a cell in the order of [`STEPS`].
#[inline]
fn around(rows: &Lines, x: usize, y: usize) -> usize {
    let (below, here, above) = (rows.three(y - 1, x), rows.three(y, x), rows.three(y + 1, x));
    // `above` is in the order north-west, north, north-east: turned round.
    let above = above >> 2 & 1 | above & 2 | above << 2 & 4;
    (here >> 2 | above << 1 | (here & 1) << 4 | below << 5) as usize
}
