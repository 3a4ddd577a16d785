//! Records as pages: `tests/RESULTS.md`, and the marked blocks of the READMEs.

use super::experiments::{EXPERIMENTS, Experiment};
use super::record::{Record, Records, Row, Table};
use super::spread::Figure;
use core::fmt::Write;

/// Begins a block in a README; the key of an experiment follows.
const BEGIN: &str = "<!-- results: ";

/// Ends the mark that begins a block.
const BEGIN_END: &str = " -->";

/// Ends a block.
const END: &str = "<!-- /results -->";

/// Begins a single figure in a line; `KEY / ROW / COLUMN` follows.
const FIGURE: &str = "<!-- figure: ";

/// Ends a single figure.
const FIGURE_END: &str = "<!-- /figure -->";

/// The page with every record.
#[must_use]
pub fn page(records: &Records) -> String {
    let mut text = String::from(
        "# Results\n\n\
         Written by `cargo run --release -p zeronav-tests --bin zeronav-results -- measure`, which \
         also writes the marked\nblocks of the READMEs; never edited by hand. Behind a figure \
         is its spread in brackets: quartiles for\nmedians, the 95 % interval for rates \
         (Wilson) and means; one number alone is a count or a percentile.\n",
    );
    for experiment in EXPERIMENTS {
        let _ = write!(text, "\n## `{}`: {}\n\n", experiment.key, experiment.title);
        text += &block(experiment, records.get(experiment.key));
    }
    text
}

/// `text` with the content of its marked blocks and its single figures replaced.
///
/// # Errors
/// One line about a block that is not closed or names no experiment, or about a figure that its
/// record does not have.
pub fn filled(text: &str, records: &Records) -> Result<String, String> {
    with_figures(&with_blocks(text, records)?, records)
}

/// `text` with its single figures replaced: `<!-- figure: KEY / ROW / COLUMN -->value<!-- /figure -->`,
/// where the column is that of a table or `n`.
fn with_figures(text: &str, records: &Records) -> Result<String, String> {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once(FIGURE) {
        let unclosed = || format!("a figure has no `{BEGIN_END}` or `{FIGURE_END}`");
        let (mark, after) = after.split_once(BEGIN_END).ok_or_else(unclosed)?;
        let (old, after) = after.split_once(FIGURE_END).ok_or_else(unclosed)?;
        if old.contains(FIGURE) {
            return Err(unclosed());
        }
        let value = single(mark, records)?;
        let _ = write!(out, "{before}{FIGURE}{mark}{BEGIN_END}{value}{FIGURE_END}");
        rest = after;
    }
    Ok(out + rest)
}

/// The figure that `KEY / ROW / COLUMN` names.
fn single(mark: &str, records: &Records) -> Result<String, String> {
    let words: Vec<&str> = mark.split(" / ").collect();
    let [key, row_name, column] = words[..] else {
        return Err(format!(
            "a figure is named `KEY / ROW / COLUMN`, not `{mark}`"
        ));
    };
    if !EXPERIMENTS.iter().any(|experiment| experiment.key == key) {
        return Err(format!("no experiment is called `{key}`"));
    }
    let Some(record) = records.get(key) else {
        return Ok("(not measured yet)".to_owned());
    };
    for table in &record.tables {
        let Some(row) = table.rows.iter().find(|row| row.name == row_name) else {
            continue;
        };
        if column == "n" {
            return Ok(row.n.to_string());
        }
        let at = table.columns.iter().position(|name| name == column);
        if let Some(value) = at.and_then(|at| row.figures[at].value) {
            return Ok(short(value));
        }
    }
    Err(format!("`{key}` has no figure `{row_name} / {column}`"))
}

/// `text` with the content of its marked blocks replaced.
///
/// # Errors
/// One line about a block that is not closed or names no experiment.
fn with_blocks(text: &str, records: &Records) -> Result<String, String> {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(BEGIN) {
        let after = &rest[at + BEGIN.len()..];
        let (key, after) = after
            .split_once(BEGIN_END)
            .ok_or_else(|| format!("a block begins with `{BEGIN}KEY{BEGIN_END}`"))?;
        let experiment = EXPERIMENTS.iter().find(|experiment| experiment.key == key);
        let experiment = experiment.ok_or_else(|| format!("no experiment is called `{key}`"))?;
        let (old, after) = after
            .split_once(END)
            .ok_or_else(|| format!("block `{key}` has no end `{END}`"))?;
        if old.contains(BEGIN) {
            return Err(format!("block `{key}` has no end `{END}`"));
        }
        out += &rest[..at];
        let content = block(experiment, records.get(key));
        let _ = write!(out, "{BEGIN}{key}{BEGIN_END}\n{content}{END}");
        rest = after;
    }
    out += rest;
    Ok(out)
}

/// Lines of a page that look like a measured figure but are in no marked block: times in `us` or
/// `ns` and sizes in `MB` anywhere, and tables of numbers under a heading `Measured` or with a
/// column of a measurement. Code is left out.
#[must_use]
pub fn figures_by_hand(text: &str) -> Vec<String> {
    const WORDS: [&str; 6] = ["p50", "p90", "p99", "median", "success", "score"];
    let (mut fenced, mut marked, mut measured) = (false, false, false);
    let mut table = None;
    let mut found = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            fenced = !fenced;
        } else if line.starts_with(BEGIN) {
            marked = true;
        } else if line.starts_with(END) {
            marked = false;
        }
        if fenced || marked {
            continue;
        }
        if line.starts_with('#') {
            measured = line.contains("Measured");
        }
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        if !line.starts_with('|') {
            table = None;
        }
        let of_measurement = line.starts_with('|')
            && *table
                .get_or_insert_with(|| measured || cells.iter().any(|cell| WORDS.contains(cell)));
        let is_number = |cell: &&str| cell.starts_with(|first: char| first.is_ascii_digit());
        if has_measured_unit(line) || of_measurement && cells.iter().any(is_number) {
            found.push(line.to_owned());
        }
    }
    found
}

/// True when the line has a number with one of the units of measurements.
fn has_measured_unit(line: &str) -> bool {
    let words: Vec<&str> = line.split([' ', '|', '(', ')', ',', ';', '`']).collect();
    let is_number = |word: &str| word.starts_with(|first: char| first.is_ascii_digit());
    words
        .windows(2)
        .any(|pair| is_number(pair[0]) && matches!(pair[1], "us" | "ns" | "MB" | "us." | "MB."))
}

/// One experiment: how it was made, and its figures.
fn block(experiment: &Experiment, record: Option<&Record>) -> String {
    let Some(record) = record else {
        return format!(
            "Not measured yet: `zeronav-results measure {}`.\n",
            experiment.key
        );
    };
    let mut text = String::new();
    for table in &record.tables {
        text += &self::table(table);
    }
    if let Some(printed) = &record.text {
        let _ = write!(text, "```\n{}\n```\n\n", printed.trim_end());
    }
    let machine = &record.machine;
    let _ = writeln!(
        text,
        "{}: commit {}, {}, {} with {} cores, Linux {}, rustc {}, load {:.1} to {:.1}, steal \
         {:.1} %, {:.0} s of wall time.{}",
        commands(&record.commands),
        record.commit,
        record.date,
        machine.cpu,
        machine.cores,
        machine.kernel,
        machine.rustc,
        machine.load[0],
        machine.load[1],
        100.0 * machine.steal,
        record.wall_s,
        experiment
            .note
            .map_or_else(String::new, |note| format!(" {note}")),
    );
    text
}

fn commands(commands: &[String]) -> String {
    let quoted: Vec<String> = commands.iter().map(|line| format!("`{line}`")).collect();
    quoted.join(", ")
}

/// A table, with an empty line behind it.
#[must_use]
pub fn table(table: &Table) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "| {} | n | {} |",
        table.title,
        table.columns.join(" | ")
    );
    let _ = writeln!(text, "|---|---{}|", "|---".repeat(table.columns.len()));
    for Row { name, n, figures } in &table.rows {
        let cells: Vec<String> = figures.iter().map(cell).collect();
        let _ = writeln!(text, "| {name} | {n} | {} |", cells.join(" | "));
    }
    text.push('\n');
    text
}

fn cell(figure: &Figure) -> String {
    let Some(value) = figure.value else {
        return "-".to_owned();
    };
    match (figure.low, figure.high) {
        (Some(low), Some(high)) => format!("{} [{}, {}]", short(value), short(low), short(high)),
        _ => short(value),
    }
}

/// A number with about three digits that count.
fn short(value: f64) -> String {
    // The sum of no numbers is -0.
    let value = value + 0.0;
    let size = value.abs();
    let digits = if value.fract() == 0.0 || size >= 100.0 {
        0
    } else if size >= 10.0 {
        1
    } else if size >= 1.0 {
        2
    } else {
        3
    };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::record::Machine;

    fn record() -> Record {
        Record {
            commit: "abc1234".to_owned(),
            date: "2026-01-02".to_owned(),
            commands: vec!["zeronav run x".to_owned()],
            machine: Machine {
                cpu: "a processor".to_owned(),
                cores: 2,
                kernel: "6.0".to_owned(),
                rustc: "1.95.0".to_owned(),
                load: [0.25, 1.0],
                steal: 0.012,
            },
            wall_s: 12.4,
            tables: vec![Table {
                title: "hop".to_owned(),
                columns: vec!["p50 [us]".to_owned(), "max [us]".to_owned()],
                rows: vec![Row {
                    name: "mapping".to_owned(),
                    n: 200,
                    figures: vec![Figure::median(&[1.0, 2.5, 40.0]), Figure::plain(None)],
                }],
            }],
            text: None,
        }
    }

    #[test]
    fn a_block_has_the_figures_and_how_they_were_made() {
        let key = EXPERIMENTS[0].key;
        let records = Records::from([(key.to_owned(), record())]);
        let old = format!("before\n{BEGIN}{key}{BEGIN_END}\nold\n{END}\nafter\n");
        let new = with_blocks(&old, &records).expect("blocks");
        assert!(
            new.starts_with(&format!("before\n{BEGIN}{key}{BEGIN_END}\n")),
            "{new}"
        );
        assert!(new.ends_with(&format!("{END}\nafter\n")), "{new}");
        assert!(!new.contains("old"), "{new}");
        assert!(
            new.contains("| mapping | 200 | 2.50 [1.75, 21.2] | - |"),
            "{new}"
        );
        for word in [
            "abc1234",
            "`zeronav run x`",
            "load 0.2 to 1.0",
            "steal 1.2 %",
        ] {
            assert!(new.contains(word), "{word}: {new}");
        }
        assert_eq!(
            with_blocks(&new, &records),
            Ok(new.clone()),
            "rendered again"
        );
        let without = with_blocks(&new, &Records::new()).expect("blocks");
        assert!(without.contains(&format!("measure {key}`")), "{without}");
    }

    #[test]
    fn single_figures_come_from_their_records() {
        let key = EXPERIMENTS[0].key;
        let records = Records::from([(key.to_owned(), record())]);
        let line = |column: &str, value: &str| {
            format!("a {FIGURE}{key} / mapping / {column}{BEGIN_END}{value}{FIGURE_END} b\n")
        };
        for (column, value) in [("p50 [us]", "2.50"), ("n", "200")] {
            let new = filled(&line(column, "old"), &records);
            assert_eq!(new, Ok(line(column, value)));
            let without = filled(&line(column, "old"), &Records::new());
            assert_eq!(without, Ok(line(column, "(not measured yet)")));
        }
        for column in ["max [us]", "mean"] {
            let error = filled(&line(column, "old"), &records).expect_err("no value");
            assert!(error.contains(column), "{error}");
        }
        assert!(
            filled(
                &format!("{FIGURE}nothing / a / b{BEGIN_END}{FIGURE_END}"),
                &records
            )
            .is_err()
        );
        assert!(
            filled(
                &format!("{FIGURE}{key} / mapping{BEGIN_END}{FIGURE_END}"),
                &records
            )
            .is_err()
        );
        assert!(filled(&format!("{FIGURE}{key} / mapping / n{BEGIN_END}"), &records).is_err());
    }

    #[test]
    fn figures_by_hand_are_found() {
        let text = "# A\n| key | default |\n|---|---|\n| `a` | 0.3 |\n\
            A cycle takes 6.3 us, or 50 ms of delay.\n\
            | | p50 | p90 |\n|---|---|---|\n| search | 1609 | 1833 |\n\n\
            ```\n| x | 3 us |\n```\n\
            ## Measured\n| scene | here |\n|---|---|\n| free | 7 (8) |\n\n\
            <!-- results: example -->\n| scene | 7 us |\n<!-- /results -->\n\
            ## Limits\n| key | default |\n|---|---|\n| `b` | 4 |\n";
        let expected = [
            "A cycle takes 6.3 us, or 50 ms of delay.",
            "| search | 1609 | 1833 |",
            "| free | 7 (8) |",
        ];
        assert_eq!(figures_by_hand(text), expected);
    }

    #[test]
    fn broken_blocks_are_named() {
        let unknown = format!("{BEGIN}nothing{BEGIN_END}\n{END}");
        let error = with_blocks(&unknown, &Records::new()).expect_err("unknown");
        assert!(error.contains("`nothing`"), "{error}");
        let key = EXPERIMENTS[0].key;
        let open = format!("{BEGIN}{key}{BEGIN_END}\n");
        assert!(with_blocks(&open, &Records::new()).is_err());
        let nested = format!("{open}{open}{END}");
        assert!(with_blocks(&nested, &Records::new()).is_err());
    }
}
