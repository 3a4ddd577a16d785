//! The folders of the data sets: which worlds are there, and what their index says.

use super::plan::SuitePlan;
use serde::de::DeserializeOwned;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A world that a suite runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct WorldFile {
    /// Name of its file without the ending.
    pub(super) name: String,
    /// Its number, by which `--worlds` picks: the one in its name, or else its place in the
    /// alphabet.
    pub(super) number: u32,
    /// The file; empty for a world that is drawn from its number.
    pub(super) file: PathBuf,
}

/// A data set of others: the name of its folder, where it comes from, and how it is laid out.
#[derive(Debug, Clone, Copy)]
pub(super) struct DataSet {
    /// Its folder below `--data`.
    pub(super) part: &'static str,
    /// Its home.
    pub(super) home: &'static str,
    /// Its files.
    pub(super) layout: &'static str,
}

/// Static worlds.
pub(super) const BARN: DataSet = DataSet {
    part: "barn",
    home: "github.com/Daffan/the-barn-challenge (jackal_helper/worlds/BARN)",
    layout: "index.csv with world,path_length_m,ot_s and worlds/world_NNN.csv with x_m,y_m,r_m per \
             cylinder",
};

/// Worlds of moving cylinders.
pub(super) const DYNABARN: DataSet = DataSet {
    part: "dynabarn",
    home: "github.com/Daffan/the-barn-challenge (jackal_helper/worlds/DynaBARN)",
    layout: "index.csv with world,difficulty and world_NN.csv with \
             obstacle,plugin,period_s,t_s,x_m,y_m per key frame",
};

/// Recorded people.
pub(super) const PEDESTRIANS: DataSet = DataSet {
    part: "pedestrians",
    home: "github.com/abduallahmohamed/Social-STGCNN (datasets/raw/all_data)",
    layout: "NAME.csv with t_s,id,x_m,y_m per sample, sorted by time and id",
};

/// Occupancy maps.
pub(super) const ROSMAPS: DataSet = DataSet {
    part: "rosmaps",
    home: "the packages of ROS that ship maps, or your own",
    layout: "NAME.yaml of map_server, each beside its image",
};

/// The folder of the data sets: `--data`, then `$ZERONAV_DATA`, then `./data`.
fn root(given: Option<&Path>, environment: Option<OsString>) -> PathBuf {
    let named = environment.filter(|root| !root.is_empty());
    given
        .map(Path::to_owned)
        .or_else(|| named.map(PathBuf::from))
        .unwrap_or_else(|| PathBuf::from("data"))
}

/// The folder of a data set.
///
/// # Errors
/// One line when it is not there, with where to get it and how to lay it out.
pub(super) fn folder(plan: &SuitePlan, set: DataSet) -> Result<PathBuf, String> {
    let root = root(plan.data.as_deref(), std::env::var_os("ZERONAV_DATA"));
    let folder = root.join(set.part);
    if folder.is_dir() {
        return Ok(absolute(&folder));
    }
    Err(format!(
        "there is no folder {}: get the data set from {}, lay it out as {}, and name the folder that \
         holds {} with --data DIR or ZERONAV_DATA; `zeronav suite generated` needs no data",
        folder.display(),
        set.home,
        set.layout,
        set.part
    ))
}

/// The worlds `PREFIX*.ENDING` of a folder that `--worlds` asks for, by number.
///
/// # Errors
/// One line when there is none.
pub(super) fn worlds(
    plan: &SuitePlan,
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
            let wanted = plan.worlds.as_ref();
            wanted.is_none_or(|wanted| wanted.contains(&world.number))
        })
        .collect();
    if !worlds.is_empty() {
        return Ok(worlds);
    }
    let wanted = plan.worlds.as_ref().map_or_else(String::new, |range| {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_flag_comes_before_the_environment_and_that_before_the_working_folder() {
        let given = Some(Path::new("here"));
        let named = || Some(OsString::from("/there"));
        assert_eq!(root(given, named()), Path::new("here"));
        assert_eq!(root(None, named()), Path::new("/there"));
        assert_eq!(root(None, Some(OsString::new())), Path::new("data"));
        assert_eq!(root(None, None), Path::new("data"));
    }
}
