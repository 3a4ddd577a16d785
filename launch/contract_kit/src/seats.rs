//! Clauses about who may sit in a seat: another contract, too little memory, a taken seat, another epoch.

use super::bench::{Bench, EPOCH, seat_row};
use super::clause::Clause;
use super::no_memory;
use super::program::Program;
use super::report::Report;
use zeronav_msgs::run::RunMode;

/// Tests them.
pub(crate) fn test(program: &Program, report: &mut Report) {
    report.add(Clause::Contract, other_contract(program));
    no_memory::test(program, report);
    report.add(Clause::Seat, one_per_seat(program));
}

/// A domain in which the topic that every answer of the seat owes is of another contract.
fn other_contract(program: &Program) -> Result<String, String> {
    let owed = seat_row(program.role).owes.first();
    let owed = owed.ok_or("the seat owes nothing")?;
    let mut bench = Bench::make(program, RunMode::Lockstep, owed.name)?;
    bench.free_seat();
    let ended = program.expect_while(&bench.flags(EPOCH), 3, &|| bench.refresh());
    bench.close();
    let ended = ended?;
    if ended.stderr.contains(owed.name) {
        Ok(format!("exit code 3, and {} is named", owed.name))
    } else {
        Err(format!(
            "it does not name {}: {}",
            owed.name,
            ended.last_words()
        ))
    }
}

/// The kit holds the seat and gives it to nobody, then frees it and expects another epoch.
fn one_per_seat(program: &Program) -> Result<String, String> {
    let mut bench = Bench::make(program, RunMode::Lockstep, "")?;
    let taken = program.expect(&bench.flags(EPOCH), 2);
    bench.free_seat();
    let other = program.expect_while(&bench.flags(EPOCH + 4), 2, &|| bench.refresh());
    bench.close();
    taken.map_err(|why| format!("a taken seat: {why}"))?;
    other.map_err(|why| format!("another epoch than run/control names: {why}"))?;
    Ok("a taken seat and another epoch than run/control names: exit code 2".to_owned())
}
