//! `zeronav replay`: drives a recorded run again and says where it begins to differ. In closed loop the scenario of a
//! lockstep run is driven; in open loop what was recorded is played to some seats.

use crate::bag::diff::{Beside, beside, run_time, ticks_of};
use crate::commands::drive_and_judge;
use crate::open_loop::{self, NotPlayed, open_loop};
use crate::output_args::OutputArgs;
use crate::recorded::Recorded;
use crate::recorder::RecordTo;
use crate::run_plan::{RunPlan, Source};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use zeronav_console::arguments::{seat, service_role};
use zeronav_console::exit::{EXIT_FAIL, EXIT_OUTPUT, EXIT_PASS, EXIT_USAGE};
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{complain, say, say_json};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_recorder::compare::Scope;
use zeronav_scenario::settings::DriverArgs;
use zeronav_shell::printable::printable;

/// Arguments of `zeronav replay`.
#[derive(Debug, Clone, Args)]
pub struct ReplayArgs {
    /// The MCAP file of a run with `--record`.
    pub file: PathBuf,
    /// Open loop: start these seats alone, and play to them what was recorded of all others. What they send is compared.
    /// Without, the scenario of a lockstep run is driven again as a whole.
    #[arg(long, value_name = "ROLE[,ROLE]", value_delimiter = ',', value_parser = open_seat)]
    pub open: Vec<Role>,
    /// Another binary in a seat; it drives on its own from the first tick. May be given several times.
    #[arg(long, value_name = "ROLE=BINARY", value_parser = seat)]
    pub swap: Vec<(Role, PathBuf)>,
    /// Compare from this run time on. [s]
    #[arg(long, value_name = "S", value_parser = run_time)]
    pub from: Option<f64>,
    /// Compare up to this run time; in open loop nothing is played beyond it. [s]
    #[arg(long, value_name = "S", value_parser = run_time)]
    pub to: Option<f64>,
    /// Exit code 1 when it differs also with --swap, --as or --set, as `git bisect run` wants it.
    #[arg(long)]
    pub equal: bool,
    /// Configure the open seats by this scenario (its name or path) in place of the one in the recording.
    #[arg(long, value_name = "SCENARIO", requires = "open")]
    pub scenario: Option<String>,
    /// Who drives.
    #[command(flatten)]
    pub driver: DriverArgs,
    /// What it shows.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// A seat that can be open.
pub(crate) fn open_seat(name: &str) -> Result<Role, String> {
    let role = service_role(name)?;
    if open_loop::SEATS.contains(&role) {
        Ok(role)
    } else {
        Err("what the robot senses is what is played: name a seat behind it".to_owned())
    }
}

/// A run that was made to be compared with the recording.
pub(crate) struct Again {
    /// Its recording.
    file: PathBuf,
    /// What it is compared with.
    original: PathBuf,
    /// What became of it, in words and for `--json`.
    said: String,
    result: Value,
}

/// Why there is nothing to compare, with what is known of the run.
pub(crate) struct NotCompared {
    pub why: String,
    code: ExitCode,
    result: Value,
}

impl From<String> for NotCompared {
    fn from(why: String) -> Self {
        Self {
            why,
            code: ExitCode::from(EXIT_USAGE),
            result: Value::Null,
        }
    }
}

/// `zeronav replay`: exit code 1 when the run differs although nothing in it was changed.
#[must_use]
pub fn replay(arguments: &ReplayArgs) -> ExitCode {
    let (again, beside) = match interrupts()
        .map_err(NotCompared::from)
        .and_then(|it| arguments.compared(&it))
    {
        Ok(compared) => compared,
        Err(NotCompared { why, code, result }) => {
            if arguments.output.json && !result.is_null() {
                say_json(&json!({ "comparison": null, "result": result }));
            }
            complain(&printable(&why));
            return code;
        }
    };
    if arguments.output.json {
        say_json(&json!({ "comparison": beside.to_json(), "result": again.result }));
    } else {
        say(&to_text(&again, &beside));
    }
    let is_changed =
        !arguments.equal && (!arguments.swap.is_empty() || !arguments.driver.settings().is_empty());
    // To what a robot of others did there is no answer that could differ.
    let has_none = !arguments.open.is_empty() && beside.cannot_differ();
    ExitCode::from(if beside.is_equal() || is_changed || has_none {
        EXIT_PASS
    } else {
        EXIT_FAIL
    })
}

fn to_text(again: &Again, beside: &Beside) -> String {
    format!(
        "a: {}\nb: {} ({})\n{}",
        again.original.display(),
        again.file.display(),
        again.said,
        beside.to_text()
    )
}

impl ReplayArgs {
    /// Drives or plays, and compares.
    ///
    /// # Errors
    /// [`NotCompared`].
    pub(crate) fn compared(
        &self,
        interrupted: &Arc<AtomicBool>,
    ) -> Result<(Again, Beside), NotCompared> {
        // Before anything is read.
        let ticks = |tick_ns| ticks_of([self.from, self.to], || Ok(tick_ns));
        ticks(1)?;
        let recorded = Recorded::read(&self.file)?;
        let scope = self.scope(&recorded, ticks(recorded.tick_ns)?);
        let again = if self.open.is_empty() {
            self.closed(&recorded, interrupted)?
        } else {
            self.opened(&recorded, interrupted)?
        };
        let beside = beside(&scope, &again.original, &again.file);
        match beside {
            Ok(beside) => Ok((again, beside)),
            Err(why) => Err(NotCompared {
                why,
                code: ExitCode::from(EXIT_OUTPUT),
                result: again.result,
            }),
        }
    }

    /// Drives the scenario again.
    fn closed(
        &self,
        recorded: &Recorded,
        interrupted: &Arc<AtomicBool>,
    ) -> Result<Again, NotCompared> {
        let (name, text) = recorded.drive().map_err(|why| self.in_file(&why))?;
        let plan = self.plan(recorded, Source::Text { name, text });
        let (result, code) = drive_and_judge(&plan, interrupted)?;
        let json = serde_json::to_value(&result).unwrap_or_default();
        if ![EXIT_PASS, EXIT_FAIL].map(ExitCode::from).contains(&code) {
            return Err(NotCompared {
                why: format!("not compared: {}", result.reason),
                code,
                result: json,
            });
        }
        Ok(Again {
            file: RecordTo::RunFolder.file(Path::new(&result.directory)),
            original: self.file.clone(),
            said: result.reason,
            result: json,
        })
    }

    /// Plays the recording to the open seats.
    fn opened(
        &self,
        recorded: &Recorded,
        interrupted: &Arc<AtomicBool>,
    ) -> Result<Again, NotCompared> {
        self.check_seats()?;
        let source = match (&self.scenario, &recorded.scenario) {
            (Some(name), _) => Source::Named(name.clone()),
            (None, Some((name, text))) => Source::Text {
                name: name.clone(),
                text: text.clone(),
            },
            (None, None) => {
                let why = "it holds no scenario, which says how the seats are configured: name one with --scenario";
                return Err(self.in_file(why).into());
            }
        };
        let plan = RunPlan {
            external: Role::SERVICES
                .into_iter()
                .filter(|role| !self.open.contains(role))
                .collect(),
            ..self.plan(recorded, source)
        };
        let input = (&*self.file, &recorded.found, recorded.is_lockstep());
        let played = open_loop(input, &plan, &self.open, self.to, interrupted);
        let played = played.map_err(|NotPlayed { why, code }| NotCompared {
            why,
            code: ExitCode::from(code),
            result: Value::Null,
        })?;
        let seats: Vec<&str> = self.open.iter().map(|role| role.label()).collect();
        Ok(Again {
            said: format!("played to {}, {} ticks", seats.join(", "), played.last_tick),
            result: json!({
                "open": seats,
                "last_tick": played.last_tick,
                "directory": played.folder,
                "recording": played.file,
            }),
            file: played.file,
            original: played.compared,
        })
    }

    /// Accepts changes of open seats alone: what is played cannot be changed.
    ///
    /// # Errors
    /// One line that names the seat.
    pub(crate) fn check_seats(&self) -> Result<(), String> {
        let settings = self.driver.settings();
        let mut changed: Vec<Role> = self.swap.iter().map(|(role, _)| *role).collect();
        changed.extend(
            Role::SERVICES
                .iter()
                .filter(|role| settings.of(**role).is_some()),
        );
        match changed.iter().find(|role| !self.open.contains(role)) {
            Some(role) => Err(format!(
                "{role} is played from the recording and cannot be changed: name it with --open, too"
            )),
            None => Ok(()),
        }
    }

    /// What is compared.
    fn scope(&self, recorded: &Recorded, ticks: [u64; 2]) -> Scope {
        Scope {
            authors: (!self.open.is_empty()).then(|| self.open.clone()),
            ticks,
            // Seats of a run in real time answer more or less often.
            numbers: recorded.is_lockstep(),
        }
    }

    fn plan(&self, recorded: &Recorded, source: Source) -> RunPlan {
        let plan = RunPlan {
            record: Some(RecordTo::RunFolder),
            seed: Some(recorded.seed),
            binaries: self.swap.iter().cloned().collect(),
            settings: self.driver.settings(),
            ..RunPlan::of(source, RunMode::Lockstep)
        };
        self.output.laid_over(plan)
    }

    fn in_file(&self, why: &str) -> String {
        format!("{}: {why}", self.file.display())
    }
}
