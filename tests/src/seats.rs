//! The correct part of test processes that misbehave, so that each of their files contains its
//! misbehaviour only.

#[path = "../../services/local_planner/examples/request_seat/mod.rs"]
mod request_seat;

pub use request_seat::{AnyConfig, RequestSeat};
use zeronav_msgs::command::VelocityRequest;
use zeronav_msgs::span::SpanKind;
use zeronav_shell::{Due, Shell};

impl RequestSeat {
    /// Sends a request that answers nothing.
    pub fn send(&mut self, shell: &mut Shell, request: VelocityRequest) {
        let due = Due {
            tick: self.odometry.tick(),
            kind: SpanKind::Extra,
        };
        let draft = self.begin(shell, due);
        shell.send(&draft, &mut self.request, request, &[]);
        shell.ring();
    }
}

/// True when this process is the one that is obeyed in its seat at `tick`.
#[must_use]
pub fn is_obeyed(shell: &Shell, tick: u64) -> bool {
    let roster = shell.roster();
    roster.own.is_some_and(|(role, epoch)| {
        let seat = roster.seat(role);
        tick > 0 && seat.is_some_and(|seat| seat.obeys(epoch, tick))
    })
}
