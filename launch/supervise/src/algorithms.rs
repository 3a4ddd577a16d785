//! The algorithms that the stock service of a seat can name, in its own words.

use super::binaries;
use super::question;
use core::fmt::Display;
use std::path::Path;
use zeronav_msgs::role::Role;
use zeronav_params::Parameter;
use zeronav_shell::nearest::unknown;

/// An algorithm: key and one line for people.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Algorithm {
    /// What a configuration calls it.
    pub key: String,
    /// One line for people.
    pub title: String,
}

/// All of the stock service in the seat of `role`.
///
/// # Errors
/// One line when it cannot be asked.
pub fn of(role: Role) -> Result<Vec<Algorithm>, String> {
    let binary = binaries::find(Path::new(binaries::stock(role)))?;
    let listed = question::ask(&binary, &["--list".as_ref()])
        .map_err(|silence| format!("{} --list: {silence}", binary.display()))?;
    let algorithm = |line: &str| {
        let (key, title) = line.split_once('\t')?;
        Some(Algorithm {
            key: key.to_owned(),
            title: title.to_owned(),
        })
    };
    Ok(listed.lines().filter_map(algorithm).collect())
}

/// The parameters of the service in `binary`.
///
/// # Errors
/// One line when it cannot be asked, or answers with something else.
pub fn parameters_of(binary: &Path) -> Result<Vec<Parameter>, String> {
    let binary = binaries::find(binary)?;
    let complaint = |why: &dyn Display| format!("{} --print-params: {why}", binary.display());
    let text = question::ask(&binary, &["--print-params".as_ref()])
        .map_err(|silence| complaint(&silence))?;
    serde_json::from_str(&text).map_err(|error| complaint(&error))
}

/// Accepts the key of a controller of the stock local planner.
///
/// # Errors
/// One line that names the nearest.
pub fn check_controller(key: &str) -> Result<(), String> {
    let known = of(Role::LocalPlanner)?;
    if known.iter().any(|one| one.key == key) {
        return Ok(());
    }
    let known = known.iter().map(|one| one.key.as_str());
    Err(format!(
        "--controller: {}",
        unknown("controller", key, known)
    ))
}
