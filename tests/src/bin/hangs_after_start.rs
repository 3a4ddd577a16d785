//! A global planner that sends its idle output, reports that it is ready, and does not return from
//! the first wake after that in which it has a goal.

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
    /// It has answered, so that the heartbeat at the end of that wake says that it is ready.
    is_ready: bool,
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
            is_ready: false,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        self.odometry.poll(shell.roster());
        let news = self.map.poll(shell) | self.goal.poll(shell.roster());
        let trigger = self.map.trigger(shell.roster(), &self.odometry, news);
        while self.is_ready && self.goal.goal().is_some() {
            std::thread::park();
        }
        for due in shell.due(&trigger) {
            self.goal.advance(shell.roster(), due.tick);
            let draft = self.map.begin(shell, due, Parents::default());
            shell.answer(&draft, &mut self.path, Path::default(), &[]);
            self.is_ready = true;
        }
        Ok(())
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<HangsAfterStart>()
}
