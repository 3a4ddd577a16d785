//! The times of the planners and of the whole replanning cycle after a change of the map.

use crate::change::{Kind, apply, place, undo};
use crate::support::{Map, Rng};
use std::time::Instant;
use zeronav_casts::Cast;
use zeronav_global_planner::{
    CellPath, Control, CornerRule, Corridor, GlobalPlanner, GlobalPlannerConfig, Legality,
    PlanQuery, PlannerOptions, Replanner, Situation, Step, Target, Unknown, row_of,
};
use zeronav_msgs::{Cell, CellRect};
use zeronav_observe::statistics::median;

/// Repeats of every change.
const REPEATS: usize = 5;

/// Times of one change, each the median of the repeats. [us]
#[derive(Default, Clone)]
pub(crate) struct Times {
    pub(crate) notify: f64,
    pub(crate) filter: f64,
    pub(crate) incremental: f64,
    /// Of a path that is cut: NaN when there was no detour.
    pub(crate) detour: f64,
    /// Its cost by that of the best path.
    pub(crate) detour_ratio: f64,
    pub(crate) scratch: f64,
    pub(crate) jumps: f64,
    pub(crate) cycle: f64,
    pub(crate) ahead: f64,
    /// The path was kept.
    pub(crate) kept: bool,
    /// Expansions of the incremental search by those from scratch.
    pub(crate) ratio: f64,
}

impl Times {
    fn median_of(runs: &[Self]) -> Self {
        let of = |field: fn(&Self) -> f64| median(runs.iter().map(field)).unwrap_or(0.0);
        Self {
            notify: of(|times| times.notify),
            filter: of(|times| times.filter),
            incremental: of(|times| times.incremental),
            detour: of(|times| times.detour),
            detour_ratio: of(|times| times.detour_ratio),
            scratch: of(|times| times.scratch),
            jumps: of(|times| times.jumps),
            cycle: of(|times| times.cycle),
            ahead: of(|times| times.ahead),
            kept: runs[0].kept,
            ratio: of(|times| times.ratio),
        }
    }
}

/// The planners under test and the map that they know.
pub(crate) struct Bench {
    pub(crate) map: Map,
    uniform: bool,
    incremental: Box<dyn GlobalPlanner>,
    pub(crate) scratch: Box<dyn GlobalPlanner>,
    jumps: Box<dyn GlobalPlanner>,
    replanner: Replanner,
    revision: u64,
    task: u64,
    /// Searches with another cost, or with too many expansions.
    pub(crate) wrong: usize,
}

impl Bench {
    pub(crate) fn new(map: Map, uniform: bool) -> Result<Self, String> {
        let cost_weight = if uniform { 0.0 } else { 3.0 };
        let options = PlannerOptions {
            cost_weight,
            ..PlannerOptions::default()
        };
        let build = |key: &str| {
            row_of(key)
                .map(|row| (row.build)(&options))
                .map_err(|error| error.to_string())
        };
        let config = GlobalPlannerConfig {
            planner: "policy".to_owned(),
            options,
            shortcut_every_revisions: 1,
            ..GlobalPlannerConfig::default()
        };
        let mut bench = Self {
            uniform,
            incremental: build("mpgaa")?,
            scratch: build("mpgaa")?,
            jumps: build("jps")?,
            replanner: Replanner::new(&config).map_err(|error| error.to_string())?,
            revision: 1,
            task: 0,
            wrong: 0,
            map,
        };
        let all = [whole(&bench.map)];
        for planner in [&mut bench.incremental, &mut bench.scratch, &mut bench.jumps] {
            planner.map_changed(&bench.map.view(), &all);
        }
        Ok(bench)
    }

    /// One cycle of the replanner; its time. [us]
    fn cycle(&mut self, ends: (Cell, Cell), changed: &[CellRect]) -> f64 {
        self.revision += 1;
        let situation = Situation {
            robot: self.map.pose(ends.0),
            map: Some(self.map.view()),
            revision: self.revision,
            changed,
            target: Some(Target {
                task: self.task,
                goal: u64::from(ends.1.x.unsigned_abs()) << 32 | u64::from(ends.1.y.unsigned_abs()),
                pose: self.map.pose(ends.1),
                tolerance_m: 0.3,
            }),
            request: None,
        };
        let started = Instant::now();
        let mut step = self.replanner.begin(&situation);
        while let Step::Search(_) = step {
            self.replanner.search(&situation, &mut |_| Control::Go);
            let settled = Situation {
                changed: &[],
                ..situation
            };
            step = self.replanner.settle(&settled);
        }
        us(started)
    }

    /// Does all work ahead of a robot in `cell`; the time for `incremental`. [us]
    fn ahead(&mut self, cell: Cell) -> f64 {
        let robot = self.map.pose(cell);
        let started = Instant::now();
        while self.incremental.prepare(&robot, 4096) {}
        let time = us(started);
        while self.replanner.prepare(4096) {}
        time
    }

    /// Notifies the planners of changed cells; the time for `incremental`. [us]
    fn notify(&mut self, rect: CellRect) -> f64 {
        let map = self.map.view();
        let started = Instant::now();
        self.incremental.map_changed(&map, &[rect]);
        let time = us(started);
        self.scratch.map_changed(&map, &[rect]);
        self.jumps.map_changed(&map, &[rect]);
        time
    }

    /// Measures one change of the map, repeated [`REPEATS`] times; `None` when there is no path or no
    /// place for it.
    pub(crate) fn measure(
        &mut self,
        kind: Kind,
        ends: (Cell, Cell),
        rng: &mut Rng,
    ) -> Option<Times> {
        let mut path = CellPath::default();
        // The path before the change, with all work ahead done.
        self.replan(ends, &mut path)?;
        self.task += 1;
        self.cycle(ends, &[]);
        self.ahead(ends.0);
        let way = cell_by_cell(&self.replanner.plan().cells.cells);
        let block = place(&self.map, kind, &way, rng)?;
        let mut from_scratch = None;
        let mut runs = Vec::with_capacity(REPEATS);
        for _ in 0..REPEATS {
            let (rect, before) = apply(&mut self.map, self.uniform, kind, block);
            if kind == Kind::Removal {
                // The block is known first, then it vanishes.
                self.notify(rect);
                self.replan(ends, &mut path)?;
                self.cycle(ends, &[rect]);
                self.ahead(ends.0);
                undo(&mut self.map, rect, &before);
            }
            runs.push(self.answer_change(ends, rect, &path, &mut from_scratch));
            if kind != Kind::Removal {
                undo(&mut self.map, rect, &before);
                self.notify(rect);
                self.replan(ends, &mut path)?;
                // Another task of the same goal: back on the path before the change.
                self.task += 1;
                self.cycle(ends, &[rect]);
            }
            self.ahead(ends.0);
        }
        Some(Times::median_of(&runs))
    }

    /// A path by the incremental planner.
    fn replan(&mut self, ends: (Cell, Cell), path: &mut CellPath) -> Option<()> {
        let query = query(&self.map, ends);
        let result = self.incremental.plan(&query, &mut |_| Control::Go, path);
        result.ok().map(|_| ())
    }

    /// What every planner needs after the cells of `rect` changed; the search from scratch takes
    /// seconds where the others take milliseconds and runs only when `from_scratch` is empty.
    fn answer_change(
        &mut self,
        ends: (Cell, Cell),
        rect: CellRect,
        path: &CellPath,
        from_scratch: &mut Option<Answer>,
    ) -> Times {
        let mut times = Times::default();
        let legality = Legality {
            unknown: Unknown::Free,
            corner_rule: CornerRule::ForbidAny,
            past_margin: false,
        };
        let mut corridor = Corridor::default();
        corridor.set(&self.map.view(), legality, &path.cells);
        times.notify = self.notify(rect);
        let started = Instant::now();
        times.kept = corridor.is_cut(&self.map.view()).is_none();
        times.filter = us(started);
        let query = query(&self.map, ends);
        let detour = Answer::detour(self.incremental.as_mut(), &query);
        let incremental = Answer::of(self.incremental.as_mut(), &query);
        times.detour = f64::NAN;
        times.detour_ratio = f64::NAN;
        if let (Some(cost), Some(best)) = (detour.cost, incremental.cost) {
            times.detour = detour.time;
            times.detour_ratio = cost / best;
        }
        let scratch = from_scratch.get_or_insert_with(|| Answer::of(self.scratch.as_mut(), &query));
        if self.uniform {
            times.jumps = Answer::of(self.jumps.as_mut(), &query).time;
        }
        times.incremental = incremental.time;
        times.scratch = scratch.time;
        times.ratio = incremental.expanded.to_f64() / scratch.expanded.max(1).to_f64();
        let same = match (incremental.cost, scratch.cost) {
            (Some(one), Some(other)) => (one - other).abs() <= 1e-3 * other,
            (one, other) => one.is_none() && other.is_none(),
        };
        let most = scratch.expanded + scratch.expanded * 3 / 10 + 1;
        times.cycle = self.cycle(ends, &[rect]);
        // The policy's own search, when the filter did not settle it.
        let plan = self.replanner.plan();
        let policy = if plan.searched_map == self.revision {
            plan.cells.stats.expanded
        } else {
            0
        };
        if !same || incremental.expanded.max(policy) > most {
            self.wrong += 1;
        }
        times.ahead = self.ahead(ends.0);
        times
    }
}

/// One search.
struct Answer {
    /// [us]
    time: f64,
    /// `None` when there is no path.
    cost: Option<f64>,
    expanded: u64,
}

impl Answer {
    /// The detour.
    fn detour(planner: &mut dyn GlobalPlanner, query: &PlanQuery<'_>) -> Self {
        let mut path = CellPath::default();
        path.cells.reserve(20_000);
        let started = Instant::now();
        let stats = planner.detour(query, &mut |_| Control::Go, &mut path);
        Self {
            time: us(started),
            cost: stats.map(|stats| stats.cost),
            expanded: path.stats.expanded,
        }
    }

    fn of(planner: &mut dyn GlobalPlanner, query: &PlanQuery<'_>) -> Self {
        let mut path = CellPath::default();
        path.cells.reserve(20_000);
        let started = Instant::now();
        let result = planner.plan(query, &mut |_| Control::Go, &mut path);
        Self {
            time: us(started),
            cost: result.ok().map(|stats| stats.cost),
            expanded: path.stats.expanded,
        }
    }
}

pub(crate) fn query(map: &Map, ends: (Cell, Cell)) -> PlanQuery<'_> {
    PlanQuery {
        map: map.view(),
        start: map.pose(ends.0),
        goal: map.pose(ends.1),
        tolerance_m: 0.3,
        unknown: Unknown::Free,
        corner_rule: CornerRule::ForbidAny,
    }
}

fn us(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e6
}

pub(crate) fn whole(map: &Map) -> CellRect {
    let (width, height) = map.geometry.size();
    CellRect {
        min: Cell::new(0, 0),
        max: Cell::new(width, height),
    }
}

/// A way with every cell that it passes from one neighbour to the next.
fn cell_by_cell(corners: &[Cell]) -> Vec<Cell> {
    let mut cells: Vec<Cell> = corners.first().copied().into_iter().collect();
    for pair in corners.windows(2) {
        let mut at = pair[0];
        while at != pair[1] {
            at.x += (pair[1].x - at.x).signum();
            at.y += (pair[1].y - at.y).signum();
            cells.push(at);
        }
    }
    cells
}
