//! The channels of a recording: each is made with its first message.

use crate::file::{Channel, RecordingFile};
use crate::native::{self, NativeTopic};
use mcap::McapError;
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use zeronav_ros_messages::RosTopic;

/// Those of both layers that there are so far.
#[derive(Debug, Default)]
pub(crate) struct Channels {
    native: BTreeMap<&'static str, u16>,
    world: BTreeMap<RosTopic, u16>,
}

impl Channels {
    /// That of a topic of the contract, or of a user's own.
    ///
    /// # Errors
    /// What the output of `file` says.
    pub(crate) fn native<W: Write + Seek>(
        &mut self,
        file: &mut RecordingFile<W>,
        topic: &NativeTopic,
    ) -> Result<u16, McapError> {
        if let Some(channel) = self.native.get(topic.row.name) {
            return Ok(*channel);
        }
        let channel = file.channel(&Channel {
            topic: &topic.channel(),
            encoding: native::ENCODING,
            schema: topic.type_name,
            schema_encoding: "",
            definition: b"",
            metadata: topic.metadata(),
        })?;
        self.native.insert(topic.row.name, channel);
        Ok(channel)
    }

    /// That of a topic for ROS 2.
    ///
    /// # Errors
    /// What the output of `file` says.
    pub(crate) fn world<W: Write + Seek>(
        &mut self,
        file: &mut RecordingFile<W>,
        topic: RosTopic,
    ) -> Result<u16, McapError> {
        if let Some(channel) = self.world.get(&topic) {
            return Ok(*channel);
        }
        let channel = file.channel(&Channel {
            topic: topic.name(),
            encoding: "cdr",
            schema: topic.type_name(),
            schema_encoding: "ros2msg",
            definition: topic.definition().as_bytes(),
            metadata: topic.metadata(),
        })?;
        self.world.insert(topic, channel);
        Ok(channel)
    }
}
