//! Writes everything in the repository again that is made from code; the tests say which file is not current.

use std::process::ExitCode;

fn main() -> ExitCode {
    match zeronav_tests::generated::write_all() {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("zeronav-regenerate: {problem}");
            ExitCode::FAILURE
        }
    }
}
