//! `zeronav top`: a running stack at a glance, by a guest that only reads.

mod cells;
pub mod cli;
mod draw;
mod events;
mod latency;
pub(crate) mod model;
mod screen;
mod source;
mod text;
mod totals;
mod view;

use crate::running::{self, Running};
use crate::topics::tap::{PAUSE, Tap};
use cli::TopArgs;
use model::Model;
use screen::{Asked, Screen};
use source::Source;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Duration;
use view::View;
use zeronav_console::exit::{EXIT_INTERRUPTED, EXIT_PASS};
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{note, say, say_json, usage as complain};
use zeronav_observe::usage::Reading;
use zeronav_shell::clock::now_ns;

/// Time between two looks in real time; the queues hold several times as much.
const LOOK: Duration = Duration::from_millis(20);

/// Time between two drawings, and the time that a sample takes. [ns]
const REFRESH_NS: u64 = 1_000_000_000;

/// Time in which every service beats. [ns]
const SETTLE_NS: u64 = 150_000_000;

/// Why the view ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    Quit,
    Interrupted,
    RunOver,
}

/// `zeronav top`.
#[must_use]
pub fn top(arguments: &TopArgs) -> ExitCode {
    match run(arguments) {
        Ok(End::Interrupted) => ExitCode::from(EXIT_INTERRUPTED),
        Ok(End::Quit) => ExitCode::from(EXIT_PASS),
        Ok(End::RunOver) => {
            note("the run has ended");
            ExitCode::from(EXIT_PASS)
        }
        Err(problem) => complain(&problem),
    }
}

fn run(arguments: &TopArgs) -> Result<End, String> {
    let stack = running::find(arguments.stack.domain.as_deref())?;
    let interrupted = interrupts()?;
    let mut source = Source::open(Tap::join(Some(stack.root()))?)?;
    let mut watch = Watch {
        model: Model::new(source.names(), source.is_lockstep()),
        look: if source.is_lockstep() { PAUSE } else { LOOK },
        refreshed_ns: 0,
    };
    let is_once = arguments.once || arguments.stack.json || !screen::is_there();
    let end = if is_once {
        watch.once(&mut source, &stack, arguments.stack.json, &interrupted)
    } else {
        watch.live(&mut source, stack, &interrupted)
    };
    source.leave();
    end
}

/// The view of a stack while it goes on.
#[derive(Debug)]
struct Watch {
    model: Model,
    /// Time between two looks.
    look: Duration,
    refreshed_ns: u64,
}

impl Watch {
    /// Prints a sample.
    fn once(
        &mut self,
        source: &mut Source,
        stack: &Running,
        json: bool,
        interrupted: &AtomicBool,
    ) -> Result<End, String> {
        // The heartbeats name the processes that are read twice.
        for time_ns in [SETTLE_NS, REFRESH_NS] {
            let began_ns = now_ns();
            while now_ns().saturating_sub(began_ns) < time_ns {
                if interrupted.load(Ordering::Relaxed) {
                    return Ok(End::Interrupted);
                }
                if !source.read(&mut self.model) {
                    return Err("the run has ended before there was a sample".to_owned());
                }
                std::thread::sleep(self.look);
            }
            if time_ns == SETTLE_NS {
                self.refresh();
            }
        }
        self.model.report(stack.report()?);
        let view = self.refresh();
        if json {
            say_json(&view);
        } else {
            say(&text::text(&view));
        }
        Ok(End::Quit)
    }

    /// Shows the stack on the terminal until something ends that.
    fn live(
        &mut self,
        source: &mut Source,
        stack: Running,
        interrupted: &AtomicBool,
    ) -> Result<End, String> {
        // What is wrong with a message is counted in the view; a line would stand across it.
        let quiet = tracing::subscriber::NoSubscriber::default();
        let _quiet = tracing::subscriber::set_default(quiet);
        let reports = reports(stack);
        let mut screen = Screen::open()?;
        let mut view = View::default();
        loop {
            let goes_on = source.read(&mut self.model);
            while let Ok(report) = reports.try_recv() {
                self.model.report(report);
            }
            if now_ns().saturating_sub(self.refreshed_ns) >= REFRESH_NS {
                view = self.refresh();
                screen.draw(&view)?;
            }
            if interrupted.load(Ordering::Relaxed) {
                return Ok(End::Interrupted);
            }
            if !goes_on {
                return Ok(End::RunOver);
            }
            match Screen::wait(self.look)? {
                Some(Asked::Quit) => return Ok(End::Quit),
                Some(Asked::Interrupt) => return Ok(End::Interrupted),
                Some(Asked::Sort) => {
                    screen.sort();
                    screen.draw(&view)?;
                }
                Some(Asked::Draw) => screen.draw(&view)?,
                None => {}
            }
        }
    }

    /// Reads the processes and brings everything up to now.
    fn refresh(&mut self) -> View {
        self.read_processes();
        self.refreshed_ns = now_ns();
        self.model.refresh(self.refreshed_ns);
        self.model.view(self.refreshed_ns)
    }

    fn read_processes(&mut self) {
        for (whose, pid) in self.model.pids() {
            self.model.read(whose, Reading::of(pid, now_ns()));
        }
    }
}

/// What the stack says of itself, every second, from a thread of its own: a stack that does not
/// answer must not hold up the view.
fn reports(stack: Running) -> Receiver<crate::control::request::RunReport> {
    let (to, from) = sync_channel(1);
    let asking = std::thread::Builder::new().spawn(move || {
        loop {
            if let Ok(report) = stack.report()
                && to.send(report).is_err()
            {
                return;
            }
            std::thread::sleep(Duration::from_nanos(REFRESH_NS));
        }
    });
    if let Err(error) = asking {
        tracing::warn!(%error, "no thread to ask the stack: its own report is missing");
    }
    from
}
