//! The outcome of a search, ready to be published and to be held against later maps.

use crate::corridor::{Corridor, Legality};
use crate::planner::{CellPath, PlanError, PlanQuery};
use crate::waypoints::{waypoints_along, waypoints_of};
use nalgebra::Point2;
use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::path::{Path, PathBlock, PathCause, PathStatus, Waypoint};
use zeronav_msgs::{Cell, MapView, Pose};

/// A path that ends farther from its goal leads to another cell than the goal's. [m]
const BESIDE_M: f64 = 1.0e-6;

/// Where the planner is asked to lead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Id of the message on `task/goal`.
    pub task: u64,
    /// [`zeronav_msgs::task::Goal::id`].
    pub goal: u64,
    /// `map_from_base` to reach.
    pub pose: Pose,
    /// [m] how close counts, > 0.
    pub tolerance_m: f64,
}

/// A blocked cell that decided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blocked {
    /// Its centre, `map` frame. [m]
    pub at_m: [f64; 2],
    /// Where the obstacle comes from that blocks it.
    pub source: ObstacleSource,
}

/// Where a path was cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cut {
    /// Its first blocked cell.
    pub(crate) blocked: Blocked,
    /// Centre of the cell before that. [m]
    pub(crate) before: Point2<f64>,
    /// What the path led to.
    pub(crate) target: Target,
    /// The path led over cells that nobody has seen: that it is closed is no surprise.
    pub(crate) was_guess: bool,
}

impl Blocked {
    /// Its centre, `map` frame. [m]
    pub(crate) fn point(&self) -> Point2<f64> {
        Point2::from(self.at_m)
    }

    pub(crate) fn of(map: &MapView<'_>, cell: Cell) -> Self {
        let centre = map.geometry.centre_of(cell);
        Self {
            at_m: [centre.x, centre.y],
            source: map.source_at(cell),
        }
    }
}

/// A path, or why there is none.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Key of the planner.
    pub planner: &'static str,
    /// The outcome.
    pub status: PathStatus,
    /// Why it was looked for.
    pub cause: PathCause,
    /// Id of the message that brought it first; 0 = not named yet.
    pub geometry: u64,
    /// Revision of the map that the search used.
    pub searched_map: u64,
    /// What it leads to.
    pub target: Option<Target>,
    /// Where the robot was.
    pub robot: Pose,
    /// In which cell, `None` beside the map.
    pub robot_cell: Option<Cell>,
    /// It was ready before the search that is still due.
    pub is_detour: bool,
    /// The path in cells, with the counters of the search.
    pub cells: CellPath,
    /// The path in metres; empty without one.
    pub waypoints: Vec<Waypoint>,
    /// Length of the waypoints. [m]
    pub length_m: f64,
    /// The cells to be held against later maps.
    pub corridor: Corridor,
    /// The first blocked cell of the path before this one.
    pub cut: Option<Blocked>,
    /// The cell that would have to open, where no way leads to the goal, or none but for what was seen from afar.
    pub closed: Option<Blocked>,
    /// It leads to where [`Self::closed`] can be seen from near.
    pub is_look: bool,
    /// Where the obstacle comes from at the end that is blocked: the robot's or the goal's.
    pub end_source: ObstacleSource,
}

impl Plan {
    /// No path, because none was asked for.
    #[must_use]
    pub fn idle(planner: &'static str) -> Self {
        Self {
            planner,
            status: PathStatus::NoGoal,
            cause: PathCause::None,
            geometry: 0,
            searched_map: 0,
            target: None,
            robot: Pose::default(),
            robot_cell: None,
            is_detour: false,
            cells: CellPath::default(),
            waypoints: Vec::new(),
            length_m: 0.0,
            corridor: Corridor::default(),
            cut: None,
            closed: None,
            is_look: false,
            end_source: ObstacleSource::None,
        }
    }

    /// Becomes [`Self::idle`], keeping its memory.
    pub(crate) fn clear(&mut self) {
        self.status = PathStatus::NoGoal;
        self.cause = PathCause::None;
        self.geometry = 0;
        self.searched_map = 0;
        self.target = None;
        self.robot_cell = None;
        self.is_detour = false;
        self.cut = None;
        self.closed = None;
        self.is_look = false;
        self.end_source = ObstacleSource::None;
        self.cells.clear();
        self.forget_way();
    }

    fn forget_way(&mut self) {
        self.cells.cells.clear();
        self.cells.curve.clear();
        self.waypoints.clear();
        self.length_m = 0.0;
        self.corridor.clear();
    }

    /// Becomes the outcome of the search that wrote `self.cells`.
    pub(crate) fn set(
        &mut self,
        query: &PlanQuery<'_>,
        legality: Legality,
        target: Target,
        error: Option<PlanError>,
    ) {
        self.geometry = 0;
        self.target = Some(target);
        self.robot = query.start;
        self.robot_cell = query.map.geometry.cell_at(query.start.point());
        self.closed = None;
        self.is_look = false;
        let end = match error {
            Some(PlanError::StartBlocked) => self.robot_cell,
            _ => query.map.geometry.cell_at(query.goal.point()),
        };
        self.end_source = end.map_or(ObstacleSource::None, |end| query.map.source_at(end));
        let length_m = error.map_or_else(
            || {
                let (cells, curve) = (&self.cells.cells, &self.cells.curve);
                waypoints_along(&query.map, curve, &query.goal, &mut self.waypoints)
                    .or_else(|_| waypoints_of(&query.map, cells, &query.goal, &mut self.waypoints))
                    .map_err(|_| PathStatus::TooLong)
            },
            |error| Err(error.status()),
        );
        match length_m {
            Ok(length_m) => {
                self.status = PathStatus::Found;
                self.length_m = length_m;
                self.corridor.set(&query.map, legality, &self.cells.cells);
            }
            Err(status) => {
                self.status = status;
                self.forget_way();
            }
        }
    }

    /// [m] from the path's end to the goal; 0 without a path.
    fn beside_goal_m(&self) -> f64 {
        self.waypoints
            .last()
            .zip(self.target)
            .map_or(0.0, |(last, target)| {
                (Point2::new(last.x_m, last.y_m) - target.pose.point()).norm()
            })
    }

    /// The first cell that cuts this path on `map`.
    pub(crate) fn first_cut(&self, map: &MapView<'_>) -> Option<Cut> {
        if self.status != PathStatus::Found || !self.corridor.is_on(map.geometry) {
            return None;
        }
        let [cell, before] = self.corridor.first_blocked(map)?;
        Some(Cut {
            target: self.target?,
            was_guess: self.corridor.is_guess(map),
            blocked: Blocked::of(map, cell),
            before: map.geometry.centre_of(before),
        })
    }

    /// True when this leads to the same place to look from as another plan, and can be followed.
    pub(crate) fn looks_like(&self, other: &Self, map: &MapView<'_>) -> bool {
        let is_same = self.target == other.target && self.closed == other.closed;
        self.is_look && is_same && !self.is_cut(map)
    }

    /// The cell that decided.
    fn block(&self) -> Option<(PathBlock, Blocked)> {
        let end = |block, [x_m, y_m]: [f64; 2]| {
            let source = self.end_source;
            let at_m = [x_m, y_m];
            (block, Blocked { at_m, source })
        };
        let goal = || {
            let pose = self.target?.pose;
            Some(end(PathBlock::Goal, [pose.x_m, pose.y_m]))
        };
        match self.status {
            PathStatus::StartBlocked => {
                Some(end(PathBlock::Robot, [self.robot.x_m, self.robot.y_m]))
            }
            PathStatus::GoalBlocked | PathStatus::GoalOutsideMap => goal(),
            _ => {
                let before = self.cut.map(|cut| (PathBlock::PathBefore, cut));
                let closed = self.closed.map(|closed| (PathBlock::Closed, closed));
                let beside = || goal().filter(|_| self.beside_goal_m() > BESIDE_M);
                before.or(closed).or_else(beside)
            }
        }
    }

    /// True when this is a path and `map` does not let the robot follow what is left of it.
    #[must_use]
    pub fn is_cut(&self, map: &MapView<'_>) -> bool {
        self.status == PathStatus::Found
            && (!self.corridor.is_on(map.geometry) || self.corridor.is_cut(map).is_some())
    }

    /// Fills every field of the message; the slice is [`Self::waypoints`].
    pub fn fill(&self, message: &mut Path) {
        let stats = &self.cells.stats;
        let (block, blocked) = self.block().unwrap_or((
            PathBlock::None,
            Blocked {
                at_m: [0.0; 2],
                source: ObstacleSource::None,
            },
        ));
        *message = Path {
            planner: Path::planner_bytes(self.planner),
            status: self.status.code(),
            cause: self.cause.code(),
            n_waypoints: u32::try_from(self.waypoints.len()).unwrap_or(u32::MAX),
            geometry: self.geometry,
            searched_map: self.searched_map,
            expanded: stats.expanded,
            generated: stats.generated,
            evaluated: stats.evaluated,
            peak_open: stats.peak_open,
            length_m: self.length_m,
            cost: stats.cost,
            bound: stats.bound.min(stats.cost),
            goal: self.target.map_or(0, |target| target.goal),
            beside_goal_m: self.beside_goal_m(),
            block: block.code(),
            source: blocked.source.code(),
            spare: [0; 2],
            block_m: blocked.at_m,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_says_how_far_beside_its_goal_it_ends() {
        let mut plan = Plan::idle("c_astar");
        let mut message = Path::default();
        plan.fill(&mut message);
        assert!(message.beside_goal_m.abs() < f64::EPSILON);
        plan.target = Some(Target {
            task: 1,
            goal: 1,
            pose: Pose::new(2.0, 1.0, 0.0),
            tolerance_m: 0.5,
        });
        plan.waypoints.push(Waypoint {
            x_m: 1.7,
            y_m: 1.4,
            ..Waypoint::default()
        });
        plan.fill(&mut message);
        assert!((message.beside_goal_m - 0.5).abs() < 1.0e-12, "{message:?}");
    }

    #[test]
    fn a_plan_names_the_cell_that_decided() {
        let mut plan = Plan::idle("c_astar");
        plan.robot = Pose::new(1.0, 2.0, 0.0);
        plan.target = Some(Target {
            task: 1,
            goal: 1,
            pose: Pose::new(5.0, 6.0, 0.0),
            tolerance_m: 0.5,
        });
        let mut message = Path::default();
        let mut check = |plan: &Plan, block: PathBlock, at: [f64; 2]| {
            plan.fill(&mut message);
            assert_eq!(message.block(), Some(block), "{message:?}");
            let off = at.iter().zip(message.block_m).map(|(a, b)| (a - b).abs());
            assert!(off.sum::<f64>() < 1.0e-12, "{message:?}");
        };
        plan.status = PathStatus::StartBlocked;
        check(&plan, PathBlock::Robot, [1.0, 2.0]);
        plan.status = PathStatus::GoalBlocked;
        check(&plan, PathBlock::Goal, [5.0, 6.0]);
        plan.status = PathStatus::Unreachable;
        check(&plan, PathBlock::None, [0.0, 0.0]);
        let at = |x_m| Blocked {
            at_m: [x_m, 4.0],
            source: ObstacleSource::Lidar,
        };
        plan.closed = Some(at(3.5));
        check(&plan, PathBlock::Closed, [3.5, 4.0]);
        plan.cut = Some(at(3.0));
        check(&plan, PathBlock::PathBefore, [3.0, 4.0]);
        (plan.cut, plan.closed) = (None, None);
        plan.status = PathStatus::Found;
        plan.waypoints.push(Waypoint {
            x_m: 5.0,
            y_m: 6.0,
            ..Waypoint::default()
        });
        check(&plan, PathBlock::None, [0.0, 0.0]);
        plan.waypoints[0].x_m = 4.75;
        check(&plan, PathBlock::Goal, [5.0, 6.0]);
    }
}
