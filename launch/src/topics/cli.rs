//! The arguments of `zeronav topics`.

use crate::remote::cli::StackArgs;
use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand};
use std::num::NonZeroU64;
use zeronav_msgs::topics::topics;

/// Arguments of `zeronav topics`.
#[derive(Debug, Clone, Args)]
pub struct TopicsArgs {
    /// What to do; without, list the topics.
    #[command(subcommand)]
    pub verb: Option<TopicsVerb>,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// What `zeronav topics` does with one topic.
#[derive(Debug, Clone, Subcommand)]
pub enum TopicsVerb {
    /// How many messages a second are sent, and their periods, every second.
    Hz(TopicArgs),
    /// How many bytes a second are sent, every second.
    Bw(TopicArgs),
    /// Every message as it comes, each field with its unit.
    Echo(TopicArgs),
}

/// The topic, and when it is enough.
#[derive(Debug, Clone, Args)]
pub struct TopicArgs {
    /// Name of the topic (see `zeronav topics`).
    #[arg(value_parser = PossibleValuesParser::new(topics().iter().map(|row| row.name)),
          hide_possible_values = true)]
    pub topic: String,
    /// End after N messages.
    #[arg(short, long, value_name = "N")]
    pub number: Option<NonZeroU64>,
}
