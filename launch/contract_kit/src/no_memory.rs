//! The clause about too little shared memory, in a /dev/shm of its own: a mount namespace in which this
//! program runs again. Nobody else sees it, so no stack of the machine is deprived of memory.

use super::bench::{Bench, EPOCH};
use super::clause::Clause;
use super::cli::ContractArgs;
use super::program::{Program, last_line};
use super::report::Report;
use rustix::fs::statvfs;
use rustix::process::Signal;
use std::process::{Command, ExitCode, Stdio};
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_console::terminal::say;
use zeronav_msgs::run::RunMode;
use zeronav_shell::memory::SHM;
use zeronav_supervise::process::end_with_this_thread;

/// The hidden command that runs in the namespace.
pub const COMMAND: &str = "contract-without-memory";

/// Makes a /dev/shm that has room for all seats but the tested one, then runs its arguments.
const SCRIPT: &str = "mount -t tmpfs -o size=256m tmpfs /dev/shm && exec \"$@\"";

/// What is left of it: enough to join a domain, too little for any topic. [bytes]
const LEFT_BYTES: u64 = 512 << 10;

/// What the answer of the hidden command begins with.
const KEPT: &str = "kept: ";
const BROKEN: &str = "broken: ";

/// Tests the clause, or skips it where the system allows no namespace.
pub fn test(program: &Program, report: &mut Report) {
    match in_private(program) {
        Ok(result) => report.add(Clause::Memory, result),
        Err(why) => report.skip(Clause::Memory, &why),
    }
}

/// The result of the hidden command.
///
/// # Errors
/// Why it could not run.
fn in_private(program: &Program) -> Result<Result<String, String>, String> {
    let used = [&program.binary, &program.config, &program.folder];
    if let Some(hidden) = used.iter().find(|path| path.starts_with(SHM)) {
        let hidden = hidden.display();
        return Err(format!("{hidden} lies in {SHM}, which this clause hides"));
    }
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let mut command = Command::new("unshare");
    command
        .args(["--user", "--map-root-user", "--mount"])
        .args(["sh", "-c", SCRIPT, "sh"])
        .arg(own)
        .args([COMMAND, program.role.label()])
        .arg(&program.binary)
        .arg("--config")
        .arg(&program.config)
        .arg("--")
        .args(&program.arguments)
        // Its folder goes with that of this command.
        .env("TMPDIR", &program.folder)
        .stdin(Stdio::null());
    end_with_this_thread(&mut command, Signal::KILL);
    let output = command.output();
    let output = output.map_err(|error| format!("unshare, to have a {SHM} of its own: {error}"))?;
    let said = String::from_utf8_lossy(&output.stdout);
    if let Some(seen) = said.strip_prefix(KEPT) {
        return Ok(Ok(seen.trim_end().to_owned()));
    }
    if let Some(why) = said.strip_prefix(BROKEN) {
        return Ok(Err(why.trim_end().to_owned()));
    }
    let why = String::from_utf8_lossy(&output.stderr);
    let why = last_line(&why);
    Err(format!("it has no {SHM} of its own here: {why}"))
}

/// The hidden command: /dev/shm is this process's own.
#[must_use]
pub fn contract_without_memory(arguments: &ContractArgs) -> ExitCode {
    let folder = tempfile::tempdir().map_err(|error| format!("a folder for logs: {error}"));
    let result = folder.and_then(|folder| starved(&Program::find(arguments, folder.path())?));
    let (code, text) = match result {
        Ok(seen) => (EXIT_PASS, format!("{KEPT}{seen}\n")),
        Err(why) => (EXIT_FAIL, format!("{BROKEN}{why}\n")),
    };
    say(&text);
    ExitCode::from(code)
}

/// All other seats are there, and then the memory is gone.
fn starved(program: &Program) -> Result<String, String> {
    let mut bench = Bench::make(program, RunMode::Lockstep, "")?;
    bench.free_seat();
    shrink()?;
    let ended = program.expect_while(&bench.flags(EPOCH), 4, &|| bench.refresh());
    bench.close();
    ended.map(|_| format!("{} kB of it are left: exit code 4", LEFT_BYTES >> 10))
}

/// Leaves [`LEFT_BYTES`] of /dev/shm.
fn shrink() -> Result<(), String> {
    let stat = statvfs(SHM).map_err(|error| format!("{SHM}: {error}"))?;
    let used = (stat.f_blocks - stat.f_bfree).saturating_mul(stat.f_frsize);
    let size = format!("remount,size={}", used + LEFT_BYTES);
    let mount = Command::new("mount").args(["-o", &size, SHM]).output();
    let output = mount.map_err(|error| format!("mount: {error}"))?;
    if output.status.success() {
        return Ok(());
    }
    let why = String::from_utf8_lossy(&output.stderr);
    Err(format!("mount: {}", last_line(&why)))
}
