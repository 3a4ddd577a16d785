//! `zeronav import`: the log of another robot as a recording for `zeronav replay --open`.

use clap::Args;
use serde_json::json;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::exit::{EXIT_OUTPUT, EXIT_PASS};
use zeronav_console::terminal::{complain, say, say_json, usage};
use zeronav_files::{Folder, parts};
use zeronav_import::recording::{Imported, assumed};
use zeronav_import::{Log, Topics};
use zeronav_shell::printable::printable;

/// Arguments of `zeronav import`.
#[derive(Debug, Clone, Args)]
pub struct ImportArgs {
    /// A bag of ROS 2 (an MCAP or .db3 file, or its folder), or a CARMEN log, which may be compressed by gzip.
    pub log: PathBuf,
    /// The recording; without, `NAME_imported.mcap` in this folder.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Replace a file of the same name.
    #[arg(long)]
    pub force: bool,
    /// The topic of the scans, of a bag that has several.
    #[arg(long, value_name = "TOPIC")]
    pub scan: Option<String>,
    /// The topic of the odometry, of a bag that has several.
    #[arg(long, value_name = "TOPIC")]
    pub odometry: Option<String>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

enum Problem {
    Input(String),
    Output(String),
}

/// `zeronav import`.
#[must_use]
pub fn import(arguments: &ImportArgs) -> ExitCode {
    let topics = Topics {
        scan: arguments.scan.clone(),
        odometry: arguments.odometry.clone(),
    };
    let log = match zeronav_import::read(&arguments.log, &topics) {
        Ok(log) => log,
        Err(error) => return usage(&printable(&error.to_string())),
    };
    let name = arguments.log.file_stem().unwrap_or_default();
    let name = name.to_string_lossy().into_owned();
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| PathBuf::from(format!("{name}_imported.mcap")));
    match write(&log, &name, &out, arguments.force) {
        Ok(imported) => {
            if arguments.json {
                say_json(&to_json(&log, &imported, &out));
            } else {
                say(&to_text(&log, &imported, &out));
            }
            ExitCode::from(EXIT_PASS)
        }
        Err(Problem::Input(why)) => usage(&printable(&why)),
        Err(Problem::Output(why)) => {
            complain(&format!("{}: {why}", out.display()));
            ExitCode::from(EXIT_OUTPUT)
        }
    }
}

fn write(log: &Log, name: &str, out: &Path, force: bool) -> Result<Imported, Problem> {
    let failed = |why: &dyn core::fmt::Display| Problem::Output(why.to_string());
    let (folder, file) = parts(out).map_err(|error| failed(&error))?;
    let folder = Folder::open(folder).map_err(|error| failed(&error))?;
    if force {
        folder.remove(file);
    }
    let output = folder.new_file(file).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => {
            let fix = "it exists; name another file with --out, or --force to replace it";
            Problem::Input(format!("{}: {fix}", out.display()))
        }
        _ => failed(&error),
    })?;
    let written = zeronav_import::recording::write(log, name, BufWriter::new(output));
    let in_log = |why: String| Problem::Input(format!("{name}: {why}"));
    let written = written.map_err(in_log).and_then(|(imported, mut output)| {
        output.flush().map_err(|error| failed(&error))?;
        Ok(imported)
    });
    written.inspect_err(|_| folder.remove(file))
}

fn to_text(log: &Log, imported: &Imported, out: &Path) -> String {
    let Imported {
        ticks,
        scans,
        corrected,
        lasts_s,
    } = imported;
    let mut lines = vec![format!(
        "{}: {} log, {lasts_s:.1} s, {ticks} ticks, {scans} scans, {corrected} corrected poses",
        out.display(),
        log.format
    )];
    let report = &log.report;
    lines.extend(report.missing.iter().map(|it| format!("missing: {it}")));
    lines.extend(assumed(log).iter().map(|it| format!("assumed: {it}")));
    let mended = report.mended.iter();
    lines.extend(mended.map(|(what, n)| format!("mended: {n} {what}")));
    lines.push(format!(
        "`zeronav replay {} --open mapping` plays it",
        out.display()
    ));
    let lines: Vec<_> = lines.iter().map(|line| printable(line)).collect();
    lines.join("\n") + "\n"
}

fn to_json(log: &Log, imported: &Imported, out: &Path) -> serde_json::Value {
    json!({
        "recording": out,
        "format": log.format,
        "lasts_s": imported.lasts_s,
        "ticks": imported.ticks,
        "scans": imported.scans,
        "corrected_poses": imported.corrected,
        "missing": log.report.missing,
        "assumed": assumed(log),
        "mended": log.report.mended,
    })
}
