//! `zeronav bag`: what is in a recording, where two differ, tables of one, and one that was cut made whole again.

pub mod diff;
mod export;
pub(crate) mod input;

use crate::output_file::{self, Problem};
use clap::{Args, Subcommand};
use diff::DiffArgs;
use export::export;
use input::open;
use serde_json::json;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_console::terminal::{complain, say, say_json, usage};
use zeronav_msgs::time::seconds;
use zeronav_recorder::native::PREFIX;
use zeronav_recorder::read::{ReadError, Summary, summary};
use zeronav_recorder::recover::{RecoverError, Recovered, recover};
use zeronav_recorder::verdict::VERDICT;

/// Arguments of `zeronav bag`.
#[derive(Debug, Clone, Args)]
pub struct BagArgs {
    /// What to do.
    #[command(subcommand)]
    pub verb: BagVerb,
}

/// What `zeronav bag` does.
#[derive(Debug, Clone, Subcommand)]
pub enum BagVerb {
    /// Say what is in a recording, and whether anything is missing.
    Info {
        /// The MCAP file.
        file: PathBuf,
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Say whether a recording is whole and complete: exit code 1 when messages are missing.
    Check {
        /// The MCAP file.
        file: PathBuf,
    },
    /// Say where two recordings begin to differ, by tick, topic and field: exit code 1 when they do.
    Diff(DiffArgs),
    /// Write every message of the contract into tables, a CSV file for each topic and one for its items.
    Export {
        /// The MCAP file.
        file: PathBuf,
        /// The folder of the tables: a new one, or an empty one.
        #[arg(long, value_name = "FOLDER")]
        csv: PathBuf,
        /// This topic only, such as plan/path. May be given several times.
        #[arg(long, value_name = "TOPIC")]
        topic: Vec<String>,
    },
    /// Write a recording that was cut again, up to its last whole chunk: at most a second is lost.
    Recover {
        /// The MCAP file.
        file: PathBuf,
        /// The new file; without, `NAME_recovered.mcap` beside the old one.
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
        /// Replace a file of the same name.
        #[arg(long)]
        force: bool,
    },
}

/// `zeronav bag`.
#[must_use]
pub fn bag(arguments: &BagArgs) -> ExitCode {
    match &arguments.verb {
        BagVerb::Info { file, json } => info(file, *json),
        BagVerb::Check { file } => check(file),
        BagVerb::Diff(arguments) => diff::diff(arguments),
        BagVerb::Export { file, csv, topic } => match export(file, csv, topic) {
            Ok(rows) => {
                let lines = rows.iter().map(|(topic, n)| format!("{n:>8}  {topic}\n"));
                say(&lines.collect::<String>());
                ExitCode::from(EXIT_PASS)
            }
            Err(problem) => problem.say(),
        },
        BagVerb::Recover { file, out, force } => {
            let out = out.clone().unwrap_or_else(|| beside(file));
            match recovered(file, &out, *force) {
                Ok((recovered, lost)) => {
                    let n = recovered.summary.messages();
                    say(&format!("{}: {n} messages{lost}\n", out.display()));
                    ExitCode::from(EXIT_PASS)
                }
                Err(problem) => problem.say(),
            }
        }
    }
}

fn info(file: &Path, json: bool) -> ExitCode {
    let (found, damage) = match open(file) {
        Ok(input) => summary(input),
        Err(problem) => return usage(&problem),
    };
    if json {
        say_json(&to_json(&found, damage.as_ref()));
    } else if !found.profile.is_empty() {
        say(&to_text(file, &found, damage.as_ref()));
    }
    match damage {
        Some(damage) => usage(&format!("{}: {damage}", file.display())),
        None => ExitCode::from(EXIT_PASS),
    }
}

/// One line on whether a recording can be relied on.
fn check(file: &Path) -> ExitCode {
    let (found, damage) = match open(file) {
        Ok(input) => summary(input),
        Err(problem) => return usage(&problem),
    };
    if let Some(damage) = damage {
        return usage(&format!("{}: {damage}", file.display()));
    }
    let n = found.messages();
    let (valid, why) = validity(&found, None);
    if valid {
        say(&format!("{}: complete, {n} messages\n", file.display()));
        return ExitCode::from(EXIT_PASS);
    }
    complain(&format!("{}: NOT COMPLETE: {why}", file.display()));
    ExitCode::from(EXIT_FAIL)
}

/// True when nothing is missing, and why it is not otherwise.
pub(crate) fn validity(found: &Summary, damage: Option<&ReadError>) -> (bool, String) {
    let verdict = found.metadata.get(VERDICT);
    let field = |name: &str| verdict.and_then(|fields| fields.get(name)).cloned();
    match (damage, field("valid")) {
        (Some(damage), _) => (false, format!("cut or damaged at {damage}")),
        (None, Some(valid)) => (valid == "true", field("why").unwrap_or_default()),
        (None, None) => (false, "it holds no verdict of zeronav-recorder".to_owned()),
    }
}

fn to_text(file: &Path, found: &Summary, damage: Option<&ReadError>) -> String {
    let [first_ns, last_ns] = found.range_ns.unwrap_or_default();
    let valid = match validity(found, damage) {
        (true, _) => "complete".to_owned(),
        (false, why) => format!("NOT COMPLETE: {why}"),
    };
    let text = format!(
        "{}: {valid}\nby {}, {} messages, {:.3} s from {:.3} s on\n",
        file.display(),
        found.library,
        found.messages(),
        seconds(last_ns - first_ns),
        seconds(first_ns)
    );
    let mut channels: Vec<_> = found.channels.values().collect();
    channels.sort_by_key(|channel| (channel.topic.starts_with(PREFIX), &channel.topic));
    let width = channels.iter().map(|channel| channel.topic.len()).max();
    let width = width.unwrap_or(0);
    let lines = channels.iter().map(|channel| {
        let (topic, schema) = (&channel.topic, &channel.schema);
        format!("  {topic:width$}  {:>8}  {schema}\n", channel.messages)
    });
    text + &lines.collect::<String>()
}

fn to_json(found: &Summary, damage: Option<&ReadError>) -> serde_json::Value {
    let (valid, why) = validity(found, damage);
    let channels: Vec<_> = found
        .channels
        .values()
        .map(|channel| {
            json!({
                "topic": channel.topic,
                "type": channel.schema,
                "encoding": channel.encoding,
                "messages": channel.messages,
            })
        })
        .collect();
    json!({
        "valid": valid,
        "why": why,
        "damaged_at": damage.map(|damage| damage.offset),
        "library": found.library,
        "messages": found.messages(),
        "range_ns": found.range_ns,
        "channels": channels,
        "metadata": found.metadata,
    })
}

fn beside(file: &Path) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    file.with_file_name(format!("{stem}_recovered.mcap"))
}

/// Writes `out`; what became of it, and what is lost, in words.
fn recovered(file: &Path, out: &Path, force: bool) -> Result<(Recovered, String), Problem> {
    let input = open(file).map_err(Problem::Input)?;
    if file.canonicalize().ok() == Some(out.canonicalize().unwrap_or_default()) {
        let problem = "it is the file to recover; name another one";
        return Err(Problem::Input(format!("{}: {problem}", out.display())));
    }
    let recovered = output_file::made(out, force, |output| {
        let copied = recover(input, BufWriter::new(output));
        let (recovered, mut output) = copied.map_err(|error| match error {
            RecoverError::Read(damage) => Problem::Input(format!("{}: {damage}", file.display())),
            RecoverError::Write(error) => Problem::writing(out, &error),
        })?;
        let flushed = output.flush();
        flushed.map_err(|error| Problem::writing(out, &error))?;
        Ok(recovered)
    })?;
    let lost = match &recovered.damage {
        Some(damage) => format!(", up to the damage at {damage}"),
        None => ", the old file was whole".to_owned(),
    };
    Ok((recovered, lost))
}
