//! `tn_hyb`: \[TN\]'s hybrid. Straight to the target where nothing is in the way, a walk of three
//! cells a step around what is.
//!
//! Other methods step in when it fails (`options.papers.walk.ladder`): the walk on the other side
//! of obstacles, the walk without rectangles, A* from where the last walk gave up, A* from the
//! start. The last finds a way whenever there is one. [`crate::remarks::Remarks::fallback`] says
//! which it was.

use crate::line::supercover;
use crate::papers::best_first::{BestFirst, Recipe};
use crate::papers::field::{Field, Meter};
use crate::papers::heuristic::Heuristic;
use crate::papers::on_map::{NO_WAY, Solver};
use crate::papers::regularise::Regions;
use crate::papers::sight::{pull, sees};
use crate::papers::tn_3n::{Memory, Rotate, Walk, WalkOptions, WalkRule};
use crate::planner::PlanError;
use crate::remarks::Fallback;
use zeronav_msgs::Cell;
use zeronav_msgs::map::FLAG_REGULARISED;

/// The planner's method.
#[must_use]
pub(crate) fn tn_hyb(options: WalkOptions, literal: bool) -> TnHyb {
    TnHyb {
        memory: Memory::read(&options, literal),
        options,
        literal,
        regions: Regions::default(),
        walk: Walk::default(),
        modes: Vec::new(),
        line: Vec::new(),
        astar: BestFirst::default(),
    }
}

/// See the module's description.
#[derive(Debug)]
pub(crate) struct TnHyb {
    options: WalkOptions,
    /// What the walk knows of the cells that it has entered.
    memory: Memory,
    /// The walk is that of the text.
    literal: bool,
    regions: Regions,
    walk: Walk,
    /// Of every entry of the walk but the first.
    modes: Vec<Mode>,
    line: Vec<Cell>,
    astar: BestFirst,
}

/// By what a piece of the path was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Attraction: straight to the target.
    Attraction,
    /// Three-neighbour walk.
    ThreeNeighbours,
}

/// How a walk ended that did not reach the goal.
enum Failure {
    /// Every cell that it could enter was entered. The proof holds for the walk's own map.
    Exhausted,
    /// Where a walk that does not go back is.
    Stuck,
    Budget(PlanError),
}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Self {
        Self::Budget(error)
    }
}

impl TnHyb {
    /// By what each piece of the last path was made; those of A* are not in it, and pulling a path
    /// taut does not change it.
    #[must_use]
    #[cfg(test)]
    pub(crate) fn modes(&self) -> &[Mode] {
        &self.modes
    }

    /// The rectangles of the last walk.
    #[must_use]
    #[cfg(test)]
    pub(crate) fn regions(&self) -> &Regions {
        &self.regions
    }

    /// One walk from `start`.
    fn hybrid(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        (rotate, fills): (Rotate, bool),
        meter: &mut Meter<'_>,
    ) -> Result<(), Failure> {
        let gait = WalkRule {
            rotate,
            keep_heading: self.options.keep_heading,
            memory: self.memory,
        };
        let options = WalkOptions {
            rectangle_share_max: if fills {
                self.options.rectangle_share_max
            } else {
                0.0
            },
            ..self.options
        };
        self.regions.begin(field.n_cells());
        self.walk.begin(field.n_cells(), start, field.index(start));
        self.modes.clear();
        meter.expand()?;
        let mut steps_left = 4 * field.n_cells();
        while let Some(at) = self.walk.cells.last().copied() {
            if at == goal {
                return Ok(());
            }
            let line_is_free =
                self.regions
                    .regularise(field, at, goal, &[start], &options, meter)?;
            if steps_left == 0 {
                return Err(Failure::Stuck);
            }
            steps_left -= 1;
            let virtual_field = field.with_walls(self.regions.walls());
            if line_is_free && sees(&virtual_field, at, goal, meter)? {
                self.enter(field, goal, Mode::Attraction, meter)?;
            } else if let Some(to) = self.advance(field, at, goal, meter)? {
                self.enter(field, to, Mode::Attraction, meter)?;
            } else {
                let walled = field.with_walls(self.regions.walls());
                match self.walk.step(&walled, goal, gait, meter.stats) {
                    Some(to) => self.enter(field, to, Mode::ThreeNeighbours, meter)?,
                    None if gait.memory.goes_back() => {
                        self.walk.turn_back();
                        self.modes.pop();
                        meter.turn_back()?;
                    }
                    None => return Err(Failure::Stuck),
                }
            }
        }
        Err(Failure::Exhausted)
    }

    fn enter(
        &mut self,
        field: &Field<'_>,
        to: Cell,
        mode: Mode,
        meter: &mut Meter<'_>,
    ) -> Result<(), PlanError> {
        self.walk.enter(field, to);
        self.modes.push(mode);
        meter.expand()
    }

    /// TN-APF up to the switching area: outside of it, the first cell inside on the line to the
    /// target, when it can be reached by a straight line of its own and was not visited yet.
    fn advance(
        &mut self,
        field: &Field<'_>,
        at: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
    ) -> Result<Option<Cell>, PlanError> {
        let margin = self.options.switch_margin_cells;
        if self.regions.is_switching(field, at, margin) {
            return Ok(None);
        }
        let walled = field.with_walls(self.regions.walls());
        self.line.clear();
        let (line, regions) = (&mut self.line, &self.regions);
        let mut arrived = false;
        supercover(at, goal, |crossing| {
            if !arrived && crossing.cell != at && walled.is_free(crossing.cell) {
                line.push(crossing.cell);
                arrived = regions.is_switching(field, crossing.cell, margin);
            }
        });
        meter.aux(self.line.len() as u64)?;
        // The cell's centre lies beside the line by up to half a cell.
        while let Some(to) = self.line.pop() {
            if sees(&walled, at, to, meter)? {
                let new = !self.memory.remembers() || !self.walk.has_visited(field.index(to));
                return Ok(new.then_some(to));
            }
        }
        Ok(None)
    }
}

impl Solver for TnHyb {
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        let rotate = self.options.rotate;
        let other_side = if rotate == Rotate::Cw {
            Rotate::Ccw
        } else {
            Rotate::Cw
        };
        let rungs = [
            (Fallback::None, (rotate, true)),
            (Fallback::Clockwise, (other_side, true)),
            (Fallback::WithoutRectangles, (rotate, false)),
        ];
        let first = cells.len();
        let rungs_used = if self.options.ladder { 3 } else { 1 };
        for (fallback, rung) in &rungs[..rungs_used] {
            // Those that mapping filled are rectangles, too.
            let field = if rung.1 {
                *field
            } else {
                field.without_layers()
            };
            match self.hybrid(&field, start, goal, *rung, meter) {
                Ok(()) => {
                    meter.stats.remarks.fallback = *fallback;
                    cells.extend_from_slice(&self.walk.cells);
                    if self.options.pull {
                        pull(&field, cells, first, meter)?;
                    }
                    return Ok(());
                }
                // Without rectangles the walk was a search over the whole map.
                Err(Failure::Exhausted)
                    if self.regions.rectangles().is_empty() && field.layers == 0 =>
                {
                    return Err(NO_WAY);
                }
                Err(Failure::Exhausted | Failure::Stuck) => {}
                Err(Failure::Budget(error)) => return Err(error),
            }
        }
        if !self.options.ladder {
            return Err(PlanError::DeadEnd);
        }
        let recipe = Recipe::plain(Heuristic::Octile);
        let plain = field.without_layers();
        if let Some((here, before)) = self.walk.cells.split_last()
            && *here != start
            && self.astar.search(&plain, &recipe, *here, goal, meter)?
        {
            meter.stats.remarks.fallback = Fallback::AstarFromHere;
            cells.extend_from_slice(before);
        } else if self.astar.search(&plain, &recipe, start, goal, meter)? {
            meter.stats.remarks.fallback = Fallback::Astar;
        } else {
            return Err(NO_WAY);
        }
        self.astar.trace(&plain, goal, cells);
        Ok(())
    }

    fn is_literal(&self) -> bool {
        self.literal
    }

    fn layers(&self) -> u8 {
        FLAG_REGULARISED
    }
}
