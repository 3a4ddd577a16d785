//! Rows as text for people, for spreadsheets and for programs.

use crate::row::Row;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;

/// How rows are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Tables of Markdown.
    Md,
    /// One line a row.
    Csv,
    /// One object.
    Json,
}

/// What was measured, and with what.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Report {
    /// Maps of every kind.
    pub seeds: u64,
    /// Scenes of every kind that the stack drove.
    pub drives: u64,
    /// Seed of the first map.
    pub seed: u64,
    /// Revision of this project; `unknown` outside of a repository.
    pub revision: String,
    /// Processor and number of them.
    pub machine: String,
    /// The command.
    pub command: String,
    /// Wall time. [s]
    pub wall_s: f64,
    /// The rows.
    pub rows: Vec<Row>,
}

impl Report {
    /// In a format.
    ///
    /// # Errors
    /// Never for rows of numbers.
    pub fn print(&self, format: Format) -> serde_json::Result<String> {
        Ok(match format {
            Format::Json => serde_json::to_string_pretty(self)? + "\n",
            Format::Csv => self.csv(),
            Format::Md => self.markdown(),
        })
    }

    fn csv(&self) -> String {
        let mut text = "paper,table,claim,metric,algorithm,maps,printed,ours,low,high,n,excluded,\
                        acceptance,verdict,note,parameters,seed\n"
            .to_owned();
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        for row in &self.rows {
            let parameters = if row.parameters.is_null() {
                String::new()
            } else {
                row.parameters.to_string()
            };
            let fields = [
                row.paper.clone(),
                row.table.clone(),
                row.claim.clone(),
                row.metric.clone(),
                row.algorithm.clone(),
                row.maps.clone(),
                number(row.printed),
                number(row.ours),
                number(row.interval.map(|interval| interval[0])),
                number(row.interval.map(|interval| interval[1])),
                row.n.to_string(),
                row.excluded.to_string(),
                row.acceptance.to_string(),
                row.verdict.words().to_owned(),
                row.note.clone(),
                parameters,
                row.seed.to_string(),
            ];
            let quoted = fields.iter().map(|field| {
                if field.contains([',', '"', '\n']) {
                    format!("\"{}\"", field.replace('"', "\"\""))
                } else {
                    field.clone()
                }
            });
            let _ = writeln!(text, "{}", quoted.collect::<Vec<_>>().join(","));
        }
        text
    }

    fn markdown(&self) -> String {
        let mut text = format!(
            "{} maps of every kind from seed {}, {} drives; revision {}; {}; {:.0} s\n",
            self.seeds, self.seed, self.drives, self.revision, self.machine, self.wall_s
        );
        let mut table = ("", "");
        for row in &self.rows {
            if (&*row.paper, &*row.table) != table {
                table = (&row.paper, &row.table);
                let _ = write!(text, "\n{}", table_head(&row.paper, &row.table));
            }
            text += &line(row);
        }
        text
    }
}

/// Heading and head of a table of rows.
#[must_use]
pub fn table_head(paper: &str, table: &str) -> String {
    format!(
        "### {paper} {table}\n\n\
         | claim | metric | algorithm | maps | printed | ours | 95 % interval | n | excluded | acceptance | verdict | note |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n"
    )
}

/// A row of Markdown.
#[must_use]
pub fn line(row: &Row) -> String {
    let is_change = is_change(row);
    let value = |value: f64| number(value, is_change);
    let shown = |option: Option<f64>| option.map_or_else(|| "-".to_owned(), value);
    let interval = row.interval.map_or_else(
        || "-".to_owned(),
        |[low, high]| format!("[{}, {}]", value(low), value(high)),
    );
    let note = if row.parameters.is_null() {
        row.note.clone()
    } else {
        format!("{} {}", row.note, row.parameters).trim().to_owned()
    };
    format!(
        "| {} | {} | {} | {} | {} | {} | {interval} | {} | {:.0} % | {:.0} % | {} | {note} |\n",
        row.claim,
        row.metric,
        row.algorithm,
        row.maps,
        shown(row.printed),
        shown(row.ours),
        row.n,
        100.0 * row.excluded,
        100.0 * row.acceptance,
        row.verdict.words(),
    )
}

/// True for a relative change, which is shown in per cent with its sign.
#[must_use]
pub fn is_change(row: &Row) -> bool {
    row.algorithm.contains(" vs ") || row.metric.contains(" vs ")
}

/// A number as it is shown.
#[must_use]
pub fn number(value: f64, is_change: bool) -> String {
    if is_change {
        format!("{:+.1} %", 100.0 * value)
    } else if value.abs() >= 100.0 {
        format!("{value:.0}")
    } else {
        format!("{value:.3}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::{Figure, Place};
    use crate::stats::Estimate;
    use crate::verdict::{Printed, Standing};

    fn report() -> Report {
        let place = Place {
            paper: "BAO",
            table: "1",
            maps: "blocky 30x20, 15.8 %, corners".to_owned(),
            acceptance: 0.85,
            seed: 1,
        };
        let figure = Figure {
            claim: "C2",
            metric: "length".to_owned(),
            algorithm: "IAA vs AAO".to_owned(),
            printed: Printed::Change(-0.1192),
            ours: Some(Estimate {
                mean: -0.02,
                interval: [-0.025, -0.015],
                n: 20,
            }),
            excluded: 0.0,
            standing: Standing::Fair,
            note: "a, b".to_owned(),
            parameters: serde_json::Value::Null,
        };
        Report {
            seeds: 20,
            drives: 0,
            seed: 1,
            revision: "abc".to_owned(),
            machine: "a machine".to_owned(),
            command: "papers".to_owned(),
            wall_s: 1.0,
            rows: vec![place.row(figure)],
        }
    }

    #[test]
    fn every_format_holds_the_row() {
        let report = report();
        let md = report.print(Format::Md).unwrap();
        assert!(md.contains("| C2 | length | IAA vs AAO |"), "{md}");
        assert!(
            md.contains("| -11.9 % | -2.0 % | [-2.5 %, -1.5 %] | 20 |"),
            "{md}"
        );
        assert!(md.contains("| qualitative |"), "{md}");
        let csv = report.print(Format::Csv).unwrap();
        assert!(csv.contains("\"a, b\""), "{csv}");
        let json: serde_json::Value =
            serde_json::from_str(&report.print(Format::Json).unwrap()).unwrap();
        let row = &json["rows"][0];
        assert_eq!(row["verdict"], "qualitative");
        assert_eq!(row["interval"][1], -0.015);
        for key in [
            "paper",
            "table",
            "claim",
            "metric",
            "algorithm",
            "printed",
            "ours",
            "n",
            "excluded",
            "acceptance",
            "note",
            "seed",
            "parameters",
        ] {
            assert!(!row[key].is_null() || key == "parameters", "{key}");
        }
    }
}
