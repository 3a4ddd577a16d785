//! `zeronav-link`: see `zeronav-link --help`.

use std::process::ExitCode;
use zeronav_link::process::Link;
use zeronav_shell::Companion;

fn main() -> ExitCode {
    Link::run()
}
