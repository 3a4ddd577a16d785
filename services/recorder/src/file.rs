//! One MCAP file while it is written.
//!
//! Chunks of 256 kB, compressed with LZ4, are written whole: a file that is cut, because its writer
//! was killed, can be read up to its last whole chunk. [`RecordingFile::flush`] ends a chunk early.

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, McapError, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::io::{Seek, Write};

/// Size of a chunk before compression; a larger message makes a larger one. [bytes]
pub const CHUNK_BYTES: u64 = 256 << 10;

/// Profile of the file: what MCAP calls the conventions of ROS 2.
const PROFILE: &str = "ros2";

/// Name of the metadata record that begins a recording: `version`, `mode` (`lockstep` or `real_time`), `seed`,
/// `tick_ns`, `times`, `run_zero_ns`, `driven_by`.
pub const START: &str = "zeronav.start";

/// Field of [`START`]: who decided where the robot drives, `scenario`, `clients` or `recording`.
pub const DRIVEN_BY: &str = "driven_by";

/// [`DRIVEN_BY`] of a run that its scenario describes.
pub const DRIVEN_BY_SCENARIO: &str = "scenario";

/// What stands before the name of a service or companion in the name of the metadata record with its parameters: the
/// values that it was started with by their path, defaults included.
pub const PARAMETERS: &str = "zeronav.parameters.";

/// Media type of the attachment with the scenario that was driven, whose name is that of the attachment without
/// `.toml`.
pub const SCENARIO_TYPE: &str = "application/toml";

/// Largest scenario that a recording holds. [bytes]
pub const SCENARIO_BYTES_MAX: u64 = 16 << 20;

/// The program that has written a file, in its header.
#[must_use]
pub fn library() -> String {
    format!("zeronav-recorder {}", env!("CARGO_PKG_VERSION"))
}

/// What a channel is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Channel<'a> {
    /// Its name.
    pub topic: &'a str,
    /// Encoding of its messages.
    pub encoding: &'a str,
    /// Name of the type of its messages.
    pub schema: &'a str,
    /// Encoding of the definition of that type; empty without one.
    pub schema_encoding: &'a str,
    /// The definition.
    pub definition: &'a [u8],
    /// Whatever else is to be said of it.
    pub metadata: BTreeMap<String, String>,
}

/// When a message was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stamped {
    /// Number of the message on its channel.
    pub sequence: u32,
    /// The moment that it is about. [ns]
    pub log_ns: u64,
    /// When it was sent. [ns]
    pub publish_ns: u64,
}

/// The last 32 bits: MCAP's numbers have no more.
pub(crate) fn low32(count: u64) -> u32 {
    u32::try_from(count & 0xffff_ffff).unwrap_or(0)
}

/// How a file of a recording is written.
#[must_use]
pub fn options() -> WriteOptions {
    WriteOptions::new()
        .profile(PROFILE)
        .library(library())
        .compression(Some(Compression::Lz4))
        .chunk_size(Some(CHUNK_BYTES))
        // A chunk lies in memory until it is whole.
        .disable_seeking(true)
}

/// A file that is being written.
pub struct RecordingFile<W: Write + Seek> {
    writer: Writer<W>,
}

impl<W: Write + Seek> core::fmt::Debug for RecordingFile<W> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("RecordingFile").finish_non_exhaustive()
    }
}

impl<W: Write + Seek> RecordingFile<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// What the output says.
    pub fn new(output: W) -> Result<Self, McapError> {
        Ok(Self {
            writer: options().create(output)?,
        })
    }

    /// Adds a channel and returns its number.
    ///
    /// # Errors
    /// What the output says.
    pub fn channel(&mut self, channel: &Channel<'_>) -> Result<u16, McapError> {
        let Channel {
            schema,
            schema_encoding,
            definition,
            ..
        } = channel;
        let schema = self
            .writer
            .add_schema(schema, schema_encoding, definition)?;
        self.writer
            .add_channel(schema, channel.topic, channel.encoding, &channel.metadata)
    }

    /// Writes a message.
    ///
    /// # Errors
    /// What the output says.
    pub fn write(&mut self, channel: u16, when: Stamped, data: &[u8]) -> Result<(), McapError> {
        let header = MessageHeader {
            channel_id: channel,
            sequence: when.sequence,
            log_time: when.log_ns,
            publish_time: when.publish_ns,
        };
        self.writer.write_to_known_channel(&header, data)
    }

    /// Writes a metadata record.
    ///
    /// # Errors
    /// What the output says.
    pub fn metadata(
        &mut self,
        name: &str,
        fields: BTreeMap<String, String>,
    ) -> Result<(), McapError> {
        self.writer.write_metadata(&Metadata {
            name: name.to_owned(),
            metadata: fields,
        })
    }

    /// Puts a whole file of this name into the recording.
    ///
    /// # Errors
    /// What the output says.
    pub fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), McapError> {
        self.writer.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: data.into(),
        })
    }

    /// Hands everything so far to the output: what a reader finds if nothing more comes.
    ///
    /// # Errors
    /// What the output says.
    pub fn flush(&mut self) -> Result<(), McapError> {
        self.writer.flush()
    }

    /// Ends the file with its index, and gives the output back.
    ///
    /// # Errors
    /// What the output says.
    pub fn finish(mut self) -> Result<W, McapError> {
        self.writer.finish()?;
        Ok(self.writer.into_inner())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::io::Cursor;

    /// A channel of bytes.
    pub(crate) fn a_channel() -> Channel<'static> {
        Channel {
            topic: "/a",
            encoding: "cdr",
            schema: "a/msg/A",
            schema_encoding: "ros2msg",
            definition: b"uint8 a\n",
            metadata: BTreeMap::new(),
        }
    }

    /// A file with `n` messages, ten in each chunk.
    pub(crate) fn recording(n: u32) -> Vec<u8> {
        let mut file = RecordingFile::new(Cursor::new(Vec::new())).expect("a file");
        let channel = file.channel(&a_channel()).expect("a channel");
        for at in 0..n {
            let ns = 1_000 + u64::from(at);
            let when = Stamped {
                sequence: at,
                log_ns: ns,
                publish_ns: ns,
            };
            file.write(channel, when, &at.to_le_bytes())
                .expect("written");
            if at % 10 == 9 {
                file.flush().expect("flushed");
            }
        }
        file.attach("a.toml", "application/toml", b"a = 1\n")
            .expect("written");
        let fields = [("valid".to_owned(), "true".to_owned())];
        file.metadata("end", fields.into()).expect("written");
        file.finish().expect("finished").into_inner()
    }

    #[test]
    fn the_same_messages_make_the_same_bytes() {
        assert_eq!(recording(25), recording(25));
        assert!(recording(25).starts_with(mcap::MAGIC));
    }
}
