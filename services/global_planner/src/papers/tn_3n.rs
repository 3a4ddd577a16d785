//! `tn_3n`: \[TN\]'s walk that looks at three cells a step.
//!
//! The paper turns the pose vector when the three cells "are all obstacle grids or grids that have been
//! searched", and does not say what becomes of a walk that has nothing left. Three readings
//! ([`Memory`]): without a memory it may turn in circles; as the text says it enters no cell twice and ends
//! in a pocket; going back there makes it a depth-first search, complete, but far from the shortest way,
//! which is the default. Literal mode is the text.

use crate::moves::Neighbours;
use crate::papers::field::{Field, LENGTHS, Look, Marks, Meter, distance};
use crate::papers::on_map::{NO_WAY, Solver};
use crate::planner::{PlanError, PlanStats};
use zeronav_casts::Cast;
use zeronav_msgs::Cell;
use zeronav_msgs::map::FLAG_REGULARISED;
use zeronav_params::{choices, parameters};

/// The planner's method.
#[must_use]
pub(crate) fn tn_3n(options: WalkOptions, literal: bool) -> Tn3n {
    Tn3n {
        memory: Memory::read(&options, literal),
        options,
        literal,
        walk: Walk::default(),
    }
}

/// Largest [`WalkOptions::switch_margin_cells`].
pub(crate) const SWITCH_MARGIN_MAX: u32 = 16;

parameters! {
    /// `tn_3n`, `tn_hyb`: the walk of three neighbours and what is around it.
    #[derive(Copy)]
    pub struct WalkOptions {
        /// What the walk knows of the cells that it has entered.
        memory: Memory = Memory::default();
        /// To which side the pose vector turns when the three cells are blocked.
        rotate: Rotate = Rotate::default();
        /// Keeps a turned vector until the direction of the target is free.
        keep_heading: bool = false;
        /// Chebyshev distance of an obstacle within which the walk takes over.
        switch_margin_cells: u32 = 1, [1, SWITCH_MARGIN_MAX] "cells";
        /// Which cells belong to one obstacle.
        components: Neighbours = Neighbours::default();
        /// Part of the map that a rectangle may cover.
        rectangle_share_max: f64 = 0.25, [0.0, 1.0];
        /// Whether other methods step in when the walk fails.
        ladder: bool = true;
        /// Whether the path is pulled taut afterwards.
        pull: bool = false;
    }
}

choices! {
    /// Readings of "grids that have been searched".
    pub enum Memory {
        /// Nothing: cells are entered as often as one likes, and the walk may go in circles.
        None = "none",
        /// It enters no cell twice, as the text says, and gives up in a pocket.
        Visited = "visited",
        /// It goes back from a pocket as well, which makes it complete.
        #[default]
        Backtracking = "backtracking",
    }
}

impl Memory {
    /// The reading of a walk: in literal mode at most that of the text.
    pub(crate) fn read(options: &WalkOptions, literal: bool) -> Self {
        match options.memory {
            Self::Backtracking if literal => Self::Visited,
            memory => memory,
        }
    }

    /// True when no cell is entered twice.
    pub(crate) fn remembers(self) -> bool {
        self != Self::None
    }

    /// True when the walk goes back where nothing is left.
    pub(crate) fn goes_back(self) -> bool {
        self == Self::Backtracking
    }
}

choices! {
    /// To which side the walk turns.
    pub enum Rotate {
        /// Counter-clockwise, as printed.
        #[default]
        Ccw = "ccw",
        /// Clockwise.
        Cw = "cw",
        /// To the side whose best cell is cheaper; counter-clockwise of two equal ones.
        Shorter = "shorter",
    }
}

/// See the module's description.
#[derive(Debug)]
pub(crate) struct Tn3n {
    options: WalkOptions,
    memory: Memory,
    literal: bool,
    walk: Walk,
}

/// The way walked so far.
#[derive(Debug, Default)]
pub(crate) struct Walk {
    visited: Marks,
    /// From the start to where the walk is.
    pub cells: Vec<Cell>,
    /// Direction of a turned pose vector that is kept.
    heading: Option<usize>,
}

/// How a walk goes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WalkRule {
    /// To which side it turns.
    pub rotate: Rotate,
    /// See [`WalkOptions::keep_heading`].
    pub keep_heading: bool,
    /// See [`WalkOptions::memory`].
    pub memory: Memory,
}

impl Walk {
    /// Stands at `start`.
    pub(crate) fn begin(&mut self, n_cells: usize, start: Cell, start_index: usize) {
        self.visited.begin(n_cells);
        self.visited.insert(start_index);
        self.cells.clear();
        self.cells.push(start);
        self.heading = None;
    }

    /// True for cells that the walk has entered.
    #[must_use]
    pub(crate) fn has_visited(&self, index: usize) -> bool {
        self.visited.has(index)
    }

    /// Goes to `cell`.
    pub(crate) fn enter(&mut self, field: &Field<'_>, cell: Cell) {
        self.visited.insert(field.index(cell));
        self.cells.push(cell);
    }

    /// Goes back one entry; false at the start.
    pub(crate) fn turn_back(&mut self) -> bool {
        self.heading = None;
        self.cells.pop();
        !self.cells.is_empty()
    }

    /// Chooses among three cells ahead of the pose vector towards `target`, turning it by 90
    /// degrees until one is free: where the walk goes next, `None` when nothing is left.
    pub(crate) fn step(
        &mut self,
        field: &Field<'_>,
        target: Cell,
        gait: WalkRule,
        stats: &mut PlanStats,
    ) -> Option<Cell> {
        let at = *self.cells.last()?;
        let towards = direction(at, target);
        let visited = &self.visited;
        let open = |n: usize| match field.look(at, n) {
            Look::Free(to) if !gait.memory.remembers() || !visited.has(field.index(to)) => Some(to),
            _ => None,
        };
        if gait.keep_heading && open(towards).is_some() {
            self.heading = None;
        }
        let ahead = self.heading.unwrap_or(towards);
        let mut best_of = |ahead: usize| {
            let mut best: Option<(f64, usize, Cell)> = None;
            // Ahead, 45 degrees to the left, 45 degrees to the right: the order decides ties.
            for n in [ahead, ahead + 1, ahead + 7] {
                stats.evaluated += 1;
                if let Some(to) = open(n) {
                    let f = LENGTHS[n % 8] * field.price(to) + distance(to, target);
                    if best.is_none_or(|(least, ..)| f < least - 1e-12) {
                        best = Some((f, n % 8, to));
                    }
                }
            }
            best
        };
        for turn in 0..4 {
            // In units of 45 degrees.
            let (ccw, cw) = (ahead + 2 * turn, ahead + 8 - 2 * turn);
            let best = match gait.rotate {
                Rotate::Ccw => best_of(ccw),
                Rotate::Cw => best_of(cw),
                Rotate::Shorter if turn == 0 => best_of(ahead),
                Rotate::Shorter => match (best_of(ccw), best_of(cw)) {
                    (Some(left), Some(right)) if right.0 < left.0 - 1e-12 => Some(right),
                    (left, right) => left.or(right),
                },
            };
            if let Some((_, n, to)) = best {
                if gait.keep_heading && turn > 0 {
                    self.heading = Some(n);
                }
                return Some(to);
            }
        }
        None
    }
}

/// The step of [`crate::moves::STEPS`] nearest to the direction from `from` to `to`.
fn direction(from: Cell, to: Cell) -> usize {
    let angle = f64::from(to.y - from.y).atan2(f64::from(to.x - from.x));
    // A whole vector is never half-way between two of the eight, tan 22.5 deg being irrational.
    (angle / core::f64::consts::FRAC_PI_4)
        .round()
        .rem_euclid(8.0)
        .to_usize()
        % 8
}

impl Solver for Tn3n {
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        let gait = WalkRule {
            rotate: self.options.rotate,
            keep_heading: self.options.keep_heading,
            memory: self.memory,
        };
        self.walk.begin(field.n_cells(), start, field.index(start));
        meter.expand()?;
        let mut at = start;
        // A walk with a memory enters every cell at most once; one without may go in circles.
        let mut steps_left = 4 * field.n_cells();
        while at != goal {
            match self.walk.step(field, goal, gait, meter.stats) {
                Some(to) if steps_left > 0 => {
                    steps_left -= 1;
                    meter.expand()?;
                    self.walk.enter(field, to);
                    at = to;
                }
                None if gait.memory.goes_back() => {
                    if !self.walk.turn_back() {
                        return Err(NO_WAY);
                    }
                    meter.turn_back()?;
                    at = self.walk.cells.last().copied().unwrap_or(start);
                }
                _ => return Err(PlanError::DeadEnd),
            }
        }
        cells.extend_from_slice(&self.walk.cells);
        Ok(())
    }

    fn is_literal(&self) -> bool {
        self.literal
    }

    fn layers(&self) -> u8 {
        FLAG_REGULARISED
    }
}
