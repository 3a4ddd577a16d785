//! `papers`: measures the tables of the papers.

#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a program for a terminal"
)]

use clap::{ArgGroup, Parser};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;
use zeronav_papers::claims::claims;
use zeronav_papers::feature;
use zeronav_papers::maps::MapFamily;
use zeronav_papers::page::page;
use zeronav_papers::report::{Format, Report};
use zeronav_papers::table::{Context, TableError};
use zeronav_papers::tables::{TABLES, Table};

/// Measures the tables of the five papers on random maps and in the real stack.
#[derive(Debug, Parser)]
#[command(version, group(ArgGroup::new("what").required(true).args(["all", "paper", "list", "feature", "rows"])))]
struct Arguments {
    /// Every table.
    #[arg(long)]
    all: bool,
    /// The tables of one paper: BAO, TN, ZM, LWX or JU.
    #[arg(long, value_name = "PAPER")]
    paper: Option<String>,
    /// One table of the paper, see --list.
    #[arg(long, requires = "paper", value_name = "TABLE")]
    table: Option<String>,
    /// Tables and claims; measures nothing.
    #[arg(long)]
    list: bool,
    /// The acceptance tests of one row of the feature table, such as ZM-ESC.
    #[arg(long, value_name = "KEY")]
    feature: Option<String>,
    /// The `rows.json` of earlier measurements, separated by commas, to print them or their page again.
    #[arg(long, value_name = "FILES", value_delimiter = ',')]
    rows: Vec<PathBuf>,
    /// Maps of every kind.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Scenes of every kind that the stack drives; without, as many as --seeds, at most 200.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    drives: Option<u64>,
    /// Only the tables that need no stack.
    #[arg(long)]
    no_drives: bool,
    /// Seed of the first map.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..1_000_000_000))]
    seed: u64,
    /// Families of maps.
    #[arg(long, value_delimiter = ',', default_value = "blocky,iid", value_enum)]
    maps: Vec<MapFamily>,
    /// How the rows are printed.
    #[arg(long, value_enum, default_value_t = Format::Md)]
    format: Format,
    /// Folder for the rows in every format and a picture for each table.
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// File for the page of all claims.
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
}

/// Exit codes.
const BROKEN: u8 = 1;
const USAGE: u8 = 2;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.list {
        list();
        return ExitCode::SUCCESS;
    }
    if let Some(key) = &arguments.feature {
        return match feature::test(key) {
            Ok(n) => {
                println!("{key}: {n} tests passed");
                ExitCode::SUCCESS
            }
            Err(error @ feature::FeatureError::Unknown { .. }) => fail(USAGE, &error.to_string()),
            Err(error) => fail(BROKEN, &error.to_string()),
        };
    }
    // Before minutes of work, not after them.
    if let Err(error) = prepare(&arguments) {
        return fail(USAGE, &error);
    }
    let (report, drawings) = if arguments.rows.is_empty() {
        let tables = match chosen(&arguments) {
            Ok(tables) => tables,
            Err(error) => return fail(USAGE, &error),
        };
        match measure(&arguments, &tables) {
            Ok(measured) => measured,
            Err(error) => return fail(BROKEN, &error.to_string()),
        }
    } else {
        let read: Result<Vec<Report>, String> =
            arguments.rows.iter().map(|file| read(file)).collect();
        match read.map(joined) {
            Ok(Some(report)) => (report, Vec::new()),
            Ok(None) => return fail(USAGE, "--rows: no file"),
            Err(error) => return fail(USAGE, &error),
        }
    };
    match leave(&arguments, &report, &drawings) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(BROKEN, &error),
    }
}

fn fail(code: u8, error: &str) -> ExitCode {
    eprintln!("papers: {error}");
    ExitCode::from(code)
}

fn list() {
    println!("tables:");
    for table in TABLES {
        let driven = if table.is_driven {
            " (driven by the stack)"
        } else {
            ""
        };
        println!(
            "  {:4} {:6} {}{driven}",
            table.paper, table.number, table.title
        );
    }
    println!("claims:");
    for claim in claims() {
        println!("  {:4} {:3} {}", claim.paper, claim.id, claim.text);
        println!("           tables {}", claim.tables.join(", "));
    }
}

/// An earlier measurement.
fn read(file: &Path) -> Result<Report, String> {
    let text = std::fs::read_to_string(file)
        .map_err(|error| format!("--rows {}: {error}", file.display()))?;
    serde_json::from_str(&text).map_err(|error| {
        let name = file.display();
        format!("--rows {name}: no rows of `papers --out`: {error}")
    })
}

/// Several measurements as one, their rows in the order of the tables.
fn joined(reports: Vec<Report>) -> Option<Report> {
    let mut reports = reports.into_iter();
    let mut all = reports.next()?;
    for report in reports {
        all.rows.extend(report.rows);
        all.wall_s += report.wall_s;
        all.drives = all.drives.max(report.drives);
        all.seeds = all.seeds.max(report.seeds);
        for (own, other) in [
            (&mut all.command, report.command),
            (&mut all.revision, report.revision),
        ] {
            if *own != other {
                *own = format!("{own}, {other}");
            }
        }
    }
    let place = |row: &zeronav_papers::row::Row| {
        let is_its = |table: &Table| table.paper == row.paper && table.number == row.table;
        TABLES.iter().position(is_its)
    };
    all.rows.sort_by_key(place);
    Some(all)
}

/// The tables asked for.
fn chosen(arguments: &Arguments) -> Result<Vec<&'static Table>, String> {
    let is_asked = |table: &&Table| {
        let of_paper = |paper: &String| table.paper.eq_ignore_ascii_case(paper);
        let of_table = |number: &String| table.number.eq_ignore_ascii_case(number);
        arguments.paper.as_ref().is_none_or(of_paper)
            && arguments.table.as_ref().is_none_or(of_table)
            && !(arguments.no_drives && table.is_driven)
    };
    let tables: Vec<&Table> = TABLES.iter().filter(is_asked).collect();
    if tables.is_empty() {
        let asked = arguments.paper.as_deref().unwrap_or_default();
        let number = arguments.table.as_deref().unwrap_or("any");
        return Err(format!(
            "{asked} has no table \"{number}\" to measure; `papers --list` shows those there are"
        ));
    }
    Ok(tables)
}

/// Makes the folder and sees whether the page can be written.
fn prepare(arguments: &Arguments) -> Result<(), String> {
    if let Some(folder) = &arguments.out {
        let problem = |error| format!("--out {}: {error}", folder.display());
        std::fs::create_dir_all(folder).map_err(problem)?;
        let probe = folder.join(".papers");
        std::fs::write(&probe, "").map_err(problem)?;
        std::fs::remove_file(&probe).map_err(problem)?;
    }
    if let Some(file) = &arguments.page {
        let folder = file
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        if folder.is_some_and(|folder| !folder.is_dir()) {
            return Err(format!("--page {}: the folder is missing", file.display()));
        }
    }
    Ok(())
}

type Drawings = Vec<(String, String)>;

fn measure(
    arguments: &Arguments,
    tables: &[&'static Table],
) -> Result<(Report, Drawings), TableError> {
    let started = Instant::now();
    let mut context = Context {
        seeds: arguments.seeds,
        drives: arguments.drives.unwrap_or(arguments.seeds.min(200)),
        seed: arguments.seed,
        families: arguments.maps.clone(),
        stack: None,
    };
    let (mut rows, mut drawings) = (Vec::new(), Vec::new());
    for table in tables {
        let begun = Instant::now();
        let outcome = (table.run)(&mut context)?;
        eprintln!(
            "{} {}: {} rows, {:.0} s",
            table.paper,
            table.number,
            outcome.rows.len(),
            begun.elapsed().as_secs_f64()
        );
        rows.extend(outcome.rows);
        let name = format!("{}_{}", table.paper, table.number).to_lowercase();
        if let Some(drawing) = outcome.drawing {
            if !drawing.cells().is_empty() {
                drawings.push((format!("{name}.csv"), drawing.cells().to_owned()));
            }
            drawings.push((format!("{name}.svg"), drawing.svg().to_owned()));
        }
    }
    let words: Vec<String> = std::env::args().skip(1).collect();
    let report = Report {
        seeds: context.seeds,
        drives: context.drives,
        seed: context.seed,
        revision: revision(),
        machine: machine(),
        command: format!("papers {}", words.join(" ")),
        wall_s: started.elapsed().as_secs_f64(),
        rows,
    };
    Ok((report, drawings))
}

/// Prints the report and leaves its files.
fn leave(arguments: &Arguments, report: &Report, drawings: &Drawings) -> Result<(), String> {
    let text = |format| report.print(format).map_err(|error| error.to_string());
    let write = |file: &Path, text: &str| {
        std::fs::write(file, text).map_err(|error| format!("{}: {error}", file.display()))
    };
    if let Some(folder) = &arguments.out {
        for (name, format) in [
            ("rows.md", Format::Md),
            ("rows.csv", Format::Csv),
            ("rows.json", Format::Json),
        ] {
            write(&folder.join(name), &text(format)?)?;
        }
        for (name, svg) in drawings {
            write(&folder.join(name), svg)?;
        }
    }
    if let Some(file) = &arguments.page {
        write(file, &page(report))?;
    }
    // A reader that closed the pipe has seen enough.
    let printed = text(arguments.format)?;
    let _ = std::io::Write::write_all(&mut std::io::stdout(), printed.as_bytes());
    Ok(())
}

/// Revision of the repository that this was built from.
fn revision() -> String {
    let output = Command::new("git")
        .args(["rev-parse", "--short", "HEAD"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output();
    output
        .ok()
        .filter(|output| output.status.success())
        .and_then(|output| String::from_utf8(output.stdout).ok())
        .map_or_else(|| "unknown".to_owned(), |text| text.trim().to_owned())
}

/// Name of the processor and how many there are.
fn machine() -> String {
    let cpus = std::thread::available_parallelism().map_or(1, usize::from);
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'))
        .map_or("unknown processor", |(_, name)| name.trim());
    format!("{name}, {cpus} cores")
}
