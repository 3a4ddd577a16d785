//! Finding the programs that a scenario names: of services, of what takes their place, and of companions.

use std::path::{Path, PathBuf};
use zeronav_scenario::Scenario;
use zeronav_supervise::binaries;

/// The program `name`, which stands in the `field` of a scenario; when there is none, that is `wrong`.
pub(crate) fn named(
    scenario: &Scenario,
    field: &str,
    name: &Path,
    wrong: &mut Vec<String>,
) -> Option<PathBuf> {
    let found = binaries::find_or_build(name);
    let refused = |why: String| wrong.push(scenario.error_at(field, &why).to_string());
    found.map_err(refused).ok()
}
