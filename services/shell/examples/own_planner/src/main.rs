//! A global planner of your own: Dijkstra's algorithm on the cells of the map.
//!
//! The shell says when an answer is due, and its readers take in what the seat is given. What is left
//! is the search, and the message with its result.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::process::ExitCode;
use zeronav_msgs::Cell;
use zeronav_msgs::header::Parents;
use zeronav_msgs::map::MapView;
use zeronav_msgs::path::{Path, PathCause, PathStatus, WAYPOINTS_MAX, Waypoint};
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::PlanPath;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    CurrentGoal, Draft, Due, MapInput, NoConfig, OdometryReader, Service, Shell, StartError, Writer,
};

struct OwnPlanner {
    odometry: OdometryReader,
    map: MapInput,
    goal: CurrentGoal,
    output: Writer<PlanPath>,
    path: Path,
    waypoints: Vec<Waypoint>,
    /// Cells of the path.
    cells: Vec<Cell>,
}

impl Service for OwnPlanner {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = NoConfig;

    fn open(shell: &mut Shell, _config: NoConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            map: MapInput::with_obstacles(peer)?,
            goal: CurrentGoal::open(peer)?,
            output: peer.writer(WAYPOINTS_MAX)?,
            path: Path::default(),
            waypoints: Vec::new(),
            cells: Vec::new(),
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        let news = self.poll(shell);
        let trigger = self.map.trigger(shell.roster(), &self.odometry, news);
        for due in shell.due(&trigger) {
            let draft = self.begin(shell, due);
            self.plan();
            shell.answer(&draft, &mut self.output, self.path, &self.waypoints);
        }
        Ok(())
    }
}

impl OwnPlanner {
    /// Takes in what has come; true when there is another map or goal.
    fn poll(&mut self, shell: &mut Shell) -> bool {
        self.odometry.poll(shell.roster());
        let mapped = self.map.poll(shell);
        let other_goal = self.goal.poll(shell.roster());
        shell.count(&[&self.odometry, &self.map, &self.goal]);
        mapped || other_goal
    }

    fn begin(&mut self, shell: &Shell, due: Due) -> Draft {
        self.goal.advance(shell.roster(), due.tick);
        let parents = Parents {
            odometry: self.odometry.id().0,
            map: self.map.revision().0,
            goal: self.goal.task().0,
            ..Parents::default()
        };
        self.map.begin(shell, due, parents)
    }

    /// A path stays while it is free and leads to the current goal; the next begins at the robot.
    fn plan(&mut self) {
        let (Some(odometry), Some(map), Some(goal)) =
            (self.odometry.newest(), self.map.view(), self.goal.goal())
        else {
            return self.set(PathStatus::NoGoal, 0, Vec::new(), Vec::new());
        };
        let same_goal = self.path.goal == goal.id;
        if same_goal && !self.cells.is_empty() && self.cells.iter().all(|cell| free(&map, *cell)) {
            return;
        }
        let robot = self.map.map_from_base(&odometry.odometry.pose);
        let cells = search(&map, &robot, &goal.pose).unwrap_or_default();
        let waypoints = corners(&map, &cells, &goal.pose);
        match waypoints.len() {
            0 => self.set(PathStatus::Unreachable, goal.id, waypoints, Vec::new()),
            1..=WAYPOINTS_MAX => self.set(PathStatus::Found, goal.id, waypoints, cells),
            _ => self.set(PathStatus::TooLong, goal.id, Vec::new(), Vec::new()),
        }
    }

    /// The path to send from now on. It keeps its identity, `geometry`, until there is another; so
    /// does a failure.
    fn set(&mut self, status: PathStatus, goal: u64, waypoints: Vec<Waypoint>, cells: Vec<Cell>) {
        let same_goal = goal == self.path.goal;
        if same_goal && status.code() == self.path.status && waypoints.is_empty() {
            return;
        }
        let cause = match status {
            PathStatus::NoGoal => PathCause::None,
            _ if same_goal => PathCause::Obstacle,
            _ => PathCause::Goal,
        };
        self.path = Path {
            geometry: self.output.next_id().0,
            searched_map: self.map.revision().0,
            ..Path::new("own_planner", status, cause, goal, &waypoints)
        };
        self.waypoints = waypoints;
        self.cells = cells;
    }
}

/// True when the robot's centre may be in a cell.
fn free(map: &MapView<'_>, cell: Cell) -> bool {
    map.get(cell).is_some_and(|cell| !cell.blocks_centre())
}

/// Cells from the robot's to the goal's, both included, at the least length weighted by the cells'
/// costs; `None` when there is no way. A diagonal step needs both cells beside it to be free.
fn search(map: &MapView<'_>, robot: &Pose, goal: &Pose) -> Option<Vec<Cell>> {
    let geometry = map.geometry;
    let start = geometry.cell_at(robot.point())?;
    let goal = geometry.cell_at(goal.point())?;
    let mut costs = vec![u64::MAX; geometry.len()];
    let mut parents = vec![start; geometry.len()];
    let mut open = BinaryHeap::from([Reverse((0, start.x, start.y))]);
    costs[geometry.index_of(start)?] = 0;
    while let Some(Reverse((cost, x, y))) = open.pop() {
        let cell = Cell::new(x, y);
        if cell == goal {
            break;
        }
        if cost > costs[geometry.index_of(cell)?] {
            continue;
        }
        let steps = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        for (dx, dy) in steps {
            let next = Cell::new(x + dx, y + dy);
            let beside = [Cell::new(x + dx, y), Cell::new(x, y + dy), next];
            let (Some(index), Some(content)) = (geometry.index_of(next), map.get(next)) else {
                continue;
            };
            if !beside.iter().all(|cell| *cell == start || free(map, *cell)) {
                continue;
            }
            let length = if dx == 0 || dy == 0 { 1000 } else { 1414 };
            let next_cost = cost + length * (64 + u64::from(content.cost)) / 64;
            if next_cost < costs[index] {
                (costs[index], parents[index]) = (next_cost, cell);
                open.push(Reverse((next_cost, next.x, next.y)));
            }
        }
    }
    let mut cells = vec![goal];
    while let Some(cell) = cells.last().copied().filter(|cell| *cell != start) {
        let index = geometry
            .index_of(cell)
            .filter(|index| costs[*index] < u64::MAX)?;
        cells.push(parents[index]);
    }
    cells.reverse();
    Some(cells)
}

/// Waypoints where the cells change direction, and at both ends.
fn corners(map: &MapView<'_>, cells: &[Cell], goal: &Pose) -> Vec<Waypoint> {
    let direction = |from: Cell, to: Cell| (to.x - from.x, to.y - from.y);
    let mut waypoints = Vec::new();
    for (index, cell) in cells.iter().enumerate() {
        let next = cells.get(index + 1);
        let before = index
            .checked_sub(1)
            .map(|index| direction(cells[index], *cell));
        if next.is_some_and(|next| before == Some(direction(*cell, *next))) {
            continue;
        }
        let centre = map.geometry.centre_of(*cell);
        let (at, yaw_rad) = match next {
            Some(next) => {
                let (dx, dy) = direction(*cell, *next);
                (centre, f64::from(dy).atan2(f64::from(dx)))
            }
            None => (goal.point(), goal.yaw_rad),
        };
        waypoints.push(Waypoint {
            x_m: at.x,
            y_m: at.y,
            yaw_rad: yaw_rad as f32,
            clearance_m: map.get(*cell).map_or(0.0, |cell| cell.clearance_m() as f32),
        });
    }
    waypoints
}

fn main() -> ExitCode {
    zeronav_shell::run::<OwnPlanner>()
}
