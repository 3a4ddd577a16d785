//! Writes a recording that was cut again, up to its last whole chunk.

use crate::file;
use crate::read::{ReadError, Summary, records};
use crate::verdict::VERDICT;
use mcap::records::Record;
use mcap::{Attachment, McapError, Writer};
use std::collections::BTreeMap;
use std::io::{Read, Seek, Write};

/// What became of a file.
#[derive(Debug)]
pub struct Recovered {
    /// What is in the new one.
    pub summary: Summary,
    /// Where the old one is damaged; `None` when it is whole.
    pub damage: Option<ReadError>,
}

/// Why there is no new file.
#[derive(Debug, thiserror::Error)]
pub enum RecoverError {
    /// Of the old one.
    #[error("{0}")]
    Read(#[from] ReadError),
    /// Of the new one.
    #[error("writing: {0}")]
    Write(#[from] McapError),
}

/// Copies what can be read of `input` into a whole file. One that is cut has no verdict: it gets one
/// that says so.
///
/// # Errors
/// [`RecoverError::Read`] when nothing can be read, [`RecoverError::Write`] for the output.
pub fn recover<W: Write + Seek>(
    input: impl Read,
    output: W,
) -> Result<(Recovered, W), RecoverError> {
    let mut copy = Copy {
        writer: file::options().create(output)?,
        schemas: BTreeMap::new(),
        channels: BTreeMap::new(),
    };
    let mut summary = Summary::default();
    let mut names = BTreeMap::new();
    let copied = records(input, |record| {
        summary.note(record, &mut names);
        copy.write(record)
    });
    let damage = match copied {
        Ok(()) => None,
        Err(RecoverError::Read(damage)) if summary.profile.is_empty() => return Err(damage.into()),
        Err(RecoverError::Read(damage)) => Some(damage),
        Err(error) => return Err(error),
    };
    if !summary.metadata.contains_key(VERDICT) {
        let why = match &damage {
            Some(damage) => format!("recovered from a file that is damaged at {damage}"),
            None => "its recorder ended before it".to_owned(),
        };
        let fields = [("valid", "false"), ("why", &why)];
        let fields: BTreeMap<String, String> = fields
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .into();
        summary.metadata.insert(VERDICT.to_owned(), fields.clone());
        copy.writer.write_metadata(&mcap::records::Metadata {
            name: VERDICT.to_owned(),
            metadata: fields,
        })?;
    }
    copy.writer.finish()?;
    let recovered = Recovered { summary, damage };
    Ok((recovered, copy.writer.into_inner()))
}

/// A copy while it is written. Schemas and channels may get other numbers.
struct Copy<W: Write + Seek> {
    writer: Writer<W>,
    schemas: BTreeMap<u16, u16>,
    channels: BTreeMap<u16, u16>,
}

impl<W: Write + Seek> Copy<W> {
    fn write(&mut self, record: &Record<'_>) -> Result<(), RecoverError> {
        match record {
            Record::Schema { header, data } => {
                let id = self
                    .writer
                    .add_schema(&header.name, &header.encoding, data)?;
                self.schemas.insert(header.id, id);
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).copied().unwrap_or(0);
                let id = self.writer.add_channel(
                    schema,
                    &channel.topic,
                    &channel.message_encoding,
                    &channel.metadata,
                )?;
                self.channels.insert(channel.id, id);
            }
            Record::Message { header, data } => {
                // A message of no channel means nothing to anybody.
                if let Some(channel) = self.channels.get(&header.channel_id) {
                    let header = mcap::records::MessageHeader {
                        channel_id: *channel,
                        ..*header
                    };
                    self.writer.write_to_known_channel(&header, data)?;
                }
            }
            Record::Metadata(metadata) => self.writer.write_metadata(metadata)?,
            Record::Attachment { header, data, .. } => self.writer.attach(&Attachment {
                log_time: header.log_time,
                create_time: header.create_time,
                name: header.name.clone(),
                media_type: header.media_type.clone(),
                data: data.clone(),
            })?,
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::tests::recording;
    use crate::read::{attachment, summary};
    use std::io::Cursor;

    #[test]
    fn what_was_whole_before_the_cut_is_whole_again() {
        let whole = recording(100);
        let cut = &whole[..whole.len() / 2];
        let (before, _) = summary(cut);
        assert!(before.messages() > 0 && before.messages() < 100);
        let (recovered, output) = recover(cut, Cursor::new(Vec::new())).expect("recovered");
        assert!(recovered.damage.is_some());
        let (after, damage) = summary(&output.into_inner()[..]);
        assert!(damage.is_none() && after.has_end, "{damage:?}");
        assert_eq!(after.messages(), before.messages());
        assert_eq!(after.metadata[VERDICT]["valid"], "false");
        assert_eq!(after.metadata, recovered.summary.metadata);
    }

    #[test]
    fn what_is_attached_comes_along() {
        let (_, output) = recover(&recording(9)[..], Cursor::new(Vec::new())).expect("recovered");
        let found = attachment(&output.into_inner()[..], "application/toml", 100);
        let found = found.expect("read").expect("it is there");
        assert_eq!(found, ("a.toml".to_owned(), b"a = 1\n".to_vec()));
    }

    #[test]
    fn what_is_no_recording_is_not_recovered() {
        for junk in [&b""[..], b"not a recording", &mcap::MAGIC[..4]] {
            let error = recover(junk, Cursor::new(Vec::new())).map(|_| ());
            assert!(matches!(error, Err(RecoverError::Read(_))), "{error:?}");
        }
    }
}
