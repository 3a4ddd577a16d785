//! How to swap a service: a global planner whose paths are straight lines.
//!
//! ```toml
//! [services.global_planner]
//! binary = "straight_line_service"
//! ```
//!
//! The shell says when an answer is due; the readers take in what the seat is given. What is left is
//! where the robot shall drive, and the message that says so.

use nalgebra::Point2;
use std::process::ExitCode;
use zeronav_casts::Cast;
use zeronav_msgs::header::Parents;
use zeronav_msgs::path::{Path, PathCause, PathStatus, Waypoint};
use zeronav_msgs::pose::{Pose, wrap_angle};
use zeronav_msgs::topics::PlanPath;
use zeronav_msgs::{map::MapView, role::Role};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    CurrentGoal, Draft, Due, MapInput, NoConfig, OdometryReader, Service, Shell, StartError, Writer,
};

struct StraightLine {
    odometry: OdometryReader,
    map: MapInput,
    goal: CurrentGoal,
    output: Writer<PlanPath>,
    path: Path,
    waypoints: Vec<Waypoint>,
}

impl Service for StraightLine {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = NoConfig;

    fn open(shell: &mut Shell, _config: NoConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            map: MapInput::with_obstacles(peer)?,
            goal: CurrentGoal::open(peer)?,
            output: peer.writer(2)?,
            path: Path::default(),
            waypoints: Vec::new(),
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

impl StraightLine {
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

    /// A line stays while it is free and leads to the current goal; the next begins at the robot.
    fn plan(&mut self) {
        let (Some(odometry), Some(goal)) = (self.odometry.newest(), self.goal.goal()) else {
            return self.set(PathStatus::NoGoal, 0, Vec::new());
        };
        let robot = self.map.map_from_base(&odometry.odometry.pose);
        let line_from = |start| straight(&self.map.view()?, start, &goal.pose);
        let start = self.waypoints.first();
        let start = start.map(|start| Point2::new(start.x_m, start.y_m));
        if self.path.goal == goal.id && start.and_then(line_from).is_some() {
            return;
        }
        match line_from(robot.point()) {
            Some(line) => self.set(PathStatus::Found, goal.id, line),
            None => self.set(PathStatus::DeadEnd, goal.id, Vec::new()),
        }
    }

    /// The path to send from now on. It keeps its identity, `geometry`, until there is another; so
    /// does a failure.
    fn set(&mut self, status: PathStatus, goal: u64, waypoints: Vec<Waypoint>) {
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
            ..Path::new("straight_line", status, cause, goal, &waypoints)
        };
        self.waypoints = waypoints;
    }
}

/// The ends of a line on which no cell blocks the robot's centre. Samples at least twice per cell
/// width, so that it misses nothing but a cut through a cell's corner.
fn straight(map: &MapView<'_>, start: Point2<f64>, end: &Pose) -> Option<Vec<Waypoint>> {
    let way = end.point() - start;
    let looks = 4 * map.geometry.width.max(map.geometry.height);
    let waypoint = |look: u32| {
        let at = start + way * (f64::from(look) / f64::from(looks));
        let cell = map.get(map.geometry.cell_at(at)?)?;
        (!cell.blocks_centre()).then(|| Waypoint {
            x_m: at.x,
            y_m: at.y,
            yaw_rad: way.y.atan2(way.x).to_f32(),
            clearance_m: cell.clearance_m().to_f32(),
        })
    };
    let mut line: Vec<Waypoint> = (0..=looks).map(waypoint).collect::<Option<_>>()?;
    line.last_mut()?.yaw_rad = wrap_angle(end.yaw_rad).to_f32();
    line.drain(1..line.len() - 1);
    Some(line)
}

fn main() -> ExitCode {
    zeronav_shell::run::<StraightLine>()
}
