//! The runs of a suite as a table for other programs.

use super::row::Row;
use zeronav_shell::printable::printable_cell;

/// One line a run.
///
/// # Errors
/// One line.
pub(super) fn text(rows: &[Row]) -> Result<String, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(|error| error.to_string())?;
    }
    let bytes = writer.into_inner().map_err(|error| error.to_string())?;
    harmless(&bytes)
}

/// The same table without what a terminal or a spreadsheet would obey.
fn harmless(table: &[u8]) -> Result<String, String> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .from_reader(table);
    let mut writer = csv::Writer::from_writer(Vec::new());
    for record in reader.records() {
        let record = record.map_err(|error| error.to_string())?;
        let cells = record.iter().map(|cell| printable_cell(cell).into_owned());
        let written = writer.write_record(cells);
        written.map_err(|error| error.to_string())?;
    }
    let bytes = writer.into_inner().map_err(|error| error.to_string())?;
    String::from_utf8(bytes).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::harmless;

    #[test]
    fn cells_are_no_formulas_and_hold_nothing_that_is_obeyed() {
        let table = "world,x\n=1+1,-2.5\n\"a,\u{1b}[2J\nb\",\n";
        let wanted = "world,x\n'=1+1,-2.5\n\"a,\\u{1b}[2J\\nb\",\n";
        assert_eq!(harmless(table.as_bytes()).as_deref(), Ok(wanted));
    }
}
