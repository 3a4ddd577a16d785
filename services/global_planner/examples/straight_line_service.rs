//! How to swap a service: a global planner that knows nothing but the straight line.
//!
//! ```toml
//! [services.global_planner]
//! binary = "straight_line_service"
//! ```
//!
//! The shell does what every service does; [`PlanningInputs`] and [`PathOutput`] do what the seat
//! asks of everybody who sits there: when to answer, and how a path is said. What is left is where
//! the robot shall drive.

use nalgebra::Point2;
use std::process::ExitCode;
use zeronav_msgs::path::{PathStatus, Waypoint};
use zeronav_msgs::pose::{Pose, wrap_angle};
use zeronav_msgs::{map::MapView, role::Role};
use zeronav_shell::{NoConfig, PathOutput, PlanningInputs};
use zeronav_shell::{Service, Shell, StartError, doorbell::Rung};

struct StraightLine {
    inputs: PlanningInputs,
    path: PathOutput,
}

impl Service for StraightLine {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = NoConfig;

    fn open(shell: &mut Shell, _config: NoConfig) -> Result<Self, StartError> {
        Ok(Self {
            inputs: PlanningInputs::open(shell.peer())?,
            path: PathOutput::open(shell.peer(), "straight_line", 2)?,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        let news = self.inputs.poll(shell);
        shell.totals(self.inputs.refused(), 0);
        for turn in self.inputs.turns(shell, news) {
            let draft = self.inputs.begin(shell, turn);
            self.plan();
            self.path.answer(shell, turn, &draft);
        }
        Ok(None)
    }
}

impl StraightLine {
    /// A line stays while it is free and leads to the goal at hand; the next begins at the robot.
    fn plan(&mut self) {
        let errand = self.inputs.map_from_base().zip(self.inputs.goals.goal());
        let Some((robot, goal)) = errand else {
            return self.path.say(PathStatus::NoGoal, 0, &[]);
        };
        let line_from = |start| straight(&self.inputs.map.view()?, start, &goal.pose);
        let start = self.path.waypoints().first();
        let start = start.map(|start| Point2::new(start.x_m, start.y_m));
        if self.path.goal() == goal.id && start.and_then(line_from).is_some() {
            return;
        }
        match line_from(robot.point()) {
            Some(line) => self.path.say(PathStatus::Found, goal.id, &line),
            None => self.path.say(PathStatus::DeadEnd, goal.id, &[]),
        }
    }
}

/// The ends of a line on which the robot's centre may be everywhere. Looks at least twice on the
/// width of a cell, so all that it can miss is a cut through a cell's corner.
#[allow(clippy::cast_possible_truncation, reason = "directions are f32")]
fn straight(map: &MapView<'_>, start: Point2<f64>, end: &Pose) -> Option<Vec<Waypoint>> {
    let way = end.point() - start;
    let looks = 4 * map.geometry.width.max(map.geometry.height);
    let waypoint = |look: u32| {
        let at = start + way * (f64::from(look) / f64::from(looks));
        let cell = map.get(map.geometry.cell_at(at)?)?;
        (!cell.blocks_centre()).then(|| Waypoint {
            x_m: at.x,
            y_m: at.y,
            yaw_rad: way.y.atan2(way.x) as f32,
            clearance_m: cell.clearance_m() as f32,
        })
    };
    let mut line: Vec<Waypoint> = (0..=looks).map(waypoint).collect::<Option<_>>()?;
    line.last_mut()?.yaw_rad = wrap_angle(end.yaw_rad) as f32;
    line.drain(1..line.len() - 1);
    Some(line)
}

fn main() -> ExitCode {
    zeronav_shell::run::<StraightLine>()
}
