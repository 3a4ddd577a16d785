//! When to look for a new path, and when a result counts.
//!
//! A pure state machine. One cycle, run after every map update and when a goal or a request came:
//!
//! ```text
//! let mut step = replanner.begin(&situation);
//! while let Step::Search(_) = step {              // at most twice
//!     replanner.search(&situation, &mut budget);
//!     situation = newest;                         // updates and goals that came meanwhile
//!     step = replanner.settle(&situation);
//! }
//! // publish replanner.plan(), as new or as unchanged
//! ```
//!
//! The rules, in the order in which they are asked; the first that holds decides:
//!
//! 1. Without a goal or a map there is no path: status `no_goal`.
//! 2. Another task: search, cause `goal`. Another goal of the same task: search, cause
//!    `next_goal`.
//! 3. The last search failed: it is repeated, with its cause, only when something happened that
//!    can make it succeed. A proof (`unreachable`, `unreachable_corner`, `goal_blocked`) needs a
//!    cell that opened or a robot that is elsewhere; `goal_outside_map` needs another grid;
//!    the others need any change of the map or a robot in another cell.
//!    A proof is none yet when a path over known cells was cut by what the lidar saw from farther than
//!    `look_from_m`: from afar beams that graze the edges of a door close it. The path then leads to the cell before the cut, and
//!    the search is repeated when the robot is near, or a cell opened and `shortcut_every_revisions` have passed.
//! 4. The map has another grid, or a cell ahead on the path blocks the robot's centre: a detour
//!    ([`GlobalPlanner::detour`]), else search, cause `obstacle`.
//! 5. The path is a detour: search, cause `improved`.
//! 6. The robot is further than `off_path_m` from its path: search, cause `request`.
//! 7. The local planner asks, about this very path, and map or robot have changed since the last
//!    search: search, cause `request`. A request is answered once.
//! 8. Cells became cheaper through which a way could lead that costs at least `shortcut_gain`
//!    less than the remaining path, and no search was made for `shortcut_every_revisions`
//!    revisions: search, cause `shortcut`. "Could" leaves nothing out: no way through a cell costs
//!    less than the octile distances to and from it.
//! 9. Otherwise the path stays.
//!
//! Where only blocked corners close the way to a goal, they are passed on the way to it (`past_corners`).
//!
//! A result counts only after it was held against the newest map ([`Replanner::settle`]):
//!
//! 10. When goal or task changed meanwhile, or a newer update cuts the path found, one more search
//!     follows, and only one. The second result is published whatever it is; the next cycle
//!     judges it again.
//! 11. A shortcut, or a path better than a detour, counts only when it saves what a shortcut must
//!     on the newest map, or when the old path is cut by now, then with cause `obstacle`. A search
//!     for one that fails changes nothing; a detour is then a path like any other.

use crate::barrier::Barrier;
use crate::change::{Change, CostMemory};
use crate::config::GlobalPlannerConfig;
use crate::look;
use crate::moves::octile_cells;
use crate::past_corners::PastCorners;
use crate::plan::{Blocked, Cut, Plan, Target};
use crate::planner::{Control, Expansions, GlobalPlanner, PlanQuery};
use crate::smooth::Smooth;
use crate::table::{UnknownPlanner, row_of};
use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::request::RequestReason;
use zeronav_msgs::stages::{Stage, StageTimer};
use zeronav_msgs::{Cell, CellRect, MapView, Pose};
use zeronav_params::ParameterError;

/// How far a robot must have moved for a proof that there is no way to be doubted. [m]
const ELSEWHERE_M: f64 = 0.5;

/// Largest ratio of octile to straight distance.
const OCTILE_MAX: f64 = 1.0824;

/// What is known at one moment.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a> {
    /// `map_from_base`.
    pub robot: Pose,
    /// The map, once there is one.
    pub map: Option<MapView<'a>>,
    /// Its revision.
    pub revision: u64,
    /// Rectangles written since the last situation handed in; all of the map when in doubt.
    pub changed: &'a [CellRect],
    /// Where to; `None` without a task.
    pub target: Option<Target>,
    /// The newest request of the local planner.
    pub request: Option<Request>,
}

/// A message on `plan/request`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// Its id.
    pub id: u64,
    /// [`zeronav_msgs::path::Path::geometry`] of the path that it is about; requests about
    /// another path are out of date.
    pub geometry: u64,
    /// Why.
    pub reason: RequestReason,
}

/// What to do next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Call [`Replanner::search`], then [`Replanner::settle`].
    Search(PathCause),
    /// Publish [`Replanner::plan`].
    Publish(News),
}

/// Whether the path of a cycle is another one than before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum News {
    /// New geometry, or a new failure: call [`Replanner::name_geometry`].
    New,
    /// As before.
    Unchanged,
}

/// A configuration that makes no planner.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BuildError {
    /// A parameter has a value that it must not have.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The configuration names a planner that there is not.
    #[error(transparent)]
    Planner(#[from] UnknownPlanner),
}

/// A search that was asked for.
#[derive(Debug, Clone, Copy)]
struct Pending {
    cause: PathCause,
    again: bool,
}

/// See the module's description.
pub struct Replanner {
    config: GlobalPlannerConfig,
    planner: Box<dyn GlobalPlanner>,
    plan: Plan,
    candidate: Plan,
    memory: CostMemory,
    smooth: Smooth,
    pending: Option<Pending>,
    /// What the map did since the last search.
    change: Change,
    /// Cheapest way that the cells that became cheaper since the last search allow. [m of free cells]
    promised_m: f64,
    robot: Pose,
    revision: u64,
    revisions_since_search: u32,
    request_served: u64,
    /// Where the last path to the goal was cut.
    cut: Option<Cut>,
    past_corners: PastCorners,
    barrier: Barrier,
    timer: StageTimer,
}

impl Replanner {
    /// A replanner without a path.
    ///
    /// # Errors
    /// [`BuildError`] when the configuration is not usable.
    pub fn new(config: &GlobalPlannerConfig) -> Result<Self, BuildError> {
        zeronav_params::check(config)?;
        let row = row_of(&config.planner)?;
        Ok(Self {
            config: config.clone(),
            planner: (row.build)(&config.options),
            plan: Plan::idle(row.key),
            candidate: Plan::idle(row.key),
            memory: CostMemory::default(),
            smooth: Smooth::default(),
            pending: None,
            change: Change::default(),
            promised_m: f64::INFINITY,
            robot: Pose::default(),
            revision: 0,
            revisions_since_search: 0,
            request_served: 0,
            cut: None,
            past_corners: PastCorners::new(config),
            barrier: Barrier::default(),
            timer: StageTimer::default(),
        })
    }

    /// What times the stages of a cycle; off unless the caller has put another one there.
    pub fn timer(&mut self) -> &mut StageTimer {
        &mut self.timer
    }

    /// The current path, or why there is none.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Names the message that brings the plan first; requests are held against it.
    pub fn name_geometry(&mut self, id: u64) {
        self.plan.geometry = id;
    }

    /// Works ahead for the next search, when the answer has been sent: a slice of about
    /// `expansions` expansions. True when more is left.
    pub fn prepare(&mut self, expansions: u64) -> bool {
        self.planner.prepare(&self.robot, expansions)
    }

    /// Begins a cycle.
    pub fn begin(&mut self, situation: &Situation<'_>) -> Step {
        self.pending = None;
        self.observe(situation);
        let (Some(map), Some(target)) = (situation.map, situation.target) else {
            return self.stop();
        };
        match self.reason_to_search(situation, &map, &target) {
            Some(cause) => self.ask(cause, false),
            None => Step::Publish(News::Unchanged),
        }
    }

    /// Searches, after [`Step::Search`]; nothing otherwise. `budget` may stop the search, as for
    /// a new goal, and is then to be followed by [`Self::settle`] with what made it do so.
    pub fn search(
        &mut self,
        situation: &Situation<'_>,
        budget: &mut dyn FnMut(Expansions) -> Control,
    ) {
        let (Some(pending), Some(map), Some(target)) =
            (self.pending, situation.map, situation.target)
        else {
            return;
        };
        self.observe(situation);
        let mut query = self.query(situation.robot, map, &target);
        let limit = self.config.budget_expansions;
        let mut limited = |expansions: Expansions| {
            if limit.is_some_and(|limit| expansions.0 >= limit) {
                Control::Stop
            } else {
                budget(expansions)
            }
        };
        let candidate = &mut self.candidate;
        let (planner, past) = (&mut self.planner, &mut self.past_corners);
        candidate.cells.clear();
        candidate.is_detour = pending.cause == PathCause::Obstacle
            && (planner.detour(&query, &mut limited, &mut candidate.cells)).is_some()
            && !past.passes_obstacles(&query, &candidate.cells);
        let tried = candidate.cells.stats;
        let result = if candidate.is_detour {
            Ok(tried)
        } else {
            let mut rest = |Expansions(n)| limited(Expansions(n + tried.expanded));
            let asked = (&mut query, target);
            let result = past.plan(planner.as_mut(), asked, &mut rest, &mut candidate.cells);
            candidate.cells.stats.add_effort(&tried);
            result
        };
        self.timer.mark(Stage::Search);
        if result.is_ok() && self.config.smooth_m > 0.0 {
            self.smooth
                .run(&query, self.config.smooth_m, &mut candidate.cells);
        }
        let legality = past.legality(&self.config, &target);
        candidate.set(&query, legality, target, result.err());
        if candidate.is_detour && candidate.status != PathStatus::Found {
            // It has more corners than a message holds.
            candidate.is_detour = false;
            let asked = (&mut query, target);
            let result = past.plan(planner.as_mut(), asked, &mut limited, &mut candidate.cells);
            let legality = past.legality(&self.config, &target);
            candidate.set(&query, legality, target, result.err());
        }
        self.timer.mark(Stage::Smooth);
        candidate.cause = pending.cause;
        let cut = self.cut.filter(|cut| cut.target == target);
        let named = cut.filter(|_| pending.cause == PathCause::Obstacle);
        candidate.cut = named.map(|cut| cut.blocked);
        let is_proof = matches!(
            candidate.status,
            PathStatus::Unreachable | PathStatus::UnreachableCorner
        );
        if is_proof && candidate.cut.is_none() {
            candidate.closed = self.barrier.find(&query);
        }
        if let Some(cut) = cut {
            let asked = (&query, &self.config, past.legality(&self.config, &target));
            look::lead(planner.as_mut(), asked, cut, &mut limited, candidate);
        }
        candidate.searched_map = situation.revision;
        if let Some(request) = situation.request {
            self.request_served = request.id;
        }
        self.change = Change::default();
        self.promised_m = f64::INFINITY;
        self.revisions_since_search = 0;
    }

    fn query<'a>(&self, robot: Pose, map: MapView<'a>, target: &Target) -> PlanQuery<'a> {
        PlanQuery {
            map,
            start: robot,
            goal: target.pose,
            tolerance_m: target.tolerance_m,
            unknown: self.config.unknown,
            corner_rule: self.past_corners.rule(target),
        }
    }

    /// Holds the result of the search against the newest situation: rules 10 and 11.
    pub fn settle(&mut self, newest: &Situation<'_>) -> Step {
        let Some(Pending { cause, again }) = self.pending.take() else {
            return Step::Publish(News::Unchanged);
        };
        self.observe(newest);
        let (Some(map), Some(target)) = (newest.map, newest.target) else {
            return self.stop();
        };
        if !again {
            if let Some(cause) = cause_of_target(self.candidate.target.as_ref(), &target) {
                return self.ask(cause, true);
            }
            if self.candidate.is_cut(&map) {
                if !self.candidate.is_look {
                    self.cut = self.candidate.first_cut(&map);
                }
                return self.ask(cause, true);
            }
        }
        if self.candidate.is_look && self.plan.looks_like(&self.candidate, &map) {
            return Step::Publish(News::Unchanged);
        }
        if matches!(cause, PathCause::Shortcut | PathCause::Improved)
            && !self.accept_shortcut(newest, &map)
        {
            self.plan.is_detour = false;
            return Step::Publish(News::Unchanged);
        }
        core::mem::swap(&mut self.plan, &mut self.candidate);
        self.plan.geometry = 0;
        if self.plan.status == PathStatus::Found && !self.plan.is_look {
            self.cut = None;
        }
        Step::Publish(News::New)
    }

    /// Rules 2 to 9.
    fn reason_to_search(
        &mut self,
        situation: &Situation<'_>,
        map: &MapView<'_>,
        target: &Target,
    ) -> Option<PathCause> {
        if let Some(cause) = cause_of_target(self.plan.target.as_ref(), target) {
            return Some(cause);
        }
        let robot_cell = map.geometry.cell_at(situation.robot.point());
        let moved = robot_cell != self.plan.robot_cell;
        if self.plan.status != PathStatus::Found {
            let retry = match self.plan.status {
                PathStatus::Unreachable
                | PathStatus::UnreachableCorner
                | PathStatus::GoalBlocked => {
                    self.change.opened || self.plan.robot.distance_m(&situation.robot) > ELSEWHERE_M
                }
                PathStatus::GoalOutsideMap => self.change.geometry,
                _ => self.change.any || moved,
            };
            return retry.then_some(self.plan.cause);
        }
        let off_path_m = self.plan.corridor.advance(situation.robot.point());
        if self.plan.is_cut(map) {
            if !self.plan.is_look {
                self.cut = self.plan.first_cut(map);
            }
            return Some(PathCause::Obstacle);
        }
        if self.plan.is_detour {
            return Some(PathCause::Improved);
        }
        if off_path_m > self.config.off_path_m {
            return Some(PathCause::Request);
        }
        let news = moved || situation.revision != self.plan.searched_map;
        if news
            && situation
                .request
                .is_some_and(|request| self.serves(request))
        {
            return Some(PathCause::Request);
        }
        let due = self.revisions_since_search >= self.config.shortcut_every_revisions;
        if self.plan.is_look {
            let near =
                |closed: Blocked| look::is_near(&self.config, map, &closed, &situation.robot);
            let is_near = self.plan.closed.is_none_or(near);
            return (is_near || due && self.change.opened).then_some(self.plan.cause);
        }
        let worth_m = (1.0 - self.config.shortcut_gain) * self.cost_ahead_m(map);
        (due && self.promised_m < worth_m).then_some(PathCause::Shortcut)
    }

    /// Rule 11.
    fn accept_shortcut(&mut self, newest: &Situation<'_>, map: &MapView<'_>) -> bool {
        if self.candidate.status != PathStatus::Found {
            return false;
        }
        self.plan.corridor.advance(newest.robot.point());
        if self.plan.is_cut(map) {
            self.candidate.cause = PathCause::Obstacle;
            self.candidate.cut = self.plan.first_cut(map).map(|cut| cut.blocked);
            return true;
        }
        let weight = self.config.options.cost_weight;
        let new_m = self.candidate.corridor.cost_ahead_m(map, weight);
        new_m < (1.0 - self.config.shortcut_gain) * self.cost_ahead_m(map)
    }

    fn cost_ahead_m(&self, map: &MapView<'_>) -> f64 {
        let weight = self.config.options.cost_weight;
        self.plan.corridor.cost_ahead_m(map, weight)
    }

    fn serves(&self, request: Request) -> bool {
        request.reason != RequestReason::None
            // Ids of the process that is obeyed after a rollback are lower than those before.
            && request.id != self.request_served
            && request.geometry == self.plan.geometry
    }

    fn ask(&mut self, cause: PathCause, again: bool) -> Step {
        self.pending = Some(Pending { cause, again });
        Step::Search(cause)
    }

    /// Rule 1.
    fn stop(&mut self) -> Step {
        if self.plan.status == PathStatus::NoGoal {
            return Step::Publish(News::Unchanged);
        }
        self.plan.clear();
        Step::Publish(News::New)
    }

    /// Takes in what the map did.
    fn observe(&mut self, situation: &Situation<'_>) {
        // The robot may have come closer to what became cheaper before.
        self.promised_m -= OCTILE_MAX * self.robot.distance_m(&situation.robot);
        self.robot = situation.robot;
        let Some(map) = situation.map else {
            return;
        };
        if situation.revision == self.revision {
            return;
        }
        self.revision = situation.revision;
        self.revisions_since_search = self.revisions_since_search.saturating_add(1);
        let ends = situation.target.and_then(|target| {
            let goal = map.geometry.cell_at(target.pose.point())?;
            Some((map.geometry.cell_at(situation.robot.point())?, goal))
        });
        let promised_m = &mut self.promised_m;
        let cost_decreased = |cell: Cell| {
            if let Some((robot, goal)) = ends {
                let cells = apart(robot, cell) + apart(cell, goal);
                *promised_m = promised_m.min(cells * map.geometry.resolution_m);
            }
        };
        let change =
            self.memory
                .take_in(&map, situation.changed, self.config.unknown, cost_decreased);
        self.change.geometry |= change.geometry;
        self.change.opened |= change.opened;
        self.change.any |= change.any;
        self.planner.map_changed(&map, situation.changed);
    }
}

/// Rule 2.
fn cause_of_target(old: Option<&Target>, new: &Target) -> Option<PathCause> {
    match old {
        Some(old) if old == new => None,
        Some(old) if old.task == new.task && old.goal != new.goal => Some(PathCause::NextGoal),
        _ => Some(PathCause::Goal),
    }
}

/// Length of the shortest way over free cells. [cells]
fn apart(one: Cell, other: Cell) -> f64 {
    octile_cells(one.x.abs_diff(other.x), one.y.abs_diff(other.y))
}
