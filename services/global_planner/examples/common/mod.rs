//! What the examples share: maps from files and numbers for tables.

#![allow(dead_code, reason = "every example uses its own part")]
#![allow(unreachable_pub, reason = "a module of several examples")]

#[path = "../../tests/support/movingai.rs"]
pub mod movingai;

use movingai::{GridMap, Scenario};
use std::path::{Path, PathBuf};
use zeronav_casts::Cast;

/// A map and its questions.
pub struct Set {
    /// Name of the file.
    pub name: String,
    pub map: GridMap,
    pub scenarios: Vec<Scenario>,
}

/// The `.map` files of a folder that have a `.map.scen` beside them, by name.
pub fn map_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries =
        std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|file| file.extension().is_some_and(|extension| extension == "map"))
        .filter(|file| scenario_file(file).exists())
        .collect();
    files.sort();
    if files.is_empty() {
        return Err(format!(
            "{}: no .map file with a .map.scen file beside it",
            folder.display()
        ));
    }
    Ok(files)
}

fn scenario_file(map: &Path) -> PathBuf {
    let mut name = map.as_os_str().to_owned();
    name.push(".scen");
    PathBuf::from(name)
}

/// Reads a map and at most `sample` of its questions, spread evenly over the file.
pub fn read_set(file: &Path, sample: Option<usize>) -> Result<Set, String> {
    let read = |file: &Path| {
        std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))
    };
    let map =
        GridMap::parse(&read(file)?).map_err(|error| format!("{}: {error}", file.display()))?;
    let questions = scenario_file(file);
    let all = Scenario::parse_all(&read(&questions)?, &map.geometry)
        .map_err(|error| format!("{}: {error}", questions.display()))?;
    let name = file
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    Ok(Set {
        name,
        map,
        scenarios: spread(&all, sample),
    })
}

/// At most `n` items, spread evenly.
pub fn spread<T: Copy>(items: &[T], n: Option<usize>) -> Vec<T> {
    match n {
        Some(n) if n < items.len() => (0..n).map(|k| items[k * items.len() / n]).collect(),
        _ => items.to_vec(),
    }
}

/// Geometric mean, smallest and largest.
pub fn spread_of(ratios: &[f64]) -> (f64, f64, f64) {
    let mean = (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len().to_f64()).exp();
    let min = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let max = ratios.iter().copied().fold(0.0, f64::max);
    (mean, min, max)
}
