//! The messages of the contract in a recording, each with what its channel says of its bytes.

use crate::layout::{Layout, LayoutError};
use crate::native::PREFIX;
use crate::read::{ReadError, records};
use crate::verdict::{END_TICK, OUTCOME, OUTCOME_INTERRUPTED, VALID, VERDICT, WHY};
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

/// What a recording says of its end.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Conclusion {
    /// The tick with which the run ended, where the recording says it.
    pub end_tick: Option<u64>,
    /// Why it is not the whole of a run that came to its end; none when it is.
    pub incomplete: Option<String>,
    /// The fields of its verdict.
    pub verdict: BTreeMap<String, String>,
}

impl Conclusion {
    /// By the fields of the verdict, of which a recording that was cut has none.
    fn of(verdict: Option<&BTreeMap<String, String>>) -> Self {
        let field = |name: &str| verdict.and_then(|fields| fields.get(name));
        let end_tick = field(END_TICK).and_then(|tick| tick.parse().ok());
        let is_valid = field(VALID).is_some_and(|valid| valid == "true");
        let missing = || field(WHY).cloned().unwrap_or_default();
        let incomplete = if verdict.is_none() {
            Some("its recorder ended before it could say whether anything is missing".to_owned())
        } else if !is_valid {
            Some(missing())
        } else if end_tick.is_none() {
            Some("the recorder, or launch, ended before the run did".to_owned())
        } else if field(OUTCOME).is_some_and(|outcome| outcome == OUTCOME_INTERRUPTED) {
            Some("the run was interrupted".to_owned())
        } else {
            None
        };
        Self {
            end_tick,
            incomplete,
            verdict: verdict.cloned().unwrap_or_default(),
        }
    }

    /// Why the messages of these topics are not all there; none when they are, whatever else is missing.
    #[must_use]
    pub fn incomplete_of(&self, topics: &[&str]) -> Option<String> {
        if self.incomplete.is_none() || self.verdict.is_empty() {
            return self.incomplete.clone();
        }
        let lost = |topic: &&str| {
            let number = |name: &str| {
                let text = self.verdict.get(&format!("{topic}.{name}"))?;
                text.parse::<u64>().ok()
            };
            let n = number("missed").unwrap_or(0) + number("before_first").unwrap_or(0);
            (n > 0).then(|| format!("{topic}: {n} messages are missing"))
        };
        let lost: Vec<String> = topics.iter().filter_map(lost).collect();
        (!lost.is_empty()).then(|| lost.join("; "))
    }
}

/// Shows the messages of the topics that are wanted: name of the topic, layout, header with fixed fields, and
/// items. One that is shorter than it can be is left out. What the recording says of its end.
///
/// # Errors
/// See [`MessagesError`]; what was read before has been shown.
pub fn native_messages(
    input: impl Read,
    wants: impl Fn(&str) -> bool,
    mut see: impl FnMut(&str, &Layout, [&[u8]; 2]),
) -> Result<Conclusion, MessagesError> {
    let mut verdict = None;
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
                verdict = Some(metadata.metadata.clone());
            }
            _ => {}
        }
        Ok(())
    })?;
    if is_ours {
        Ok(Conclusion::of(verdict.as_ref()))
    } else {
        Err(MessagesError::Foreign)
    }
}
