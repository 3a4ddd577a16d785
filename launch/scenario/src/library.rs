//! Where scenarios and the files that they build on come from.
//!
//! What contains a `/` or ends with `.toml` is a path. A name is looked up among the files of the
//! working folder (`launch/scenarios/NAME.toml`, `launch/worlds/NAME.toml`), then among those that
//! are built into the program, so the program works in any folder and files override.
//!
//! The variants of a scenario have names of their own: variant `4m` of `u_trap.toml` is `u_trap_4m`.
//! They are what is listed then; `u_trap` is the file as it is.

use super::error::ScenarioError;
use std::path::{Path, PathBuf};
use zeronav_files::read;
use zeronav_shell::nearest::{nearest, unknown};

/// Largest scenario file. [bytes]
const TEXT_BYTES_MAX: u64 = 4 << 20;

/// The key that holds the variants: tables that are laid over the scenario, by name.
pub(super) const VARIANTS: &str = "variants";

// `SCENARIOS` and `WORLDS`: name and text of the files that users read, listed by `build.rs`.
include!(concat!(env!("OUT_DIR"), "/library.rs"));

/// Which shelf a name is looked up on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Scenario,
    World,
}

impl Kind {
    fn folder(self) -> &'static str {
        match self {
            Self::Scenario => "launch/scenarios",
            Self::World => "launch/worlds",
        }
    }

    fn built_in(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Scenario => &SCENARIOS,
            Self::World => &WORLDS,
        }
    }
}

/// Where a text comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Origin {
    File(PathBuf),
    BuiltIn(&'static str, &'static str),
    /// Name and text of what a command line asks for.
    Made(String, String),
}

impl Origin {
    /// The folder from which its relative paths count; `None` for what is built in.
    pub(super) fn folder(&self) -> Option<&Path> {
        match self {
            Self::File(file) => file.parent(),
            Self::BuiltIn(..) | Self::Made(..) => None,
        }
    }

    /// The name of the scenario: the file's without `.toml`.
    pub(super) fn name(&self) -> String {
        match self {
            Self::File(file) => file
                .file_stem()
                .map(|stem| stem.to_string_lossy().into_owned())
                .unwrap_or_default(),
            Self::BuiltIn(name, _) => (*name).to_owned(),
            Self::Made(name, _) => name.clone(),
        }
    }

    pub(super) fn text(&self) -> Result<String, ScenarioError> {
        let file = match self {
            Self::File(file) => file,
            Self::BuiltIn(_, text) => return Ok((*text).to_owned()),
            Self::Made(_, text) => return Ok(text.clone()),
        };
        read::text(file, TEXT_BYTES_MAX).map_err(|source| ScenarioError::Read {
            file: file.clone(),
            source,
        })
    }
}

impl core::fmt::Display for Origin {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::File(file) => write!(formatter, "{}", file.display()),
            Self::BuiltIn(name, _) => write!(formatter, "(built-in) {name}.toml"),
            Self::Made(name, _) => write!(formatter, "{name}"),
        }
    }
}

/// A scenario that can be run by its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// What it belongs to in a list; empty when its file does not say.
    pub group: String,
    /// Its name.
    pub name: String,
    /// Its title; of a file without a readable one, what is wrong with it.
    pub title: String,
    /// The file; `None` when it is built in.
    pub file: Option<PathBuf>,
    /// Binaries that it names beside the stock ones, not by a path.
    pub binaries: Vec<PathBuf>,
}

/// The scenarios of a working folder and of this program.
#[derive(Debug, Clone)]
pub struct Library {
    folder: PathBuf,
}

impl Library {
    /// What can be run from the folder `working`, empty for that of this process.
    #[must_use]
    pub fn of(working: impl Into<PathBuf>) -> Self {
        Self {
            folder: working.into(),
        }
    }

    /// All scenarios that there are, by group and name.
    #[must_use]
    pub fn list(&self) -> Vec<Listed> {
        let kind = Kind::Scenario;
        let mut names = self.names(kind);
        names.sort();
        names.dedup();
        let mut listed: Vec<Listed> = names
            .into_iter()
            .filter_map(|name| Some((self.named(kind, &name)?, name)))
            .flat_map(|(origin, name)| listed(&origin, name))
            .collect();
        // A file comes before a variant of the same name, here and when it is looked up.
        listed.sort_by(|one, other| (&one.group, &one.name).cmp(&(&other.group, &other.name)));
        listed.dedup_by(|one, other| one.name == other.name);
        listed
    }

    /// The scenario that `name_or_path` means, and which of its variants.
    pub(super) fn scenario(
        &self,
        name_or_path: &str,
    ) -> Result<(Origin, Option<String>), ScenarioError> {
        if is_path(name_or_path) {
            return Ok((Origin::File(self.folder.join(name_or_path)), None));
        }
        let kind = Kind::Scenario;
        if let Some(origin) = self.named(kind, name_or_path) {
            return Ok((origin, None));
        }
        let of_file = |(at, _): (usize, &str)| {
            let (file, variant) = (&name_or_path[..at], &name_or_path[at + 1..]);
            let origin = self.named(kind, file)?;
            let known = variants_of(&table_of(&origin)).any(|(known, _)| known == variant);
            known.then(|| (origin, Some(variant.to_owned())))
        };
        let found = name_or_path.match_indices('_').find_map(of_file);
        found.ok_or_else(|| {
            let known: Vec<String> = self.list().into_iter().map(|listed| listed.name).collect();
            ScenarioError::Unknown {
                name: name_or_path.to_owned(),
                closest: nearest(name_or_path, known.iter().map(String::as_str)).map(str::to_owned),
            }
        })
    }

    /// What `name_or_path` means in a file that lies in `folder`, or why nothing.
    pub(super) fn find(
        &self,
        kind: Kind,
        name_or_path: &str,
        folder: Option<&Path>,
    ) -> Result<Origin, String> {
        if is_path(name_or_path) {
            let file = folder.unwrap_or(&self.folder).join(name_or_path);
            return if file.is_file() {
                Ok(Origin::File(file))
            } else {
                Err(format!("there is no file {}", file.display()))
            };
        }
        self.named(kind, name_or_path).ok_or_else(|| {
            let mut known = self.names(kind);
            known.sort();
            known.dedup();
            unknown("base", name_or_path, known.iter().map(String::as_str))
        })
    }

    fn named(&self, kind: Kind, name: &str) -> Option<Origin> {
        let file = self.folder.join(kind.folder()).join(format!("{name}.toml"));
        if file.is_file() {
            return Some(Origin::File(file));
        }
        kind.built_in()
            .iter()
            .find(|(known, _)| *known == name)
            .map(|(name, text)| Origin::BuiltIn(name, text))
    }

    fn names(&self, kind: Kind) -> Vec<String> {
        let built_in = kind.built_in().iter().map(|(name, _)| (*name).to_owned());
        let files = std::fs::read_dir(self.folder.join(kind.folder()));
        let files = files
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| entry.path())
            .filter(|file| file.extension().is_some_and(|end| end == "toml"))
            .filter_map(|file| Some(file.file_stem()?.to_str()?.to_owned()));
        built_in.chain(files).collect()
    }
}

fn is_path(name_or_path: &str) -> bool {
    name_or_path.contains('/')
        || Path::new(name_or_path)
            .extension()
            .is_some_and(|end| end == "toml")
}

/// The variants of a scenario, or the scenario when it has none.
fn listed(origin: &Origin, name: String) -> Vec<Listed> {
    let table = table_of(origin);
    let word = |table: &toml::Table, key: &str| {
        let word = table.get(key).and_then(toml::Value::as_str);
        word.map(str::to_owned)
    };
    let title = word(&table, "title").unwrap_or_else(|| match origin.text() {
        Ok(_) => "(no readable title)".to_owned(),
        Err(error) => format!("({error})"),
    });
    let group = word(&table, "group").unwrap_or_default();
    let file = match origin {
        Origin::File(file) => Some(file.clone()),
        Origin::BuiltIn(..) | Origin::Made(..) => None,
    };
    let of_variant = |(variant, changes): (&str, &toml::Table)| Listed {
        group: group.clone(),
        name: format!("{name}_{variant}"),
        title: word(changes, "title").unwrap_or_else(|| title.clone()),
        file: file.clone(),
        binaries: binaries_in([changes].into_iter().chain(services_of(&table))),
    };
    let variants: Vec<Listed> = variants_of(&table).map(of_variant).collect();
    if !variants.is_empty() {
        return variants;
    }
    vec![Listed {
        group,
        name,
        title,
        file,
        binaries: binaries_in([&table]),
    }]
}

/// What a file with variants says of the services of all of them.
fn services_of(table: &toml::Table) -> impl Iterator<Item = &toml::Table> {
    let services = table.get("services").and_then(toml::Value::as_table);
    services.into_iter()
}

/// The binaries that tables name, not by a path.
fn binaries_in<'a>(tables: impl IntoIterator<Item = &'a toml::Table>) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open: Vec<&toml::Table> = tables.into_iter().collect();
    while let Some(table) = open.pop() {
        for (key, value) in table {
            match value {
                toml::Value::String(name) if key == "binary" && !name.contains('/') => {
                    found.push(PathBuf::from(name));
                }
                toml::Value::Table(inner) => open.push(inner),
                toml::Value::Array(list) => {
                    open.extend(list.iter().filter_map(toml::Value::as_table));
                }
                _ => {}
            }
        }
    }
    found
}

/// The table of a scenario's own file; empty when it is none.
fn table_of(origin: &Origin) -> toml::Table {
    let text = origin.text().unwrap_or_default();
    text.parse().unwrap_or_default()
}

/// The names of the variants of the scenario in `file`.
pub(super) fn variants_in(file: &Path) -> Vec<String> {
    let table = table_of(&Origin::File(file.to_owned()));
    variants_of(&table)
        .map(|(name, _)| name.to_owned())
        .collect()
}

/// Name and changes of the variants of a scenario's own file.
fn variants_of(table: &toml::Table) -> impl Iterator<Item = (&str, &toml::Table)> {
    let variants = table.get(VARIANTS).and_then(toml::Value::as_table);
    let variants = variants.into_iter().flatten();
    variants.filter_map(|(name, changes)| Some((name.as_str(), changes.as_table()?)))
}
