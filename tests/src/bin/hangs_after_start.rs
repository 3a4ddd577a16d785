//! A global planner that says its idle output, says that it is ready, and with the first map or
//! task never returns from its wake.

use serde::{Deserialize, Serialize};
use std::process::ExitCode;
use zeronav_msgs::header::Parents;
use zeronav_msgs::path::Path;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::{PlanPath, TaskGoal};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Cycle, Latest, Service, Shell, StartError, Writer};

#[derive(Debug, Serialize, Deserialize)]
struct AnyConfig {}

struct HangsAfterStart {
    goal: Latest<TaskGoal>,
    path: Writer<PlanPath>,
    idle_said: bool,
}

impl Service for HangsAfterStart {
    const ROLE: Role = Role::GlobalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self {
            goal: shell.peer().latest()?,
            path: shell.peer().writer(1)?,
            idle_said: false,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        if !shell.roster().has_clock() {
            return Ok(None);
        }
        if !self.idle_said {
            self.idle_said = true;
            let draft = shell.draft(0, 0, 0, Parents::default());
            let geometry = self.path.next_id().0;
            let path = Path {
                geometry,
                ..Path::default()
            };
            let sent = self.path.publish(&draft, path, &[]);
            let output = shell.sent(&self.path, sent);
            shell.finish(&Cycle {
                kind: SpanKind::Idle,
                draft,
                output,
                work: 0,
            });
            shell.ready();
        } else if self.goal.poll(shell.roster()) {
            loop {
                std::thread::park();
            }
        }
        Ok(None)
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<HangsAfterStart>()
}
