//! `zeronav bisect`: the first tick, seat and field in which two programs or parameter values drive a run otherwise, or
//! the first commit of a range whose program does. The search itself is `git bisect run`, in a worktree of its own.

mod commits;
mod worktree;

use crate::bag::diff::Beside;
use crate::commands::drive_and_judge;
use crate::output_args::OutputArgs;
use crate::recorder::RecordTo;
use crate::replay::ReplayArgs;
use crate::run_plan::{RunPlan, Source};
use clap::Args;
use commits::{Commits, Found, Problem};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use zeronav_console::arguments::seat;
use zeronav_console::exit::{EXIT_FAIL, EXIT_INTERRUPTED, EXIT_PASS};
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{complain, note, say, usage};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_scenario::settings::DriverArgs;
use zeronav_shell::printable::printable;

/// Arguments of `zeronav bisect`.
#[derive(Debug, Clone, Args)]
pub struct BisectArgs {
    /// Recording of a lockstep run, or name or path of a scenario, which is driven and recorded first.
    pub run: PathBuf,
    /// The other binary in a seat; with --commits, the path of the built binary from the top folder of the repository. May
    /// be given several times.
    #[arg(long, value_name = "ROLE=BINARY", value_parser = seat)]
    pub swap: Vec<(Role, PathBuf)>,
    /// Who drives instead.
    #[command(flatten)]
    pub driver: DriverArgs,
    /// Look for the first of these commits, GOOD not among them, with whose binary the run differs.
    #[arg(long, value_name = "GOOD..BAD", value_parser = range, requires = "build")]
    pub commits: Option<(String, String)>,
    /// What builds a commit, for the shell, in the top folder of a worktree; a commit that it fails for is skipped.
    #[arg(long, value_name = "COMMAND", requires = "commits")]
    pub build: Option<String>,
    /// The repository.
    #[arg(long, value_name = "FOLDER", default_value = ".", requires = "commits")]
    pub repository: PathBuf,
    /// Folder in which every run's own folder is made.
    #[arg(long, value_name = "FOLDER", default_value = "runs")]
    pub out: PathBuf,
}

/// `v1..HEAD` as two commits.
fn range(text: &str) -> Result<(String, String), String> {
    let ends = text.split_once("..");
    let is_commit = |text: &&str| !text.is_empty() && !text.starts_with(['-', '.']);
    let ends = ends.filter(|(good, bad)| [good, bad].into_iter().all(is_commit));
    let (good, bad) =
        ends.ok_or("commits read like v1.0..HEAD: one that is good, and a later one that is not")?;
    Ok((good.to_owned(), bad.to_owned()))
}

/// `zeronav bisect`: exit code 0 when it has found the first difference, 1 when there is none.
#[must_use]
pub fn bisect(arguments: &BisectArgs) -> ExitCode {
    let found = interrupts().map_err(Problem::from).and_then(|interrupted| {
        arguments.check()?;
        let found = arguments.find(&interrupted);
        if interrupted.load(Ordering::Relaxed) {
            return Err(Problem::Interrupted);
        }
        found
    });
    match found {
        Ok(code) => ExitCode::from(code),
        Err(Problem::Usage(why)) => usage(&printable(&why)),
        Err(Problem::Interrupted) => {
            complain("interrupted");
            ExitCode::from(EXIT_INTERRUPTED)
        }
    }
}

impl BisectArgs {
    fn check(&self) -> Result<(), Problem> {
        let none = self.swap.is_empty() && self.driver.settings().is_empty();
        if none {
            let why = "name what to change: --swap ROLE=BINARY or --set ROLE.KEY=VALUE";
            return Err(Problem::Usage(why.to_owned()));
        }
        if self.commits.is_some() && self.swap.is_empty() {
            let why = "--commits needs --swap ROLE=BINARY: the built program and its seat";
            return Err(Problem::Usage(why.to_owned()));
        }
        if self.commits.is_some() && !self.driver.settings().is_empty() {
            let why = "--as and --set differ in every commit: record a run with them, and search with that";
            return Err(Problem::Usage(why.to_owned()));
        }
        Ok(())
    }

    fn find(&self, interrupted: &Arc<AtomicBool>) -> Result<u8, Problem> {
        let (Some((good, bad)), Some(build)) = (&self.commits, &self.build) else {
            let file = self.reference(interrupted)?;
            let beside = self.compared(&file, &self.swap, interrupted)?;
            return Ok(tell(&beside));
        };
        let ends = [good, bad].map(|name| worktree::commit(&self.repository, name));
        let [good_hash, bad_hash] = ends;
        let (good_hash, bad_hash) = (good_hash?, bad_hash?);
        let file = self.reference(interrupted)?;
        let commits = Commits {
            good: (good, &good_hash),
            bad: (bad, &bad_hash),
            build,
            file: &file,
            out: &self.out,
            interrupted,
        };
        let worktree = worktree::Worktree::add(&self.repository, &bad_hash)?;
        let swap = worktree.laid_under(&self.swap);
        match commits.first(&worktree, &swap)? {
            Found::First(commit) => {
                say(&format!(
                    "the first commit that differs: {}\n",
                    printable(&commit)
                ));
                let beside = self.compared(&file, &swap, interrupted)?;
                Ok(tell(&beside))
            }
            Found::OneOf(commits) => {
                say(&format!(
                    "one of these is the first commit that differs; those before the last one could not be built or driven:\n{}\n",
                    commits.join("\n")
                ));
                Ok(EXIT_PASS)
            }
        }
    }

    /// The recording that the other is compared with.
    fn reference(&self, interrupted: &Arc<AtomicBool>) -> Result<PathBuf, String> {
        if self.run.extension().is_some_and(|it| it == "mcap") {
            return std::path::absolute(&self.run).map_err(|error| error.to_string());
        }
        let name = self.run.to_str().ok_or("a scenario's name is UTF-8")?;
        note(&format!("recording {}", printable(name)));
        let plan = RunPlan {
            record: Some(RecordTo::RunFolder),
            out: self.out.clone(),
            progress: false,
            ..RunPlan::of(Source::Named(name.to_owned()), RunMode::Lockstep)
        };
        let (result, code) = drive_and_judge(&plan, interrupted)?;
        if ![EXIT_PASS, EXIT_FAIL].map(ExitCode::from).contains(&code) {
            return Err(format!("{name} was not recorded: {}", result.reason));
        }
        let file = RecordTo::RunFolder.file(Path::new(&result.directory));
        std::path::absolute(file).map_err(|error| error.to_string())
    }

    /// Drives again with these binaries, and compares.
    fn compared(
        &self,
        file: &Path,
        swap: &[(Role, PathBuf)],
        interrupted: &Arc<AtomicBool>,
    ) -> Result<Beside, String> {
        let replay = ReplayArgs {
            file: file.to_owned(),
            open: Vec::new(),
            swap: swap.to_vec(),
            from: None,
            to: None,
            equal: false,
            scenario: None,
            driver: self.driver.clone(),
            output: OutputArgs {
                json: false,
                headless: true,
                out: self.out.clone(),
                log_level: "info".to_owned(),
            },
        };
        let compared = replay.compared(interrupted);
        compared.map(|(_, beside)| beside).map_err(|not| not.why)
    }
}

/// Says where two runs begin to differ, and which seat does.
fn tell(beside: &Beside) -> u8 {
    if let Some(first) = &beside.comparison.first {
        say(&format!(
            "{} is the first seat that differs, at tick {} ({:.3} s)\n",
            printable(&first.author),
            first.tick,
            first.run_s
        ));
    }
    say(&beside.to_text());
    if beside.is_equal() {
        EXIT_FAIL
    } else {
        EXIT_PASS
    }
}
