//! `zeronav debug`: a lockstep run that stands before a tick, with a debugger on one of its processes.
//!
//! The run is driven again from its start until there, and back to an earlier tick in the same way: in lockstep it is the
//! same every time. While it stands, and while a debugger holds a process, nothing counts as hung and nobody waits in vain.

mod console;
mod debugger;
mod held_run;
mod moment;
mod words;

use crate::prepare::prepare;
use crate::recorded::Recorded;
use crate::recorder::RecordTo;
use crate::run_plan::{RunPlan, Source};
use clap::Args;
use console::Console;
use moment::Moment;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use zeronav_console::arguments::{seat, service_role};
use zeronav_console::terminal::usage;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_scenario::settings::DriverArgs;

/// Arguments of `zeronav debug`.
#[derive(Debug, Clone, Args)]
pub struct DebugArgs {
    /// Recording of a lockstep run, folder of a run with one, or name or path of a scenario.
    pub run: PathBuf,
    /// Where it stands: before this tick, such as 412, or before the first tick at or after this run time, such as 20.6s.
    #[arg(long, value_name = "TICK|TIMEs", default_value = "1")]
    pub at: Moment,
    /// Start the debugger on the process in this seat at once.
    #[arg(long, value_name = "ROLE", value_parser = service_role)]
    pub attach: Option<Role>,
    /// Another binary in a seat. May be given several times.
    #[arg(long, value_name = "ROLE=BINARY", value_parser = seat)]
    pub swap: Vec<(Role, PathBuf)>,
    /// Seed of everything random, in place of the scenario's or the recording's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Who drives.
    #[command(flatten)]
    pub driver: DriverArgs,
    /// Folder in which the folder with the logs is made.
    #[arg(long, value_name = "FOLDER", default_value = "runs")]
    pub out: PathBuf,
    /// The debugger and its arguments; `{pid}` in them is the process, without it `-p PID` is put behind the first word.
    /// Without, rust-gdb, gdb or lldb.
    #[arg(last = true, value_name = "DEBUGGER")]
    pub debugger: Vec<OsString>,
}

/// `zeronav debug`.
#[must_use]
pub fn debug(arguments: &DebugArgs) -> ExitCode {
    let opened = arguments.plan().and_then(|plan| {
        let prepare = move || prepare(&plan);
        let debugger = debugger::Debugger::of(&arguments.debugger)?;
        Console::open(prepare, debugger)
    });
    match opened {
        Ok(console) => console.run(&arguments.at, arguments.attach),
        Err(problem) => usage(&problem),
    }
}

impl DebugArgs {
    fn plan(&self) -> Result<RunPlan, String> {
        let (source, seed) = self.source()?;
        Ok(RunPlan {
            seed: self.seed.or(seed),
            binaries: self.swap.iter().cloned().collect(),
            settings: self.driver.settings(),
            out: self.out.clone(),
            progress: false,
            ..RunPlan::of(source, RunMode::Lockstep)
        })
    }

    /// What is driven, with the seed of a recording.
    fn source(&self) -> Result<(Source, Option<u64>), String> {
        let Some(file) = recording_of(&self.run) else {
            let name = self.run.to_str().ok_or("a scenario's name is UTF-8")?;
            return Ok((Source::Named(name.to_owned()), None));
        };
        let recorded = Recorded::read(&file)?;
        let (name, text) = recorded
            .drive()
            .map_err(|why| format!("{}: {why}", file.display()))?;
        Ok((Source::Text { name, text }, Some(recorded.seed)))
    }
}

/// The recording that `run` is or has in it; `None` = it names a scenario.
fn recording_of(run: &Path) -> Option<PathBuf> {
    if run.extension().is_some_and(|it| it == "mcap") {
        return Some(run.to_owned());
    }
    let inside = RecordTo::RunFolder.file(run);
    inside.is_file().then_some(inside)
}
