//! A local planner whose velocity requests have items of another type: the slice of its topic holds
//! `f32` and not `u8`. Everything else, the schema hash included, agrees.

use zeronav_msgs::command::VelocityRequest;
use zeronav_msgs::message::Refusal;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{ControlRequest, Topic, TopicRow, VelocityRequestEnvelope};
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Service, Shell, StartError, Writer};
use zeronav_tests::seats::AnyConfig;

#[derive(Debug)]
enum RequestWithNumbers {}

impl Topic for RequestWithNumbers {
    type Envelope = VelocityRequestEnvelope;
    type Meta = VelocityRequest;
    type Item = f32;
    const ROW: &'static TopicRow = ControlRequest::ROW;

    fn check(_meta: &VelocityRequest, _items: &[f32]) -> Result<(), Refusal> {
        Ok(())
    }
}

pub(crate) struct WritesWrongType {
    _request: Writer<RequestWithNumbers>,
}

impl Service for WritesWrongType {
    const ROLE: Role = Role::LocalPlanner;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        Ok(Self {
            _request: shell.peer().writer(1)?,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        shell.ready();
        Ok(())
    }
}
