//! The folders of the data sets: which worlds are there, and what their index says.

use crate::cli::SuiteArgs;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// A world that a suite runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct WorldFile {
    /// Name of its file without the ending.
    pub(super) name: String,
    /// Its number, by which `--worlds` picks: the one in its name, or else its place in the
    /// alphabet.
    pub(super) number: u32,
    /// The file.
    pub(super) file: PathBuf,
}

/// The folder of a data set below `--data`.
///
/// # Errors
/// One line when it is not there.
pub(super) fn folder(arguments: &SuiteArgs, part: &str) -> Result<PathBuf, String> {
    let folder = arguments.data.join(part);
    if folder.is_dir() {
        return Ok(absolute(&folder));
    }
    Err(format!(
        "there is no folder {}: name the one that holds {part} with --data",
        folder.display()
    ))
}

/// The worlds `PREFIX*.ENDING` of a folder that `--worlds` asks for, by number.
///
/// # Errors
/// One line when there is none.
pub(super) fn worlds(
    arguments: &SuiteArgs,
    folder: &Path,
    prefix: &str,
    ending: &str,
) -> Result<Vec<WorldFile>, String> {
    let entries = std::fs::read_dir(folder)
        .map_err(|error| format!("reading the folder {}: {error}", folder.display()))?;
    let mut files: Vec<(String, PathBuf)> = entries
        .flatten()
        .filter_map(|entry| {
            let file = entry.path();
            let name = file.file_stem()?.to_str()?.to_owned();
            let is_world = name.starts_with(prefix)
                && name != "index"
                && file.extension().is_some_and(|own| own == ending);
            is_world.then_some((name, file))
        })
        .collect();
    files.sort();
    let worlds: Vec<WorldFile> = files
        .into_iter()
        .enumerate()
        .map(|(place, (name, file))| WorldFile {
            number: name
                .strip_prefix(prefix)
                .filter(|_| !prefix.is_empty())
                .and_then(|digits| digits.parse().ok())
                .unwrap_or_else(|| u32::try_from(place).unwrap_or(u32::MAX)),
            name,
            file: absolute(&file),
        })
        .filter(|world| {
            let wanted = arguments.worlds.as_ref();
            wanted.is_none_or(|wanted| wanted.contains(&world.number))
        })
        .collect();
    if !worlds.is_empty() {
        return Ok(worlds);
    }
    let wanted = arguments.worlds.as_ref().map_or_else(String::new, |range| {
        format!(" with a number in {}..{}", range.start, range.end)
    });
    Err(format!(
        "no file {prefix}*.{ending}{wanted} in {}",
        folder.display()
    ))
}

/// The rows of a CSV file with a header.
///
/// # Errors
/// One line naming file and place.
pub(super) fn index<T: DeserializeOwned>(file: &Path) -> Result<Vec<T>, String> {
    let failed = |error: csv::Error| format!("reading {}: {error}", file.display());
    csv::Reader::from_path(file)
        .map_err(failed)?
        .into_deserialize()
        .map(|row| row.map_err(failed))
        .collect()
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}
