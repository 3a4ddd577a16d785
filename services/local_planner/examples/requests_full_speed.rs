//! A local planner that requests full speed straight on with every odometry, whatever is ahead, and
//! reports a braking distance of zero.

mod request_seat;

use request_seat::{AnyConfig, RequestSeat};
use std::process::ExitCode;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::role::Role;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Service, Shell, StartError};

/// Faster than any robot of this project. [m/s]
const FULL_MPS: f64 = 5.0;

struct RequestsFullSpeed(RequestSeat);

impl Service for RequestsFullSpeed {
    const ROLE: Role = Role::LocalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self(RequestSeat::open(shell)?))
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        let request = VelocityRequest {
            v_mps: FULL_MPS,
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        };
        self.0.answer_all(shell, request);
        Ok(())
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<RequestsFullSpeed>()
}
