//! A service that ends before it has opened anything, as one does whose library is missing.

use std::process::ExitCode;

fn main() -> ExitCode {
    eprintln!("this is the last line of a service that could not start");
    ExitCode::FAILURE
}
