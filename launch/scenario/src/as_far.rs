//! A scenario and everything that is wrong with it, at once.

use super::check::{Checked, Examined};
use super::document::{self, Reading};
use super::library::Origin;
use super::{Library, Scenario, ScenarioError, absolute, binaries_of, files_of, hosts};
use std::path::Path;

/// A scenario as far as it could be read.
#[derive(Debug)]
pub struct AsFar {
    /// What was read of it.
    pub scenario: Scenario,
    /// Everything that is wrong with what was read.
    pub wrong: Vec<ScenarioError>,
    /// Fields whose value is not that of the file, because that cannot be read: nothing that is
    /// found about them is of use.
    pub(super) doubtful: Vec<String>,
}

impl AsFar {
    /// The scenario when everything could be read, or else everything that is wrong with it.
    ///
    /// # Errors
    /// All that is wrong, a line each.
    pub fn whole(mut self) -> Result<Scenario, ScenarioError> {
        if self.wrong.is_empty() {
            return Ok(self.scenario);
        }
        self.examine();
        match ScenarioError::of(self.wrong) {
            Some(error) => Err(error),
            None => Ok(self.scenario),
        }
    }

    /// Adds what [`Scenario::validate`] finds to what is wrong; the world when it could be made.
    pub fn examine(&mut self) -> Option<Checked> {
        let Examined { checked, wrong } = self.scenario.examine();
        for error in wrong {
            if !self.is_known(&error) {
                self.wrong.push(error);
            }
        }
        checked
    }

    /// True for an error about a value that is known to be wrong, or about what lies in it.
    fn is_known(&self, error: &ScenarioError) -> bool {
        let Some(field) = error.field() else {
            return false;
        };
        let known = self.wrong.iter().filter_map(ScenarioError::field);
        let mut known = known.chain(self.doubtful.iter().map(String::as_str));
        known.any(|known| {
            let rest = field.strip_prefix(known);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        })
    }
}

impl From<Scenario> for AsFar {
    fn from(scenario: Scenario) -> Self {
        Self {
            scenario,
            wrong: Vec::new(),
            doubtful: Vec::new(),
        }
    }
}

impl Scenario {
    /// Reads the scenario that a name or a path means from the working folder of this process.
    /// [`Self::validate`] tells whether it can work.
    ///
    /// # Errors
    /// See [`ScenarioError`].
    pub fn load(name_or_path: &str) -> Result<Self, ScenarioError> {
        Self::load_from(&Library::of(""), name_or_path)
    }

    /// Like [`Self::load`] from the working folder of `library`.
    ///
    /// # Errors
    /// See [`ScenarioError`]; with a value that cannot be read also what [`Self::validate`] finds
    /// wrong with the others.
    pub fn load_from(library: &Library, name_or_path: &str) -> Result<Self, ScenarioError> {
        let (origin, variant) = library.scenario(name_or_path)?;
        Self::read(library, origin, variant.as_deref())?.whole()
    }

    pub(super) fn read(
        library: &Library,
        origin: Origin,
        variant: Option<&str>,
    ) -> Result<AsFar, ScenarioError> {
        let name = match variant {
            Some(variant) => format!("{}_{variant}", origin.name()),
            None => origin.name(),
        };
        let folder = origin.folder().map(Path::to_path_buf);
        let Reading {
            value,
            document,
            wrong,
            doubtful,
        } = document::read::<Self>(library, origin, variant)?;
        let Some(mut scenario) = value else {
            return Err(ScenarioError::of(wrong)
                .unwrap_or_else(|| document.at_field("scenario", "cannot be read")));
        };
        for (field, file) in files_of(&mut scenario.world) {
            let folder = document.folder_of(field).unwrap_or(Path::new(""));
            *file = absolute(&folder.join(&*file));
        }
        for (index, zone) in scenario.zones.iter_mut().enumerate() {
            let field = format!("zones[{index}].mask");
            if let Some(mask) = &mut zone.mask {
                let folder = document.folder_of(&field).unwrap_or(Path::new(""));
                *mask = absolute(&folder.join(&*mask));
            }
        }
        for (field, binary) in binaries_of(&mut scenario) {
            if let Some(folder) = document.folder_of(&field)
                && binary.components().count() > 1
                && folder.join(&*binary).is_file()
            {
                *binary = absolute(&folder.join(&*binary));
            }
        }
        for (field, keys) in hosts::keys_of(&mut scenario.hosts) {
            let folder = document.folder_of(&field).unwrap_or(Path::new(""));
            *keys = absolute(&folder.join(&*keys));
        }
        let scenario = Self {
            name,
            folder,
            document,
            ..scenario
        };
        Ok(AsFar {
            scenario,
            wrong,
            doubtful,
        })
    }

    /// Like [`Self::load`], but leaves what is wrong with single values beside it.
    ///
    /// # Errors
    /// When nothing can be read at all.
    pub fn load_as_far(name_or_path: &str) -> Result<AsFar, ScenarioError> {
        let library = Library::of("");
        let (origin, variant) = library.scenario(name_or_path)?;
        Self::read(&library, origin, variant.as_deref())
    }
}
