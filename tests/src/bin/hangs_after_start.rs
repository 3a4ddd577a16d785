//! A global planner that says its idle output, says that it is ready, and with the first task
//! never returns from its wake.

use std::process::ExitCode;
use zeronav_msgs::role::Role;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{PathOutput, PlanningInputs, Service, Shell, StartError};
use zeronav_tests::seats::AnyConfig;

struct HangsAfterStart {
    inputs: PlanningInputs,
    path: PathOutput,
}

impl Service for HangsAfterStart {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self {
            inputs: PlanningInputs::open(shell.peer())?,
            path: PathOutput::open(shell.peer(), "hangs", 1)?,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        let news = self.inputs.poll(shell);
        for turn in self.inputs.turns(shell, news) {
            let draft = self.inputs.begin(shell, turn);
            self.path.answer(shell, turn, &draft);
        }
        while self.inputs.goals.goal().is_some() {
            std::thread::park();
        }
        Ok(None)
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<HangsAfterStart>()
}
