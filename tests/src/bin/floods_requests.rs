//! A local planner that asks for far more than the robot can do, ten thousand times a second:
//! ten requests every millisecond, to turn as fast as a message can say, now left, now right.

use serde::{Deserialize, Serialize};
use std::process::ExitCode;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::header::Parents;
use zeronav_msgs::message::SPEED_MAX;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::{ControlRequest, RobotOdometry};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Cycle, Service, Shell, StartError, Stream, Track, Writer};

/// Requests of one wake, and the time to the next. [ns]
const REQUESTS: u64 = 10;
const PAUSE_NS: u64 = 1_000_000;

#[derive(Debug, Serialize, Deserialize)]
struct AnyConfig {}

struct FloodsRequests {
    odometry: Stream<RobotOdometry>,
    request: Writer<ControlRequest>,
    track: Track,
    idle_said: bool,
}

impl Service for FloodsRequests {
    const ROLE: Role = Role::LocalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self {
            odometry: shell.peer().stream()?,
            request: shell.peer().writer(1)?,
            track: Track::default(),
            idle_said: false,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<Option<u64>, StartError> {
        let track = &mut self.track;
        self.odometry
            .drain(shell.roster(), |view| track.push(view.header, view.meta));
        if !shell.roster().has_clock() {
            return Ok(None);
        }
        let newest = self.track.newest();
        let (tick, run_ns) = newest.map_or((0, 0), |newest| (newest.tick, newest.run_ns));
        let parents = Parents {
            odometry: newest.map_or(0, |newest| newest.id.0),
            ..Parents::default()
        };
        for _ in 0..REQUESTS {
            let draft = shell.draft(tick, run_ns, 0, parents);
            let left = (self.request.next_id().count() / 1024).is_multiple_of(2);
            let request = VelocityRequest {
                w_radps: if left { SPEED_MAX } else { -SPEED_MAX },
                validity: Validity::Drive.code(),
                ..VelocityRequest::default()
            };
            let sent = self.request.publish(&draft, request, &[]);
            let output = shell.sent(&self.request, sent);
            shell.ring();
            if !self.idle_said {
                self.idle_said = true;
                shell.finish(&Cycle {
                    kind: SpanKind::Idle,
                    draft,
                    output,
                    work: 0,
                });
                shell.ready();
            }
        }
        Ok(Some(shell.woken_ns() + PAUSE_NS))
    }
}

fn main() -> ExitCode {
    zeronav_shell::run::<FloodsRequests>()
}
