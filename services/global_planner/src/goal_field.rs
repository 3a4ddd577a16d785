//! What is left to the goal from every cell, kept from search to search as the heuristic of A*.
//!
//! Hernandez, Asin, Baier, "Reusing Previously Found A* Paths for Fast Goal-Directed Navigation in
//! Dynamic Terrain" (MPGAA*), AAAI 2015, and Sun, Koenig, Yeoh, "Generalized Adaptive A*", AAMAS
//! 2008, of which come: raising the heuristic of expanded cells to what the search proved, and
//! making it consistent again where costs fell. What is added: the heuristic begins as the exact
//! cost to the goal of the cells, found by one search from the goal while no answer is due.
//!
//! While costs only rise the field stays a consistent lower bound, so a search expands the cells
//! whose best way led through what changed, and the new way. It is made exact again when no answer
//! is due.
//!
//! Where costs fell since the field was made consistent, a search does not wait for the repair.
//! Let a box hold every step that became cheaper, and `least` be the smallest bound on the ring of
//! cells around it. A way that avoids the box costs what the field says; one that enters it has
//! to come there and to leave it for the last time, so it costs at least the octile distance to
//! the box plus `least`. The smaller of the two is a consistent bound again.
//!
//! The field ends some way behind the robot ([`MARGIN`]): it costs what the way takes, not what the
//! map does. From a cell beyond its reach at least the reach is left.
//!
//! No bound is ever below the octile distance to the goal. A search therefore closes no cell that
//! a search from scratch would not, ties left aside, whatever happened to the map.

mod around;
mod bounds;
mod change;
pub(crate) mod detours;
mod eased_box;
mod node;
mod open_list;
mod prices;
mod raise;
mod raise_state;
mod run;
mod upkeep;

use bounds::Bounds;
use eased_box::EasedBox;
use node::{GENERATION_MAX, NO_WAY, Node, STEP_MASK, STEP_SHIFT, Spot};
use open_list::HeapQueue;
use prices::Prices;
use raise_state::Raise;
use run::{FIELD, FIELD_AND_BOX, OCTILE, Run, WEIGHTED, Within};
use zeronav_casts::Cast;

use crate::bucket_queue::BucketQueue;
use crate::moves::{DIAGONAL, STEPS, STRAIGHT, price};
use crate::planner::{Control, CornerRule, Expansions, PlanStats, Unknown};
use crate::search::Found;
use core::cmp::Reverse;
use std::collections::BinaryHeap;
use zeronav_msgs::{Cell, GridGeometry, MapView, Pose};

/// The field covers every cell from which at most half as much again is left as from the robot, and
/// at least this much more, which is 25.6 m of free cells of 5 cm. What lies farther off costs memory
/// and time that follow the size of the map, and no way round of that length is expected.
const MARGIN: u32 = 512 * STRAIGHT;

/// How far the field is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// There is none.
    Missing,
    /// The bounds of the one before are forgotten.
    Clearing,
    /// The search from the goal is under way.
    Growing,
    /// Every cell within reach has its bound.
    Whole,
    /// Ways are longer than the numbers reach.
    Beyond,
}

/// What guides a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Guide {
    /// The octile distance.
    Octile,
    /// The field, see [`GoalField::is_whole_for`].
    Field,
    /// So many quarters of the octile distance, at least four: the way costs at most as many
    /// quarters of the least. Only ways cheaper than `below` count.
    Weighted {
        /// Weight times four.
        quarters: u32,
        /// In the integer costs of the search.
        below: u32,
    },
}

/// What an update of the map did to the prices.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Changed {
    /// At least one is another.
    pub(crate) any: bool,
    /// At least one is lower.
    pub(crate) cost_decreased: bool,
}

/// What a search keeps beside the nodes.
#[derive(Debug, Default)]
struct Lists {
    open: BucketQueue,
    /// Cells that the search closed, in order, until the field has learnt from it.
    closed: Vec<Spot>,
}

/// See the module's description.
#[derive(Debug)]
pub(crate) struct GoalField {
    geometry: GridGeometry,
    unknown: Unknown,
    rule: CornerRule,
    told: bool,
    built: bool,
    /// How often it was begun from nothing: spots of another life mean other cells.
    life: u64,
    width: u32,
    prices: Prices,
    left: Bounds,
    nodes: Vec<Node>,
    generation: u32,
    lists: Lists,
    /// Open list of the search around a cut.
    open_around: HeapQueue,
    /// Open list of the search from the goal, which goes on between other searches.
    front: BucketQueue,
    steps: [[u32; 256]; 2],
    span: u32,
    /// Differences of spots in the order of [`STEPS`].
    offsets: [u32; 8],
    goal: Spot,
    /// Where the last search began.
    from: Spot,
    state: State,
    /// Larger bounds are not known: from such a cell at least this is left. [`NO_WAY`] when the field
    /// covers all that is connected to the goal.
    reach: u32,
    /// How far beyond the robot the field grows, see [`MARGIN`].
    margin: u32,
    /// Cells that became cheaper since the field was made consistent.
    cost_decreased: Vec<Spot>,
    /// The box of these cells: padded x and y, first and last.
    eased_box: EasedBox,
    lowered: BinaryHeap<Reverse<u64>>,
    raise: Raise,
    /// Cost of the way that it found, [`NO_WAY`] when there was none.
    proved: u32,
    /// The box that bounded it, if any.
    closed_box: Option<EasedBox>,
}

impl GoalField {
    pub(crate) fn new(cost_weight: f64) -> Self {
        let mut steps = [[0; 256]; 2];
        for (cost, (straight, diagonal)) in (0..=u8::MAX).map(|cost| (cost, (STRAIGHT, DIAGONAL))) {
            let price = price(cost, cost_weight);
            steps[0][usize::from(cost)] = rounded(straight, price);
            steps[1][usize::from(cost)] = rounded(diagonal, price);
        }
        let largest = steps[1].iter().max().copied().unwrap_or(DIAGONAL);
        Self {
            geometry: GridGeometry::default(),
            unknown: Unknown::default(),
            rule: CornerRule::default(),
            told: false,
            built: false,
            life: 0,
            width: 0,
            prices: Prices::default(),
            left: Bounds::default(),
            nodes: Vec::new(),
            generation: 0,
            lists: Lists::default(),
            open_around: HeapQueue::default(),
            front: BucketQueue::default(),
            steps,
            // A key exceeds that of the node it came from by the step there and back.
            span: 2 * largest,
            offsets: [0; 8],
            goal: 0,
            from: 0,
            state: State::Missing,
            reach: NO_WAY,
            margin: MARGIN,
            cost_decreased: Vec::new(),
            eased_box: EasedBox::EMPTY,
            lowered: BinaryHeap::new(),
            raise: Raise::default(),
            proved: 0,
            closed_box: None,
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        self.prices.bytes()
            + self.left.bytes()
            + self.nodes.capacity() * size_of::<Node>()
            + self.lists.open.bytes()
            + self.open_around.bytes()
            + self.front.bytes()
            + (self.cost_decreased.capacity() + self.lists.closed.capacity()) * size_of::<Spot>()
            + self.lowered.capacity() * size_of::<Reverse<u64>>()
            + self.raise.bytes()
    }

    /// Makes the prices those of the map.
    pub(crate) fn follow(&mut self, map: &MapView<'_>, unknown: Unknown, rule: CornerRule) {
        if rule != self.rule {
            self.rule = rule;
            self.life += 1;
            self.state = State::Missing;
        }
        let fits = self.built && *map.geometry == self.geometry && unknown == self.unknown;
        if fits && self.told {
            return;
        }
        self.built = true;
        self.life += 1;
        self.geometry = *map.geometry;
        self.unknown = unknown;
        self.state = State::Missing;
        self.forget_eased();
        self.lists.closed.clear();
        (self.from, self.generation) = (0, 0);
        let (width, height) = (map.geometry.width + 2, map.geometry.height + 2);
        self.width = width;
        self.offsets = STEPS.map(|(dx, dy)| {
            dx.cast_unsigned()
                .wrapping_add(dy.cast_unsigned().wrapping_mul(width))
        });
        let n_nodes = width as usize * height as usize;
        self.prices.reset(map, unknown, width, n_nodes);
        // The old ones go first: both need not fit.
        (self.left, self.nodes) = Default::default();
        self.left = Bounds::new(n_nodes);
        self.nodes = bytemuck::allocation::zeroed_vec(n_nodes);
        self.raise = Raise::new(n_nodes);
    }

    /// True when every bound is the very cost.
    fn is_exact(&self) -> bool {
        self.state == State::Whole
            && self.eased_box.is_empty()
            && self.raise.is_idle()
            && self.lists.closed.is_empty()
    }

    fn forget_eased(&mut self) {
        self.cost_decreased.clear();
        self.lowered.clear();
        self.eased_box = EasedBox::EMPTY;
    }

    /// True when the field of this goal can guide a search.
    pub(crate) fn is_whole_for(&self, goal: Cell) -> bool {
        self.state == State::Whole && self.goal == self.spot(goal)
    }

    /// The box of all steps that became cheaper, with what the ways through it cost at least.
    fn whole_box(&self) -> EasedBox {
        let EasedBox { min, max, .. } = self.eased_box;
        let last = (self.geometry.width, self.geometry.height);
        // A cell that opened also frees the diagonal steps past it.
        let mut grown = EasedBox {
            min: (min.0.max(2) - 1, min.1.max(2) - 1),
            max: ((max.0 + 1).min(last.0), (max.1 + 1).min(last.1)),
            least: NO_WAY,
        };
        let goal = (self.goal % self.width, self.goal / self.width);
        if (grown.min.0..=grown.max.0).contains(&goal.0)
            && (grown.min.1..=grown.max.1).contains(&goal.1)
        {
            grown.least = 0;
            return grown;
        }
        let mut least = NO_WAY;
        let mut see = |x: u32, y: u32| {
            least = least.min(self.left.at(y * self.width + x).min(self.reach));
        };
        for x in grown.min.0 - 1..=grown.max.0 + 1 {
            see(x, grown.min.1 - 1);
            see(x, grown.max.1 + 1);
        }
        for y in grown.min.1..=grown.max.1 {
            see(grown.min.0 - 1, y);
            see(grown.max.0 + 1, y);
        }
        grown.least = least;
        grown
    }

    /// Searches from `start` to `goal`, both free, adding to the counters of `stats`; stops after
    /// `most` expansions.
    pub(crate) fn search(
        &mut self,
        (start, goal): (Cell, Cell),
        guide: Guide,
        most: u64,
        budget: &mut dyn FnMut(Expansions) -> Control,
        stats: &mut PlanStats,
    ) -> Found {
        self.learn();
        self.next_generation();
        let ends = (self.spot(start), self.spot(goal));
        self.from = ends.0;
        let eased_box = if guide == Guide::Field && !self.eased_box.is_empty() {
            Some(self.whole_box())
        } else {
            None
        };
        let span = self.span;
        let mut lists = core::mem::take(&mut self.lists);
        let mut run = self.run(&mut lists.open, &mut lists.closed, ends.1);
        run.eased_box = eased_box.unwrap_or(EasedBox::EMPTY);
        run.last = stats.expanded.saturating_add(most);
        let found = match (guide, eased_box) {
            (Guide::Octile, _) => run.search::<OCTILE>(ends.0, span, budget, stats),
            (Guide::Field, None) => run.search::<FIELD>(ends.0, span, budget, stats),
            (Guide::Field, Some(_)) => run.search::<FIELD_AND_BOX>(ends.0, span, budget, stats),
            (Guide::Weighted { quarters, below }, _) => {
                (run.quarters, run.below) = (quarters, below);
                let span = span + DIAGONAL * quarters;
                run.search::<WEIGHTED>(ends.0, span, budget, stats)
            }
        };
        stats.generated += run.generated;
        stats.peak_open = stats.peak_open.max(lists.open.peak() as u64);
        self.lists = lists;
        self.closed_box = eased_box;
        self.proved = match found {
            Found::Path => self.nodes[ends.1 as usize].so_far,
            Found::Nothing => NO_WAY,
            Found::Stopped => {
                self.lists.closed.clear();
                0
            }
        };
        if self.state != State::Whole || self.goal != ends.1 {
            self.lists.closed.clear();
        }
        found
    }

    fn next_generation(&mut self) {
        if self.generation == GENERATION_MAX {
            for node in &mut self.nodes {
                node.meta = 0;
            }
            self.generation = 0;
        }
        self.generation += 1;
    }

    /// A search of this generation that ends at `goal`.
    fn run<'a, Q>(
        &'a mut self,
        open: &'a mut Q,
        closed: &'a mut Vec<Spot>,
        goal: Spot,
    ) -> Run<'a, Q> {
        let goal_xy = (goal % self.width, goal / self.width);
        Run {
            left: Within {
                bounds: &self.left,
                reach: self.reach,
                beyond: self.reach,
                width: self.width,
                goal_xy,
            },
            nodes: &mut self.nodes,
            prices: &self.prices,
            open,
            closed,
            steps: &self.steps,
            offsets: self.offsets,
            rule: self.rule,
            width: self.width,
            generation: self.generation,
            goal,
            goal_xy,
            eased_box: EasedBox::EMPTY,
            span: self.span,
            quarters: 4,
            below: NO_WAY,
            last: u64::MAX,
            generated: 0,
            overflow: false,
        }
    }

    /// Integer cost of the way that the last search found.
    pub(crate) fn cost_of(&self, goal: Cell) -> u32 {
        self.nodes[self.spot(goal) as usize].so_far
    }

    /// Appends the way that was found, both ends included.
    pub(crate) fn trace(&self, goal: Cell, cells: &mut Vec<Cell>) {
        let first = cells.len();
        let mut cell = goal;
        for _ in 0..self.nodes.len() {
            cells.push(cell);
            let node = self.nodes[self.spot(cell) as usize];
            let step = (node.meta & STEP_MASK) >> STEP_SHIFT;
            let Some((dx, dy)) = STEPS.get(step as usize) else {
                break;
            };
            cell = Cell::new(cell.x - dx, cell.y - dy);
        }
        cells[first..].reverse();
    }

    /// Which diagonal steps are legal.
    pub(crate) const fn rule(&self) -> CornerRule {
        self.rule
    }

    /// The cell of a pose of the robot, `map_from_base`.
    pub(crate) fn cell_at(&self, robot: &Pose) -> Option<Cell> {
        self.geometry.cell_at(robot.point())
    }

    const fn cell(&self, spot: Spot) -> Cell {
        Cell::new(
            (spot % self.width).cast_signed() - 1,
            (spot / self.width).cast_signed() - 1,
        )
    }

    const fn spot(&self, cell: Cell) -> Spot {
        (cell.y.cast_unsigned() + 1) * self.width + cell.x.cast_unsigned() + 1
    }
}

fn rounded(step: u32, price: f64) -> u32 {
    (f64::from(step) * price).round().to_u32()
}
