//! What is sent from link to link: messages of topics, rings, and a beat that says how things stand.
//!
//! A frame begins with its kind (one byte), its sender and its number (8 bytes each, little-endian; numbers count from 1):
//! frames of one sender that are lost on the way are counted by the gaps, and a link that was started again is another sender.

use serde::{Deserialize, Serialize};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::EVENT_MAX;
use zeronav_shell::remote_seats::{Held, Wanted};

const MESSAGE: u8 = 1;
const RING: u8 = 2;
const BEAT: u8 = 3;

/// Kind, sender and number.
const HEAD_BYTES: usize = 17;

/// Which frame of which sender it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Origin {
    /// A number that no other start of a link has.
    pub sender: u64,
    /// Its place among the frames of that sender, from 1.
    pub number: u64,
}

/// Longest beat. [bytes]
const BEAT_BYTES_MAX: usize = 32 * 1024;

/// How things stand on a host. Sent several times a second, and whenever something has changed.
/// A field that another version has more is ignored: what it was built from is judged by `contract`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Beat {
    /// Hash of all topics' schemas: both hosts must be built from the same contract.
    pub contract: u64,
    /// Name of the host.
    pub host: String,
    /// Name of its domain: another one after a new start of the host, the same after one of its link. That of the host of
    /// launch is the name of the run.
    pub instance: String,
    /// The receiver's instance that it hears; empty before it has heard any.
    pub hears: String,
    /// Hash of the scenario, as text.
    pub scenario: String,
    /// True in the last beat of a link that was asked to end.
    pub leaving: bool,
    /// True once the sender knows by how much the clocks differ: it accepts messages from then on.
    pub synchronised: bool,
    /// [ns] of the sender's clock, when it was sent.
    pub sent_ns: u64,
    /// [ns] `sent_ns` of the newest beat that came from the receiver; 0 = none.
    pub echo_sent_ns: u64,
    /// [ns] of the sender's clock, when that one came.
    pub echo_received_ns: u64,
    /// Bits of the numbers of the topics that somebody reads here.
    pub reads: u64,
    /// Frames from the receiver that were lost on the way.
    pub lost: u64,
    /// Seats that are to be filled by the receiver.
    pub wanted: Vec<Wanted>,
    /// Seats of the receiver's that are filled here, or were.
    pub held: Vec<Held>,
}

/// One frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Frame<'a> {
    /// A message of a topic, as it lay in shared memory.
    Message {
        /// Number of the topic.
        topic: u8,
        /// Header and fixed fields; of a record nothing.
        envelope: &'a [u8],
        /// The slice.
        items: &'a [u8],
    },
    /// Somebody rang for a role that is on the other host.
    Ring {
        /// Whose doorbell.
        role: Role,
        /// The event's number.
        event: u8,
    },
    /// How things stand.
    Beat(Box<Beat>),
}

/// Why bytes are no frame.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Malformed {
    /// They end too early, or are longer than any of their kind.
    #[error("{0} bytes are no frame")]
    Length(usize),
    /// A kind, role or event without a meaning.
    #[error("unknown {0}")]
    Unknown(&'static str),
    /// The text of a beat.
    #[error("beat: {0}")]
    Beat(String),
}

impl Frame<'_> {
    /// The bytes of this frame.
    #[must_use]
    pub fn encode(&self, origin: Origin) -> Vec<u8> {
        let head = |kind: u8, len: usize| {
            let mut bytes = Vec::with_capacity(HEAD_BYTES + len);
            bytes.push(kind);
            bytes.extend_from_slice(&origin.sender.to_le_bytes());
            bytes.extend_from_slice(&origin.number.to_le_bytes());
            bytes
        };
        match self {
            Self::Message {
                topic,
                envelope,
                items,
            } => {
                let mut bytes = head(MESSAGE, 5 + envelope.len() + items.len());
                bytes.push(*topic);
                let len = u32::try_from(envelope.len()).unwrap_or(u32::MAX);
                bytes.extend_from_slice(&len.to_le_bytes());
                bytes.extend_from_slice(envelope);
                bytes.extend_from_slice(items);
                bytes
            }
            Self::Ring { role, event } => {
                let mut bytes = head(RING, 3);
                bytes.extend_from_slice(&role.code().to_le_bytes());
                bytes.push(*event);
                bytes
            }
            Self::Beat(beat) => {
                let text = serde_json::to_vec(beat).unwrap_or_default();
                let mut bytes = head(BEAT, text.len());
                bytes.extend_from_slice(&text);
                bytes
            }
        }
    }
}

/// Origin and content of a frame.
///
/// # Errors
/// [`Malformed`].
pub fn decode(bytes: &[u8]) -> Result<(Origin, Frame<'_>), Malformed> {
    let short = || Malformed::Length(bytes.len());
    let (head, rest) = bytes.split_at_checked(HEAD_BYTES).ok_or_else(short)?;
    let number = |at: usize| -> Result<u64, Malformed> {
        let bytes = head[at..at + 8].try_into().map_err(|_| short())?;
        Ok(u64::from_le_bytes(bytes))
    };
    let origin = Origin {
        sender: number(1)?,
        number: number(9)?,
    };
    let frame = match head[0] {
        MESSAGE => {
            let (head, rest) = rest.split_at_checked(5).ok_or_else(short)?;
            let len = u32::from_le_bytes(head[1..].try_into().map_err(|_| short())?);
            let len = usize::try_from(len).map_err(|_| short())?;
            let (envelope, items) = rest.split_at_checked(len).ok_or_else(short)?;
            Frame::Message {
                topic: head[0],
                envelope,
                items,
            }
        }
        RING => {
            let [low, high, event] = *rest else {
                return Err(short());
            };
            let role = Role::from_code(u16::from_le_bytes([low, high]))
                .filter(|role| Role::SERVICES.contains(role))
                .ok_or(Malformed::Unknown("role"))?;
            if usize::from(event) > EVENT_MAX {
                return Err(Malformed::Unknown("event"));
            }
            Frame::Ring { role, event }
        }
        BEAT if rest.len() > BEAT_BYTES_MAX => return Err(short()),
        BEAT => {
            let beat = serde_json::from_slice(rest);
            Frame::Beat(beat.map_err(|error| Malformed::Beat(error.to_string()))?)
        }
        _ => return Err(Malformed::Unknown("kind")),
    };
    Ok((origin, frame))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use zeronav_shell::remote_seats::{Program, SeatStart};

    const ORIGIN: Origin = Origin {
        sender: 9,
        number: u64::MAX,
    };

    proptest! {
        #[test]
        fn foreign_bytes_are_a_frame_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = decode(&bytes);
        }

        #[test]
        fn a_message_comes_back_as_it_was(
            sender in any::<u64>(),
            number in any::<u64>(),
            topic in any::<u8>(),
            envelope in prop::collection::vec(any::<u8>(), 0..300),
            items in prop::collection::vec(any::<u8>(), 0..300),
        ) {
            let frame = Frame::Message { topic, envelope: &envelope, items: &items };
            let origin = Origin { sender, number };
            let bytes = frame.encode(origin);
            prop_assert_eq!(decode(&bytes), Ok((origin, frame)));
        }
    }

    #[test]
    fn rings_and_beats_come_back_as_they_were() {
        let ring = Frame::Ring {
            role: Role::Mapping,
            event: 40,
        };
        let bytes = ring.encode(ORIGIN);
        assert_eq!(decode(&bytes), Ok((ORIGIN, ring)));
        let seat = SeatStart {
            role: Role::Mapping.code(),
            epoch: 2,
        };
        let beat = Frame::Beat(Box::new(Beat {
            host: "base".to_owned(),
            reads: u64::MAX,
            held: vec![Held {
                seat,
                ended: Some(137),
                why: "killed".to_owned(),
            }],
            wanted: vec![Wanted {
                seat,
                program: Program {
                    binary: "zeronav-mapping".to_owned(),
                    keys: "x = 1".to_owned(),
                },
            }],
            ..Beat::default()
        }));
        let bytes = beat.encode(ORIGIN);
        assert_eq!(decode(&bytes), Ok((ORIGIN, beat)));
    }

    #[test]
    fn what_no_link_sends_is_named() {
        let ring = |role: u16, event: u8| {
            let mut bytes = Frame::Ring {
                role: Role::Robot,
                event,
            }
            .encode(ORIGIN);
            bytes[HEAD_BYTES..HEAD_BYTES + 2].copy_from_slice(&role.to_le_bytes());
            decode(&bytes).map(|_| ())
        };
        assert_eq!(ring(2, 63), Ok(()));
        assert_eq!(ring(2, 64), Err(Malformed::Unknown("event")));
        // Launch has no doorbell.
        assert_eq!(ring(1, 3), Err(Malformed::Unknown("role")));
        assert_eq!(decode(&[9; HEAD_BYTES]), Err(Malformed::Unknown("kind")));
        assert_eq!(decode(&[MESSAGE; 8]), Err(Malformed::Length(8)));
        let mut beat = vec![BEAT; HEAD_BYTES];
        beat.extend_from_slice(br#"{"contract": 1}"#);
        assert!(matches!(decode(&beat), Err(Malformed::Beat(_))));
    }
}
