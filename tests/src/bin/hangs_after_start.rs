//! A global planner that sends its idle output, reports that it is ready, and does not return from
//! the wake in which it has a goal for the first time.

use std::process::ExitCode;
use zeronav_msgs::header::Parents;
use zeronav_msgs::path::{Path, WAYPOINTS_MAX};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::PlanPath;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{CurrentGoal, MapInput, OdometryReader, Service, Shell, StartError, Writer};
use zeronav_tests::seats::AnyConfig;

struct HangsAfterStart {
    odometry: OdometryReader,
    map: MapInput,
    goal: CurrentGoal,
    path: Writer<PlanPath>,
}

impl Service for HangsAfterStart {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            map: MapInput::open(peer)?,
            goal: CurrentGoal::open(peer)?,
            path: peer.writer(WAYPOINTS_MAX)?,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        self.odometry.poll(shell.roster());
        let news = self.map.poll(shell) | self.goal.poll(shell.roster());
        let trigger = self.map.trigger(shell.roster(), &self.odometry, news);
        for due in shell.due(&trigger) {
            self.goal.advance(shell.roster(), due.tick);
            let draft = self.map.begin(shell, due, Parents::default());
            shell.answer(&draft, &mut self.path, Path::default(), &[]);
        }
        while self.goal.goal().is_some() {
            std::thread::park();
        }
        Ok(())
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<HangsAfterStart>()
}
