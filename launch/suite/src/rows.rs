//! Runs cases and gathers their rows.

use super::case::Case;
use super::journal::Journal;
use super::row::Row;
use super::runner::{Runner, Stopped};

/// Runs the cases; their rows in the order of the cases.
pub(super) fn drive(runner: &Runner<'_>, title: &str, cases: &[Case]) -> Result<Vec<Row>, Stopped> {
    let mut rows: Vec<Option<Row>> = vec![None; cases.len()];
    let all: Vec<&Case> = cases.iter().collect();
    runner.each(title, &all, |index, finish| {
        rows[index] = Some(Row::new(&cases[index], &finish));
        Ok(())
    })?;
    Ok(rows.into_iter().flatten().collect())
}

/// Makes the runs that the journal does not have yet, and those again that left no result: their machine may have
/// ended them.
pub(super) fn drive_rest(
    runner: &Runner<'_>,
    title: &str,
    cases: &[Case],
    journal: &mut Journal,
) -> Result<(), Stopped> {
    let left: Vec<&Case> = cases
        .iter()
        .filter(|case| journal.row(case).is_none_or(|row| row.outcome.is_none()))
        .collect();
    runner.each(title, &left, |index, finish| {
        let case = left[index];
        journal.note(case, Row::new(case, &finish))
    })
}
