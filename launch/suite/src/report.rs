//! What a suite gave: one object for machines, one page for people, and files for both.

use super::hindsight::ContactRow;
use super::kind::Kind;
use super::plan::Setup;
use super::row::Row;
use super::shard::Shard;
use super::soaked::verdict::{End, SoakReport};
use super::summary::Summary;
use super::timing::Timing;
use super::{csv_file, junit};
use core::fmt::Write;
use serde::Serialize;
use std::collections::BTreeMap;
use zeronav_files::Folder;

/// Columns of the table beside the name.
const COLUMNS: usize = 14;

const WIDTHS: [usize; COLUMNS] = [5, 8, 7, 8, 8, 6, 7, 7, 7, 6, 9, 8, 6, 13];

const HEADER: [&str; COLUMNS] = [
    "runs",
    "success",
    "contact",
    "contact",
    "timeout",
    "other",
    "time",
    "score",
    "score",
    "path",
    "clearance",
    "turning",
    "jerk",
    "interventions",
];

/// Units, and what tells columns of the same name apart.
const UNITS: [&str; COLUMNS] = [
    "", "", "moving", "standing", "", "", "s", "2-OT", "4-OT", "ratio", "m", "rad", "m/s^3", "",
];

/// Failures that the page names at most; the files have them all.
const FAILURES_SHOWN: usize = 40;

/// What the numbers are when nothing was driven.
const BOUND_NOTE: &str = "nothing was driven: ways without any contact, planned with exact wheels and \
     every future known, up to the goal's tolerance; where none was found there may be one";

/// A class of worlds.
#[derive(Debug, Clone, Serialize)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// Its numbers.
    pub summary: Summary,
}

/// What a suite gave.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Which suite.
    pub suite: String,
    /// What the numbers are.
    pub note: String,
    /// Key of the local planner's controller; `default` is its own default, `bound (...)` none.
    pub controller: String,
    /// How badly the robot did.
    pub noise: String,
    /// What services were told of what moves: then nothing here is a result of the stack. Null in
    /// earnest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub foresight: Option<String>,
    /// Runs of each world.
    pub seeds: u64,
    /// False when the suite was stopped before its last run.
    pub complete: bool,
    /// The part of the suite that this is; null when it is all of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
    /// Runs that were asked for, of this part.
    pub planned: usize,
    /// All runs together.
    pub summary: Summary,
    /// Each class of worlds, where there are several.
    pub groups: Vec<Group>,
    /// The runs.
    pub runs: Vec<Row>,
    /// Every contact of every run.
    pub contacts: Vec<ContactRow>,
    /// What is asked of a soak, and what it came to; null for other suites.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub soak: Option<SoakReport>,
}

impl Report {
    pub(super) fn new(setup: &Setup<'_>, kind: Kind, planned: usize, runs: Vec<Row>) -> Self {
        let plan = setup.plan;
        let mut classes: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
        for row in &runs {
            if let Some(class) = &row.class {
                classes.entry(class).or_default().push(row);
            }
        }
        let groups = classes
            .iter()
            .map(|(name, rows)| Group {
                name: (*name).to_owned(),
                summary: Summary::of(rows),
            })
            .collect();
        Self {
            suite: plan.suite.clone(),
            note: if plan.bound { BOUND_NOTE } else { kind.note() }.to_owned(),
            controller: setup.driver().to_owned(),
            noise: plan.noise.label().to_owned(),
            foresight: plan.foresight.label(),
            seeds: plan.seeds,
            shard: plan.shard,
            complete: runs.len() == planned,
            planned,
            summary: Summary::of(&runs.iter().collect::<Vec<_>>()),
            groups,
            contacts: runs.iter().flat_map(|row| row.contacts.clone()).collect(),
            runs,
            soak: None,
        }
    }

    /// The same with what a soak came to, whose last run is known when it has ended.
    pub(super) fn of_soak(self, soak: SoakReport) -> Self {
        Self {
            complete: soak.ended != End::Interrupted,
            soak: Some(soak),
            ..self
        }
    }

    /// Writes `suite.json`, `runs.csv` and `junit.xml` into the suite's folder.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn leave(&self, folder: &Folder) -> Result<(), String> {
        let write =
            |name: &str, text: String| zeronav_console::artifacts::write_in(folder, name, &text);
        let json = serde_json::to_string_pretty(self).map_err(|error| error.to_string())?;
        write("suite.json", json + "\n")?;
        write("junit.xml", junit::text(&self.suite, &self.runs))?;
        write("runs.csv", csv_file::text(&self.runs)?)
    }

    /// Why no run at all could begin, if none could.
    pub(super) fn refusal(&self) -> Option<String> {
        let all = !self.runs.is_empty() && self.runs.iter().all(|row| row.refusal.is_some());
        let first = self.runs.first().filter(|_| all);
        first.and_then(|row| row.refusal.clone())
    }

    /// The page for people.
    pub(super) fn to_text(&self, timing: &Timing) -> String {
        let mut text = String::new();
        if !self.complete {
            let of = match &self.soak {
                Some(_) => String::new(),
                None => format!(" of {}", self.planned),
            };
            let _ = writeln!(
                text,
                "interrupted: {}{of} runs; go on with `zeronav suite --resume {}`",
                self.runs.len(),
                timing.directory
            );
        }
        let _ = writeln!(
            text,
            "{}: controller {}, noise {}, {} worlds, {} runs in {:.0} s of wall time\n  {}\n",
            self.suite,
            self.controller,
            self.noise,
            self.summary.worlds,
            self.summary.runs,
            timing.wall_s,
            self.note
        );
        if let Some(shard) = self.shard {
            let _ = writeln!(
                text,
                "  shard {shard} alone; `zeronav suite merge` makes one result of all\n"
            );
        }
        if let Some(told) = &self.foresight {
            let _ = writeln!(
                text,
                "  told by the simulator what moves ({told}): no result of the stack\n"
            );
        }
        self.write_table(&mut text);
        self.write_failures(&timing.directory, &mut text);
        self.write_faults(&mut text);
        if let Some(arrival) = self.summary.arrival_where_a_way_exists {
            let ratio = self.summary.mean_time_ratio.unwrap_or(0.0);
            let _ = writeln!(
                text,
                "\n  arrived where the outline has a way {arrival:.4}; arrivals that were none {}; run time per \
                 time of that way at top speeds {ratio:.2}",
                self.summary.wrong_arrivals
            );
        }
        if Kind::of(&self.suite) == Kind::Kidnapped {
            let of = |value: Option<f64>| value.unwrap_or(0.0);
            let _ = writeln!(
                text,
                "\n  wrong and certain {}; pose errors of those who were found at most {:.3} m and {:.4} rad",
                self.summary.wrong_arrivals,
                of(self.summary.pose_error_m_max),
                of(self.summary.pose_error_rad_max)
            );
        }
        self.write_not_reproducible(&mut text);
        if let Some(soak) = &self.soak {
            soak.write(&mut text);
        }
        let _ = writeln!(text, "\n  {}", timing.directory);
        text
    }

    /// A row for each class of worlds, where there are several, and one for all runs.
    fn write_table(&self, text: &mut String) {
        let names = self.groups.iter().map(|group| group.name.len());
        let width = names.max().unwrap_or(0).max("all".len());
        write_row("", &HEADER, width, text);
        write_row("", &UNITS, width, text);
        let groups = Some(&self.groups).filter(|groups| groups.len() > 1);
        for group in groups.into_iter().flatten() {
            write_row(&group.name, &cells(&group.summary), width, text);
        }
        write_row("all", &cells(&self.summary), width, text);
    }

    /// The runs that failed, by cause.
    fn write_failures(&self, directory: &str, text: &mut String) {
        for (cause, n) in &self.summary.causes {
            let _ = writeln!(text, "\n  {n} x {cause}:");
            let failures = self
                .runs
                .iter()
                .filter(|row| row.cause.as_ref() == Some(cause));
            for row in failures.take(FAILURES_SHOWN) {
                let own = row.directory.as_ref();
                let own = own.map_or_else(String::new, |own| format!("{directory}/{own}"));
                let _ = writeln!(text, "    {} seed {}  {own}", row.world, row.seed);
            }
        }
    }

    /// The runs that may go otherwise the next time.
    fn write_not_reproducible(&self, text: &mut String) {
        if self.summary.not_reproducible == 0 {
            return;
        }
        let _ = writeln!(
            text,
            "\n  {} not reproducible:",
            self.summary.not_reproducible
        );
        let rows = self.runs.iter();
        let rows = rows.filter_map(|row| Some((row, row.not_reproducible.as_ref()?)));
        for (row, why) in rows.take(FAILURES_SHOWN) {
            let _ = writeln!(text, "    {} seed {}  {why}", row.world, row.seed);
        }
    }

    /// Whose fault the contacts were, where that can be told.
    fn write_faults(&self, text: &mut String) {
        let sum = &self.summary;
        let Some(unavoidable) = sum.unavoidable else {
            return;
        };
        let _ = writeln!(
            text,
            "\n  arrived {:.4}; runs with a contact by own fault {}; contacts while moving that an \
             oracle could not avoid either {unavoidable}",
            sum.arrival, sum.contacts_own_fault
        );
        let listed = |contact: &&ContactRow| contact.moving && contact.unavoidable;
        for contact in self.contacts.iter().filter(listed) {
            let _ = writeln!(
                text,
                "    {} seed {} at {:.1} s: {}",
                contact.world, contact.seed, contact.time_s, contact.with
            );
        }
    }
}

/// The cells of a group's row, in the order of [`HEADER`].
fn cells(sum: &Summary) -> [String; COLUMNS] {
    let cell = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
    };
    let named = |cause: &str| cause.starts_with("contact") || cause == "timeout";
    let other: usize = sum
        .causes
        .iter()
        .filter(|(cause, _)| !named(cause))
        .map(|(_, n)| n)
        .sum();
    [
        sum.runs.to_string(),
        cell(Some(sum.success), 4),
        sum.contacts_moving.to_string(),
        sum.contacts_standing.to_string(),
        sum.timeouts.to_string(),
        other.to_string(),
        cell(sum.mean_time_s, 2),
        cell(sum.score, 4),
        cell(sum.score_4ot, 4),
        cell(sum.mean_path_ratio, 3),
        cell(sum.mean_clearance_m_min, 3),
        cell(sum.mean_turning_rad, 2),
        cell(sum.mean_jerk_mps3, 2),
        sum.interventions
            .map_or_else(|| "-".to_owned(), |n| n.to_string()),
    ]
}

/// Writes a line of the table: a name of at most `width` letters, then its cells.
fn write_row(
    name: &str,
    cells: &[impl core::fmt::Display; COLUMNS],
    width: usize,
    text: &mut String,
) {
    let _ = write!(text, "  {name:width$}");
    for (cell, width) in cells.iter().zip(WIDTHS) {
        let _ = write!(text, " {cell:>width$}");
    }
    text.push('\n');
}
