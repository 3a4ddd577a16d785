//! Shells in a private domain, seen from outside: what they send, ring, record and beat.

use super::*;
use crate::fixture::{Beats, Stage, TICK_NS, Words};
use crate::records::SpanReader;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::grid::GridGeometry;
use zeronav_msgs::header::{Id, SHADOW_EPOCH_MIN};
use zeronav_msgs::health::{HealthState, REASON_MAP, REASON_REFUSED};
use zeronav_msgs::map::{MapCell, MapInfo, MapTile};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::run::{RunClock, RunControl, RunMode, TopicFault, TopicFaultKind};
use zeronav_msgs::stages::Stage as WorkStage;
use zeronav_msgs::topics::{ControlRequest, MapKeyframe, RobotOdometry};

mod health;
mod sending;
mod waking;

const SECOND_NS: u64 = 1_000_000_000;

const SEATS: [(Role, u32); 5] = [
    (Role::Robot, 2),
    (Role::Mapping, 3),
    (Role::GlobalPlanner, 4),
    (Role::LocalPlanner, 5),
    (Role::CollisionGuard, 6),
];

fn stage(mode: RunMode) -> Stage {
    Stage::new(Words::of(mode, &SEATS))
}

/// The local planner of a run, and who sees what it does.
struct Bench {
    shell: Shell,
    writer: Writer<ControlRequest>,
    spans: SpanReader,
    beats: Beats,
    tap: Peer,
    stage: Stage,
}

impl Bench {
    fn new(mode: RunMode) -> Self {
        let mut stage = stage(mode);
        let tap = stage.join(Role::Tap, 1);
        let shell = stage.open(Role::LocalPlanner, 5);
        Self {
            writer: shell.peer().writer(0).expect("a writer"),
            spans: tap.span_reader().expect("a reader"),
            beats: Beats::of(&stage, Role::LocalPlanner),
            shell,
            tap,
            stage,
        }
    }

    fn begin(&self, due: Due) -> Draft {
        self.shell.begin(due, 0, 0, Parents::default())
    }

    fn send(&mut self, draft: &Draft, v_mps: f64) -> Option<Sent> {
        self.shell.send(draft, &mut self.writer, ask(v_mps), &[])
    }

    /// The record that has come.
    fn span(&mut self) -> Span {
        let span = self.spans.take().expect("a record");
        assert_eq!(self.spans.take(), None, "one record an answer");
        span
    }

    /// What has been due since the start, for this trigger.
    fn due(&mut self, trigger: Trigger) -> Vec<Due> {
        self.shell.due(&trigger).collect()
    }

    /// State and reasons of a beat at this moment. [ns]
    fn how(&mut self, now_ns: u64) -> (Option<HealthState>, u32) {
        self.shell.beat(now_ns);
        let health = self.beats.one();
        (health.state(), health.reasons)
    }

    /// The doorbell of another role, and what keeps it.
    fn bell(&self, role: Role) -> Bell {
        let peer = self.stage.join(role, 9);
        let (own, other) = UnixStream::pair().expect("a pair");
        own.set_nonblocking(true).expect("a flag");
        Bell {
            doorbell: Doorbell::open(&peer, own).expect("the doorbell"),
            _signal: other,
            _peer: peer,
        }
    }
}

/// Somebody's doorbell.
struct Bell {
    doorbell: Doorbell,
    _signal: UnixStream,
    _peer: Peer,
}

impl Bell {
    /// What has rung since this was last asked.
    fn rung(&self) -> Rung {
        self.doorbell.wait(0)
    }
}

fn ask(v_mps: f64) -> VelocityRequest {
    VelocityRequest {
        v_mps,
        validity: Validity::Drive.code(),
        ..VelocityRequest::default()
    }
}

fn answer_to(tick: u64) -> Due {
    Due {
        tick,
        kind: SpanKind::Answer,
    }
}

fn complete(tick: u64) -> Trigger {
    Trigger {
        tick,
        complete: true,
        ..Trigger::default()
    }
}
