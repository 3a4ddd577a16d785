//! `zeronav suite soak`: drives in which services are killed, hang and are disturbed at random, until the
//! time is used up or enough was broken.
//!
//! The drives are an endless list, each drawn from its number ([`drives`]). What each has left over is
//! looked at before the next ones begin ([`left`]), and one that did not reach its goals is made once
//! more without faults: what is not reached then either says nothing of faults. Drives in lockstep go
//! side by side; one in real time goes alone.

mod drives;
#[cfg(test)]
mod tests;

use super::case::Case;
use super::journal::Journal;
use super::left;
use super::plan::Setup;
use super::row::Row;
use super::runner::{Finish, Runner, Stopped};
use super::soaked::Soaked;
use super::soaked::verdict::{End, Totals};
use drives::Drive;
use std::collections::VecDeque;
use std::io::ErrorKind;
use std::ops::Range;
use std::time::Instant;
use zeronav_console::artifacts;
use zeronav_console::progress::ProgressLine;
use zeronav_files::Folder;

/// Wall time of a soak of which nothing is said. [h]
pub(super) const HOURS: f64 = 1.0;

/// What was driven.
#[derive(Debug)]
pub(super) struct Driven {
    /// The drives that were begun, in this call and before.
    pub(super) cases: Vec<Case>,
    /// Why there are no more.
    pub(super) end: End,
    /// Wall time that was used, in this call and before. [s]
    pub(super) used_s: f64,
    /// What stopped it, if something did.
    pub(super) ended: Result<(), Stopped>,
}

/// The wall time that a soak may use, in all of its calls.
#[derive(Debug)]
struct Budget {
    hours: f64,
    /// Used by calls before. [s]
    before_s: f64,
    since: Instant,
}

impl Budget {
    fn used_s(&self) -> f64 {
        self.before_s + self.since.elapsed().as_secs_f64()
    }

    fn is_used_up(&self) -> bool {
        self.used_s() >= self.hours * 3600.0
    }
}

/// A soak that goes on.
struct Soak<'a> {
    runner: &'a Runner<'a>,
    setup: &'a Setup<'a>,
    temp: Folder,
    totals: Totals,
    /// Drives in real time that wait until the others beside which they may not go are made.
    waiting: VecDeque<(Drive, Case)>,
}

/// Drives, from the first number that the journal does not have yet.
///
/// # Errors
/// One line naming a file that cannot be written, or a world that cannot be drawn.
pub(super) fn drive(
    runner: &Runner<'_>,
    setup: &Setup<'_>,
    folder: &Folder,
    journal: &mut Journal,
) -> Result<Driven, String> {
    let plan = setup.plan;
    let budget = Budget {
        hours: plan.hours.unwrap_or(HOURS),
        before_s: journal.used_s(),
        since: Instant::now(),
    };
    let mut soak = Soak {
        runner,
        setup,
        temp: inner(folder, "temp")?,
        totals: Totals::default(),
        waiting: VecDeque::new(),
    };
    let mut line = ProgressLine::new("soak", plan.progress);
    let mut cases = Vec::new();
    let mut numbers = plan.worlds.clone().unwrap_or(0..u32::MAX);
    let (end, ended) = loop {
        let batch = soak.next(&mut numbers, journal, &mut cases)?;
        if runner.is_interrupted() {
            break (End::Interrupted, Err(Stopped::Interrupted));
        } else if soak.totals.is_enough() {
            break (End::Enough, Ok(()));
        } else if budget.is_used_up() {
            break (End::Hours, Ok(()));
        } else if batch.is_empty() {
            break (End::Worlds, Ok(()));
        }
        line.show(|| soak.progress(&budget));
        cases.extend(batch.iter().map(|(_, case)| case.clone()));
        let driven = soak.drive(&batch, journal);
        journal.use_up(budget.used_s())?;
        if let Err(stopped) = driven {
            break (End::Interrupted, Err(stopped));
        }
    };
    line.clear();
    left::clear(soak.temp.path());
    Ok(Driven {
        cases,
        end,
        used_s: budget.used_s(),
        ended,
    })
}

impl Soak<'_> {
    /// The drives that are made next: one in real time alone, or as many others as go side by side. Those
    /// that the journal has are noted, and go to `cases`.
    fn next(
        &mut self,
        numbers: &mut Range<u32>,
        journal: &Journal,
        cases: &mut Vec<Case>,
    ) -> Result<Vec<(Drive, Case)>, String> {
        if let Some(alone) = self.waiting.pop_front() {
            return Ok(vec![alone]);
        }
        let mut batch = Vec::new();
        while batch.len() < self.runner.jobs()
            && let Some(number) = numbers.next()
        {
            let drive = Drive::of(number);
            let case = drive.case(self.setup, &self.temp, false)?;
            if let Some(row) = journal.row(&case) {
                self.note(row);
                cases.push(case);
            } else if !drive.is_real_time() {
                batch.push((drive, case));
            } else if batch.is_empty() {
                return Ok(vec![(drive, case)]);
            } else {
                self.waiting.push_back((drive, case));
            }
        }
        // The last ones.
        if batch.is_empty() {
            batch.extend(self.waiting.pop_front());
        }
        Ok(batch)
    }

    /// Makes drives side by side, and those in doubt once more without faults.
    fn drive(&mut self, batch: &[(Drive, Case)], journal: &mut Journal) -> Result<(), Stopped> {
        let cases: Vec<&Case> = batch.iter().map(|(_, case)| case).collect();
        let mut in_doubt: Vec<(usize, Row)> = Vec::new();
        let mut refusal = None;
        let runner = self.runner;
        runner.each("soak", &cases, |index, finish| {
            let row = row(cases[index], &finish);
            if row.refusal.is_some() {
                refusal = row.refusal;
            } else if row.soaked.as_deref().is_some_and(Soaked::is_in_doubt) {
                in_doubt.push((index, row));
            } else {
                self.note(&row);
                return journal.note(cases[index], row);
            }
            Ok(())
        })?;
        if let Some(problem) = refusal {
            return Err(Stopped::Refused(problem));
        }
        for (index, mut row) in in_doubt {
            let (drive, case) = &batch[index];
            let calm = drive
                .case(self.setup, &self.temp, true)
                .map_err(Stopped::Lost)?;
            let mut arrives = None;
            runner.each("soak", &[&calm], |_, finish| {
                arrives = Some(self::row(&calm, &finish).arrived);
                Ok(())
            })?;
            if let Some(soaked) = &mut row.soaked {
                soaked.arrives_without_faults = arrives;
            }
            self.note(&row);
            journal.note(case, row).map_err(Stopped::Lost)?;
        }
        Ok(())
    }

    fn note(&mut self, row: &Row) {
        if let Some(soaked) = &row.soaked {
            self.totals.add(soaked);
        }
    }

    fn progress(&self, budget: &Budget) -> String {
        let Totals { drives, faults, .. } = &self.totals;
        format!(
            "{drives} drives  {faults} faults  {} restarts of the seat with the fewest  {:.2} of {} h",
            self.totals.restarts_least(),
            budget.used_s() / 3600.0,
            budget.hours
        )
    }
}

/// The row of a drive. What is left over is looked at and cleared away.
fn row(case: &Case, finish: &Finish) -> Row {
    let mut row = Row::new(case, finish);
    let temp = case.manner.temp.as_deref();
    let left = temp.map(|temp| left::left_over(temp, finish.domain.as_deref()));
    if let Some(temp) = temp {
        left::clear(temp);
    }
    let of_run = (row.arrived, &row.contacts[..]);
    let soaked = Soaked::of(
        case,
        of_run,
        finish.result.as_ref(),
        left.unwrap_or_default(),
    );
    // Contacts of no fault of its own are no failure here.
    row.cause = soaked
        .cause()
        .map(str::to_owned)
        .or(row.cause.filter(|_| !row.arrived));
    row.success = row.cause.is_none();
    row.soaked = Some(Box::new(soaked));
    row
}

/// The folder `name` in `folder`, which a soak that was killed may have left.
fn inner(folder: &Folder, name: &str) -> Result<Folder, String> {
    let made = match folder.create(name) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => folder.inside(name),
        made => made,
    };
    made.map_err(|error| artifacts::refused(&folder.path().join(name), &error))
}
