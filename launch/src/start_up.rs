//! `zeronav start-up`: what a run did from the command to the first motion, and who waited for whom.

use clap::Args;
use core::fmt::Write;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_casts::Cast;
use zeronav_console::terminal::{say, say_json, usage};
use zeronav_measure::result::RunResult;
use zeronav_measure::result::start_up::{Stage, StartUp};

/// Width of the bars. [characters]
const BAR: usize = 40;

/// Arguments of `zeronav start-up`.
#[derive(Debug, Clone, Args)]
pub struct StartUpArgs {
    /// Folder of a run in real time; without, the newest in `--out`.
    #[arg(value_name = "RUN")]
    pub run: Option<PathBuf>,
    /// Folder in which the folders of the runs lie.
    #[arg(long, value_name = "FOLDER", default_value = "runs")]
    pub out: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    directory: String,
    #[serde(flatten)]
    start_up: &'a StartUp,
    critical_chain: Vec<&'a Stage>,
}

/// `zeronav start-up`.
#[must_use]
pub fn start_up(arguments: &StartUpArgs) -> ExitCode {
    let shown = folder(arguments).and_then(|run| {
        let result = RunResult::read(&run)?;
        let start_up = result.start_up.ok_or_else(|| {
            format!(
                "{}: no stages of its start: trials, runs in lockstep and runs of older versions \
                 have none",
                run.display()
            )
        })?;
        Ok((run, start_up))
    });
    let (run, start_up) = match shown {
        Ok(shown) => shown,
        Err(problem) => return usage(&problem),
    };
    if arguments.json {
        say_json(&Report {
            directory: run.display().to_string(),
            start_up: &start_up,
            critical_chain: start_up.critical_chain(),
        });
    } else {
        say(&to_text(&run, &start_up));
    }
    ExitCode::SUCCESS
}

/// The run that is meant.
fn folder(arguments: &StartUpArgs) -> Result<PathBuf, String> {
    if let Some(run) = &arguments.run {
        return Ok(run.clone());
    }
    let out = arguments.out.display();
    let entries = std::fs::read_dir(&arguments.out)
        .map_err(|error| format!("{out}: {error}; name the folder of a run"))?;
    let result = |entry: std::io::Result<std::fs::DirEntry>| {
        let run = entry.ok()?.path();
        let made = std::fs::metadata(run.join("result.json")).ok()?;
        Some((made.modified().ok()?, run))
    };
    let newest = entries.filter_map(result).max();
    newest
        .map(|(_, run)| run)
        .ok_or_else(|| format!("{out} holds no run: name the folder of one"))
}

fn to_text(run: &Path, start_up: &StartUp) -> String {
    let mut text = String::new();
    let end_ms = start_up.stages.last().map_or(0.0, |stage| stage.to_ms);
    match start_up.first_motion_ms {
        Some(motion_ms) => {
            let _ = writeln!(text, "first motion {motion_ms:.0} ms after the command");
        }
        None => text.push_str("the robot has not moved\n"),
    }
    let chain = start_up.critical_chain();
    let _ = writeln!(
        text,
        "\n  {:<26} {:>9} {:>9}  critical chain",
        "stage", "took [ms]", "done [ms]"
    );
    for stage in &chain {
        write_stage(stage, end_ms, &mut text);
    }
    let beside = |stage: &&Stage| !chain.iter().any(|on| on.name == stage.name);
    let mut beside = start_up.stages.iter().filter(beside).peekable();
    if beside.peek().is_some() {
        text.push_str("\n  beside it\n");
    }
    for stage in beside {
        write_stage(stage, end_ms, &mut text);
    }
    let _ = writeln!(text, "  {}", run.display());
    text
}

/// A line with a bar from the beginning to the end of a stage.
fn write_stage(stage: &Stage, end_ms: f64, text: &mut String) {
    let place = |at_ms: f64| {
        let share = if end_ms > 0.0 { at_ms / end_ms } else { 0.0 };
        (share.clamp(0.0, 1.0) * BAR.to_f64()).round().to_usize()
    };
    let (from, to) = (place(stage.from_ms), place(stage.to_ms));
    let bar = "#".repeat(to.saturating_sub(from).max(1));
    let from = from.min(BAR - 1);
    let _ = writeln!(
        text,
        "  {:<26} {:>9.1} {:>9.1}  {:from$}{bar}",
        stage.name,
        stage.to_ms - stage.from_ms,
        stage.to_ms,
        ""
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chain_comes_first_and_the_rest_beside_it() {
        let stage = |name: &str, from_ms, to_ms, waited_for: Option<&str>| Stage {
            name: name.to_owned(),
            who: "launch".to_owned(),
            from_ms,
            to_ms,
            waited_for: waited_for.map(str::to_owned),
        };
        let start_up = StartUp {
            first_motion_ms: Some(400.0),
            stages: vec![
                stage("scenario checked", 0.0, 100.0, None),
                stage("robot ready", 100.0, 150.0, Some("scenario checked")),
                stage("mapping ready", 100.0, 300.0, Some("scenario checked")),
                stage("first motion", 300.0, 400.0, Some("mapping ready")),
            ],
        };
        let text = to_text(Path::new("runs/it"), &start_up);
        let (chain, beside) = text.split_once("beside it").expect("two parts");
        assert!(chain.starts_with("first motion 400 ms"), "{text}");
        assert!(
            chain.contains("mapping ready") && !chain.contains("robot ready"),
            "{text}"
        );
        assert!(beside.contains("robot ready"), "{text}");
        assert!(
            chain.contains(&format!("{:10}{}", "", "#".repeat(20))),
            "{text}"
        );
    }
}
