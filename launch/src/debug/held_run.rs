//! A run of this process that can stand, driven on a thread of its own. It is asked as every other run is.

use crate::control::request::{Request, RunReport};
use crate::drive::{Driven, drive};
use crate::ending::Ending;
use crate::prepare::Prepared;
use crate::running::{self, Running};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Between two looks.
const PAUSE: Duration = Duration::from_millis(5);

/// How long a run may take from its last answer to its end.
const ENDS_WITHIN: Duration = Duration::from_secs(60);

/// See the module's description.
#[derive(Debug)]
pub(super) struct HeldRun {
    thread: JoinHandle<Result<Over, String>>,
    ends: Arc<AtomicBool>,
    /// Once it answers.
    running: Option<Running>,
    /// Length of a tick. [ns]
    pub tick_ns: u64,
}

/// What became of a run.
#[derive(Debug)]
pub(super) struct Over {
    pub ending: Ending,
    pub end_tick: u64,
    /// Of all answers, as in the result of `zeronav run --lockstep`.
    pub run_hash: String,
    /// Why another run would go otherwise, one line each.
    pub not_reproducible: Vec<String>,
}

impl Over {
    fn of(driven: Driven) -> Self {
        Self {
            run_hash: driven.run_hash(),
            ending: driven.ending,
            end_tick: driven.end_tick,
            not_reproducible: driven.not_reproducible,
        }
    }
}

/// What a run does that is waited for.
#[derive(Debug)]
pub(super) enum Stand {
    /// It stands.
    Stands(Box<RunReport>),
    /// It has ended.
    Over,
    /// Nobody waits any longer.
    GivenUp,
}

impl HeldRun {
    /// Starts it; it will stand before `tick`.
    ///
    /// # Errors
    /// One line when there can be no thread.
    pub(super) fn start(mut prepared: Prepared, tick: u64) -> Result<Self, String> {
        let tick_ns = prepared.scenario.run.tick_ns();
        prepared.stands_before = Some(tick);
        let ends = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&ends);
        let thread = std::thread::Builder::new().name("drive".to_owned());
        let thread = thread
            .spawn(move || drive(&prepared, None, &flag).map(Over::of))
            .map_err(|error| format!("starting a thread: {error}"))?;
        Ok(Self {
            thread,
            ends,
            running: None,
            tick_ns,
        })
    }

    /// Waits until it stands or has ended, or `gives_up`.
    ///
    /// # Errors
    /// One line when it does not answer.
    pub(super) fn wait(&mut self, gives_up: impl Fn() -> bool) -> Result<Stand, String> {
        let mut silent_since = None;
        while !self.thread.is_finished() {
            if gives_up() {
                return Ok(Stand::GivenUp);
            }
            if self.running.is_none() {
                self.running = running::own();
            }
            if let Some(running) = &self.running {
                match running.report() {
                    Ok(report) if report.stands => return Ok(Stand::Stands(Box::new(report))),
                    Ok(_) => silent_since = None,
                    // It may be ending, and closes its socket first.
                    Err(problem) => {
                        let since = silent_since.get_or_insert_with(Instant::now);
                        if since.elapsed() > ENDS_WITHIN {
                            return Err(problem.text);
                        }
                    }
                }
            }
            std::thread::sleep(PAUSE);
        }
        Ok(Stand::Over)
    }

    /// Lets it do so many ticks more.
    ///
    /// # Errors
    /// What it says against that.
    pub(super) fn step(&self, ticks: u64) -> Result<(), String> {
        self.ask(&Request::Step { ticks })
    }

    /// Lets it drive to its end.
    ///
    /// # Errors
    /// What it says against that.
    pub(super) fn go_on(&self) -> Result<(), String> {
        self.ask(&Request::Resume)
    }

    /// True when it has ended.
    pub(super) fn is_over(&self) -> bool {
        self.thread.is_finished()
    }

    /// Ends it; what became of it.
    ///
    /// # Errors
    /// One line when it could not be driven, or does not end.
    pub(super) fn end(self) -> Result<Over, String> {
        self.ends.store(true, Ordering::Relaxed);
        let since = Instant::now();
        while !self.thread.is_finished() {
            if since.elapsed() > ENDS_WITHIN {
                return Err("the run does not end; its warden stops what is left of it".to_owned());
            }
            std::thread::sleep(PAUSE);
        }
        self.thread
            .join()
            .unwrap_or_else(|_| Err("the run has panicked".to_owned()))
    }

    fn ask(&self, request: &Request) -> Result<(), String> {
        let running = self.running.as_ref().ok_or("the run does not answer yet")?;
        running.ask(request)?;
        Ok(())
    }
}
