//! A local planner that requests the fastest turn a message can hold, alternately left and right,
//! ten thousand times a second: ten requests every millisecond.

use std::process::ExitCode;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::message::SPEED_MAX;
use zeronav_msgs::role::Role;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Service, Shell, StartError};
use zeronav_tests::seats::{AnyConfig, RequestSeat};

/// Requests of one wake, and the time to the next. [ns]
const REQUESTS: u64 = 10;
const PAUSE_NS: u64 = 1_000_000;

/// Requests before it changes the direction of the turn.
const ONE_WAY: u64 = 1024;

struct FloodsRequests {
    seat: RequestSeat,
    sent: u64,
}

impl Service for FloodsRequests {
    const ROLE: Role = Role::LocalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self {
            seat: RequestSeat::open(shell)?,
            sent: 0,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        for due in self.seat.due(shell) {
            self.seat.answer(shell, due, turning(self.sent));
        }
        if shell.roster().has_clock() {
            for _ in 0..REQUESTS {
                self.seat.send(shell, turning(self.sent));
                self.sent += 1;
            }
        }
        shell.wake_by(shell.woken_ns() + PAUSE_NS);
        Ok(())
    }
}

fn turning(sent: u64) -> VelocityRequest {
    let left = (sent / ONE_WAY).is_multiple_of(2);
    VelocityRequest {
        w_radps: if left { SPEED_MAX } else { -SPEED_MAX },
        validity: Validity::Drive.code(),
        ..VelocityRequest::default()
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<FloodsRequests>()
}
