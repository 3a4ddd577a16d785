//! A local planner that requests NaN with every odometry message.

mod request_seat;

use request_seat::{AnyConfig, RequestSeat};
use std::process::ExitCode;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::role::Role;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Service, Shell, StartError};

struct RequestsNan(RequestSeat);

impl Service for RequestsNan {
    const ROLE: Role = Role::LocalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self(RequestSeat::open(shell)?))
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        let request = VelocityRequest {
            v_mps: f64::NAN,
            w_radps: f64::NAN,
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        };
        self.0.answer_all(shell, request);
        Ok(())
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<RequestsNan>()
}
