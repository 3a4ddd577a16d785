//! `zeronav completions` and `zeronav man`: for shells and for `man`, from the command line's own
//! declaration.

use crate::cli::Cli;
use crate::exit::{EXIT_OUTPUT, EXIT_PASS};
use crate::show::terminal::{complain, pour, say};
use clap::CommandFactory;
use clap_complete::Shell;
use std::path::Path;
use std::process::ExitCode;

/// Name of the command.
const NAME: &str = "zeronav";

/// `zeronav completions`.
#[must_use]
pub fn completions(shell: Shell) -> ExitCode {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), NAME, &mut script);
    let _ = pour(|to| to.write_all(&script));
    ExitCode::from(EXIT_PASS)
}

/// `zeronav man`: a page for the command and for each of its verbs.
#[must_use]
pub fn man(folder: &Path) -> ExitCode {
    let written = std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Cli::command(), folder));
    if let Err(error) = written {
        complain(&format!("{}: {error}", folder.display()));
        return ExitCode::from(EXIT_OUTPUT);
    }
    say(&format!(
        "{}: read one with `man {}`\n",
        folder.display(),
        folder.join(format!("{NAME}.1")).display()
    ));
    ExitCode::from(EXIT_PASS)
}
