//! `zeronav topics`: a look into a run, by a guest that only reads.

pub mod cli;
mod message;
mod rate;
mod table;
pub(crate) mod tap;
mod user;
mod value;
mod watches;

use cli::{TopicArgs, TopicsArgs, TopicsVerb};
use std::process::ExitCode;
use tap::{End, Tap};
use watches::{Echo, Meter, Unit, Wanted};
use zeronav_console::exit::{EXIT_FAIL, EXIT_INTERRUPTED, EXIT_PASS};
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{complain, note, usage};

/// `zeronav topics`.
#[must_use]
pub fn topics(arguments: &TopicsArgs) -> ExitCode {
    match run(arguments) {
        Ok(code) => ExitCode::from(code),
        Err(problem) => usage(&problem),
    }
}

fn run(arguments: &TopicsArgs) -> Result<u8, String> {
    let tap = Tap::join(arguments.stack.domain.as_deref())?;
    let json = arguments.stack.json;
    match &arguments.verb {
        None => {
            let listed = table::list(&tap, json);
            tap.leave();
            listed.map(|()| EXIT_PASS)
        }
        Some(TopicsVerb::Echo(topic)) => {
            let mut echo = Echo::new(json, Wanted::new(topic.number));
            let end = tap.listen(&topic.topic, &mut echo, &interrupts()?)?;
            Ok(exit_code(end, echo.wanted, topic))
        }
        Some(TopicsVerb::Hz(topic)) => meter(tap, Unit::Hz, topic, json),
        Some(TopicsVerb::Bw(topic)) => meter(tap, Unit::Bytes, topic, json),
    }
}

fn meter(tap: Tap, unit: Unit, topic: &TopicArgs, json: bool) -> Result<u8, String> {
    let mut meter = Meter::new(unit, &topic.topic, json, Wanted::new(topic.number));
    let end = tap.listen(&topic.topic, &mut meter, &interrupts()?)?;
    meter.finish();
    Ok(exit_code(end, meter.wanted, topic))
}

fn exit_code(end: End, wanted: Wanted, topic: &TopicArgs) -> u8 {
    match end {
        End::Enough => EXIT_PASS,
        End::Interrupted => EXIT_INTERRUPTED,
        End::RunOver if wanted.is_missed() => {
            complain(&format!(
                "the run has ended before so many messages came on {}",
                topic.topic
            ));
            EXIT_FAIL
        }
        End::RunOver => {
            note("the run has ended");
            EXIT_PASS
        }
    }
}
