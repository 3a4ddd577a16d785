//! With what and on what a run was made, and what lies in its folder.

use super::folder::{Outcome, RunFolder};
use super::html::{megabytes, pairs, text_of};
use core::fmt::Write;
use zeronav_measure::result::Environment;

/// Files of a run that a report links to, when they are there.
const FILES: [&str; 7] = [
    "result.json",
    "recording.json",
    "run.svg",
    "animation.svg",
    "answers.csv",
    "trace.json",
    "logs",
];

/// Longest command that is shown. [characters]
const COMMAND_MAX: usize = 380;

/// The table of the machine.
pub(super) fn environment(run: &RunFolder) -> String {
    let mut all = Vec::new();
    if let Some(recording) = &run.recording
        && !recording.command.is_empty()
    {
        let command: String = recording
            .command
            .join(" ")
            .chars()
            .take(COMMAND_MAX)
            .collect();
        all.push(("command", command));
    }
    match &run.outcome {
        Outcome::Run(result) => {
            all.extend(machine(&result.environment));
            all.push(("wall time", format!("{:.1} s", result.wall_s)));
            all.push(("shared memory", megabytes(result.shared_memory_bytes)));
            all.extend(result.link.iter().map(|link| ("link", link.to_string())));
            if let Some(hash) = &result.run_hash {
                all.push(("run hash", hash.clone()));
            }
            if result.reproducible == Some(false) {
                all.push(("not reproducible", result.not_reproducible.join("; ")));
            }
            all.push(("folder", result.directory.clone()));
        }
        Outcome::Stay(result) => {
            all.extend(machine(&result.environment));
            all.extend(result.link.iter().map(|link| ("link", link.to_string())));
            all.push(("folder", result.directory.clone()));
        }
    }
    pairs(&all) + &files(run)
}

fn machine(environment: &Environment) -> Vec<(&'static str, String)> {
    vec![
        (
            "version",
            format!("{}, {}", environment.version, environment.build),
        ),
        (
            "processor",
            format!("{}, {} cores", environment.cpu, environment.cores),
        ),
        ("kernel", environment.kernel.clone()),
        (
            "load average",
            format!(
                "{:.2} to {:.2}",
                environment.load_start, environment.load_end
            ),
        ),
        ("steal", format!("{:.1} %", 100.0 * environment.steal)),
    ]
}

/// Version, machine and load of a run in one line.
pub(super) fn machine_line(run: &RunFolder) -> String {
    let environment = match &run.outcome {
        Outcome::Run(result) => &result.environment,
        Outcome::Stay(result) => &result.environment,
    };
    format!(
        "{}, {}, {} cores, load {:.1} to {:.1}",
        environment.version,
        environment.cpu,
        environment.cores,
        environment.load_start,
        environment.load_end
    )
}

/// Links to the other files of the folder.
fn files(run: &RunFolder) -> String {
    let mut html = String::new();
    for name in FILES.iter().filter(|name| run.path.join(name).exists()) {
        let _ = write!(html, " <a href=\"{0}\">{0}</a>", text_of(name));
    }
    if html.is_empty() {
        return html;
    }
    format!("<p class=\"files\">Beside this file:{html}</p>\n")
}
