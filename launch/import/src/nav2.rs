//! A parameter file of Nav2, and a URDF, as a scenario.
//!
//! The file is read into a tree (`yaml`), its nodes and wildcards into sections (`parameters`), the rows of a table
//! (`table`) find in them what becomes a field of the scenario (`carry`), the rest is assumed (`assume`) or said to
//! be left out (`left`). Names and defaults are those of Nav2, Humble to Lyrical.

mod assume;
mod carry;
mod draft;
mod left;
mod outline;
mod parameters;
mod plugins;
mod reading;
mod report;
mod table;
#[cfg(test)]
mod tests;
mod urdf;
mod yaml;

pub use draft::Draft;
pub use report::{Assumed, Carried, Left, Report, Unknown};

use crate::ImportError;
use parameters::Sections;
use plugins::Plugins;
use std::path::{Path, PathBuf};
use zeronav_files::read;

/// Largest URDF: descriptions of whole manipulators are longer than a file that is written by hand. [bytes]
const URDF_BYTES_MAX: u64 = 8 << 20;

/// A scenario in the making.
#[derive(Debug, Clone, PartialEq)]
pub struct Converted {
    /// Its fields.
    pub draft: Draft,
    /// What became of the parameters.
    pub report: Report,
    /// The map: that of the command line, or the one that the file names and that is there.
    pub map: Option<PathBuf>,
}

impl Converted {
    /// Takes in the side of a cell of the map that it is driven on. [m]
    pub fn fit(&mut self, resolution_m: f64) {
        assume::clearance((&mut self.draft, &mut self.report), resolution_m);
    }

    /// Puts the robot where the map is free, and says so.
    pub fn start_at(&mut self, pose: [f64; 3], why: &str) {
        self.report.assumed.retain(|it| it.to != "start");
        let making = (&mut self.draft, &mut self.report);
        assume::assume(making, "start", pose.to_vec(), why);
    }
}

/// Whether `path` is the name of a parameter file rather than of a log.
#[must_use]
pub fn is_parameter_file(path: &Path) -> bool {
    let ending = path.extension().and_then(|it| it.to_str());
    ending.is_some_and(|it| it.eq_ignore_ascii_case("yaml") || it.eq_ignore_ascii_case("yml"))
}

/// Reads the parameters in `file`, with what `urdf` adds, for a robot on `map`. Without a map, one that the file names is
/// taken when it is there.
///
/// # Errors
/// [`ImportError`] naming file, line and parameter.
pub fn scenario_of(
    file: &Path,
    urdf: Option<&Path>,
    map: Option<&Path>,
) -> Result<Converted, ImportError> {
    let text = text_of(file, read::TEXT_BYTES_MAX)?;
    let robot = urdf.map(|path| {
        let text = text_of(path, URDF_BYTES_MAX)?;
        urdf::read(&text).map_err(|(line, why)| wrong(path, line.map(u64::from), &why))
    });
    let robot = robot.transpose()?;
    let at = |line, why: &str| wrong(file, line, why);
    let tree = yaml::read(&text)
        .map_err(|error| at(error.line, &format!("is not YAML: {}", error.why)))?;
    let sections = Sections::of(&tree).map_err(|(line, why)| at(Some(line), &why))?;
    if !left::is_nav2(&sections) {
        let why = "has no node of Nav2, such as controller_server or local_costmap/local_costmap";
        return Err(at(None, why));
    }
    let plugins = Plugins::of(&sections);
    let (mut draft, mut report) = (Draft::default(), Report::default());
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    draft.head = format!(
        "Made by `zeronav import {name}`. A comment says which parameter of Nav2 a value comes from; what it \
         assumed, and what it left out, the command has printed."
    );
    draft.title = format!("The robot of {name}");
    let making = (&mut draft, &mut report);
    let seen = carry::carry(&sections, &plugins, making).map_err(|(line, field, why)| {
        let line = (line > 0).then_some(line);
        at(line, &format!("{field}: {why}"))
    })?;
    assume::limits((&mut draft, &mut report));
    assume::ros((&mut draft, &mut report), &sections);
    let outline = assume::outline((&mut draft, &mut report), robot.as_ref());
    outline.map_err(|why| at(None, &why))?;
    assume::lidar((&mut draft, &mut report), robot.as_ref());
    assume::algorithms((&mut draft, &mut report), &sections, &plugins);
    let map = map
        .map(Path::to_path_buf)
        .or_else(|| named_map(file, &sections, &mut report));
    assume::world((&mut draft, &mut report), &sections, map.is_some());
    left::say(&sections, &plugins, &seen, &mut report);
    Ok(Converted { draft, report, map })
}

/// The map that the file names, when it is there.
fn named_map(file: &Path, sections: &Sections, report: &mut Report) -> Option<PathBuf> {
    let parameter = sections.get("map_server", "yaml_filename")?;
    let named = sections.text("map_server", "yaml_filename")?;
    let beside = file.parent().unwrap_or(Path::new("")).join(named);
    let found = [beside, PathBuf::from(named)]
        .into_iter()
        .find(|it| it.is_file());
    if found.is_none() {
        let means = "there is no such file here: give the map with --map";
        report.leave(format!("map_server.yaml_filename = {named:?}"), means);
    } else {
        report.carried.push(Carried {
            from: "map_server.yaml_filename".to_owned(),
            line: Some(parameter.line),
            value: parameter.value.to_string(),
            to: "world.map",
            ours: Some(parameter.value.to_string()),
        });
    }
    found
}

fn text_of(path: &Path, most: u64) -> Result<String, ImportError> {
    read::text(path, most).map_err(|error| wrong(path, None, &error.to_string()))
}

fn wrong(file: &Path, line: Option<u64>, why: &str) -> ImportError {
    let why = line.map_or_else(|| why.to_owned(), |line| format!("line {line}: {why}"));
    ImportError {
        file: file.to_path_buf(),
        why,
    }
}
