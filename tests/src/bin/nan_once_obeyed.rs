//! A local planner that keeps the robot at rest until it is obeyed, and requests NaN from then on.

use std::process::ExitCode;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::role::Role;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Service, Shell, StartError};
use zeronav_tests::seats::{AnyConfig, RequestSeat, is_obeyed};

struct NanOnceObeyed(RequestSeat);

impl Service for NanOnceObeyed {
    const ROLE: Role = Role::LocalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self(RequestSeat::open(shell)?))
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        let due: Vec<_> = self.0.due(shell).collect();
        for due in due {
            let v_mps = if is_obeyed(shell, due.tick) {
                f64::NAN
            } else {
                0.0
            };
            let request = VelocityRequest {
                v_mps,
                validity: Validity::Drive.code(),
                ..VelocityRequest::default()
            };
            self.0.answer(shell, due, request);
        }
        Ok(())
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<NanOnceObeyed>()
}
