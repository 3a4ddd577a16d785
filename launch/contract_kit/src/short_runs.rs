//! Clauses about short runs: what is printed, and the exit codes of wrong flags and configurations.

use super::clause::Clause;
use super::program::Program;
use super::report::Report;
use std::ffi::OsString;
use std::path::Path;

/// A flag that no service has.
const NO_FLAG: &str = "--no-such-flag";

/// A field that no configuration has.
const NO_FIELD: &str = "no_such_field";

/// Tests the clauses that need no domain.
pub(crate) fn test(program: &Program, report: &mut Report) {
    report.add(Clause::Help, help(program));
    report.add(Clause::PrintConfig, print_config(program));
    report.add(Clause::UnknownFlag, unknown_flag(program));
    report.add(Clause::BadConfig, bad_config(program));
}

fn help(program: &Program) -> Result<String, String> {
    let ended = program.expect(&["--help".into()], 0)?;
    let missing = ["--domain", "--epoch", "--config", "--print-config"]
        .into_iter()
        .filter(|flag| !ended.stdout.contains(flag))
        .collect::<Vec<_>>();
    if missing.is_empty() {
        Ok("exit code 0, and every flag is named".to_owned())
    } else {
        Err(format!("its help does not name {}", missing.join(", ")))
    }
}

fn asks(config: &Path) -> [OsString; 3] {
    ["--print-config".into(), "--config".into(), config.into()]
}

fn print_config(program: &Program) -> Result<String, String> {
    let ended = program.expect(&asks(&program.config), 0)?;
    let table = toml::from_str::<toml::Table>(&ended.stdout)
        .map_err(|error| format!("what it prints is no TOML: {}", error.message()))?;
    Ok(format!("exit code 0, {} keys", table.len()))
}

fn unknown_flag(program: &Program) -> Result<String, String> {
    let flags = [NO_FLAG.into(), "--print-config".into()];
    let ended = program.expect(&flags, 2)?;
    one_line(&ended.stderr)?;
    if ended.stderr.contains(NO_FLAG) {
        Ok("exit code 2 and one line that names it".to_owned())
    } else {
        Err(format!(
            "it does not name {NO_FLAG}: {}",
            ended.last_words()
        ))
    }
}

/// Three lines, of which the last is wrong: the place has to be found, not guessed.
fn bad_config(program: &Program) -> Result<String, String> {
    let config = program.folder.join("bad.toml");
    std::fs::write(&config, format!("\n\n{NO_FIELD} = 1\n"))
        .map_err(|error| format!("{}: {error}", config.display()))?;
    let ended = program.expect(&asks(&config), 2)?;
    one_line(&ended.stderr)?;
    let place = format!("{}:3: {NO_FIELD}: ", config.display());
    if ended.stderr.contains(&place) {
        Ok("exit code 2 and FILE:LINE: FIELD: REASON".to_owned())
    } else {
        let said = ended.last_words();
        Err(format!("no `FILE:3: {NO_FIELD}: REASON` in: {said}"))
    }
}

fn one_line(said: &str) -> Result<(), String> {
    match said.lines().count() {
        1 => Ok(()),
        n => Err(format!("{n} lines on standard error in place of one")),
    }
}
