//! Runs side by side: each a `zeronav run` of its own, in lockstep unless its case is in real time.

use super::case::Case;
use super::left;
use super::plan::SuitePlan;
use rustix::process::{Pid, Signal, kill_process};
use std::fs::File;
use std::io::{ErrorKind, Seek};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use zeronav_casts::Cast;
use zeronav_console::exit::EXIT_INTERRUPTED;
use zeronav_console::progress::{ProgressLine, Tally};
use zeronav_console::terminal::note;
use zeronav_files::{Folder, read};
use zeronav_measure::result::RunResult;
use zeronav_supervise::process::end_with_this_thread;

/// How long a run that was asked to stop may take, before it is killed.
const STOP_LIMIT: Duration = Duration::from_secs(20);

/// Between two looks at the runs.
const PAUSE: Duration = Duration::from_millis(10);

/// Between two looks for the domain of a run.
const DOMAIN_PAUSE: Duration = Duration::from_millis(50);

/// How a run begins what it complains; warnings of the log may stand before it.
const COMPLAINT: &str = "zeronav: ";

/// How a run finished.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Finish {
    /// Its result; `None` when it left none.
    pub(super) result: Option<RunResult>,
    /// Its exit code, `None` when a signal ended it.
    pub(super) code: Option<i32>,
    /// True when it was stopped because it took too long.
    pub(super) hung: bool,
    /// What it complained, without the log before; empty when it did not.
    pub(super) complaint: String,
    /// Root folder of its domain; `None` when that was not looked for, or it ended before it had one.
    pub(super) domain: Option<PathBuf>,
}

impl Finish {
    /// The first line that it complained in; empty when it did not.
    pub(super) fn headline(&self) -> &str {
        self.complaint.lines().next().unwrap_or_default()
    }
}

/// Why not all runs were made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Stopped {
    /// A run could not be started, and so could the others.
    Refused(String),
    /// What a run gave could not be written.
    Lost(String),
    /// Ctrl-C.
    Interrupted,
}

/// Where and how the runs are made.
#[derive(Debug)]
pub(super) struct Runner<'a> {
    program: PathBuf,
    out: Folder,
    jobs: usize,
    progress: bool,
    interrupted: &'a AtomicBool,
}

/// A run that goes on.
#[derive(Debug)]
struct Going<'a> {
    index: usize,
    case: &'a Case,
    process: Child,
    /// Where what it writes and what it complains lies.
    out: Folder,
    names: [String; 2],
    files: [File; 2],
    started: Instant,
    /// When it was asked to stop, and whether because it took too long.
    asked: Option<(Instant, bool)>,
    /// Root folder of its domain, and when that was looked for.
    domain: Option<PathBuf>,
    looked: Instant,
}

impl<'a> Runner<'a> {
    /// Runs of this very program whose folders lie in `out`.
    ///
    /// # Errors
    /// One line when this program cannot be found.
    pub(super) fn new(
        plan: &SuitePlan,
        out: Folder,
        interrupted: &'a AtomicBool,
    ) -> Result<Self, String> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Ok(Self {
            program: std::env::current_exe()
                .map_err(|error| format!("looking for this program: {error}"))?,
            out,
            jobs: plan.jobs.map_or(cores, usize::from),
            progress: plan.progress,
            interrupted,
        })
    }

    /// Runs at a time.
    pub(super) const fn jobs(&self) -> usize {
        self.jobs
    }

    /// The same without a line that says how far the runs are.
    pub(super) fn quiet(self) -> Self {
        Self {
            progress: false,
            ..self
        }
    }

    /// True after Ctrl-C.
    pub(super) fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    /// Makes all runs, some at a time, and hands over what each finished with as it does. A run
    /// that was stopped before its end has not finished.
    ///
    /// # Errors
    /// [`Stopped`], when all that were going on are stopped, too; what `finished` complains of is
    /// [`Stopped::Lost`].
    pub(super) fn each(
        &self,
        title: &str,
        cases: &[&Case],
        mut finished: impl FnMut(usize, Finish) -> Result<(), String>,
    ) -> Result<(), Stopped> {
        let mut line = ProgressLine::new(title, self.progress);
        let began = Instant::now();
        let mut waiting = cases.iter().enumerate();
        let mut going: Vec<Going<'_>> = Vec::new();
        let mut stopped: Option<Stopped> = None;
        let (mut done, mut passed) = (0, 0);
        let mut last = String::new();
        let mut is_said = false;
        loop {
            while stopped.is_none() && going.len() < self.jobs {
                let Some((index, case)) = waiting.next() else {
                    break;
                };
                match self.start(index, case) {
                    Ok(one) => going.push(one),
                    Err(problem) => stopped = Some(Stopped::Refused(problem)),
                }
            }
            if self.is_interrupted() {
                stopped.get_or_insert(Stopped::Interrupted);
            }
            let mut still = Vec::with_capacity(going.len());
            for mut one in going.drain(..) {
                one.hurry(stopped.is_some());
                one.look();
                let Some(status) = one.ended() else {
                    still.push(one);
                    continue;
                };
                let finish = one.finish(status);
                let code = finish.code.and_then(|code| u8::try_from(code).ok());
                if code == Some(EXIT_INTERRUPTED) && !finish.hung {
                    stopped.get_or_insert(Stopped::Interrupted);
                    continue;
                }
                if one.is_cut_short() && finish.result.is_none() {
                    continue;
                }
                done += 1;
                passed += usize::from(code == Some(0));
                one.case.world.clone_into(&mut last);
                if let Err(problem) = finished(one.index, finish) {
                    stopped.get_or_insert(Stopped::Lost(problem));
                }
            }
            going = still;
            if going.is_empty() && (stopped.is_some() || waiting.len() == 0) {
                break;
            }
            let tally = Tally {
                done,
                total: cases.len(),
                each_s: (done > 0).then(|| began.elapsed().as_secs_f64() / count(done)),
            };
            // Once a run of each place is over, the rest can be known.
            if self.progress && !is_said && done >= self.jobs {
                is_said = true;
                if let Some(estimate) = tally.estimate("runs", self.jobs) {
                    note(&format!("{title}: {estimate}"));
                }
            }
            line.show(|| format!("{}  {passed} passed  {last}", tally.in_words("runs")));
            std::thread::sleep(PAUSE);
        }
        line.clear();
        // What runs that had to be killed have left.
        for root in zeronav_shell::domain::sweep_dead() {
            tracing::info!(root = %root.display(), "removed the domain of a run that was killed");
        }
        stopped.map_or(Ok(()), Err)
    }

    fn start<'c>(&self, index: usize, case: &'c Case) -> Result<Going<'c>, String> {
        let name = case.name();
        let names = ["json", "txt"].map(|ending| format!("{name}.{ending}"));
        let failed = |error: std::io::Error| format!("starting a run of {name}: {error}");
        // Those of a suite that was killed.
        for name in &names {
            self.out.remove(name);
        }
        let file = |name: &String| self.out.new_file(name).map_err(failed);
        let files = [file(&names[0])?, file(&names[1])?];
        let handed = |file: &File| file.try_clone().map_err(failed);
        let mut command = Command::new(&self.program);
        if let Some(temp) = &case.manner.temp {
            // What a suite that was killed has left of this very run.
            left::clear(temp);
            std::fs::create_dir(temp).map_err(failed)?;
            command.env(left::TEMP, temp);
        }
        match std::fs::remove_dir_all(self.out.here().join(&name)) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(failed(error)),
            _ => {}
        }
        // A suite that is killed must not leave runs behind, whose folders the one that goes on takes.
        end_with_this_thread(&mut command, Signal::TERM);
        let lockstep = (!case.manner.real_time).then_some("--lockstep");
        let process = command
            .arg("run")
            .arg(&case.scenario)
            .args(lockstep)
            .args(["--headless", "--json", "--log-level", "warn"])
            .arg("--report-failures-only")
            .args(["--seed", &case.seed.to_string()])
            .arg("--out")
            .arg(self.out.path())
            .arg(format!("--folder={name}"))
            // The binaries were built before the first run, if cargo started the suite.
            .env_remove("CARGO")
            .stdin(Stdio::null())
            .stdout(handed(&files[0])?)
            .stderr(handed(&files[1])?)
            .spawn()
            .map_err(failed)?;
        Ok(Going {
            index,
            case,
            process,
            out: self.out.clone(),
            names,
            files,
            started: Instant::now(),
            asked: None,
            domain: None,
            looked: Instant::now(),
        })
    }
}

fn count(n: usize) -> f64 {
    n.to_f64()
}

impl Going<'_> {
    /// Asks a run to stop that takes too long, or when all shall; kills it when it does not.
    fn hurry(&mut self, all: bool) {
        match self.asked {
            None => {
                let late = self.started.elapsed() > self.case.wall_limit();
                if all || late {
                    self.asked = Some((Instant::now(), !all));
                    let pid = i32::try_from(self.process.id()).ok();
                    if let Some(pid) = pid.and_then(Pid::from_raw) {
                        // It may have ended by itself just now.
                        let _ = kill_process(pid, Signal::TERM);
                    }
                }
            }
            Some((when, _)) if when.elapsed() > STOP_LIMIT => {
                let _ = self.process.kill();
            }
            Some(_) => {}
        }
    }

    /// Looks for its domain, if what it leaves over is asked for.
    fn look(&mut self) {
        if self.domain.is_none() && self.looked.elapsed() >= DOMAIN_PAUSE {
            self.looked = Instant::now();
            self.domain = self.case.manner.temp.as_deref().and_then(left::domain);
        }
    }

    /// True when it was asked to stop because all were.
    fn is_cut_short(&self) -> bool {
        self.asked.is_some_and(|(_, hung)| !hung)
    }

    fn ended(&mut self) -> Option<ExitStatus> {
        self.process.try_wait().ok().flatten()
    }

    /// Takes in what the run has written.
    fn finish(&self, status: ExitStatus) -> Finish {
        let [text, complaint] = self.files.each_ref().map(said);
        // The same lies in the run's own folder.
        self.out.remove(&self.names[0]);
        if complaint.is_empty() {
            self.out.remove(&self.names[1]);
        }
        let complaint = complaint
            .lines()
            .skip_while(|line| !line.starts_with(COMPLAINT))
            .collect::<Vec<&str>>()
            .join("\n");
        Finish {
            result: serde_json::from_str(&text).ok(),
            code: status.code(),
            hung: self.asked.is_some_and(|(_, hung)| hung),
            domain: self.domain.clone(),
            complaint: complaint
                .strip_prefix(COMPLAINT)
                .unwrap_or_default()
                .to_owned(),
        }
    }
}

/// What was written to a file, unless it is too long.
fn said(mut file: &File) -> String {
    let read = (file.rewind()).and_then(|()| read::bounded(file, read::RESULT_BYTES_MAX));
    read.map_or_else(
        |_| String::new(),
        |bytes| String::from_utf8_lossy(&bytes).into_owned(),
    )
}
