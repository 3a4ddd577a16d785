//! Logs: `tracing` to stderr, one line per event.

use tracing_subscriber::EnvFilter;

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
