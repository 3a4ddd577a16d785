//! Runs what is measured: the release build of `zeronav`, criterion benches, programs that print.

use super::record::{Machine, Table};
use crate::workspace;
use serde_json::Value;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::SystemTime;

/// What an experiment gave.
#[derive(Debug, Default)]
pub struct Measured {
    /// Its tables.
    pub tables: Vec<Table>,
    /// What a program printed.
    pub text: Option<String>,
}

impl Measured {
    /// Figures alone.
    #[must_use]
    pub fn tables(tables: Vec<Table>) -> Self {
        Self { tables, text: None }
    }

    /// What a program printed.
    #[must_use]
    pub fn printed(text: &str) -> Self {
        Self {
            tables: Vec::new(),
            text: Some(text.to_owned()),
        }
    }
}

/// Writes the scenario of an experiment and returns its file from the workspace's folder.
///
/// # Errors
/// One line naming the file.
pub(super) fn write_scenario(name: &str, text: &str) -> Result<String, String> {
    let file = format!("target/experiments/{name}.toml");
    let path = workspace().join(&file);
    let write = || {
        std::fs::create_dir_all(workspace().join("target/experiments"))?;
        std::fs::write(&path, text)
    };
    write().map_err(|error: std::io::Error| format!("{file}: {error}"))?;
    Ok(file)
}

/// The first line of such a scenario that builds on a shipped one.
pub(super) fn on_shipped(name: &str) -> String {
    format!("base = \"../../launch/scenarios/{name}.toml\"\n")
}

/// True when all trials were made and nothing failed but that some were not answered.
fn is_only_unanswered(result: &Value) -> bool {
    let expectations = result["expectations"].as_array().into_iter().flatten();
    let mut failed = expectations.filter(|one| one["met"] != true).peekable();
    failed.peek().is_some() && failed.all(|one| one["name"] == "trials without an answer")
}

/// One criterion benchmark.
#[derive(Debug)]
pub struct Timing {
    /// Its name.
    pub name: String,
    /// Time of one iteration in every sample. [us]
    pub samples_us: Vec<f64>,
}

/// Where the measured programs run, and what was run so far.
#[derive(Debug)]
pub struct Bench {
    folder: tempfile::TempDir,
    data: Option<PathBuf>,
    /// The commands that were run, as a user types them.
    pub commands: Vec<String>,
}

impl Bench {
    /// Builds what is measured. `data` is the folder of the external data sets.
    ///
    /// # Errors
    /// One line about what failed.
    pub fn new(data: Option<PathBuf>) -> Result<Self, String> {
        cargo(&["build", "--release", "--locked", "--workspace", "--bins"])?;
        Ok(Self {
            folder: tempfile::tempdir().map_err(|error| format!("a working folder: {error}"))?,
            data,
            commands: Vec::new(),
        })
    }

    /// Runs `zeronav` and returns its JSON object.
    ///
    /// # Errors
    /// One line with the end of what it said when it fails or the scenario does.
    pub fn zeronav(&mut self, arguments: &[&str]) -> Result<Value, String> {
        let text = self.zeronav_prints(arguments, &["--json"])?;
        serde_json::from_str(&text).map_err(|error| format!("zeronav {arguments:?}: {error}"))
    }

    /// Makes trials and returns their result, also when some were not answered: that is a figure, too.
    ///
    /// # Errors
    /// See [`Self::zeronav`].
    pub fn trials(&mut self, scenario: &str, n: usize) -> Result<Value, String> {
        let n = n.to_string();
        let mut command = self.command(&["run", scenario, "--trials", &n], &["--json"]);
        let problem = |error: &dyn core::fmt::Display| format!("trials of {scenario}: {error}");
        let output = command.stdin(Stdio::null()).output();
        let output = output.map_err(|error| problem(&error))?;
        let result = serde_json::from_slice(&output.stdout);
        if let Some(result) = result
            .as_ref()
            .ok()
            .filter(|result| is_only_unanswered(result))
        {
            return Ok(result.clone());
        }
        text_of(&command, &output)?;
        result.map_err(|error| problem(&error))
    }

    /// Runs `zeronav` and returns its page for people.
    ///
    /// # Errors
    /// See [`Self::zeronav`].
    pub fn zeronav_page(&mut self, arguments: &[&str]) -> Result<String, String> {
        self.zeronav_prints(arguments, &[])
    }

    /// Runs `zeronav` and returns its JSON object, and what `beside` gave, which is told the folder of
    /// the binaries and the process id once it runs.
    ///
    /// # Errors
    /// See [`Self::zeronav`], and those of `beside`.
    pub fn zeronav_beside<T>(
        &mut self,
        arguments: &[&str],
        beside: impl FnOnce(&Path, u32) -> Result<T, String>,
    ) -> Result<(Value, T), String> {
        let mut command = self.command(arguments, &["--json"]);
        let problem = |error: &dyn core::fmt::Display| format!("zeronav {arguments:?}: {error}");
        let child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| problem(&error))?;
        let found = beside(&target().join("release"), child.id());
        let output = child.wait_with_output().map_err(|error| problem(&error))?;
        let text = text_of(&command, &output)?;
        let result = serde_json::from_str(&text).map_err(|error| problem(&error))?;
        Ok((result, found?))
    }

    fn zeronav_prints(&mut self, arguments: &[&str], more: &[&str]) -> Result<String, String> {
        output(&mut self.command(arguments, more))
    }

    /// `zeronav` of the release build with these arguments, whose results go to a folder of this bench.
    pub(super) fn command(&mut self, arguments: &[&str], more: &[&str]) -> Command {
        let mut command = Command::new(target().join("release").join("zeronav"));
        command
            .args(arguments)
            .args(more)
            .args(["--headless", "--out"])
            .arg(self.folder.path())
            // The binaries are fresh, and no other build is to be measured.
            .env_remove("CARGO")
            .current_dir(workspace());
        if arguments.first() == Some(&"suite")
            && let Some(data) = &self.data
        {
            command.arg("--data").arg(data);
        }
        let line = format!("zeronav {}", arguments.join(" "));
        if !self.commands.contains(&line) {
            self.commands.push(line);
        }
        command
    }

    /// Runs `cargo` with these arguments and returns what it and its program printed.
    ///
    /// # Errors
    /// See [`Self::zeronav`].
    pub fn cargo(&mut self, arguments: &[&str]) -> Result<String, String> {
        self.commands.push(format!("cargo {}", arguments.join(" ")));
        cargo(arguments)
    }

    /// Runs another binary of the tests and returns what it printed. `arguments` are followed by the
    /// folder of the data sets.
    ///
    /// # Errors
    /// See [`Self::zeronav`].
    pub fn tool(&mut self, name: &str, arguments: &[&str]) -> Result<String, String> {
        let mut command = Command::new(target().join("release").join(name));
        command.args(arguments).current_dir(workspace());
        if let Some(data) = &self.data {
            command.arg("--data").arg(data);
        }
        let run = format!("cargo run --release -p zeronav-tests --bin {name}");
        self.commands
            .push(format!("{run} -- {}", arguments.join(" ")));
        output(&mut command)
    }

    /// Runs a script of the workspace, which finds `zeronav` on its path, and returns what it printed. Its results
    /// go to a folder by `--out`.
    ///
    /// # Errors
    /// See [`Self::zeronav`].
    pub fn python(
        &mut self,
        python: &Path,
        script: &str,
        arguments: &[&str],
    ) -> Result<String, String> {
        let path = std::env::var("PATH").unwrap_or_default();
        let mut command = Command::new(python);
        command
            .arg(script)
            .arg("--out")
            .arg(self.folder.path())
            .args(arguments)
            .env(
                "PATH",
                format!("{}:{path}", target().join("release").display()),
            )
            .env_remove("CARGO")
            .current_dir(workspace());
        let line = format!("python {script} --out runs {}", arguments.join(" "));
        if !self.commands.contains(&line) {
            self.commands.push(line);
        }
        output(&mut command)
    }

    /// True when the data sets are there.
    #[must_use]
    pub fn has_data(&self) -> bool {
        self.data.is_some()
    }

    /// Runs an example that wants the data sets.
    ///
    /// # Errors
    /// See [`Self::zeronav`]; one line when no folder was named.
    pub fn cargo_with_data(&mut self, arguments: &[&str], part: &str) -> Result<String, String> {
        let data = self.data.as_ref().ok_or("name the data sets with --data")?;
        let folder = data.join(part).display().to_string();
        self.commands
            .push(format!("cargo {} --data {part}", arguments.join(" ")));
        let mut all = arguments.to_vec();
        all.extend(["--data", &folder]);
        cargo(&all)
    }

    /// Runs one bench of a library.
    ///
    /// # Errors
    /// One line when it fails or leaves no samples.
    pub fn criterion(&mut self, package: &str, bench: &str) -> Result<Vec<Timing>, String> {
        let started = SystemTime::now();
        self.cargo(&[
            "bench",
            "-p",
            package,
            "--no-default-features",
            "--bench",
            bench,
            "--",
            "--warm-up-time",
            "1",
            "--measurement-time",
            "2",
        ])?;
        let mut timings = Vec::new();
        find_timings(&target().join("criterion"), started, &mut timings)?;
        timings.sort_by(|a, b| a.name.cmp(&b.name));
        if timings.is_empty() {
            return Err(format!("{package}: bench `{bench}` left no samples"));
        }
        Ok(timings)
    }
}

/// The machine now; load and steal are filled in when the experiment is over.
///
/// # Errors
/// One line when the compiler does not say its version.
pub fn machine(before: zeronav_console::environment::Before) -> Result<Machine, String> {
    let environment = before.environment();
    let rustc = output(Command::new("rustc").arg("--version"))?;
    Ok(Machine {
        cpu: environment.cpu,
        cores: environment.cores,
        kernel: environment.kernel,
        rustc: rustc.split(' ').nth(1).unwrap_or("unknown").to_owned(),
        load: [environment.load_start, environment.load_end],
        steal: environment.steal,
    })
}

/// The commit, marked when sources differ from it; pages and records are no sources.
///
/// # Errors
/// One line when this is no git repository.
pub fn commit() -> Result<String, String> {
    let git =
        |arguments: &[&str]| output(Command::new("git").args(arguments).current_dir(workspace()));
    let mut commit = git(&["rev-parse", "--short=10", "HEAD"])?.trim().to_owned();
    let changes = git(&[
        "status",
        "--porcelain",
        "--",
        ".",
        ":!*.md",
        ":!tests/results.json",
    ])?;
    if !changes.trim().is_empty() {
        commit += "+changes";
    }
    Ok(commit)
}

/// Today, UTC.
///
/// # Errors
/// One line when the system does not say.
pub fn date() -> Result<String, String> {
    let date = output(Command::new("date").args(["-u", "+%F"]))?;
    Ok(date.trim().to_owned())
}

fn target() -> PathBuf {
    workspace().join("target")
}

fn cargo(arguments: &[&str]) -> Result<String, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command
        .args(arguments)
        .env("CARGO_TARGET_DIR", target())
        // Set by a cargo around this one; they name its package.
        .env_remove("CARGO_MANIFEST_DIR")
        .current_dir(workspace());
    output(&mut command)
}

/// What a command prints that succeeds.
fn output(command: &mut Command) -> Result<String, String> {
    let name = command.get_program().display().to_string();
    let output = command.stdin(Stdio::null()).output();
    let output = output.map_err(|error| format!("{name}: {error}"))?;
    text_of(command, &output)
}

/// Standard output of a command that has succeeded; standard error when there is none.
fn text_of(command: &Command, output: &Output) -> Result<String, String> {
    /// Lines of a failure that are shown.
    const SHOWN: usize = 12;
    let mut text = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        if text.is_empty() {
            text.push_str(&errors);
        }
        return Ok(text);
    }
    let lines: Vec<&str> = text.lines().chain(errors.lines()).collect();
    let end = lines[lines.len().saturating_sub(SHOWN)..].join("\n  ");
    let arguments: Vec<_> = command.get_args().map(OsStr::to_string_lossy).collect();
    Err(format!(
        "{} {}: {}\n  {end}",
        command.get_program().display(),
        arguments.join(" "),
        output.status
    ))
}

/// Every benchmark below `folder` that was made since `started`.
fn find_timings(
    folder: &Path,
    started: SystemTime,
    timings: &mut Vec<Timing>,
) -> Result<(), String> {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if !path.is_dir() {
            continue;
        }
        if entry.file_name() != "new" {
            find_timings(&path, started, timings)?;
            continue;
        }
        let sample = path.join("sample.json");
        let made = std::fs::metadata(&sample).and_then(|file| file.modified());
        if made.is_ok_and(|made| made >= started) {
            timings.push(read_timing(&path)?);
        }
    }
    Ok(())
}

/// One benchmark from criterion's files.
fn read_timing(folder: &Path) -> Result<Timing, String> {
    let read = |name: &str| -> Result<Value, String> {
        let file = folder.join(name);
        let text = std::fs::read_to_string(&file);
        let text = text.map_err(|error| format!("{}: {error}", file.display()))?;
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", file.display()))
    };
    let (benchmark, sample) = (read("benchmark.json")?, read("sample.json")?);
    let numbers = |key: &str| -> Vec<f64> {
        let list = sample[key].as_array().into_iter().flatten();
        list.filter_map(Value::as_f64).collect()
    };
    let (iterations, times_ns) = (numbers("iters"), numbers("times"));
    let name = benchmark["full_id"].as_str();
    let name = name.ok_or_else(|| format!("{}: no name", folder.display()))?;
    Ok(Timing {
        name: name.to_owned(),
        samples_us: iterations
            .iter()
            .zip(times_ns)
            .filter(|(n, _)| **n > 0.0)
            .map(|(n, time_ns)| time_ns / n / 1000.0)
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn timings_are_read_from_what_criterion_leaves() {
        let folder = tempfile::tempdir().expect("a folder");
        let leave = |name: &str, id: &str| {
            let new = folder.path().join(name).join("new");
            std::fs::create_dir_all(&new).expect("a folder");
            let benchmark = format!("{{\"full_id\":\"{id}\"}}");
            std::fs::write(new.join("benchmark.json"), benchmark).expect("written");
            let sample = "{\"iters\":[2.0,4.0],\"times\":[6000.0,16000.0]}";
            std::fs::write(new.join("sample.json"), sample).expect("written");
        };
        leave("group/a", "group/a");
        let mut timings = Vec::new();
        let long_ago = SystemTime::UNIX_EPOCH;
        find_timings(folder.path(), long_ago, &mut timings).expect("timings");
        assert_eq!(timings.len(), 1);
        assert_eq!(timings[0].name, "group/a");
        assert_eq!(timings[0].samples_us, [3.0, 4.0]);
        // Those of an earlier bench are not taken for new.
        let later = SystemTime::now() + std::time::Duration::from_secs(60);
        let mut none = Vec::new();
        find_timings(folder.path(), later, &mut none).expect("timings");
        assert!(none.is_empty());
    }

    #[test]
    fn trials_without_an_answer_are_figures_and_contacts_are_failures() {
        let result = |met: [bool; 2]| {
            let names = ["trials without an answer", "contacts"];
            let expectations = names.iter().zip(met);
            let expectations = expectations.map(|(name, met)| json!({"name": name, "met": met}));
            json!({"expectations": expectations.collect::<Vec<_>>()})
        };
        assert!(is_only_unanswered(&result([false, true])));
        assert!(!is_only_unanswered(&result([false, false])));
        assert!(!is_only_unanswered(&result([true, true])));
        assert!(!is_only_unanswered(&json!({})));
    }

    #[test]
    fn failures_are_named_with_the_end_of_their_output() {
        let error = output(Command::new("sh").args(["-c", "echo no such thing >&2; exit 3"]));
        let error = error.expect_err("a failure");
        assert!(
            error.contains("no such thing") && error.contains('3'),
            "{error}"
        );
    }
}
