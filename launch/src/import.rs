//! `zeronav import`: the log of another robot as a recording for `zeronav replay --open`.

use crate::output_file::{self, Problem};
use clap::Args;
use serde_json::json;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{say, say_json, usage};
use zeronav_import::recording::{Imported, WriteError, assumed};
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

/// `zeronav import`.
#[must_use]
pub fn import(arguments: &ImportArgs) -> ExitCode {
    let topics = Topics {
        scan: arguments.scan.clone(),
        odometry: arguments.odometry.clone(),
    };
    let log = match zeronav_import::log_in(&arguments.log, &topics) {
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
        Err(problem) => problem.say(),
    }
}

fn write(log: &Log, name: &str, out: &Path, force: bool) -> Result<Imported, Problem> {
    output_file::made(out, force, |output| {
        let written = zeronav_import::recording::write(log, name, BufWriter::new(output));
        let (imported, mut output) = written.map_err(|error| match error {
            WriteError::Log(why) => Problem::Input(format!("{name}: {why}")),
            WriteError::Made(error) => Problem::writing(out, &error),
        })?;
        let flushed = output.flush();
        flushed.map_err(|error| Problem::writing(out, &error))?;
        Ok(imported)
    })
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
