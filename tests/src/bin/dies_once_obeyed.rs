//! A local planner that keeps the robot at rest until it is obeyed, and dies then.

use std::process::ExitCode;
use zeronav_msgs::command::VelocityRequest;
use zeronav_msgs::role::Role;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Service, Shell, StartError};
use zeronav_tests::seats::{AnyConfig, RequestSeat, is_obeyed};

struct DiesOnceObeyed(RequestSeat);

impl Service for DiesOnceObeyed {
    const ROLE: Role = Role::LocalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self(RequestSeat::open(shell)?))
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        let due: Vec<_> = self.0.due(shell).collect();
        for due in due {
            if is_obeyed(shell, due.tick) {
                return Err(StartError::system("being obeyed", "it is too much"));
            }
            self.0.answer(shell, due, VelocityRequest::default());
        }
        Ok(())
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<DiesOnceObeyed>()
}
