//! A global planner that says more waypoints than it has opened its topic for.

use std::process::ExitCode;
use zeronav_msgs::path::{PathStatus, Waypoint};
use zeronav_msgs::role::Role;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{NoConfig, PathOutput, PlanningInputs, Service, Shell, StartError};

struct TooMany {
    inputs: PlanningInputs,
    path: PathOutput,
}

impl Service for TooMany {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = NoConfig;

    fn open(shell: &mut Shell, _config: NoConfig) -> Result<Self, StartError> {
        Ok(Self {
            inputs: PlanningInputs::open(shell.peer())?,
            path: PathOutput::open(shell.peer(), "too_many", 2)?,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        let news = self.inputs.poll(shell);
        for turn in self.inputs.turns(shell, news) {
            let draft = self.inputs.begin(shell, turn);
            if let Some(goal) = self.inputs.goals.goal() {
                let three = [Waypoint::default(); 3];
                self.path.say(PathStatus::Found, goal.id, &three);
            }
            self.path.answer(shell, turn, &draft);
        }
        Ok(None)
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<TooMany>()
}
