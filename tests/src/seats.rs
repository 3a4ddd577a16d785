//! The seats of processes that misbehave: everything that is in good order about them, so that
//! each of their files shows its misbehaviour alone.

use serde::{Deserialize, Serialize};
use zeronav_msgs::command::VelocityRequest;
use zeronav_msgs::header::Parents;
use zeronav_msgs::topics::ControlRequest;
use zeronav_shell::{Draft, Shell, StartError, TrackReader, Trigger, Turn, Writer};

/// Any configuration will do.
#[derive(Debug, Serialize, Deserialize)]
pub struct AnyConfig {}

/// The seat of a local planner that looks at nothing but odometry.
#[derive(Debug)]
pub struct RequestSeat {
    odometry: TrackReader,
    request: Writer<ControlRequest>,
}

impl RequestSeat {
    /// Opens its topics.
    ///
    /// # Errors
    /// What keeps a service from starting.
    pub fn open(shell: &Shell) -> Result<Self, StartError> {
        Ok(Self {
            odometry: TrackReader::open(shell.peer())?,
            request: shell.peer().writer(1)?,
        })
    }

    /// Takes in odometry; the answers that are due.
    pub fn turns(&mut self, shell: &Shell) -> impl Iterator<Item = Turn> + use<> {
        self.odometry.poll(shell.roster());
        shell.turns(&Trigger {
            tick: self.odometry.tick(),
            complete: true,
            news: false,
        })
    }

    /// Answers with a request.
    pub fn answer(&mut self, shell: &mut Shell, turn: Turn, request: VelocityRequest) {
        let draft = self.draft(shell, turn.tick);
        shell.answer(turn.kind, &draft, &mut self.request, request, &[]);
    }

    /// Answers everything that is due with the same request.
    pub fn answer_all(&mut self, shell: &mut Shell, request: VelocityRequest) {
        for turn in self.turns(shell) {
            self.answer(shell, turn, request);
        }
    }

    /// Sends a request that answers nothing.
    pub fn send(&mut self, shell: &mut Shell, request: VelocityRequest) {
        let draft = self.draft(shell, self.odometry.tick());
        let sent = self.request.publish(&draft, request, &[]);
        shell.sent(&self.request, sent);
        shell.ring();
    }

    fn draft(&self, shell: &Shell, tick: u64) -> Draft {
        let run_ns = tick.saturating_mul(shell.roster().clock.tick_ns);
        let parents = Parents {
            odometry: self.odometry.id().0,
            ..Parents::default()
        };
        shell.draft(tick, run_ns, 0, parents)
    }
}
