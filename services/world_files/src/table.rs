//! CSV tables of numbers, as data sets come in: read with a ceiling, believed cell by cell.

use std::io;
use std::path::{Path, PathBuf};
use zeronav_files::read;

/// Largest file. [bytes]
const BYTES_MAX: u64 = 64 << 20;

/// Why the file of a data set could not be used.
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    /// It could not be opened or read.
    #[error("{}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A line cannot be.
    #[error("{}:{line}: {why}", file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong and what would be right.
        why: String,
    },
}

/// A file that has been read: lines `header`, then rows; what begins with `#` does not count.
#[derive(Debug, Clone)]
pub(crate) struct Table {
    file: PathBuf,
    text: String,
    n_columns: usize,
}

/// A row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<'a> {
    table: &'a Table,
    line: usize,
    text: &'a str,
}

/// The text of a file.
///
/// # Errors
/// [`DataError::Read`]; also for more than `bytes_max` bytes and for what is not UTF-8.
pub(crate) fn read_text(file: &Path, bytes_max: u64) -> Result<String, DataError> {
    read::text(file, bytes_max).map_err(|source| DataError::Read {
        file: file.to_path_buf(),
        source,
    })
}

impl Table {
    /// Reads `file`, whose header must be `header`.
    ///
    /// # Errors
    /// See [`DataError`]; also for more than 64 MB and for what is not UTF-8.
    pub(crate) fn read(file: &Path, header: &str) -> Result<Self, DataError> {
        let text = read_text(file, BYTES_MAX)?;
        Self::new(file, text, header)
    }

    fn new(file: &Path, text: String, header: &str) -> Result<Self, DataError> {
        let table = Self {
            file: file.to_path_buf(),
            text,
            n_columns: header.split(',').count(),
        };
        let wrong = match table.lines().next() {
            Some((_, found)) if found == header => None,
            Some((line, found)) => {
                let found: String = found.chars().take(80).collect();
                Some((
                    line,
                    format!("the header must be `{header}`, not `{found}`"),
                ))
            }
            None => Some((1, format!("the header `{header}` is missing"))),
        };
        match wrong {
            Some((line, why)) => Err(table.wrong(line, why)),
            None => Ok(table),
        }
    }

    /// The rows below the header.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.lines().skip(1).map(|(line, text)| Row {
            table: self,
            line,
            text,
        })
    }

    /// The error that the file as a whole is wrong.
    #[must_use]
    pub(crate) fn refused(&self, why: impl Into<String>) -> DataError {
        self.wrong(1, why.into())
    }

    fn lines(&self) -> impl Iterator<Item = (usize, &str)> {
        let lines = (1..).zip(self.text.lines());
        lines
            .map(|(line, text)| (line, text.trim()))
            .filter(|(_, text)| !text.is_empty() && !text.starts_with('#'))
    }

    fn wrong(&self, line: usize, why: String) -> DataError {
        DataError::Line {
            file: self.file.clone(),
            line,
            why,
        }
    }
}

impl Row<'_> {
    /// The number in column `column`, which must lie from `min` to `max`.
    ///
    /// # Errors
    /// Naming file and line; also when the row has another number of columns than the header.
    pub(crate) fn number(&self, column: usize, min: f64, max: f64) -> Result<f64, DataError> {
        let mut cells = self.text.split(',');
        let n_cells = self.text.split(',').count();
        if n_cells != self.table.n_columns {
            return Err(self.refused(format!(
                "{n_cells} columns instead of {}",
                self.table.n_columns
            )));
        }
        let cell = cells.nth(column).unwrap_or_default().trim();
        match cell.parse::<f64>() {
            Ok(value) if (min..=max).contains(&value) => Ok(value),
            _ => {
                let cell: String = cell.chars().take(40).collect();
                Err(self.refused(format!(
                    "column {}: `{cell}` is no number from {min} to {max}",
                    column + 1
                )))
            }
        }
    }

    /// The error that this row is wrong.
    #[must_use]
    pub(crate) fn refused(&self, why: impl Into<String>) -> DataError {
        self.table.wrong(self.line, why.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn table(text: &str) -> Result<Table, DataError> {
        Table::new(Path::new("t.csv"), text.to_owned(), "a,b")
    }

    #[test]
    fn comments_and_empty_lines_do_not_count_but_keep_their_numbers() {
        let table = table("# about\na,b\n\n1, 2.5 \n3,x\n4\n").unwrap();
        let rows: Vec<Row> = table.rows().collect();
        assert_eq!(rows.len(), 3);
        assert!((rows[0].number(1, 0.0, 9.0).unwrap() - 2.5).abs() < 1e-15);
        let error = |row: &Row, column| row.number(column, 0.0, 2.0).unwrap_err().to_string();
        assert_eq!(
            error(&rows[0], 1),
            "t.csv:4: column 2: `2.5` is no number from 0 to 2"
        );
        assert_eq!(
            error(&rows[1], 1),
            "t.csv:5: column 2: `x` is no number from 0 to 2"
        );
        assert_eq!(error(&rows[2], 0), "t.csv:6: 1 columns instead of 2");
    }

    #[test]
    fn another_header_is_refused() {
        assert!(table("").unwrap_err().to_string().contains("missing"));
        let error = table("\na;b\n1,2").unwrap_err().to_string();
        assert_eq!(error, "t.csv:2: the header must be `a,b`, not `a;b`");
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "(a,b\n)?[0-9a,.\n#e\\-Ni]{0,60}") {
            if let Ok(table) = table(&text) {
                for row in table.rows() {
                    for column in 0..3 {
                        if let Ok(value) = row.number(column, -5.0, 5.0) {
                            prop_assert!((-5.0..=5.0).contains(&value));
                        }
                    }
                }
            }
        }
    }
}
