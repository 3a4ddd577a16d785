//! Local planners that misbehave: they read odometry only.

use std::process::ExitCode;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::message::SPEED_MAX;
use zeronav_msgs::role::Role;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Service, Shell, StartError};
use zeronav_tests::seats::{AnyConfig, RequestSeat, is_obeyed};

/// What a local planner does when it wakes.
pub(crate) trait Requests: Default {
    fn wake(&mut self, seat: &mut RequestSeat, shell: &mut Shell) -> Result<(), StartError>;
}

struct LocalPlanner<R>(RequestSeat, R);

impl<R: Requests> Service for LocalPlanner<R> {
    const ROLE: Role = Role::LocalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self(RequestSeat::open(shell)?, R::default()))
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        self.1.wake(&mut self.0, shell)
    }
}

pub(crate) fn run<R: Requests>() -> ExitCode {
    zeronav_shell::run::<LocalPlanner<R>>()
}

/// Keeps the robot at rest until it is obeyed, and dies then.
#[derive(Default)]
pub(crate) struct DiesOnceObeyed;

impl Requests for DiesOnceObeyed {
    fn wake(&mut self, seat: &mut RequestSeat, shell: &mut Shell) -> Result<(), StartError> {
        for due in seat.due(shell) {
            if is_obeyed(shell, due.tick) {
                return Err(StartError::system("being obeyed", "it is too much"));
            }
            seat.answer(shell, due, VelocityRequest::default());
        }
        Ok(())
    }
}

/// Keeps the robot at rest until it is obeyed, and requests NaN from then on.
#[derive(Default)]
pub(crate) struct NanOnceObeyed;

impl Requests for NanOnceObeyed {
    fn wake(&mut self, seat: &mut RequestSeat, shell: &mut Shell) -> Result<(), StartError> {
        for due in seat.due(shell) {
            let obeyed = is_obeyed(shell, due.tick);
            let request = VelocityRequest {
                v_mps: if obeyed { f64::NAN } else { 0.0 },
                validity: Validity::Drive.code(),
                ..VelocityRequest::default()
            };
            seat.answer(shell, due, request);
        }
        Ok(())
    }
}

/// Keeps the robot stopped and ignores the request to exit.
#[derive(Default)]
pub(crate) struct IgnoresSigterm;

impl Requests for IgnoresSigterm {
    fn wake(&mut self, seat: &mut RequestSeat, shell: &mut Shell) -> Result<(), StartError> {
        seat.answer_all(shell, VelocityRequest::default());
        Ok(())
    }
}

/// The shell drops a service that was asked to exit; this one never returns from that.
impl Drop for IgnoresSigterm {
    fn drop(&mut self) {
        loop {
            std::thread::park();
        }
    }
}

/// Requests the fastest turn a message can hold, alternately left and right, ten thousand times a
/// second: ten requests every millisecond.
#[derive(Default)]
pub(crate) struct FloodsRequests {
    sent: u64,
}

impl FloodsRequests {
    /// Requests of one wake, and the time to the next. [ns]
    const AT_ONCE: u64 = 10;
    const PAUSE_NS: u64 = 1_000_000;

    /// Requests before it changes the direction of the turn.
    const ONE_WAY: u64 = 1024;

    fn turning(&self) -> VelocityRequest {
        let left = (self.sent / Self::ONE_WAY).is_multiple_of(2);
        VelocityRequest {
            w_radps: if left { SPEED_MAX } else { -SPEED_MAX },
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        }
    }
}

impl Requests for FloodsRequests {
    fn wake(&mut self, seat: &mut RequestSeat, shell: &mut Shell) -> Result<(), StartError> {
        seat.answer_all(shell, self.turning());
        if shell.roster().has_clock() {
            for _ in 0..Self::AT_ONCE {
                seat.send(shell, self.turning());
                self.sent += 1;
            }
        }
        shell.wake_by(shell.woken_ns() + Self::PAUSE_NS);
        Ok(())
    }
}
