//! `zeronav-recorder`: see `zeronav-recorder --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    zeronav_recorder::process::main()
}
