//! The supervisor's own log: warnings on standard error beside the progress line, and from `info`
//! on everything in the run's `logs/launch.log`.

use std::fs::File;
use std::io::Write;
use std::sync::{Mutex, PoisonError};
use tracing_subscriber::Layer;
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::fmt::MakeWriter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use zeronav_console::terminal::beside_the_line;
use zeronav_files::Folder;
use zeronav_shell::logs::Bounded;
use zeronav_shell::printable::printable_event;

/// The log of the run that goes on.
static RUN: Mutex<Option<Bounded<File>>> = Mutex::new(None);

/// Standard error, past the progress line.
#[derive(Debug, Clone, Copy)]
struct Terminal;

/// The log of the run, while there is one.
#[derive(Debug, Clone, Copy)]
struct RunLog;

/// Sends the events of this process to both.
pub fn start() {
    zeronav_shell::logs::quiet_middleware();
    let terminal = tracing_subscriber::fmt::layer()
        .with_writer(Terminal)
        .with_ansi(false)
        .log_internal_errors(false)
        .with_filter(LevelFilter::WARN);
    let run = tracing_subscriber::fmt::layer()
        .with_writer(RunLog)
        .with_ansi(false)
        .log_internal_errors(false)
        .with_filter(LevelFilter::INFO);
    // A second call in one process (tests) keeps the first subscriber.
    let _ = tracing_subscriber::registry()
        .with(terminal)
        .with(run)
        .try_init();
}

/// From now on events go to `launch.log` in this folder, too.
///
/// # Errors
/// What the file system says.
pub fn open(logs: &Folder) -> std::io::Result<()> {
    let log = Bounded::new(logs.append("launch.log")?);
    *RUN.lock().unwrap_or_else(PoisonError::into_inner) = Some(log);
    Ok(())
}

impl<'a> MakeWriter<'a> for Terminal {
    type Writer = Self;

    fn make_writer(&'a self) -> Self {
        *self
    }
}

impl Write for Terminal {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let text = String::from_utf8_lossy(bytes);
        let text = printable_event(&text);
        beside_the_line(|| std::io::stderr().write_all(text.as_bytes()))?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl<'a> MakeWriter<'a> for RunLog {
    type Writer = Self;

    fn make_writer(&'a self) -> Self {
        *self
    }
}

impl Write for RunLog {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let mut log = RUN.lock().unwrap_or_else(PoisonError::into_inner);
        log.as_mut().map_or(Ok(bytes.len()), |log| log.write(bytes))
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
