//! A global planner that says nothing until it is obeyed, and leads through obstacles from then on.

use std::process::ExitCode;
use zeronav_msgs::header::Parents;
use zeronav_msgs::path::{Path, PathCause, PathStatus, Waypoint};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::PlanPath;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{CurrentGoal, MapInput, OdometryReader, Service, Shell, StartError, Writer};
use zeronav_tests::seats::{AnyConfig, is_obeyed};

/// How far to the side the path leads: across the shelves of a warehouse. [m]
const ASIDE_M: f64 = 3.0;

struct ThroughWalls {
    odometry: OdometryReader,
    map: MapInput,
    goal: CurrentGoal,
    path: Writer<PlanPath>,
}

impl Service for ThroughWalls {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            map: MapInput::open(peer)?,
            goal: CurrentGoal::open(peer)?,
            path: peer.writer(3)?,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        self.odometry.poll(shell.roster());
        let news = self.map.poll(shell) | self.goal.poll(shell.roster());
        let trigger = self.map.trigger(shell.roster(), &self.odometry, news);
        for due in shell.due(&trigger) {
            self.goal.advance(shell.roster(), due.tick);
            let draft = self.map.begin(shell, due, Parents::default());
            let line = self.line().filter(|_| is_obeyed(shell, due.tick));
            let (path, line) = match (self.goal.goal(), line) {
                (Some(goal), Some(line)) => {
                    let (status, cause) = (PathStatus::Found, PathCause::Goal);
                    (
                        Path::new("through_walls", status, cause, goal.id, &line),
                        line,
                    )
                }
                _ => (Path::default(), Vec::new()),
            };
            shell.answer(&draft, &mut self.path, path, &line);
        }
        Ok(())
    }
}

impl ThroughWalls {
    fn line(&self) -> Option<Vec<Waypoint>> {
        let robot = self.odometry.newest()?;
        let from = self.map.map_from_base(&robot.odometry.pose);
        let to = self.goal.goal()?.pose;
        let corners = [
            (from.x_m, from.y_m),
            (0.5 * (from.x_m + to.x_m), from.y_m + ASIDE_M),
            (to.x_m, to.y_m),
        ];
        let waypoint = |(x_m, y_m)| Waypoint {
            x_m,
            y_m,
            ..Waypoint::default()
        };
        Some(corners.map(waypoint).to_vec())
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<ThroughWalls>()
}
