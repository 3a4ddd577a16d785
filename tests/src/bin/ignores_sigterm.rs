//! A local planner that keeps the robot stopped and ignores the request to exit.

use std::process::ExitCode;
use zeronav_msgs::command::VelocityRequest;
use zeronav_msgs::role::Role;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Service, Shell, StartError};
use zeronav_tests::seats::{AnyConfig, RequestSeat};

struct IgnoresSigterm(RequestSeat);

impl Service for IgnoresSigterm {
    const ROLE: Role = Role::LocalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self(RequestSeat::open(shell)?))
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        self.0.answer_all(shell, VelocityRequest::default());
        Ok(())
    }
}

/// The shell drops a service that was asked to leave; this one never lets go.
impl Drop for IgnoresSigterm {
    fn drop(&mut self) {
        loop {
            std::thread::park();
        }
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<IgnoresSigterm>()
}
