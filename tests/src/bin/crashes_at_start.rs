//! A service that accepts any configuration and ends before it has opened anything.

use std::process::ExitCode;

fn main() -> ExitCode {
    if std::env::args().any(|word| word == "--print-config") {
        return ExitCode::SUCCESS;
    }
    eprintln!("this is the last line of a service that could not start");
    ExitCode::FAILURE
}
