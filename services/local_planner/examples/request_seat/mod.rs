//! The correct part of a local planner that knows odometry only, for services whose requests are wrong.

#![allow(
    unreachable_pub,
    reason = "the test processes use it from a library of their own"
)]

use serde::{Deserialize, Serialize};
use zeronav_msgs::command::VelocityRequest;
use zeronav_msgs::header::Parents;
use zeronav_msgs::topics::ControlRequest;
use zeronav_shell::{Draft, Due, OdometryReader, Shell, StartError, Trigger, Writer};

/// Accepts any configuration.
#[derive(Debug, Serialize, Deserialize)]
pub struct AnyConfig {}

/// The seat of a local planner that reads odometry only.
#[derive(Debug)]
pub struct RequestSeat {
    pub(super) odometry: OdometryReader,
    pub(super) request: Writer<ControlRequest>,
}

impl RequestSeat {
    /// Opens its topics.
    ///
    /// # Errors
    /// What keeps a service from starting.
    pub fn open(shell: &Shell) -> Result<Self, StartError> {
        Ok(Self {
            odometry: OdometryReader::open(shell.peer())?,
            request: shell.peer().writer(1)?,
        })
    }

    /// Polls odometry; the answers that are due.
    pub fn due(&mut self, shell: &mut Shell) -> impl Iterator<Item = Due> + use<> {
        self.odometry.poll(shell.roster());
        shell.due(&Trigger {
            tick: self.odometry.tick(),
            complete: true,
            ..Trigger::default()
        })
    }

    /// Answers with a request.
    pub fn answer(&mut self, shell: &mut Shell, due: Due, request: VelocityRequest) {
        let draft = self.begin(shell, due);
        shell.answer(&draft, &mut self.request, request, &[]);
    }

    /// Answers everything that is due with the same request.
    pub fn answer_all(&mut self, shell: &mut Shell, request: VelocityRequest) {
        for due in self.due(shell) {
            self.answer(shell, due, request);
        }
    }

    pub(super) fn begin(&self, shell: &Shell, due: Due) -> Draft {
        let parents = Parents {
            odometry: self.odometry.id().0,
            ..Parents::default()
        };
        shell.begin(due, shell.run_ns(due.tick), 0, parents)
    }
}
