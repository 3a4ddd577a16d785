//! Companions: processes beside a stack. They are started, started again within a budget of their own and
//! asked to end when the services are gone; nothing in the run waits for them, and losing one is a line.

mod budget;

use crate::control::request::CompanionReport;
use crate::live_view::{self, LivePage};
use crate::recorder::DrivenBy;
use budget::{Budget, Decision};
use rustix::process::Signal;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Stdio;
use std::time::{Duration, Instant};
use zeronav_console::terminal::{complain, note};
use zeronav_measure::result::companion::{CompanionResult, STOPPED};
use zeronav_supervise::child::Child;
use zeronav_supervise::child_log::LogPlace;
use zeronav_supervise::cleaner::Ticket;
use zeronav_supervise::descendants::MARK;
use zeronav_supervise::occupant::file_name;
use zeronav_supervise::own_time::Patience;
use zeronav_supervise::process::{Beginning, Process};
use zeronav_supervise::stack::Stack;

/// How long a companion may take to stop before it is killed, of its own time: time without a processor does
/// not count.
const STOP_LIMIT: Duration = Duration::from_secs(2);

/// How long it may take in any case.
const WALL_LIMIT: Duration = Duration::from_secs(8);

/// The same for the recorder, which first writes what it still holds: without its end the file is damaged.
const RECORDER_LIMITS: (Duration, Duration) = (Duration::from_secs(20), Duration::from_secs(60));

/// Between two looks at companions that are to stop.
const PAUSE: Duration = Duration::from_millis(2);

/// What a companion is started with.
#[derive(Debug)]
pub(crate) struct Plan {
    /// Its name.
    pub name: String,
    /// Its binary.
    pub binary: PathBuf,
    /// How often it is started again.
    pub restarts: u32,
    /// Where its log goes.
    pub log: LogPlace,
    /// How it is started.
    pub invocation: Invocation,
}

/// The arguments of a companion, and its standard streams.
#[derive(Debug)]
pub(crate) enum Invocation {
    /// The flags of a companion.
    Flags {
        /// Its configuration file.
        config: PathBuf,
        /// What it logs.
        log_level: String,
    },
    /// Those of the recorder.
    Recording {
        /// The file that it writes.
        file: PathBuf,
        /// The scenario that is driven, which it puts into that.
        scenario: PathBuf,
        /// Who decides where the robot drives.
        driven_by: DrivenBy,
        /// What services and companions are started with, which it puts into that, too.
        parameters: PathBuf,
        /// The folder of the logs, whose lines it records.
        logs: PathBuf,
        /// True when the file's folder becomes a bag of rosbag2.
        is_bag: bool,
    },
    /// Those of the live page, whose link is printed.
    Page(LivePage),
}

#[derive(Debug)]
enum State {
    Running {
        process: Process,
        since: Instant,
    },
    /// The backoff goes on, or what the dead process has left is still being removed.
    Waiting {
        due: Instant,
        cleaning: Ticket,
    },
    /// No more process is started. What the last one has left is being removed.
    Over {
        cleaning: Option<Ticket>,
    },
}

#[derive(Debug)]
struct Companion {
    plan: Plan,
    budget: Budget,
    state: State,
    starts: u32,
    /// How the last process ended that has ended.
    end: String,
}

/// The companions of a run. Dropping them ends them.
#[derive(Debug, Default)]
pub(crate) struct Companions(Vec<Companion>);

impl Companions {
    /// Starts a companion. One that cannot be started is treated as one that has ended with failure.
    pub(crate) fn start(&mut self, stack: &mut Stack, plan: Plan) {
        let mut companion = Companion {
            budget: Budget::new(plan.restarts),
            plan,
            state: State::Over { cleaning: None },
            starts: 0,
            end: String::new(),
        };
        companion.start(stack);
        self.0.push(companion);
    }

    /// One look at all of them: starts again what has ended and may be started.
    pub(crate) fn look(&mut self, stack: &mut Stack) {
        for companion in &mut self.0 {
            companion.look(stack);
        }
    }

    /// How the companion `name` has ended, if it has; it is not started again then.
    pub(crate) fn end_of(&mut self, name: &str) -> Option<String> {
        let mut all = self.0.iter_mut();
        let companion = all.find(|companion| companion.plan.name == name)?;
        if let State::Running { process, .. } = &mut companion.state {
            companion.end = Child::end_in_words(process.ended()?);
            companion.state = State::Over { cleaning: None };
        }
        Some(companion.end.clone())
    }

    /// The process of the companion `name`, while one runs.
    pub(crate) fn pid_of(&self, name: &str) -> Option<u32> {
        let mut all = self.0.iter();
        match &all.find(|it| it.plan.name == name)?.state {
            State::Running { process, .. } => Some(process.pid()),
            State::Waiting { .. } | State::Over { .. } => None,
        }
    }

    /// What they do now.
    pub(crate) fn reports(&self) -> Vec<CompanionReport> {
        self.0.iter().map(Companion::report).collect()
    }

    /// Ends them: asks, waits, kills. What became of each.
    pub(crate) fn stop(&mut self) -> Vec<CompanionResult> {
        for companion in &mut self.0 {
            if let State::Running { process, .. } = &mut companion.state {
                // One that has ended before it was asked to.
                if let Some(status) = process.ended() {
                    companion.end = Child::end_in_words(status);
                    companion.state = State::Over { cleaning: None };
                } else {
                    process.signal(Signal::TERM);
                }
            }
        }
        let asked = Instant::now();
        let stopped = self.0.drain(..).map(|companion| companion.stop(asked));
        stopped.collect()
    }
}

impl Drop for Companions {
    fn drop(&mut self) {
        self.stop();
    }
}

impl Companion {
    fn start(&mut self, stack: &mut Stack) {
        self.starts += 1;
        let started = self.try_start(stack);
        let name = &self.plan.name;
        match started {
            Ok(process) => {
                tracing::info!(
                    companion = name,
                    pid = process.pid(),
                    start = self.starts,
                    "started"
                );
                let since = Instant::now();
                self.state = State::Running { process, since };
            }
            Err(error) => self.ended(stack, None, error.to_string(), Duration::ZERO),
        }
    }

    fn try_start(&self, stack: &Stack) -> std::io::Result<Process> {
        let root = stack.root();
        let (arguments, stdin, stdout) = match &self.plan.invocation {
            Invocation::Flags { config, log_level } => {
                let arguments: Vec<OsString> = vec![
                    "--domain".into(),
                    root.into(),
                    "--epoch".into(),
                    self.starts.to_string().into(),
                    "--config".into(),
                    config.into(),
                    "--log-level".into(),
                    log_level.into(),
                ];
                (arguments, Stdio::null(), None)
            }
            Invocation::Recording {
                file,
                scenario,
                driven_by,
                parameters,
                logs,
                is_bag,
            } => {
                let arguments = [
                    "--domain".into(),
                    root.into(),
                    "--out".into(),
                    file.into(),
                    "--scenario".into(),
                    scenario.into(),
                    "--driven-by".into(),
                    driven_by.label().into(),
                    "--parameters".into(),
                    parameters.into(),
                    "--logs".into(),
                    logs.into(),
                ];
                let mut arguments: Vec<OsString> = arguments.into();
                arguments.extend(is_bag.then(|| "--metadata".into()));
                (arguments, Stdio::null(), None)
            }
            Invocation::Page(page) => (page.flags(root), page.stdin(), Some(Stdio::piped())),
        };
        let beginning = Beginning {
            name: &self.plan.name,
            binary: &self.plan.binary,
            arguments: &arguments,
            root,
            log: &self.plan.log,
            stdin,
            stdout,
        };
        // A browser that the live page opens is none of the stack's processes.
        let is_page = matches!(self.plan.invocation, Invocation::Page(_));
        let mut process = Process::start(beginning, |command| {
            if is_page {
                command.env_remove(MARK);
            }
        })?;
        if let Invocation::Page(page) = &self.plan.invocation {
            page.ingest(&mut process)?;
        }
        Ok(process)
    }

    fn look(&mut self, stack: &mut Stack) {
        match &mut self.state {
            State::Running { process, since } => {
                let Some(status) = process.ended() else {
                    return;
                };
                let lived = since.elapsed();
                let how = Child::end_in_words(status);
                self.ended(stack, status.code(), how, lived);
            }
            State::Waiting { due, cleaning } => {
                if Instant::now() >= *due && stack.is_clean(*cleaning) {
                    self.start(stack);
                }
            }
            State::Over { cleaning } => {
                cleaning.take_if(|ticket| stack.is_clean(*ticket));
            }
        }
    }

    /// A process has ended in this way after it had `lived`.
    fn ended(&mut self, stack: &mut Stack, code: Option<i32>, how: String, lived: Duration) {
        let name = &self.plan.name;
        let cleaning = stack.clean();
        self.state = State::Over {
            cleaning: Some(cleaning),
        };
        match self.budget.decide(code, lived) {
            Decision::Restart(wait) => {
                let wait_ms = u64::try_from(wait.as_millis()).unwrap_or(u64::MAX);
                tracing::info!(companion = name, how, wait_ms, "ended, is started again");
                let due = Instant::now() + wait;
                self.state = State::Waiting { due, cleaning };
            }
            Decision::GiveUp(why) => {
                tracing::info!(companion = name, how, why, "lost");
                let log = self.plan.log.path();
                let log = log.display();
                let hint = match self.plan.invocation {
                    Invocation::Page(_) => live_view::HINT.to_owned(),
                    Invocation::Recording { .. } => format!(
                        "the run goes on and is not recorded; see {log}, and `zeronav bag recover`"
                    ),
                    Invocation::Flags { .. } => format!("the run goes on; see {log}"),
                };
                complain(&format!("companion {name} is lost ({how}): {why}; {hint}"));
            }
            Decision::Done => note(&format!("companion {name} has ended")),
        }
        self.end = how;
    }

    fn report(&self) -> CompanionReport {
        let (pid, state) = match &self.state {
            State::Running { process, .. } => (process.pid(), "running"),
            State::Waiting { .. } => (0, "restarting"),
            State::Over { .. } => (0, "ended"),
        };
        CompanionReport {
            name: self.plan.name.clone(),
            pid,
            state: state.to_owned(),
            starts: self.starts,
            binary: file_name(&self.plan.binary),
            end: self.end.clone(),
        }
    }

    /// Waits for the end of its process, which was asked to end at `asked`.
    fn stop(self, asked: Instant) -> CompanionResult {
        let (own_limit, wall_limit) = match self.plan.invocation {
            Invocation::Recording { .. } => RECORDER_LIMITS,
            Invocation::Flags { .. } | Invocation::Page(_) => (STOP_LIMIT, WALL_LIMIT),
        };
        let end = match self.state {
            State::Running { mut process, .. } => {
                let mut patience = Patience::with(process.pid());
                while !process.wait(PAUSE)
                    && !patience.is_over(own_limit)
                    && asked.elapsed() < wall_limit
                {}
                match process.ended() {
                    Some(status) if status.success() => STOPPED.to_owned(),
                    Some(status) => Child::end_in_words(status),
                    None => "did not stop when asked, killed".to_owned(),
                }
            }
            State::Waiting { .. } | State::Over { .. } => self.end,
        };
        CompanionResult {
            name: self.plan.name,
            binary: file_name(&self.plan.binary),
            starts: self.starts,
            end,
        }
    }
}
