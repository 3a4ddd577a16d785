//! `zeronav-viewer`: see `zeronav-viewer --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    zeronav_viewer::process::main()
}
