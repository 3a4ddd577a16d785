//! Logs: `tracing` to stderr, one line per event, bounded in size.

use crate::nearest::unknown;
use crate::printable::printable_event;
use std::io::Write;
use std::sync::Mutex;
use tracing_subscriber::Layer as _;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

/// Most that one process logs. [bytes]
pub(crate) const LOG_BYTES_MAX: u64 = 8 << 20;

/// Last line of a log that has become too long.
const LAST_LINE: &[u8] = b"the log is full, nothing more is written\n";

/// A writer that takes everything and passes on `LOG_BYTES_MAX` of it. What cannot be written is
/// dropped: a log must not stop its process. Each write is an event, and becomes one printable line.
#[derive(Debug)]
pub struct Bounded<W> {
    writer: W,
    left: u64,
}

impl<W> Bounded<W> {
    /// Nothing was written yet.
    pub fn new(writer: W) -> Self {
        Self::with_limit(writer, LOG_BYTES_MAX)
    }

    fn with_limit(writer: W, bytes: u64) -> Self {
        Self {
            writer,
            left: bytes,
        }
    }
}

impl<W: Write> Write for Bounded<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        // What is logged may come from other programs, and their files.
        let text = String::from_utf8_lossy(bytes);
        let text = printable_event(&text);
        let len = text.len() as u64;
        if len < self.left {
            self.left -= len;
            let _ = self.writer.write_all(text.as_bytes());
        } else if self.left > 0 {
            self.left = 0;
            let _ = self.writer.write_all(LAST_LINE);
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        let _ = self.writer.flush();
        Ok(())
    }
}

/// Quiets the middleware, whose messages have no other switch.
pub fn quiet_middleware() {
    iceoryx2::prelude::set_log_level(iceoryx2::prelude::LogLevel::Fatal);
}

/// The levels of a log.
const LEVELS: [&str; 6] = ["error", "warn", "info", "debug", "trace", "off"];

/// Accepts a level or a filter directive, such as `warn,zeronav_mapping=debug`. A lone word is a
/// level here, not the name of a module of which everything is wanted.
///
/// # Errors
/// What is wrong with it, in words.
pub fn filter(text: &str) -> Result<String, String> {
    for part in text.split(',').map(str::trim) {
        let lone = !part.contains(['=', ':']);
        if lone && !LEVELS.contains(&part.to_lowercase().as_str()) {
            return Err(unknown("level", part, LEVELS));
        }
    }
    match text.parse::<Targets>() {
        Ok(_) => Ok(text.to_owned()),
        Err(_) => Err("no filter; one reads like `warn,zeronav_mapping=debug`".to_owned()),
    }
}

/// Libraries that log what only their authors read: nothing of them, unless the filter names them.
const LIBRARIES: [&str; 2] = ["rustdds", "ros2_client"];

/// Sends logs to stderr and quiets the middleware to errors.
///
/// `filter` is a level or a filter directive; an unusable one falls back to `info`, aloud.
pub fn start(filter: &str) {
    quiet_middleware();
    let (targets, problem) = match filter.parse::<Targets>() {
        Ok(targets) => (targets, None),
        Err(error) => (
            Targets::new().with_default(tracing::Level::INFO),
            Some(error),
        ),
    };
    let targets = (LIBRARIES.iter())
        .filter(|library| !filter.contains(**library))
        .fold(targets, |targets, library| {
            targets.with_target(*library, LevelFilter::OFF)
        });
    // A second call in one process (tests) keeps the first subscriber, which is what is wanted.
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(Mutex::new(Bounded::new(std::io::stderr())))
        .with_ansi(false)
        .log_internal_errors(false);
    let _ = tracing_subscriber::registry()
        .with(lines.with_filter(targets))
        .try_init();
    if let Some(error) = problem {
        tracing::warn!(filter, %error, "unusable log filter, using info");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_and_filters_are_told_from_other_words() {
        for good in [
            "info",
            "WARN",
            "warn,zeronav_mapping=debug",
            "off",
            "a::b=trace",
        ] {
            assert_eq!(filter(good), Ok(good.to_owned()));
        }
        assert_eq!(
            filter("inf"),
            Err("there is no level `inf`, did you mean `info`?".to_owned())
        );
        for bad in ["nonsense", "", "warn,nonsense", "a=loud", "info,,warn"] {
            assert!(filter(bad).is_err(), "{bad:?} was accepted");
        }
    }

    #[test]
    fn a_log_ends_at_its_limit_with_a_line_that_says_so() {
        let mut log = Bounded::with_limit(Vec::new(), 100);
        for _ in 0..1000 {
            assert_eq!(log.write(b"thirty bytes of a log's lines\n").ok(), Some(30));
        }
        let text = String::from_utf8(log.writer).expect("text");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4, "{text}");
        assert_eq!(lines[3].as_bytes(), &LAST_LINE[..LAST_LINE.len() - 1]);
    }

    #[test]
    fn what_a_terminal_obeys_is_written_out() {
        let mut log = Bounded::new(Vec::new());
        let _ = log.write(b"a \x1b[2J\nb\n");
        assert_eq!(log.writer, b"a \\u{1b}[2J\\nb\n");
    }

    #[test]
    fn a_full_disk_is_no_error_of_the_log() {
        let full = std::fs::File::options().write(true).open("/dev/full");
        let mut log = Bounded::new(full.expect("/dev/full"));
        assert!(writeln!(log, "a line").is_ok());
    }
}
