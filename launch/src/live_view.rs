//! The live page of a stack: `zeronav view`, and the viewer that `zeronav run` and `zeronav up`
//! start beside the services.

use crate::running;
use clap::Args;
use rustix::process::{Pid, Signal, kill_process};
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};
use zeronav_console::terminal::{complain, note, usage};
use zeronav_supervise::binaries;
use zeronav_supervise::child::end_with_this_thread;
use zeronav_supervise::child_log::{LogPlace, last_lines};
use zeronav_supervise::cleaner::Ticket;
use zeronav_supervise::stack::Stack;

/// The binary.
const BINARY: &str = "zeronav-viewer";

/// How long the viewer may take to tell its clients that the run is over.
const STOP_LIMIT: Duration = Duration::from_millis(700);

/// Longest line that is read from the viewer. [bytes]
const LINK_BYTES_MAX: u64 = 256;

/// Where the page is served and what it is opened with.
#[derive(Debug, Clone, Default, Args)]
pub struct PageArgs {
    /// Port of the live page on 127.0.0.1; without, 8090, or any that is free.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub port: Option<u16>,
    /// Open the live page in a browser.
    #[arg(long)]
    pub open: bool,
}

impl PageArgs {
    fn flags(&self, root: &Path) -> Vec<OsString> {
        let mut flags: Vec<OsString> = vec!["--domain".into(), root.into()];
        if let Some(port) = self.port {
            flags.extend(["--port".into(), port.to_string().into()]);
        }
        if self.open {
            flags.push("--open".into());
        }
        flags
    }
}

/// Arguments of `zeronav view`.
#[derive(Debug, Clone, Args)]
pub struct ViewArgs {
    /// Root folder of the stack, when several run (see `zeronav ps`).
    #[arg(long, value_name = "ROOT", env = "ZERONAV_DOMAIN")]
    pub domain: Option<PathBuf>,
    /// The page.
    #[command(flatten)]
    pub page: PageArgs,
    /// Let every user of this machine look at the run, and nobody change anything from the page.
    #[arg(long)]
    pub view_only: bool,
}

/// `zeronav view`: becomes the viewer, which prints the link and ends with the stack or with Ctrl-C.
#[must_use]
pub fn view(arguments: &ViewArgs) -> ExitCode {
    let found = running::find(arguments.domain.as_deref())
        .and_then(|run| Ok((run, binaries::find_or_build(Path::new(BINARY))?)));
    let (run, binary) = match found {
        Ok(found) => found,
        Err(problem) => return usage(&problem),
    };
    let mut command = Command::new(&binary);
    command.args(arguments.page.flags(run.root()));
    if arguments.view_only {
        command.arg("--view-only");
    }
    let error = command.exec();
    usage(&format!("starting {}: {error}", binary.display()))
}

/// The viewer of a run. It is no part of the stack: it may die or hang, and ends with the run, with
/// this process, and when this is dropped.
#[derive(Debug, Default)]
pub(crate) struct LiveView {
    process: Option<Child>,
    /// The cleaning after it has died.
    cleaning: Option<Ticket>,
}

impl LiveView {
    /// Starts the viewer of the stack at `root` and has its link printed, or why it cannot be
    /// started. Call it from a thread that lives as long as the viewer shall.
    pub(crate) fn start(root: &Path, page: &PageArgs, log: &LogPlace) -> Self {
        let process = start(root, page, log)
            .inspect_err(|problem| complain(&format!("no live page: {problem}")));
        Self {
            process: process.ok(),
            cleaning: None,
        }
    }

    /// Has removed what a viewer that has died left; the run goes on without it.
    pub(crate) fn look(&mut self, stack: &mut Stack) {
        if self.process.as_mut().is_some_and(has_ended) {
            note("the live page has ended; `zeronav view` brings it back");
            self.process = None;
            self.cleaning = Some(stack.clean());
        }
        self.cleaning.take_if(|ticket| stack.is_clean(*ticket));
    }
}

fn has_ended(process: &mut Child) -> bool {
    !matches!(process.try_wait(), Ok(None))
}

impl Drop for LiveView {
    fn drop(&mut self) {
        let Some(process) = &mut self.process else {
            return;
        };
        let pid = i32::try_from(process.id()).ok().and_then(Pid::from_raw);
        if let Some(pid) = pid.filter(|_| !has_ended(process)) {
            let _ = kill_process(pid, Signal::TERM);
        }
        let asked = Instant::now();
        while !has_ended(process) && asked.elapsed() < STOP_LIMIT {
            std::thread::sleep(Duration::from_millis(5));
        }
        let _ = process.kill();
        let _ = process.wait();
    }
}

fn start(root: &Path, page: &PageArgs, log: &LogPlace) -> Result<Child, String> {
    let binary = binaries::find(Path::new(BINARY))?;
    let log = log.open().map_err(|error| error.to_string())?;
    let mut command = Command::new(&binary);
    command
        .args(page.flags(root))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(log.try_clone().map_err(|error| error.to_string())?)
        // Ctrl-C ends the run, and the run its viewer.
        .process_group(0);
    end_with_this_thread(&mut command, Signal::KILL);
    let mut process =
        (command.spawn()).map_err(|error| format!("starting {}: {error}", binary.display()))?;
    let output = process.stdout.take();
    // It is told when it is known; the thread ends with the viewer.
    let told = std::thread::Builder::new().spawn(move || {
        let Some(output) = output else { return };
        let mut link = String::new();
        let read = BufReader::new(output.take(LINK_BYTES_MAX)).read_line(&mut link);
        match (read, link.trim()) {
            (Ok(1..), link) if link.starts_with("http://127.0.0.1:") => {
                note(&format!("live page: {link}"));
            }
            _ => {
                let said = last_lines(&log, 1);
                let why = said.first().map_or("the viewer has ended", String::as_str);
                complain(&format!("no live page: {why}"));
            }
        }
    });
    if let Err(error) = told {
        let _ = process.kill();
        let _ = process.wait();
        return Err(error.to_string());
    }
    Ok(process)
}
