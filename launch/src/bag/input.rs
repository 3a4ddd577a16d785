//! A recording as it is read.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use zeronav_files::read;
use zeronav_msgs::fields::KINDS;

/// Opens a recording.
///
/// # Errors
/// One line naming the file.
pub(crate) fn open(file: &Path) -> Result<BufReader<File>, String> {
    let opened = read::open(file).map(BufReader::new);
    opened.map_err(|error| format!("{}: {error}", file.display()))
}

/// True for a unit of measure, in the place of what kind of number it is.
pub(super) fn is_unit(unit: &str) -> bool {
    !KINDS.contains(&unit) && unit != "-"
}
