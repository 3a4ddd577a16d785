//! A recording as it is read again: how its run was driven, and its messages.

pub(crate) mod drive;
pub(crate) mod notes;

use crate::bag::input::open;
use std::path::{Path, PathBuf};
use zeronav_import::recording::{IMPORTED, MAP};
use zeronav_msgs::run::RunMode;
use zeronav_recorder::file::{
    DRIVEN_BY, DRIVEN_BY_SCENARIO, SCENARIO_BYTES_MAX, SCENARIO_TYPE, START,
};
use zeronav_recorder::read::{Summary, attachment, summary};
use zeronav_recorder::verdict::{END_TICK, VERDICT};

/// The tick with which a recorded run ended, where its recording says so.
pub(crate) fn end_tick(found: &Summary) -> Option<u64> {
    let tick = found.metadata.get(VERDICT)?.get(END_TICK)?;
    tick.parse().ok()
}

/// The map of an imported recording, which lies beside it wherever that is.
fn map_beside(file: &Path, found: &Summary) -> Option<PathBuf> {
    let name = found.metadata.get(IMPORTED)?.get(MAP)?;
    // A name, and no way to somewhere else.
    let is_name = Path::new(name).file_name().is_some_and(|it| it == &**name);
    let beside = is_name.then(|| file.with_file_name(name))?;
    std::path::absolute(beside).ok()
}

/// The scenario `text` with this map for mapping.
fn with_map(text: &str, map: &Path) -> Result<String, String> {
    let failed = |error: &dyn core::fmt::Display| format!("its scenario: {error}");
    let mut table: toml::Table = toml::from_str(text).map_err(|error| failed(&error))?;
    let mut at = &mut table;
    for name in ["services", "mapping", "config"] {
        let below = at.entry(name).or_insert_with(|| toml::Table::new().into());
        at = below
            .as_table_mut()
            .ok_or_else(|| failed(&format!("{name} is no table")))?;
    }
    let map = map
        .to_str()
        .ok_or_else(|| failed(&"the name of its map is no UTF-8"))?;
    at.insert("static_map".to_owned(), map.into());
    toml::to_string(&table).map_err(|error| failed(&error))
}

/// How the run in a recording was driven.
#[derive(Debug)]
pub(crate) struct Recorded {
    pub found: Summary,
    /// Name and text of its scenario.
    pub scenario: Option<(String, String)>,
    pub seed: u64,
    pub tick_ns: u64,
}

impl Recorded {
    /// Reads the recording in `file`.
    ///
    /// # Errors
    /// One line naming the file.
    pub(crate) fn read(file: &Path) -> Result<Self, String> {
        let wrong = |why: &dyn core::fmt::Display| format!("{}: {why}", file.display());
        let (found, damage) = summary(open(file)?);
        if let Some(damage) = damage {
            // Of what is no recording nothing can be made whole.
            let fix = if found.profile.is_empty() {
                "; it is no MCAP file of `zeronav run --record`, and `zeronav import` reads logs of other robots"
            } else {
                "; `zeronav bag recover` makes a whole file of what is there"
            };
            return Err(wrong(&format!("{damage}{fix}")));
        }
        if !found.metadata.contains_key(START) {
            let why =
                "zeronav-recorder has not written it; `zeronav import` reads logs of other robots";
            return Err(wrong(&why));
        }
        let most = usize::try_from(SCENARIO_BYTES_MAX).unwrap_or(usize::MAX);
        let attached =
            attachment(open(file)?, SCENARIO_TYPE, most).map_err(|error| wrong(&error))?;
        let scenario = attached.map(|(name, text)| {
            let text = String::from_utf8(text).map_err(|_| wrong(&"its scenario is no UTF-8"))?;
            let text = match map_beside(file, &found) {
                Some(map) => with_map(&text, &map).map_err(|error| wrong(&error))?,
                None => text,
            };
            Ok::<_, String>((name.strip_suffix(".toml").unwrap_or(&name).to_owned(), text))
        });
        let number = |name: &str| {
            let field = found.metadata.get(START).and_then(|it| it.get(name));
            let number = field.and_then(|field| field.parse::<u64>().ok());
            number.ok_or_else(|| wrong(&format!("it does not say its {name}")))
        };
        Ok(Self {
            seed: number("seed")?,
            tick_ns: number("tick_ns")?.max(1),
            scenario: scenario.transpose()?,
            found,
        })
    }

    pub(crate) fn field(&self, name: &str) -> Option<&str> {
        let fields = self.found.metadata.get(START)?;
        fields.get(name).map(String::as_str)
    }

    /// Who decided where the robot drove.
    pub(crate) fn driven_by(&self) -> Option<&str> {
        self.field(DRIVEN_BY)
    }

    pub(crate) fn is_lockstep(&self) -> bool {
        self.field("mode") == Some(RunMode::Lockstep.label())
    }

    /// Name and text of the scenario that drove the run in lockstep alone, so that it can be driven again.
    ///
    /// # Errors
    /// Why it cannot.
    pub(crate) fn drive(&self) -> Result<(String, String), String> {
        const OPEN: &str = "`--open ROLE` plays it to a seat";
        if !self.is_lockstep() {
            return Err(format!(
                "it was recorded in real time, which nothing can drive again the same: `zeronav run SCENARIO \
                 --lockstep --record` makes one that can; {OPEN}"
            ));
        }
        if self
            .driven_by()
            .is_some_and(|who| who != DRIVEN_BY_SCENARIO)
        {
            return Err(format!(
                "clients, or processes that were started by hand, drove it, which is not known to the scenario; {OPEN}"
            ));
        }
        self.scenario.clone().ok_or_else(|| {
            format!("it holds no scenario: only a recording of `zeronav run --record` does; {OPEN}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_looked_for_beside_the_recording_alone() {
        let beside = |name: &str| {
            let fields = [(MAP.to_owned(), name.to_owned())].into();
            let found = Summary {
                metadata: [(IMPORTED.to_owned(), fields)].into(),
                ..Summary::default()
            };
            map_beside(Path::new("/a/it.mcap"), &found)
        };
        assert_eq!(beside("m.yaml"), Some(PathBuf::from("/a/m.yaml")));
        for bad in ["../m.yaml", "/etc/m.yaml", "b/m.yaml", "..", ""] {
            assert_eq!(beside(bad), None, "{bad}");
        }
        let text = "start = [0.0, 0.0, 0.0]\n[services.mapping]\nconfig.static_map = \"m.yaml\"\n";
        let with = with_map(text, Path::new("/a/m.yaml")).expect("a scenario");
        let table: toml::Table = toml::from_str(&with).expect("TOML");
        let map = &table["services"]["mapping"]["config"]["static_map"];
        assert_eq!(map.as_str(), Some("/a/m.yaml"));
        let error = with_map("services = 1", Path::new("/a/m.yaml")).expect_err("none");
        assert!(error.contains("services is no table"), "{error}");
    }
}
