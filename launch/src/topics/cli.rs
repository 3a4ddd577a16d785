//! The arguments of `zeronav topics`.

use crate::remote::cli::StackArgs;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, Args, Command, Error, Subcommand};
use std::ffi::OsStr;
use std::num::NonZeroU64;
use zeronav_msgs::topics::topics;
use zeronav_msgs::user;

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
    /// Name of the topic (see `zeronav topics`), also of one of a user's own.
    #[arg(value_parser = TopicName, hide_possible_values = true)]
    pub topic: String,
    /// End after N messages.
    #[arg(short, long, value_name = "N")]
    pub number: Option<NonZeroU64>,
}

/// A topic of the contract, or one that a user may have made.
#[derive(Debug, Clone, Copy)]
struct TopicName;

impl TypedValueParser for TopicName {
    type Value = String;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<String, Error> {
        match value.to_str().filter(|name| user::name_in(name).is_some()) {
            Some(name) => Ok(name.to_owned()),
            None => PossibleValuesParser::new(names()).parse_ref(command, argument, value),
        }
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(names().map(PossibleValue::new)))
    }
}

fn names() -> impl Iterator<Item = &'static str> {
    topics().into_iter().map(|row| row.name)
}
