//! `zeronav fault`: from its words to the request.

use super::cli::{FaultArgs, FaultCommand, LastsArgs};
use super::verbs::make;
use crate::control::request::Request;
use std::process::ExitCode;
use zeronav_msgs::run::DELAY_STEP_NS;
use zeronav_msgs::time::seconds;
use zeronav_scenario::StackFault;

/// `zeronav fault`.
#[must_use]
pub fn fault(arguments: &FaultArgs) -> ExitCode {
    let (request, done) = request(&arguments.fault);
    make(&arguments.stack, &request, done)
}

// long: an arm for each fault
/// The request, and what is said when it was met.
fn request(command: &FaultCommand) -> (Request, &'static str) {
    let begins = None;
    let (fault, done) = match command {
        FaultCommand::Heal { target } => {
            let target = target.clone();
            return (Request::Heal { target }, "healed");
        }
        FaultCommand::Kill { role } => {
            let service = role.to_string();
            (StackFault::Kill { service, begins }, "killed")
        }
        FaultCommand::Stop { role, lasts } => {
            let (service, LastsArgs { lasts_s }) = (role.to_string(), *lasts);
            let stop = StackFault::Stop {
                service,
                begins,
                lasts_s,
            };
            (stop, "stopped")
        }
        FaultCommand::Slow {
            delay: (role, steps),
            lasts,
        } => {
            let slow = StackFault::Slow {
                service: role.to_string(),
                by_ms: f64::from(*steps) * seconds(DELAY_STEP_NS) * 1.0e3,
                begins,
                lasts_s: lasts.lasts_s,
            };
            (slow, "slowed")
        }
        FaultCommand::Drop { share, lasts } => {
            let drop = StackFault::Drop {
                topic: share.0.clone(),
                share: share.1,
                begins,
                lasts_s: lasts.lasts_s,
            };
            (drop, "messages are lost")
        }
        FaultCommand::Delay { delay, lasts } => {
            let delay = StackFault::Delay {
                topic: delay.0.clone(),
                by_ms: delay.1,
                begins,
                lasts_s: lasts.lasts_s,
            };
            (delay, "messages are late")
        }
        FaultCommand::Corrupt { share, lasts } => {
            let corrupt = StackFault::Corrupt {
                topic: share.0.clone(),
                share: share.1,
                begins,
                lasts_s: lasts.lasts_s,
            };
            (corrupt, "messages are corrupted")
        }
        FaultCommand::Clock {
            offset: (role, by_ms),
            lasts,
        } => {
            let clock = StackFault::Clock {
                service: role.to_string(),
                by_ms: *by_ms,
                begins,
                lasts_s: lasts.lasts_s,
            };
            (clock, "its clock is off")
        }
        FaultCommand::FillShm { lasts_s } => {
            let lasts_s = Some(*lasts_s);
            let full = StackFault::FillShm { begins, lasts_s };
            (full, "the shared memory is full")
        }
        FaultCommand::DiskFull { lasts_s } => {
            let lasts_s = Some(*lasts_s);
            let full = StackFault::DiskFull { begins, lasts_s };
            (full, "the file system is full")
        }
    };
    (Request::Fault { fault }, done)
}
