//! `zeronav-remote-seat`: see `zeronav-remote-seat --help`.

use clap::Parser;
use std::io::Write;
use std::process::ExitCode;
use zeronav_link::remote_seat::sit;
use zeronav_shell::flags::{Flags, one_line};

fn main() -> ExitCode {
    let flags = match Flags::try_parse() {
        Ok(flags) => flags,
        Err(error) if error.use_stderr() => {
            let _ = writeln!(std::io::stderr(), "{}", one_line(&error));
            return ExitCode::from(2);
        }
        Err(error) => {
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
    };
    let member = &flags.member;
    if member.print_config || member.print_params || flags.list {
        // The program on the other host says what its configuration means.
        return ExitCode::SUCCESS;
    }
    zeronav_shell::logs::start(&member.log_level);
    match sit(&flags) {
        Ok(code) => code,
        Err(error) => {
            tracing::error!("{error}");
            error.exit_code()
        }
    }
}
