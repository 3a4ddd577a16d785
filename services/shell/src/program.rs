//! What the main programs of services and companions share beside their flags.

use crate::error::{EXIT_STOPPED, EXIT_USAGE, StartError};
use crate::flags::one_line;
use crate::printable::printable;
use clap::Parser;
use std::io::Write;
use std::process::ExitCode;
use zeronav_params::Parameter;

/// The flags of this process; otherwise the exit code of a process that has said what is wrong with them,
/// or what was asked.
pub(crate) fn flags<F: Parser>() -> Result<F, ExitCode> {
    F::try_parse().map_err(|error| {
        if error.use_stderr() {
            complain(&one_line(&error));
            return ExitCode::from(EXIT_USAGE);
        }
        let _ = error.print();
        ExitCode::from(EXIT_STOPPED)
    })
}

/// Data for the caller, such as `--print-config`, on standard output.
///
/// # Errors
/// [`StartError::System`] when it cannot be written.
pub(crate) fn print(text: &str) -> Result<(), StartError> {
    let mut output = std::io::stdout().lock();
    output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush())
        .map_err(|error| StartError::system("writing to standard output", error))
}

/// The parameters as a JSON list.
///
/// # Errors
/// As [`print`].
pub(crate) fn print_parameters(parameters: &[Parameter]) -> Result<(), StartError> {
    let text = serde_json::to_string_pretty(parameters)
        .map_err(|error| StartError::system("writing the parameters as JSON", error))?;
    print(&format!("{text}\n"))
}

/// One line on standard error.
pub(crate) fn complain(problem: &str) {
    let _ = writeln!(std::io::stderr(), "{}", printable(problem));
}
