//! Where scenarios and the files that they build on come from.
//!
//! What contains a `/` or ends with `.toml` is a path. A name is looked up among the files of the
//! working folder (`launch/scenarios/NAME.toml`, `launch/worlds/NAME.toml`), then among those that
//! are built into the program, so the program works in any folder and files override.

use super::error::{ScenarioError, closest};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest scenario file. [bytes]
const TEXT_BYTES_MAX: u64 = 4 << 20;

/// Name and text of the scenarios in this program. The files are those that users read.
const SCENARIOS: [(&str, &str); 9] = [
    (
        "blocked_aisle",
        include_str!("../../scenarios/blocked_aisle.toml"),
    ),
    (
        "crossing_cart",
        include_str!("../../scenarios/crossing_cart.toml"),
    ),
    (
        "crossing_walkers",
        include_str!("../../scenarios/crossing_walkers.toml"),
    ),
    (
        "door_closes",
        include_str!("../../scenarios/door_closes.toml"),
    ),
    (
        "moving_discs",
        include_str!("../../scenarios/moving_discs.toml"),
    ),
    (
        "open_aisle",
        include_str!("../../scenarios/open_aisle.toml"),
    ),
    ("sealed", include_str!("../../scenarios/sealed.toml")),
    (
        "swap_planner",
        include_str!("../../scenarios/swap_planner.toml"),
    ),
    ("unsealed", include_str!("../../scenarios/unsealed.toml")),
];

/// Name and text of what they build on.
const WORLDS: [(&str, &str); 6] = [
    ("jackal", include_str!("../../worlds/jackal.toml")),
    ("porter", include_str!("../../worlds/porter.toml")),
    ("turtlebot2", include_str!("../../worlds/turtlebot2.toml")),
    (
        "turtlebot3_burger",
        include_str!("../../worlds/turtlebot3_burger.toml"),
    ),
    ("two_rooms", include_str!("../../worlds/two_rooms.toml")),
    ("warehouse", include_str!("../../worlds/warehouse.toml")),
];

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
}

impl Origin {
    /// The folder from which its relative paths count; `None` for what is built in.
    pub(super) fn folder(&self) -> Option<&Path> {
        match self {
            Self::File(file) => file.parent(),
            Self::BuiltIn(..) => None,
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
        }
    }

    pub(super) fn text(&self) -> Result<String, ScenarioError> {
        let file = match self {
            Self::File(file) => file,
            Self::BuiltIn(_, text) => return Ok((*text).to_owned()),
        };
        let mut text = String::new();
        // One byte more than allowed tells too large from just large enough.
        std::fs::File::open(file)
            .and_then(|opened| opened.take(TEXT_BYTES_MAX + 1).read_to_string(&mut text))
            .and_then(|length| {
                let fits = length as u64 <= TEXT_BYTES_MAX;
                fits.then_some(()).ok_or_else(|| {
                    let why = format!("more than {TEXT_BYTES_MAX} bytes");
                    std::io::Error::new(std::io::ErrorKind::FileTooLarge, why)
                })
            })
            .map_err(|source| ScenarioError::Read {
                file: file.clone(),
                source,
            })?;
        Ok(text)
    }
}

impl core::fmt::Display for Origin {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::File(file) => write!(formatter, "{}", file.display()),
            Self::BuiltIn(name, _) => write!(formatter, "(built-in) {name}.toml"),
        }
    }
}

/// A scenario that can be run by its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// Its name.
    pub name: String,
    /// Its title; of a file without a readable one, what is wrong with it.
    pub title: String,
    /// The file; `None` when it is built in.
    pub file: Option<PathBuf>,
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

    /// All scenarios that a name can mean, by name.
    #[must_use]
    pub fn list(&self) -> Vec<Listed> {
        let kind = Kind::Scenario;
        let mut names = self.names(kind);
        names.sort();
        names.dedup();
        names
            .into_iter()
            .filter_map(|name| {
                let origin = self.named(kind, &name)?;
                let title = match origin.text() {
                    Ok(text) => title_of(&text),
                    Err(error) => format!("({error})"),
                };
                let file = match origin {
                    Origin::File(file) => Some(file),
                    Origin::BuiltIn(..) => None,
                };
                Some(Listed { name, title, file })
            })
            .collect()
    }

    /// The scenario that `name_or_path` means.
    pub(super) fn scenario(&self, name_or_path: &str) -> Result<Origin, ScenarioError> {
        if is_path(name_or_path) {
            return Ok(Origin::File(self.folder.join(name_or_path)));
        }
        let kind = Kind::Scenario;
        self.named(kind, name_or_path).ok_or_else(|| {
            let mut known = self.names(kind);
            known.sort();
            known.dedup();
            ScenarioError::Unknown {
                name: name_or_path.to_owned(),
                closest: closest(name_or_path, &known).map(str::to_owned),
                known,
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
            let known = known.join(", ");
            format!("there is no `{name_or_path}` to build on; known are {known}")
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

fn title_of(text: &str) -> String {
    let title = text
        .parse::<toml::Table>()
        .ok()
        .and_then(|table| Some(table.get("title")?.as_str()?.to_owned()));
    title.unwrap_or_else(|| "(no readable title)".to_owned())
}
