//! A local planner that stands still in good order and, asked to leave, keeps its ports and stays.

use serde::{Deserialize, Serialize};
use std::process::ExitCode;
use zeronav_msgs::command::VelocityRequest;
use zeronav_msgs::header::Parents;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::{ControlRequest, RobotOdometry};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Cycle, Service, Shell, StartError, Stream, Track, Writer};

#[derive(Debug, Serialize, Deserialize)]
struct AnyConfig {}

struct IgnoresSigterm {
    odometry: Stream<RobotOdometry>,
    request: Writer<ControlRequest>,
    track: Track,
    answered_tick: Option<u64>,
}

impl Service for IgnoresSigterm {
    const ROLE: Role = Role::LocalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self {
            odometry: shell.peer().stream()?,
            request: shell.peer().writer(1)?,
            track: Track::default(),
            answered_tick: None,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        let track = &mut self.track;
        self.odometry
            .drain(shell.roster(), |view| track.push(view.header, view.meta));
        let newest = self.track.newest();
        let (tick, run_ns) = newest.map_or((0, 0), |newest| (newest.tick, newest.run_ns));
        if !shell.roster().has_clock() || self.answered_tick.is_some_and(|last| last >= tick) {
            return Ok(None);
        }
        let parents = Parents {
            odometry: newest.map_or(0, |newest| newest.id.0),
            ..Parents::default()
        };
        let draft = shell.draft(tick, run_ns, 0, parents);
        let sent = self
            .request
            .publish(&draft, VelocityRequest::default(), &[]);
        let output = shell.sent(&self.request, sent);
        let kind = self
            .answered_tick
            .map_or(SpanKind::Idle, |_| SpanKind::Answer);
        self.answered_tick = Some(tick);
        shell.finish(&Cycle {
            kind,
            draft,
            output,
            work: 0,
        });
        shell.ready();
        Ok(None)
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
