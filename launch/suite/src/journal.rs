//! The journal of a suite: what it was asked for, and one line per finished run, so that a suite
//! that was interrupted can go on where it stopped.

use super::case::Case;
use super::hindsight::ContactRow;
use super::plan::Setup;
use super::row::Row;
use super::soak::soaked::Soaked;
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
}

/// A run that has finished.
#[derive(Debug, Serialize, Deserialize)]
struct Entry {
    key: String,
    row: Row,
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

/// The journal, open for more.
#[derive(Debug)]
pub(super) struct Journal {
    file: PathBuf,
    open: File,
    /// The rows that it holds by [`key`].
    rows: BTreeMap<String, Row>,
    /// Wall time that a soak has used. [s]
    used_s: f64,
}

/// Names a run: its scenario and its seed.
pub(super) fn key(case: &Case) -> String {
    let name = case.scenario.file_stem().unwrap_or_default();
    format!("{}-seed{}", name.to_string_lossy(), case.seed)
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
        let mut journal = Self {
            file,
            open,
            rows: BTreeMap::new(),
            used_s: 0.0,
        };
        journal.append(order)?;
        Ok(journal)
    }

    /// Opens the journal of a suite that shall go on: what was asked for, and what there is.
    ///
    /// # Errors
    /// One line naming the file and what is wrong with it.
    pub(super) fn resume(directory: &Path) -> Result<(Order, Self), String> {
        let file = directory.join(NAME);
        let nothing = |error| format!("nothing to resume, {}: {error}", file.display());
        let folder = Folder::open(directory).map_err(nothing)?;
        let text = read::text(&file, read::RESULT_BYTES_MAX).map_err(nothing)?;
        // A line without its end was being written when the suite was killed.
        let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
        let mut lines = whole.lines();
        let unusable = |line: usize, error: &dyn core::fmt::Display| {
            format!("nothing to resume, {}:{line}: {error}", file.display())
        };
        let order: Order = serde_json::from_str(lines.next().unwrap_or_default())
            .map_err(|error| unusable(1, &error))?;
        let mut rows = BTreeMap::new();
        let mut used_s: f64 = 0.0;
        for (n, line) in lines.enumerate() {
            if let Ok(used) = serde_json::from_str::<Used>(line) {
                used_s = used_s.max(used.used_s);
                continue;
            }
            let entry: Entry =
                serde_json::from_str(line).map_err(|error| unusable(n + 2, &error))?;
            let row = Row {
                contacts: entry.contacts,
                soaked: entry.soaked,
                ..entry.row
            };
            rows.insert(entry.key, row);
        }
        let open = folder
            .append(NAME)
            .and_then(|open| open.set_len(whole.len() as u64).map(|()| open))
            .map_err(|error| failed(&file, &error))?;
        let journal = Self {
            file,
            open,
            rows,
            used_s,
        };
        Ok((order, journal))
    }

    /// The row of a run that has finished.
    pub(super) fn row(&self, case: &Case) -> Option<&Row> {
        self.rows.get(&key(case))
    }

    /// Notes a run that has finished.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn note(&mut self, case: &Case, row: Row) -> Result<(), String> {
        let entry = Entry {
            key: key(case),
            contacts: row.contacts.clone(),
            soaked: row.soaked.clone(),
            row,
        };
        self.append(&entry)?;
        self.rows.insert(entry.key, entry.row);
        Ok(())
    }

    /// Wall time that a soak has used, in all of its calls. [s]
    pub(super) fn used_s(&self) -> f64 {
        self.used_s
    }

    /// Notes how much that is by now.
    ///
    /// # Errors
    /// One line naming the file.
    pub(super) fn use_up(&mut self, used_s: f64) -> Result<(), String> {
        self.used_s = used_s;
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
        })
    }
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
