//! A global planner that sends more waypoints than it has opened its topic for.

use std::process::ExitCode;
use zeronav_msgs::header::Parents;
use zeronav_msgs::path::{Path, PathCause, PathStatus, Waypoint};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::PlanPath;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{
    CurrentGoal, MapInput, NoConfig, OdometryReader, Service, Shell, StartError, Writer,
};

struct TooMany {
    odometry: OdometryReader,
    map: MapInput,
    goal: CurrentGoal,
    path: Writer<PlanPath>,
}

impl Service for TooMany {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = NoConfig;

    fn open(shell: &mut Shell, _config: NoConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            map: MapInput::open(peer)?,
            goal: CurrentGoal::open(peer)?,
            path: peer.writer(2)?,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        self.odometry.poll(shell.roster());
        let news = self.map.poll(shell) | self.goal.poll(shell.roster());
        let trigger = self.map.trigger(shell.roster(), &self.odometry, news);
        for due in shell.due(&trigger) {
            self.goal.advance(shell.roster(), due.tick);
            let draft = self.map.begin(shell, due, Parents::default());
            let Some(goal) = self.goal.goal() else {
                shell.answer(&draft, &mut self.path, Path::default(), &[]);
                continue;
            };
            let three = [Waypoint::default(); 3];
            let path = Path {
                geometry: self.path.next_id().0,
                ..Path::new(
                    "too_many",
                    PathStatus::Found,
                    PathCause::Goal,
                    goal.id,
                    &three,
                )
            };
            shell.answer(&draft, &mut self.path, path, &three);
        }
        Ok(())
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<TooMany>()
}
