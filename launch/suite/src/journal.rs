//! The journal of a suite: what it was asked for, and one line per finished run, so that a suite
//! that was interrupted can go on where it stopped.

use super::case::Case;
use super::hindsight::ContactRow;
use super::noise::Noise;
use super::plan::{Setup, SuitePlan};
use super::row::Row;
use super::shard::Shard;
use super::soaked::Soaked;
use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use zeronav_files::{Folder, read};
use zeronav_msgs::message::{FNV_OFFSET, fnv1a};
use zeronav_msgs::role::Role;
use zeronav_scenario::ForesightSpec;
use zeronav_scenario::settings::Settings;
use zeronav_supervise::binaries;

/// Its name in the suite's folder.
const NAME: &str = "runs.jsonl";

/// First line: what decides about every run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Order {
    pub(super) suite: String,
    pub(super) controller: Option<String>,
    #[serde(default, skip_serializing_if = "Settings::is_empty")]
    pub(super) settings: Settings,
    pub(super) seeds: u64,
    pub(super) worlds: Option<[u32; 2]>,
    pub(super) noise: String,
    #[serde(default)]
    pub(super) foresight: ForesightSpec,
    /// Folder of the data sets, if one was named.
    pub(super) data: Option<PathBuf>,
    /// Wall time of a soak, of which another may be said when it goes on. [h]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) hours: Option<f64>,
    /// Hash of the stock binaries.
    pub(super) build: String,
    /// The part that is driven here; `None` = all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) shard: Option<Shard>,
}

/// The names of all runs, also of those that other shards make.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Planned {
    cases: Vec<String>,
}

/// A run that has finished.
#[derive(Debug, Serialize, Deserialize)]
struct Entry {
    key: String,
    row: Row,
    wall_s: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    refusal: Option<String>,
    contacts: Vec<ContactRow>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    soaked: Option<Box<Soaked>>,
}

/// Wall time that a soak has used by then, in all of its calls.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Used {
    used_s: f64,
}

/// What a journal holds beside its order.
#[derive(Debug, Default)]
pub(super) struct Contents {
    /// The names of all runs; `None` when they are not known in advance, or were not yet.
    pub(super) planned: Option<Vec<String>>,
    /// The rows by the names of their runs.
    pub(super) rows: BTreeMap<String, Row>,
    /// Wall time that a soak has used. [s]
    used_s: f64,
    /// Length of the lines that are whole. [bytes]
    bytes: u64,
}

/// The journal, open for more.
#[derive(Debug)]
pub(super) struct Journal {
    file: PathBuf,
    open: File,
    contents: Contents,
}

impl Journal {
    /// Begins the journal of a new suite.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn begin(folder: &Folder, order: &Order) -> Result<Self, String> {
        let file = folder.path().join(NAME);
        let open = folder
            .new_file(NAME)
            .map_err(|error| failed(&file, &error))?;
        lock(&open, &file)?;
        let mut journal = Self {
            file,
            open,
            contents: Contents::default(),
        };
        journal.append(order)?;
        Ok(journal)
    }

    /// Reads the journal in `directory`: what was asked for, and what there is.
    ///
    /// # Errors
    /// One line naming the file and what is wrong with it.
    pub(super) fn read(directory: &Path) -> Result<(Order, Contents), String> {
        let file = directory.join(NAME);
        let unreadable = |error| format!("{}: not the journal of a suite: {error}", file.display());
        Folder::open(directory).map_err(unreadable)?;
        let text = read::text(&file, read::RESULT_BYTES_MAX).map_err(unreadable)?;
        // A line without its end was being written when the suite was killed.
        let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
        let mut lines = whole.lines();
        let unusable = |line: usize, error: &dyn core::fmt::Display| {
            format!(
                "{}:{line}: not the journal of a suite: {error}",
                file.display()
            )
        };
        let order: Order = serde_json::from_str(lines.next().unwrap_or_default())
            .map_err(|error| unusable(1, &error))?;
        let mut contents = Contents {
            bytes: whole.len() as u64,
            ..Contents::default()
        };
        for (n, line) in lines.enumerate() {
            if let Ok(used) = serde_json::from_str::<Used>(line) {
                contents.used_s = contents.used_s.max(used.used_s);
                continue;
            }
            if let Ok(planned) = serde_json::from_str::<Planned>(line) {
                contents.planned = Some(planned.cases);
                continue;
            }
            let entry: Entry =
                serde_json::from_str(line).map_err(|error| unusable(n + 2, &error))?;
            let row = Row {
                wall_s: entry.wall_s,
                refusal: entry.refusal,
                contacts: entry.contacts,
                soaked: entry.soaked,
                ..entry.row
            };
            contents.rows.insert(entry.key, row);
        }
        Ok((order, contents))
    }

    /// Opens the journal of a suite that shall go on.
    ///
    /// # Errors
    /// As [`Self::read`], and when another process drives the suite.
    pub(super) fn resume(directory: &Path) -> Result<(Order, Self), String> {
        let file = directory.join(NAME);
        let open = Folder::open(directory)
            .and_then(|folder| folder.append(NAME))
            .map_err(|error| format!("{}: not the journal of a suite: {error}", file.display()))?;
        lock(&open, &file)?;
        let (order, contents) = Self::read(directory)?;
        open.set_len(contents.bytes)
            .map_err(|error| failed(&file, &error))?;
        let journal = Self {
            file,
            open,
            contents,
        };
        Ok((order, journal))
    }

    /// Notes the names of all runs, or compares them with those that it holds: false when they differ.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn plan(&mut self, cases: Vec<String>) -> Result<bool, String> {
        if let Some(planned) = &self.contents.planned {
            return Ok(*planned == cases);
        }
        self.append(&Planned {
            cases: cases.clone(),
        })?;
        self.contents.planned = Some(cases);
        Ok(true)
    }

    /// The row of a run that has finished.
    pub(super) fn row(&self, case: &Case) -> Option<&Row> {
        self.contents.rows.get(&case.name())
    }

    /// Notes a run that has finished.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn note(&mut self, case: &Case, row: Row) -> Result<(), String> {
        self.note_as(case.name(), row)
    }

    /// The same of the run with this name.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn note_as(&mut self, name: String, row: Row) -> Result<(), String> {
        let entry = Entry {
            key: name,
            wall_s: row.wall_s,
            refusal: row.refusal.clone(),
            contacts: row.contacts.clone(),
            soaked: row.soaked.clone(),
            row,
        };
        self.append(&entry)?;
        self.contents.rows.insert(entry.key, entry.row);
        Ok(())
    }

    /// Wall time that a soak has used, in all of its calls. [s]
    pub(super) fn used_s(&self) -> f64 {
        self.contents.used_s
    }

    /// Notes how much that is by now.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn use_up(&mut self, used_s: f64) -> Result<(), String> {
        self.contents.used_s = used_s;
        self.append(&Used { used_s })
    }

    fn append(&mut self, line: &impl Serialize) -> Result<(), String> {
        let text = serde_json::to_string(line).map_err(|error| error.to_string())? + "\n";
        self.open
            .write_all(text.as_bytes())
            .and_then(|()| self.open.sync_data())
            .map_err(|error| failed(&self.file, &error))
    }
}

impl Order {
    /// True when the runs of `other` are those of this one, for however long they go on.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let other = Self {
            hours: self.hours,
            ..other.clone()
        };
        *self == other
    }

    /// What was asked for; options that do not affect the runs come from `plan`.
    pub(super) fn plan(&self, plan: &SuitePlan) -> SuitePlan {
        SuitePlan {
            suite: self.suite.clone(),
            controller: self.controller.clone(),
            settings: self.settings.clone(),
            seeds: self.seeds,
            worlds: self.worlds.map(|[from, until]| from..until),
            noise: Noise::from_label(&self.noise).unwrap_or_default(),
            foresight: self.foresight,
            data: self.data.clone(),
            hours: plan.hours.or(self.hours),
            shard: self.shard,
            ..plan.clone()
        }
    }

    /// What `setup` asks for, with the binaries that are there now.
    ///
    /// # Errors
    /// One line naming a binary that cannot be read.
    pub(super) fn of(setup: &Setup<'_>) -> Result<Self, String> {
        let plan = setup.plan;
        let absolute = |path: &PathBuf| std::path::absolute(path).unwrap_or_else(|_| path.clone());
        Ok(Self {
            suite: plan.suite.clone(),
            controller: plan.controller.clone(),
            settings: plan.settings.clone(),
            seeds: plan.seeds,
            worlds: plan.worlds.as_ref().map(|range| [range.start, range.end]),
            noise: plan.noise.label().to_owned(),
            foresight: plan.foresight,
            data: plan.data.as_ref().map(absolute),
            hours: plan.hours,
            build: build()?,
            shard: plan.shard,
        })
    }
}

/// Makes this the only process that drives the suite; the lock ends with the process.
fn lock(open: &File, file: &Path) -> Result<(), String> {
    flock(open, FlockOperation::NonBlockingLockExclusive).map_err(|error| match error {
        Errno::WOULDBLOCK => format!("{}: another process drives this suite", file.display()),
        error => failed(file, &error.into()),
    })
}

fn failed(file: &Path, error: &std::io::Error) -> String {
    format!("writing {}: {error}", file.display())
}

/// Hash over the stock binaries, this program's among them.
fn build() -> Result<String, String> {
    let mut hash = FNV_OFFSET;
    for role in Role::SERVICES.into_iter().chain([Role::Launch]) {
        let file = binaries::find(Path::new(binaries::stock(role)))?;
        let unreadable = |error: std::io::Error| format!("reading {}: {error}", file.display());
        let mut open = File::open(&file).map_err(unreadable)?;
        let mut part = vec![0; 1 << 20];
        loop {
            let n = open.read(&mut part).map_err(unreadable)?;
            if n == 0 {
                break;
            }
            hash = fnv1a(hash, &part[..n]);
        }
    }
    Ok(format!("{hash:016x}"))
}
