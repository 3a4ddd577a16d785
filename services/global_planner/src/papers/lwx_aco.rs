//! `lwx_aco`: the ant colony that \[LWX\] compares with. Every parameter is ours.
//!
//! Dorigo, Gambardella, "Ant Colony System", 1997, on a grid: an ant goes to a neighbour that it
//! has not visited with probability `tau^alpha (1 / distance to the goal)^beta`; one without such a
//! neighbour dies. After every iteration pheromone evaporates; ants that arrived, and the best of
//! all so far, leave some on the cells of their path. As no ant enters a cell twice, no path has a
//! loop that could be removed.

use crate::papers::field::{Field, LENGTHS, Look, Marks, Meter, distance};
use crate::papers::on_map::Solver;
use crate::planner::PlanError;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use zeronav_msgs::Cell;
use zeronav_params::parameters;

/// Pheromone everywhere at the beginning.
const TAU_START: f64 = 1.0;

/// Pheromone that never evaporates, so that no way is ever ruled out.
const TAU_MIN: f64 = 1e-9;

/// The planner's method.
#[must_use]
pub(crate) fn lwx_aco(options: AntOptions, seed: u64) -> LwxAco {
    LwxAco {
        options,
        seed,
        tau: Vec::new(),
        attraction: Vec::new(),
        visited: Marks::default(),
        ant: Vec::new(),
        arrived: Vec::new(),
    }
}

/// Exponents of the pheromone and of 1 / distance to the goal. The paper gives none.
const ALPHA: f64 = 1.0;
const BETA: f64 = 7.0;

/// Part of the pheromone that is lost in an iteration.
const EVAPORATION: f64 = 0.3;

/// Pheromone of an ant times the length of its path.
const DEPOSIT_CELLS: f64 = 1.0;

/// Steps of all ants together, which bound the search on large maps.
const STEPS_MAX: u32 = 2_000_000;

parameters! {
    /// `lwx_aco`: the ant colony, PAPERS Appendix D.
    #[derive(Copy)]
    pub struct AntOptions {
        /// Ants in every iteration.
        ants: u32 = 50, [1, 1_000];
        /// Most iterations.
        iterations: u32 = 100, [1, 10_000];
        /// Iterations without a better path after which the search ends.
        patience: u32 = 30, [1, u32::MAX];
    }
}

/// See the module's description.
#[derive(Debug)]
pub(crate) struct LwxAco {
    options: AntOptions,
    seed: u64,
    /// Pheromone, row-major.
    tau: Vec<f64>,
    /// `(1 / distance to the goal)^beta`, row-major; 0 = not asked for yet.
    attraction: Vec<f64>,
    visited: Marks,
    ant: Vec<Cell>,
    /// Paths of this iteration, one after the other, with their costs and lengths.
    arrived: Vec<(f64, Vec<Cell>)>,
}

/// A colony at work on one query.
struct Colony<'a, 'f> {
    field: &'a Field<'f>,
    goal: Cell,
    rng: Pcg64Mcg,
    steps_left: u32,
}

impl LwxAco {
    /// One ant's walk into `self.ant`; true when it arrived.
    fn walk(
        &mut self,
        colony: &mut Colony<'_, '_>,
        start: Cell,
        meter: &mut Meter<'_>,
    ) -> Result<bool, PlanError> {
        let field = colony.field;
        self.visited.begin(field.n_cells());
        self.visited.insert(field.index(start));
        self.ant.clear();
        self.ant.push(start);
        let mut at = start;
        while at != colony.goal {
            if colony.steps_left == 0 {
                return Ok(false);
            }
            colony.steps_left -= 1;
            meter.expand()?;
            meter.stats.evaluated += LENGTHS.len() as u64;
            let mut choices = [(0.0, at); LENGTHS.len()];
            let mut sum = 0.0;
            for (n, choice) in choices.iter_mut().enumerate() {
                if let Look::Free(to) = field.look(at, n)
                    && !self.visited.has(field.index(to))
                {
                    sum += self.charm(field, to, colony.goal);
                    *choice = (sum, to);
                }
            }
            if sum <= 0.0 {
                return Ok(false);
            }
            let draw = colony.rng.random_range(0.0..sum);
            // The sums rise along the choices; those that cannot be taken have none.
            let chosen = choices.iter().find(|(sum, _)| draw < *sum);
            at = chosen.map_or(at, |(_, to)| *to);
            self.visited.insert(field.index(at));
            self.ant.push(at);
        }
        Ok(true)
    }

    /// How much a cell attracts an ant.
    fn charm(&mut self, field: &Field<'_>, cell: Cell, goal: Cell) -> f64 {
        let index = field.index(cell);
        let attraction = &mut self.attraction[index];
        if *attraction <= 0.0 {
            *attraction = (distance(cell, goal) + 1e-6).recip().powf(BETA);
        }
        // So that the sum of eight is a number, whatever the exponents.
        (*attraction * self.tau[index].powf(ALPHA)).clamp(1e-300, 1e300)
    }
}

impl Solver for LwxAco {
    fn solve(
        &mut self,
        field: &Field<'_>,
        start: Cell,
        goal: Cell,
        meter: &mut Meter<'_>,
        cells: &mut Vec<Cell>,
    ) -> Result<(), PlanError> {
        let options = self.options;
        let n_cells = field.n_cells();
        self.tau.clear();
        self.tau.resize(n_cells, TAU_START);
        self.attraction.clear();
        self.attraction.resize(n_cells, 0.0);
        let mut colony = Colony {
            field,
            goal,
            rng: Pcg64Mcg::seed_from_u64(self.seed),
            steps_left: STEPS_MAX,
        };
        let mut best: Option<(f64, Vec<Cell>)> = None;
        let mut since_better = 0;
        for _ in 0..options.iterations {
            self.arrived.clear();
            for _ in 0..options.ants {
                if self.walk(&mut colony, start, meter)? {
                    let cost = cost_of(field, &self.ant);
                    self.arrived.push((cost, self.ant.clone()));
                }
            }
            since_better += 1;
            let found = self.arrived.iter().min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((cost, path)) = found
                && best.as_ref().is_none_or(|(least, _)| *cost < *least - 1e-9)
            {
                best = Some((*cost, path.clone()));
                since_better = 0;
            }
            if since_better >= options.patience || colony.steps_left == 0 {
                break;
            }
            meter.aux(n_cells as u64)?;
            for tau in &mut self.tau {
                *tau = (*tau * (1.0 - EVAPORATION)).max(TAU_MIN);
            }
            for (cost, path) in self.arrived.iter().chain(&best) {
                for cell in path {
                    self.tau[field.index(*cell)] += DEPOSIT_CELLS / cost.max(1.0);
                }
            }
        }
        let Some((_, path)) = best else {
            return Err(PlanError::DeadEnd);
        };
        cells.extend_from_slice(&path);
        Ok(())
    }
}

fn cost_of(field: &Field<'_>, path: &[Cell]) -> f64 {
    path.windows(2)
        .map(|pair| field.line_cost(pair[0], pair[1]))
        .sum()
}
