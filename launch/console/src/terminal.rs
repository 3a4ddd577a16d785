//! Standard output and standard error. Either may be full, closed, or a terminal with a progress
//! line on it; writing to them never panics.

use crate::exit::{EXIT_OUTPUT, EXIT_USAGE};
use indicatif::ProgressBar;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::io::{BufWriter, ErrorKind, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use zeronav_shell::printable::{printable_json, printable_lines};

/// Something of the result was lost.
static LOST: AtomicBool = AtomicBool::new(false);

/// The progress line that is on the terminal.
static LINE: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Writes to standard output what the user asked for. A reader that has seen enough (`| head`) is
/// no error; whatever else keeps the text from being written ends the command with
/// [`EXIT_OUTPUT`].
pub fn say(text: &str) {
    let _ = pour(|to| to.write_all(printable_lines(text).as_bytes()));
}

/// [`say`] for text that is made while it is written; false when no more can be written.
pub fn pour(write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> bool {
    let mut output = BufWriter::new(std::io::stdout().lock());
    match write(&mut output).and_then(|()| output.flush()) {
        Ok(()) => true,
        Err(error) => {
            // What is left in the buffer must not be tried again.
            let _ = output.into_parts();
            if error.kind() != ErrorKind::BrokenPipe {
                lose(&format!("writing to standard output: {error}"));
            }
            false
        }
    }
}

/// False when standard output is a pipe whose reader is gone.
#[must_use]
pub fn is_read() -> bool {
    let output = std::io::stdout();
    let mut look = [PollFd::new(&output, PollFlags::empty())];
    let polled = poll(&mut look, Some(&Timespec::default()));
    polled.is_err() || !look[0].revents().contains(PollFlags::ERR)
}

/// Writes a value to standard output as JSON.
pub fn say_json(value: &impl serde::Serialize) {
    match serde_json::to_string_pretty(value) {
        Ok(text) => say(&(printable_json(&text).into_owned() + "\n")),
        Err(error) => complain(&format!("no JSON form: {error}")),
    }
}

/// Writes a value to standard output as JSON on one line.
pub fn say_json_line(value: &impl serde::Serialize) {
    match serde_json::to_string(value) {
        Ok(text) => say(&(printable_json(&text).into_owned() + "\n")),
        Err(error) => complain(&format!("no JSON form: {error}")),
    }
}

/// Complains in one line; the exit code of usage and configuration.
#[must_use]
pub fn usage(problem: &str) -> ExitCode {
    complain(problem);
    ExitCode::from(EXIT_USAGE)
}

/// Writes a complaint to standard error, on a line of its own.
pub fn complain(problem: &str) {
    note(&format!("zeronav: {}", printable_lines(problem)));
}

/// Writes a line to standard error.
pub fn note(line: &str) {
    beside_the_line(|| {
        // Nothing is left to which this failure could be told.
        let _ = writeln!(std::io::stderr(), "{line}");
    });
}

/// Complains about a result that could not be written, once however many there are: the command
/// ends with [`EXIT_OUTPUT`].
pub fn lose(problem: &str) {
    if !LOST.swap(true, Ordering::Relaxed) {
        complain(problem);
    }
}

/// The exit code of the command: [`EXIT_OUTPUT`] in place of success or of a failed expectation
/// when something of the result was lost.
#[must_use]
pub fn settle(code: ExitCode) -> ExitCode {
    let was_judged = code == ExitCode::SUCCESS || code == ExitCode::FAILURE;
    if was_judged && LOST.load(Ordering::Relaxed) {
        ExitCode::from(EXIT_OUTPUT)
    } else {
        code
    }
}

/// From now on this line is on the terminal; `None` = none.
pub fn show_line(line: Option<ProgressBar>) {
    *LINE.lock().unwrap_or_else(PoisonError::into_inner) = line;
}

/// Writes to the terminal while the progress line is out of the way.
pub fn beside_the_line<R>(write: impl FnOnce() -> R) -> R {
    let line = LINE.lock().unwrap_or_else(PoisonError::into_inner).clone();
    match line {
        Some(line) => line.suspend(write),
        None => write(),
    }
}
