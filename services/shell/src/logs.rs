//! Logs: `tracing` to stderr, one line per event.

use crate::nearest::unknown;
use tracing_subscriber::EnvFilter;

/// The levels of a log.
const LEVELS: [&str; 6] = ["error", "warn", "info", "debug", "trace", "off"];

/// Accepts a level or a filter directive, such as `warn,zeronav_mapping=debug`. A lone word is a
/// level here, not the name of a module of which everything is wanted.
///
/// # Errors
/// What is wrong with it, in words.
pub fn filter(text: &str) -> Result<String, String> {
    for part in text.split(',').map(str::trim) {
        let lone = !part.contains(['=', '[', ':']);
        if lone && !LEVELS.contains(&part.to_lowercase().as_str()) {
            return Err(unknown("level", part, LEVELS));
        }
    }
    match EnvFilter::try_new(text) {
        Ok(_) => Ok(text.to_owned()),
        Err(_) => Err("no filter; one reads like `warn,zeronav_mapping=debug`".to_owned()),
    }
}

/// Sends logs to stderr and quiets the middleware to errors.
///
/// `filter` is a level or a filter directive; an unusable one falls back to `info`, aloud.
pub fn start(filter: &str) {
    iceoryx2::prelude::set_log_level(iceoryx2::prelude::LogLevel::Fatal);
    let (directives, problem) = match EnvFilter::try_new(filter) {
        Ok(directives) => (directives, None),
        Err(error) => (EnvFilter::new("info"), Some(error)),
    };
    // A second call in one process (tests) keeps the first subscriber, which is what is wanted.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(directives)
        .with_writer(std::io::stderr)
        .with_ansi(false)
        .try_init();
    if let Some(error) = problem {
        tracing::warn!(filter, %error, "unusable log filter, using info");
    }
}

#[cfg(test)]
mod tests {
    use super::filter;

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
}
