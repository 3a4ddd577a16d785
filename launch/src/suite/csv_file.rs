//! The runs of a suite as a table for other programs.

use super::row::Row;
use std::path::Path;

/// Writes one line a run.
///
/// # Errors
/// One line naming the file.
pub(super) fn write(file: &Path, rows: &[Row]) -> Result<(), String> {
    let failed = |error: csv::Error| format!("writing {}: {error}", file.display());
    let mut writer = csv::Writer::from_path(file).map_err(failed)?;
    for row in rows {
        writer.serialize(row).map_err(failed)?;
    }
    writer.flush().map_err(|error| failed(error.into()))
}
