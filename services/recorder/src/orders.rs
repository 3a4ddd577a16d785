//! What the two threads of a recorder say to each other, and what they know of the file.

use crate::native::NativeTopic;
use crate::taps::Message;
use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, AtomicUsize};
use zeronav_ros_messages::RosTopic;
use zeronav_ros_messages::times::TimeBase;

/// Why a file cannot be written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum WriteError {
    /// The system, or the file's format.
    #[error("{}", in_words(.0))]
    File(#[from] mcap::McapError),
    /// The system.
    #[error("{0}")]
    System(#[from] std::io::Error),
    /// A message that has no form in CDR.
    #[error("a message has no form in CDR: {0}")]
    Cdr(#[from] zeronav_ros_messages::CdrError),
    /// The thread is gone.
    #[error("the writing thread has ended unexpectedly")]
    Ended,
}

/// What is wrong with a file: what the system says of it, where it is the system.
pub(crate) fn in_words(error: &mcap::McapError) -> String {
    match error {
        mcap::McapError::Io(error) => error.to_string(),
        error => error.to_string(),
    }
}

/// What the reading thread tells the writing one.
pub(crate) enum Order {
    /// A topic that was found while the run went on: behind all others.
    Topic(NativeTopic),
    /// Messages that were read together.
    Write(VecDeque<Message>),
    /// The end of the file, with the fields of its verdict.
    Finish(BTreeMap<String, String>),
}

/// What both threads look at.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    /// What waits to be written. [bytes]
    pub queued_bytes: AtomicUsize,
    /// The map can only be shown with a keyframe.
    pub needs_keyframe: AtomicBool,
    /// A writer that gives way hands over.
    pub hurry: AtomicBool,
}

/// What of the layer for the world is in a file.
#[derive(Debug)]
pub(crate) struct World {
    /// Messages by topic.
    pub messages: BTreeMap<RosTopic, u64>,
    /// The first and the last moment that they are about. [ns]
    pub range_ns: [u64; 2],
}

/// Parameters by service or companion, and by their path.
pub(crate) type Parameters = BTreeMap<String, BTreeMap<String, String>>;

/// What a recording says of itself at its beginning.
#[derive(Debug, Clone, Default)]
pub(crate) struct Start {
    pub times: TimeBase,
    /// `real_time` or `lockstep`.
    pub mode: &'static str,
    pub seed: u64,
    pub tick_ns: u64,
    /// Name and text of the scenario that is driven, if that is known.
    pub scenario: Option<(String, String)>,
    /// What services and companions are started with: for each, its parameters by their path.
    pub parameters: Parameters,
    /// Who decides where the robot drives, if that is known.
    pub driven_by: Option<String>,
}
