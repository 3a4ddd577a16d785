//! `zeronav-link`: see `zeronav-link --help`.

use std::io::Write;
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitCode};
use zeronav_link::process::Link;
use zeronav_shell::Companion;

/// Sets Zenoh's runtime to one thread that reads and writes. Two of them change one TLS connection at the same time, which
/// then stands still (eclipse-zenoh/zenoh#2557).
const RUNTIME: &str = "ZENOH_RUNTIME";
const ONE_THREAD: &str = "(rx: (worker_threads: 1), tx: (handover: rx))";

fn main() -> ExitCode {
    if std::env::var_os(RUNTIME).is_none_or(|set| set != ONE_THREAD) {
        // A process cannot change its own environment safely: it becomes itself with another one.
        let error = match std::env::current_exe() {
            Ok(program) => {
                let mut command = Command::new(program);
                command.args(std::env::args_os().skip(1));
                command.env(RUNTIME, ONE_THREAD).exec()
            }
            Err(error) => error,
        };
        let _ = writeln!(std::io::stderr(), "starting with one thread: {error}");
        return ExitCode::FAILURE;
    }
    Link::run()
}
