//! The messages of the contract in a recording, each with what its channel says of its bytes.

use crate::layout::{Layout, LayoutError};
use crate::native::PREFIX;
use crate::read::{ReadError, records};
use crate::verdict::{END_TICK, VERDICT};
use mcap::records::Record;
use std::collections::BTreeMap;
use std::io::Read;

/// Most messages of a recording that are looked at: ten hours of all topics. Who compares keeps about 150 bytes of
/// each.
const MESSAGES_MAX: usize = 20_000_000;

/// Most topics of the contract, and the longest of their names. [bytes]
const CHANNELS_MAX: usize = 256;
const NAME_BYTES_MAX: usize = 256;

/// Why the messages of a recording cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum MessagesError {
    /// It is damaged.
    #[error("{0}")]
    Read(#[from] ReadError),
    /// It does not say what is in it.
    #[error("{0}")]
    Layout(#[from] LayoutError),
    /// It is too long.
    #[error("it has more than {MESSAGES_MAX} messages of the contract")]
    TooLong,
    /// It has more channels than any contract.
    #[error("it has two channels of one topic, or more than {CHANNELS_MAX} topics of the contract")]
    Channels,
    /// It was made by something else.
    #[error("it holds no messages of the contract: zeronav-recorder has not written it")]
    Foreign,
}

/// Shows the messages of the topics that are wanted: name of the topic, layout, header with fixed fields, and
/// items. One that is shorter than it can be is left out. The tick with which the run ended, if the recording says
/// it.
///
/// # Errors
/// See [`MessagesError`]; what was read before has been shown.
pub fn native_messages(
    input: impl Read,
    wants: impl Fn(&str) -> bool,
    mut see: impl FnMut(&str, &Layout, [&[u8]; 2]),
) -> Result<Option<u64>, MessagesError> {
    let mut end_tick = None;
    let mut channels: BTreeMap<u16, (String, Layout)> = BTreeMap::new();
    let mut is_ours = false;
    let mut n = 0;
    records(input, |record| {
        match record {
            Record::Channel(channel) => {
                if let Some(name) = channel.topic.strip_prefix(PREFIX) {
                    is_ours = true;
                    if wants(name) && !channels.contains_key(&channel.id) {
                        let is_known = channels.values().any(|(known, _)| known == name);
                        if is_known || channels.len() >= CHANNELS_MAX || name.len() > NAME_BYTES_MAX
                        {
                            return Err(MessagesError::Channels);
                        }
                        let layout = Layout::of(&channel.topic, &channel.metadata)?;
                        channels.insert(channel.id, (name.to_owned(), layout));
                    }
                }
            }
            Record::Message { header, data } => {
                if let Some((name, layout)) = channels.get(&header.channel_id)
                    && let Some((envelope, items)) = layout.parts(data)
                {
                    n += 1;
                    if n > MESSAGES_MAX {
                        return Err(MessagesError::TooLong);
                    }
                    see(name, layout, [envelope, items]);
                }
            }
            Record::Metadata(metadata) if metadata.name == VERDICT => {
                let tick = metadata.metadata.get(END_TICK);
                end_tick = tick.and_then(|tick| tick.parse().ok());
            }
            _ => {}
        }
        Ok(())
    })?;
    if is_ours {
        Ok(end_tick)
    } else {
        Err(MessagesError::Foreign)
    }
}
