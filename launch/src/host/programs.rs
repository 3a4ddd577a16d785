//! What is started in the seats of a host for the launch of another: what the scenario names for a seat, and after a
//! swap another of its programs, or the same with other keys.

use crate::prepare::Prepared;
use crate::swap::config::{GIVEN, merged};
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use zeronav_msgs::role::Role;
use zeronav_shell::remote_seats::{KEYS_BYTES_MAX, SeatStart, Wanted};
use zeronav_supervise::binaries;

/// A program and its configuration.
type Files = (PathBuf, PathBuf);

/// See the module's description.
pub(super) struct Programs {
    /// Of each seat the one of the scenario, then those of its shadow and swaps, and the stock one.
    named: BTreeMap<Role, Vec<PathBuf>>,
    configs: BTreeMap<Role, PathBuf>,
    root: PathBuf,
}

impl Programs {
    /// What the scenario names; `configs` are those of its programs.
    pub(super) fn new(prepared: &Prepared, configs: BTreeMap<Role, PathBuf>, root: &Path) -> Self {
        let named = prepared.binaries.iter().map(|(role, binary)| {
            let swaps = prepared.swaps.iter().map(|(_, order)| order);
            let swaps = swaps.filter(|order| order.role == role.label());
            let mut all = vec![binary.clone()];
            all.extend(swaps.filter_map(|order| order.binary.clone()));
            all.extend(binaries::find(Path::new(binaries::stock(*role))));
            (*role, all)
        });
        Self {
            named: named.collect(),
            configs,
            root: root.to_owned(),
        }
    }

    /// What a start comes to. The other host chooses among what this host's scenario names, and sets keys: it may not
    /// start anything else here.
    ///
    /// # Errors
    /// One line: what there is not, or cannot be.
    pub(super) fn files(&self, role: Role, wanted: &Wanted) -> Result<Files, String> {
        let none = || format!("{role} is no seat of this host");
        let named = self.named.get(&role).ok_or_else(none)?;
        let (incumbent, config) = (
            named.first().ok_or_else(none)?,
            self.configs.get(&role).ok_or_else(none)?,
        );
        let program = &wanted.program;
        if program.binary.is_empty() && program.keys.is_empty() {
            return Ok((incumbent.clone(), config.clone()));
        }
        let is_it = |path: &&PathBuf| path.file_name() == Some(OsStr::new(&program.binary));
        let binary = if program.binary.is_empty() {
            incumbent
        } else {
            named
                .iter()
                .find(is_it)
                .ok_or_else(|| no_program(role, &program.binary, named))?
        };
        if program.keys.len() > KEYS_BYTES_MAX {
            return Err(format!("more than {KEYS_BYTES_MAX} bytes of keys"));
        }
        let table = |text: &str| toml::from_str(text).map_err(|error| error.to_string());
        let text = std::fs::read_to_string(config);
        let text = text.map_err(|error| format!("{}: {error}", config.display()))?;
        let keys: toml::Table = table(&program.keys)?;
        // Where the map lies, and how large it is, each host knows for itself.
        let given = GIVEN.iter().filter(|_| role == Role::Mapping);
        if let Some(key) = given.into_iter().find(|key| keys.contains_key(**key)) {
            return Err(format!("{key} is not set from another host"));
        }
        let table = merged(table(&text)?, role, binary == incumbent, keys);
        let file = self.file(role, wanted.seat);
        std::fs::write(&file, table.to_string())
            .map_err(|error| format!("writing {}: {error}", file.display()))?;
        Ok((binary.clone(), file))
    }

    /// Configuration of a start of its own. Another start with the same epoch comes after a restart of the robot's host
    /// alone, and to a new folder.
    fn file(&self, role: Role, seat: SeatStart) -> PathBuf {
        self.root.join(format!("{role}.{}.toml", seat.epoch))
    }

    /// Removes what was written for a start that has ended.
    pub(super) fn forget(&self, seat: SeatStart) {
        if let Some(role) = seat.role() {
            // Most have none.
            let _ = std::fs::remove_file(self.file(role, seat));
        }
    }
}

fn no_program(role: Role, name: &str, named: &[PathBuf]) -> String {
    let names = named.iter().filter_map(|path| path.file_name());
    let mut names: Vec<_> = names.map(|name| name.to_string_lossy()).collect();
    names.dedup();
    format!(
        "the scenario names no `{name}` for {role}, but {}",
        names.join(", ")
    )
}
