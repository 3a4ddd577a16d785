//! What is in a recording, from its bytes. Whatever these are, there is an answer or an error with the
//! place of the damage, in bounded memory.

use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::BTreeMap;
use std::io::Read;

/// Largest record that is read; the keyframe of the largest map has 68 MB. [bytes]
const RECORD_BYTES_MAX: usize = 256 << 20;

/// Why a file cannot be read any further.
#[derive(Debug, thiserror::Error)]
#[error("byte {offset}: {why}")]
pub struct ReadError {
    /// About where. [bytes] from the beginning
    pub offset: u64,
    /// What is wrong there.
    pub why: String,
}

/// A channel and what is on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelSummary {
    /// Its name.
    pub topic: String,
    /// Name of the type of its messages; empty without one.
    pub schema: String,
    /// Encoding of its messages.
    pub encoding: String,
    /// Its messages.
    pub messages: u64,
    /// Metadata of the channel.
    pub metadata: BTreeMap<String, String>,
}

/// What is in a file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Summary {
    /// The program that has written it.
    pub library: String,
    /// Its conventions.
    pub profile: String,
    /// Channels by their number.
    pub channels: BTreeMap<u16, ChannelSummary>,
    /// Metadata records by name; the last one of each.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// The first and the last moment that a message is about. [ns]
    pub range_ns: Option<[u64; 2]>,
    /// True when the file has its end: it is not cut.
    pub has_end: bool,
}

impl Summary {
    /// All messages.
    #[must_use]
    pub fn messages(&self) -> u64 {
        self.channels.values().map(|channel| channel.messages).sum()
    }

    /// Takes in a record.
    pub(crate) fn note(&mut self, record: &Record<'_>, schemas: &mut BTreeMap<u16, String>) {
        match record {
            Record::Header(header) => {
                self.library.clone_from(&header.library);
                self.profile.clone_from(&header.profile);
            }
            Record::Schema { header, .. } => {
                schemas.insert(header.id, header.name.clone());
            }
            Record::Channel(channel) => {
                let schema = schemas.get(&channel.schema_id);
                self.channels
                    .entry(channel.id)
                    .or_insert_with(|| ChannelSummary {
                        topic: channel.topic.clone(),
                        schema: schema.cloned().unwrap_or_default(),
                        encoding: channel.message_encoding.clone(),
                        messages: 0,
                        metadata: channel.metadata.clone(),
                    });
            }
            Record::Message { header, .. } => {
                if let Some(channel) = self.channels.get_mut(&header.channel_id) {
                    channel.messages += 1;
                }
                let ns = header.log_time;
                let [first_ns, last_ns] = self.range_ns.unwrap_or([ns; 2]);
                self.range_ns = Some([first_ns.min(ns), last_ns.max(ns)]);
            }
            Record::Metadata(metadata) => {
                let (name, fields) = (metadata.name.clone(), metadata.metadata.clone());
                self.metadata.insert(name, fields);
            }
            Record::DataEnd(_) => self.has_end = true,
            _ => {}
        }
    }
}

/// Shows the records of a file to `see`, those in chunks only when their chunk is whole, up to the end of
/// its data or the first damage. The end itself is shown, what repeats behind it is not.
///
/// # Errors
/// The damage, or the first error of `see`.
pub fn records<E: From<ReadError>>(
    mut input: impl Read,
    mut see: impl FnMut(&Record<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let options = LinearReaderOptions::default()
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(RECORD_BYTES_MAX);
    let mut reader = LinearReader::new_with_options(options);
    let mut offset = 0;
    let damaged = |offset: u64, why: &dyn core::fmt::Display| {
        E::from(ReadError {
            offset,
            why: why.to_string(),
        })
    };
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(need)) => {
                let n = input
                    .read(reader.insert(need))
                    .map_err(|error| damaged(offset, &error))?;
                reader.notify_read(n);
                offset += n as u64;
            }
            Ok(LinearReadEvent::Record { opcode, data }) => {
                if opcode == op::MESSAGE_INDEX {
                    continue;
                }
                let record =
                    mcap::parse_record(opcode, data).map_err(|error| damaged(offset, &error))?;
                see(&record)?;
                if matches!(record, Record::DataEnd(_)) {
                    return Ok(());
                }
            }
            Err(error) => return Err(damaged(offset, &error)),
        }
    }
    Err(damaged(offset, &"the file ends in the middle"))
}

/// Name and bytes of the first file of this type that lies in a recording, if one does; one larger than
/// `bytes_max` counts as damage.
///
/// # Errors
/// The damage before it.
pub fn attachment(
    input: impl Read,
    media_type: &str,
    bytes_max: usize,
) -> Result<Option<(String, Vec<u8>)>, ReadError> {
    let mut found = None;
    let read = records(input, |record| match record {
        Record::Attachment { header, data, .. } if header.media_type == media_type => {
            if data.len() > bytes_max {
                let why = format!("{} in it has more than {bytes_max} bytes", header.name);
                return Err(Stop::Damage(ReadError { offset: 0, why }));
            }
            found = Some((header.name.clone(), data.to_vec()));
            Err(Stop::Found)
        }
        _ => Ok(()),
    });
    match read {
        Err(Stop::Damage(damage)) => Err(damage),
        Err(Stop::Found) | Ok(()) => Ok(found),
    }
}

/// Why a file is not read to its end.
enum Stop {
    Found,
    Damage(ReadError),
}

impl From<ReadError> for Stop {
    fn from(damage: ReadError) -> Self {
        Self::Damage(damage)
    }
}

/// What is in a file up to its end or the first damage, and which that is.
pub fn summary(input: impl Read) -> (Summary, Option<ReadError>) {
    let mut summary = Summary::default();
    let mut schemas = BTreeMap::new();
    let damage = records(input, |record| {
        summary.note(record, &mut schemas);
        Ok::<(), ReadError>(())
    });
    (summary, damage.err())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::tests::recording;
    use proptest::prelude::*;

    #[test]
    fn a_whole_file_is_summed_up() {
        let (summary, damage) = summary(&recording(100)[..]);
        assert!(damage.is_none(), "{damage:?}");
        assert!(summary.has_end);
        assert_eq!(summary.messages(), 100);
        assert_eq!(summary.range_ns, Some([1_000, 1_099]));
        assert_eq!(summary.profile, "ros2");
        assert_eq!(summary.metadata["end"]["valid"], "true");
        let channel = summary.channels.values().next().expect("a channel");
        assert_eq!((&*channel.topic, &*channel.schema), ("/a", "a/msg/A"));
    }

    #[test]
    fn what_is_attached_is_found_by_its_type() {
        const TYPE: &str = "application/toml";
        let whole = recording(100);
        let found = |media_type: &str, bytes_max| attachment(&whole[..], media_type, bytes_max);
        let file = ("a.toml".to_owned(), b"a = 1\n".to_vec());
        assert_eq!(found(TYPE, 6).expect("read"), Some(file));
        assert_eq!(found("text/plain", 6).expect("read"), None);
        assert!(found(TYPE, 5).is_err(), "too large");
        let cut = attachment(&whole[..whole.len() / 20], TYPE, 6);
        assert!(cut.is_err(), "cut before it");
    }

    #[test]
    fn a_cut_file_is_read_up_to_its_last_whole_chunk() {
        let whole = recording(100);
        let mut seen = 0;
        for len in (0..whole.len()).step_by(97) {
            let (summary, damage) = summary(&whole[..len]);
            let messages = summary.messages();
            assert!(messages >= seen || damage.is_some());
            // Ten messages lie in each chunk.
            assert_eq!(messages % 10, 0, "cut after {len} bytes");
            seen = seen.max(messages);
            if !summary.has_end {
                let damage = damage.expect("a reason");
                assert!(damage.offset <= len as u64, "{damage}");
            }
        }
        assert_eq!(seen, 100);
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(
            at in 0_usize..6_000, bit in 0_u8..8, len in 0_usize..6_000, junk: [u8; 9],
        ) {
            let mut bytes = recording(60);
            let n = bytes.len();
            bytes[at % n] ^= 1 << bit;
            let _ = summary(&bytes[..]);
            for (to, from) in bytes[at % n..].iter_mut().zip(junk) {
                *to = from;
            }
            let _ = summary(&bytes[..len.min(n)]);
            let _ = summary(&junk[..]);
        }
    }
}
