//! `zeronav logs`: what the processes of a run write, merged by time.

mod merge;

use crate::remote::cli::StackArgs;
use crate::running;
use clap::Args;
use merge::{Line, Merge};
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use zeronav_console::exit::{EXIT_INTERRUPTED, EXIT_PASS};
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{is_read, note, pour, usage};
use zeronav_shell::{Domain, printable};

/// Time between two looks at the logs.
const PAUSE: Duration = Duration::from_millis(50);

/// Arguments of `zeronav logs`.
#[derive(Debug, Clone, Args)]
pub struct LogsArgs {
    /// Whose: a role, `launch`, or the name of a companion; without, of all.
    pub writer: Option<String>,
    /// Go on until the run ends.
    #[arg(short, long)]
    pub follow: bool,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// What to say where nobody of this name has a log: who has one.
fn no_log(folder: &Path, name: &str) -> String {
    let mut all = Merge::new(folder, None);
    let _ = all.look();
    let names: Vec<&str> = all.names().collect();
    format!(
        "nothing called `{}` writes a log in this run; there are those of {}",
        printable(name),
        printable(&names.join(", "))
    )
}

/// `zeronav logs`.
#[must_use]
pub fn logs(arguments: &LogsArgs) -> ExitCode {
    match show(arguments) {
        Ok(code) => ExitCode::from(code),
        Err(problem) => usage(&problem),
    }
}

fn show(arguments: &LogsArgs) -> Result<u8, String> {
    let run = running::find(arguments.stack.domain.as_deref())?;
    let folder = run.report()?.folder.join("logs");
    let unreadable = |error| format!("{}: {error}", folder.display());
    let mut merge = Merge::new(&folder, arguments.writer.as_deref());
    merge.look().map_err(unreadable)?;
    if let Some(name) = &arguments.writer
        && merge.names().next().is_none()
    {
        return Err(no_log(&folder, name));
    }
    if !arguments.follow {
        let _ = show_lines(&mut merge, arguments, true, &AtomicBool::new(false));
        return Ok(EXIT_PASS);
    }
    let interrupted = interrupts()?;
    // As a member it sees at once that launch is gone.
    let domain = Domain::join(run.root()).map_err(|error| error.to_string())?;
    loop {
        let is_over = domain.is_orphaned();
        // A run's folder may be removed while it goes on.
        let _ = merge.look();
        if !show_lines(&mut merge, arguments, is_over, &interrupted) || !is_read() {
            return Ok(EXIT_PASS);
        }
        if interrupted.load(Ordering::Relaxed) {
            return Ok(EXIT_INTERRUPTED);
        }
        if is_over {
            // Of a run that is over, launch removes what this cannot.
            let _ = domain.close();
            note("the run has ended");
            return Ok(EXIT_PASS);
        }
        std::thread::sleep(PAUSE);
    }
}

/// Shows the lines that are there, until `interrupted`; false when standard output is closed.
fn show_lines(
    merge: &mut Merge,
    arguments: &LogsArgs,
    last: bool,
    interrupted: &AtomicBool,
) -> bool {
    let width = merge.names().map(str::len).max().unwrap_or(0);
    pour(|to| {
        while !interrupted.load(Ordering::Relaxed)
            && let Some(line) = merge.next(last)
        {
            if arguments.stack.json {
                writeln!(to, "{}", to_json(&line))?;
                continue;
            }
            let text = String::from_utf8_lossy(&line.bytes);
            if arguments.writer.is_none() {
                write!(to, "{:width$}  ", printable(&line.name))?;
            }
            writeln!(to, "{}", printable(&text))?;
        }
        Ok(())
    })
}

/// Time, service, level and text of a line; foreign output has no level.
fn to_json(line: &Line) -> String {
    let text = String::from_utf8_lossy(&line.bytes);
    let after = text.strip_prefix(&line.time).unwrap_or(&text).trim_start();
    let (word, rest) = after.split_once(' ').unwrap_or(("", after));
    let is_level = matches!(word, "ERROR" | "WARN" | "INFO" | "DEBUG" | "TRACE");
    let (level, text) = if is_level {
        (Some(word.to_lowercase()), rest)
    } else {
        (None, after)
    };
    let value = json!({
        "time": (!line.time.is_empty()).then_some(&line.time),
        "service": line.name,
        "level": level,
        "text": text,
    });
    zeronav_shell::printable::printable_json(&value.to_string()).into_owned()
}
