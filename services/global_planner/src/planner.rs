//! What every global planner is: a question, an answer, a budget, and the ways to fail.

use crate::remarks::Remarks;
use nalgebra::Point2;
use zeronav_msgs::map::{COST_LETHAL, COST_UNKNOWN};
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::{Cell, CellRect, MapCell, MapView, Pose};
use zeronav_params::choices;

/// A search over the map. Every row of [`crate::table::PLANNERS`] is one.
pub trait GlobalPlanner: Send {
    /// Finds a path for `query` and writes it, with the counters of the search, to `path`.
    ///
    /// Deterministic: the same sequence of calls gives the same paths. No clock, no I/O, no
    /// threads. `budget` is asked every few thousand expansions.
    ///
    /// # Errors
    /// See [`PlanError`]. `path.cells` is then empty, `path.stats` says how far the search went.
    fn plan(
        &mut self,
        query: &PlanQuery<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
        path: &mut CellPath,
    ) -> Result<PlanStats, PlanError>;

    /// These cells changed since the last call (incremental planners; default: nothing).
    ///
    /// Who has called it once calls it for every change from then on, before the next
    /// [`Self::plan`]. Before the first call nothing is believed to last from plan to plan.
    fn map_changed(&mut self, _map: &MapView<'_>, _changed: &[CellRect]) {}

    /// Work that makes the next answer faster, done while none is due: a slice of about
    /// `expansions` expansions; `robot` is `map_from_base`. True when more is left. The default has
    /// none.
    fn prepare(&mut self, _robot: &Pose, _expansions: u64) -> bool {
        false
    }

    /// A legal path that [`Self::prepare`] made ready, or that a search of bounded effort finds; it need
    /// not be the best, [`PlanStats::bound`] says what no path costs less than. Without one the counters
    /// in `path` are those of what was tried. The default has none.
    fn detour(
        &mut self,
        _query: &PlanQuery<'_>,
        _budget: &mut dyn FnMut(Expansions) -> Control,
        _path: &mut CellPath,
    ) -> Option<PlanStats> {
        None
    }
}

/// Where from, where to, and what counts as free.
#[derive(Debug, Clone, Copy)]
pub struct PlanQuery<'a> {
    /// The map.
    pub map: MapView<'a>,
    /// `map_from_base` of the robot.
    pub start: Pose,
    /// `map_from_base` to reach.
    pub goal: Pose,
    /// [m] around `goal` in which another cell may take its place when its own is blocked, >= 0.
    pub tolerance_m: f64,
    /// Whether unknown cells may be crossed.
    pub unknown: Unknown,
    /// Which diagonal steps are legal. Planners of the papers whose rule is a part of the method keep
    /// to their own.
    pub corner_rule: CornerRule,
}

choices! {
    /// Policy for cells about which nothing is known.
    pub enum Unknown {
        /// They may be crossed, at the price of free cells.
        #[default]
        Free = "free",
        /// They block like obstacles.
        Lethal = "lethal",
    }
}

/// In place of a cost: the robot's centre must not be in the cell.
pub(crate) const BLOCKED: u8 = u8::MAX;

impl Unknown {
    /// True when the robot's centre must not be in `cell`.
    #[must_use]
    pub const fn blocks(self, cell: MapCell) -> bool {
        cell.blocks_centre() || (matches!(self, Self::Lethal) && cell.cost == COST_UNKNOWN)
    }

    /// True when not even a robot that is already too close to an obstacle may enter `cell`.
    #[must_use]
    pub const fn is_lethal(self, cell: MapCell) -> bool {
        cell.cost == COST_LETHAL || (matches!(self, Self::Lethal) && cell.cost == COST_UNKNOWN)
    }

    /// What it costs to enter `cell`: [`BLOCKED`], or the map's cost, which of an unknown cell is 0.
    #[inline]
    pub(crate) const fn cost(self, cell: MapCell) -> u8 {
        if self.blocks(cell) {
            BLOCKED
        } else if cell.cost == COST_UNKNOWN {
            0
        } else {
            cell.cost
        }
    }
}

choices! {
    /// When a diagonal step is legal, given the two cells that share an edge with both its ends.
    pub enum CornerRule {
        /// Always: the path may pass between two obstacles that touch at a corner.
        Allow = "allow",
        /// When neither of the two is blocked. Reachability is then that of 4-connected grids.
        #[default]
        ForbidAny = "forbid_any",
        /// When not both are blocked.
        ForbidBoth = "forbid_both",
    }
}

impl CornerRule {
    /// True when a diagonal step past two cells with these states is legal.
    #[must_use]
    pub const fn permits(self, one_blocked: bool, other_blocked: bool) -> bool {
        match self {
            Self::Allow => true,
            Self::ForbidAny => !one_blocked && !other_blocked,
            Self::ForbidBoth => !(one_blocked && other_blocked),
        }
    }
}

/// A path over the map, reused from call to call.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CellPath {
    /// The way from the robot's own cell to the goal's. It is straight between the centres of two
    /// entries that follow each other; they need not be neighbours.
    pub cells: Vec<Cell>,
    /// [m] `map` frame: the curve that rounds the path, straight between two points, from its
    /// first cell to its last; empty when the path is not rounded. It stays in the surroundings of
    /// the cells, which are what is held against later maps.
    pub curve: Vec<Point2<f64>>,
    /// Counters of the search that wrote the path, also when it failed.
    pub stats: PlanStats,
}

impl CellPath {
    /// Forgets path and counters, keeps the memory.
    pub fn clear(&mut self) {
        self.cells.clear();
        self.curve.clear();
        self.stats = PlanStats::default();
    }

    /// Length between the centres. [cells]
    #[must_use]
    pub fn length_cells(&self) -> f64 {
        self.cells
            .windows(2)
            .map(|pair| f64::from(pair[1].x - pair[0].x).hypot(f64::from(pair[1].y - pair[0].y)))
            .sum()
    }
}

/// What a search did. Counts and costs, never times.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlanStats {
    /// Nodes taken from the open list and closed.
    pub expanded: u64,
    /// Nodes put into the open list, repeats counted.
    pub generated: u64,
    /// Neighbours looked at, repeats counted.
    pub evaluated: u64,
    /// Longest open list.
    pub peak_open: u64,
    /// Cost of the path in the planner's own measure, >= its length [m]; 0 without a path.
    pub cost: f64,
    /// No path costs less, in the same measure; `cost` where the planner proves its path the best,
    /// else 0 unless it knows better.
    pub bound: f64,
    /// What else is to be said about the path.
    pub remarks: Remarks,
    /// Paths that an anytime planner had on the way, dearer ones first; the rest is 0.
    pub improved: [Improvement; IMPROVEMENTS_MAX],
}

impl PlanStats {
    /// Adds what was tried before.
    pub(crate) const fn add_effort(&mut self, tried: &Self) {
        self.expanded += tried.expanded;
        self.generated += tried.generated;
        self.evaluated += tried.evaluated;
    }
}

/// Most entries of [`PlanStats::improved`].
pub(crate) const IMPROVEMENTS_MAX: usize = 4;

/// A path that was found while the search went on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Improvement {
    /// Expansions until then.
    pub expanded: u64,
    /// Its cost, as [`PlanStats::cost`].
    pub cost: f64,
}

/// Expansions of the running search so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Expansions(pub u64);

/// Whether a search may go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// Go on.
    Go,
    /// Give up: the search ends with [`PlanError::OutOfBudget`].
    Stop,
}

/// Why there is no path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
pub enum PlanError {
    /// The robot is not on the map.
    #[error("the robot is not on the map")]
    StartOutsideMap,
    /// The robot is in an obstacle, or too close to one with no free cell near.
    #[error("the robot is in an obstacle and no free cell is near")]
    StartBlocked,
    /// The goal is not on the map.
    #[error("the goal is not on the map")]
    GoalOutsideMap,
    /// No free cell within the tolerance of the goal.
    #[error("no free cell within the tolerance of the goal")]
    GoalBlocked,
    /// Proved: no legal way leads to the goal, among what the planner takes for obstacles.
    #[error("no way leads to the goal{}", if *blocked_by_corner { " without cutting a corner" } else { "" })]
    Unreachable {
        /// A way exists that differs only in cutting corners.
        blocked_by_corner: bool,
    },
    /// An incomplete planner gave up.
    #[error("the planner found no way, though there may be one")]
    DeadEnd,
    /// The budget ended before the search did.
    #[error("the budget ended before the search did")]
    OutOfBudget,
}

impl PlanError {
    /// The code that tells it to other processes.
    #[must_use]
    pub const fn status(self) -> PathStatus {
        match self {
            Self::StartOutsideMap => PathStatus::StartOutsideMap,
            Self::StartBlocked => PathStatus::StartBlocked,
            Self::GoalOutsideMap => PathStatus::GoalOutsideMap,
            Self::GoalBlocked => PathStatus::GoalBlocked,
            Self::Unreachable {
                blocked_by_corner: false,
            } => PathStatus::Unreachable,
            Self::Unreachable {
                blocked_by_corner: true,
            } => PathStatus::UnreachableCorner,
            Self::DeadEnd => PathStatus::DeadEnd,
            Self::OutOfBudget => PathStatus::OutOfBudget,
        }
    }
}
