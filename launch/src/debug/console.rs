//! The prompt: where the run stands, and what is done next.

use super::debugger::{Debugger, restriction};
use super::held_run::{HeldRun, Over, Stand};
use super::moment::Moment;
use super::words::{HELP, Word};
use crate::commands::{exit_code, explain};
use crate::control::request::RunReport;
use crate::prepare::Prepared;
use core::fmt::Write;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use zeronav_console::exit::{EXIT_INTERRUPTED, EXIT_PASS, EXIT_SERVICE};
use zeronav_console::interrupts::keyboard_and_others;
use zeronav_console::terminal::{complain, note, say};
use zeronav_msgs::role::Role;
use zeronav_shell::printable::printable;

/// Between two looks at a debugger, and at a flag while a line is awaited.
const PAUSE: Duration = Duration::from_millis(20);

/// Longest line at the prompt. [bytes]
const LINE_MAX: usize = 1000;

/// What prepares the run, each time that it is driven.
type Prepare<'a> = Box<dyn Fn() -> Result<Prepared, String> + 'a>;

/// See the module's description.
pub(super) struct Console<'a> {
    prepare: Prepare<'a>,
    debugger: Debugger,
    keyboard: Arc<AtomicBool>,
    others: Arc<AtomicBool>,
    /// The seat that a debugger was started on last.
    role: Option<Role>,
}

/// How the command ends.
enum End {
    /// The run was driven to its end, or came to it.
    Over(Over),
    /// As was asked for.
    Quit,
    /// By a signal.
    Interrupted,
    /// With a run that does not answer, or could not be driven.
    Failed(String),
}

impl From<String> for End {
    fn from(why: String) -> Self {
        Self::Failed(why)
    }
}

impl<'a> Console<'a> {
    /// Opens it for what is prepared so each time that it is driven.
    ///
    /// # Errors
    /// One line when signals cannot be caught.
    pub(super) fn open(
        prepare: impl Fn() -> Result<Prepared, String> + 'a,
        debugger: Debugger,
    ) -> Result<Self, String> {
        let [keyboard, others] = keyboard_and_others()?;
        if let Some(restriction) = restriction() {
            note(restriction);
        }
        Ok(Self {
            prepare: Box::new(prepare),
            debugger,
            keyboard,
            others,
            role: None,
        })
    }

    /// Drives until `at`, starts the debugger on the seat `attach`, and does what is said then.
    pub(super) fn run(mut self, at: &Moment, attach: Option<Role>) -> ExitCode {
        let prepared = match (self.prepare)() {
            Ok(prepared) => prepared,
            Err(problem) => return zeronav_console::terminal::usage(&problem),
        };
        let tick = at.tick(prepared.scenario.run.tick_ns());
        let end = match HeldRun::start(prepared, tick) {
            Ok(run) => self.serve(run, attach.map(|role| Word::Attach(Some(role)))),
            Err(why) => End::Failed(why),
        };
        match end {
            End::Over(over) => {
                explain(&over.ending);
                say(&in_words(&over));
                let stood = over.end_tick >= tick;
                if !stood {
                    complain(&format!("the run ended before tick {tick}"));
                }
                exit_code(&over.ending, stood)
            }
            End::Quit => ExitCode::from(EXIT_PASS),
            End::Interrupted => {
                complain("interrupted, everything is stopped");
                ExitCode::from(EXIT_INTERRUPTED)
            }
            End::Failed(why) => {
                complain(&printable(&why));
                ExitCode::from(EXIT_SERVICE)
            }
        }
    }

    /// Does what is said, `first` before all else, with a run that will stand.
    fn serve(&mut self, mut run: HeldRun, mut first: Option<Word>) -> End {
        let mut began = Instant::now();
        loop {
            let report = match self.until_it_stands(&mut run) {
                Ok(Some(report)) => report,
                Ok(None) => return over(run.end()),
                Err(end) => {
                    let ended = run.end();
                    return ended.map_or_else(End::Failed, |_| end);
                }
            };
            say(&stands(&report, began.elapsed()));
            let told = self.do_until_it_moves(&mut run, &report, first.take());
            began = Instant::now();
            match told {
                Ok(Next::Moves) => {}
                Ok(Next::Again(tick)) => {
                    if let Err(why) = run.end() {
                        return End::Failed(why);
                    }
                    began = Instant::now();
                    let again = (self.prepare)().and_then(|it| HeldRun::start(it, tick));
                    match again {
                        Ok(again) => run = again,
                        Err(why) => return End::Failed(why),
                    }
                }
                Err(end) => return run.end().map_or_else(End::Failed, |_| end),
            }
        }
    }

    /// What the run says of itself once it stands; `None` when it has ended instead.
    fn until_it_stands(&self, run: &mut HeldRun) -> Result<Option<RunReport>, End> {
        match run.wait(|| self.is_interrupted())? {
            Stand::Stands(report) => Ok(Some(*report)),
            Stand::Over => Ok(None),
            Stand::GivenUp => Err(End::Interrupted),
        }
    }

    /// Does what is said while the run stands, until something lets it go on.
    fn do_until_it_moves(
        &mut self,
        run: &mut HeldRun,
        report: &RunReport,
        mut word: Option<Word>,
    ) -> Result<Next, End> {
        // The tick that is done next.
        let tick = report.tick + 1;
        loop {
            let said = match word.take() {
                Some(word) => Ok(word),
                None => self.ask(tick)?,
            };
            let asked = match said {
                Ok(Word::Nothing) => continue,
                Ok(Word::Help) => {
                    say(HELP);
                    continue;
                }
                Ok(Word::Why) => {
                    say(&format!("{}\n", printable(&report.why)));
                    continue;
                }
                Ok(Word::Quit) => return Err(End::Quit),
                Ok(Word::Continue) => run.go_on(),
                Ok(Word::Step(ticks)) => run.step(ticks),
                Ok(Word::Back(ticks)) => return Ok(Next::Again(tick.saturating_sub(ticks).max(1))),
                Ok(Word::Goto(moment)) => {
                    let to = moment.tick(run.tick_ns);
                    if to <= tick {
                        return Ok(Next::Again(to));
                    }
                    run.step(to - tick)
                }
                Ok(Word::Attach(role)) => {
                    self.attach(report, role)?;
                    // It may have let the run go on.
                    return Ok(Next::Moves);
                }
                Err(why) => Err(why),
            };
            match asked {
                Ok(()) => return Ok(Next::Moves),
                Err(_) if run.is_over() => return Ok(Next::Moves),
                Err(why) => complain(&printable(&why)),
            }
        }
    }

    /// Runs the debugger on the process in a seat, until it ends.
    fn attach(&mut self, report: &RunReport, role: Option<Role>) -> Result<(), End> {
        let Some(role) = role.or(self.role) else {
            complain("attach to which seat? such as `attach local_planner`");
            return Ok(());
        };
        self.role = Some(role);
        let service = report.services.iter().find(|it| it.role == role.label());
        let Some(service) = service else {
            complain(&format!("{role} has no process"));
            return Ok(());
        };
        let mut child = match self.debugger.start(service.pid, Path::new(&report.domain)) {
            Ok(child) => child,
            Err(why) => {
                complain(&printable(&why));
                return Ok(());
            }
        };
        loop {
            match child.try_wait() {
                Ok(None) => {}
                Ok(Some(status)) if status.success() => break,
                Ok(Some(status)) => {
                    complain(&format!("the debugger ended: {status}"));
                    break;
                }
                Err(error) => {
                    return Err(End::Failed(format!("waiting for the debugger: {error}")));
                }
            }
            if self.others.load(Ordering::Relaxed) {
                // What it has stopped goes on when it ends.
                let _ = child.kill();
                let _ = child.wait();
                return Err(End::Interrupted);
            }
            std::thread::sleep(PAUSE);
        }
        // What the keyboard sent was for the debugger.
        self.keyboard.store(false, Ordering::Relaxed);
        Ok(())
    }

    fn is_interrupted(&self) -> bool {
        let flags = [&self.keyboard, &self.others];
        flags.iter().any(|flag| flag.load(Ordering::Relaxed))
    }

    /// A line from standard input; its end is the word `quit`.
    fn ask(&self, tick: u64) -> Result<Result<Word, String>, End> {
        say(&format!("tick {tick}> "));
        let input = std::io::stdin();
        let mut line = Vec::new();
        // A byte at a time: what follows the line may be for a debugger.
        let mut byte = [0_u8; 1];
        loop {
            if self.is_interrupted() {
                return Err(End::Interrupted);
            }
            let mut look = [PollFd::new(&input, PollFlags::IN)];
            let pause = Timespec::try_from(PAUSE).ok();
            if matches!(poll(&mut look, pause.as_ref()), Ok(0) | Err(Errno::INTR)) {
                continue;
            }
            match rustix::io::read(&input, &mut byte) {
                Err(Errno::INTR | Errno::AGAIN) => continue,
                Ok(1) if byte[0] != b'\n' => {
                    if line.len() < LINE_MAX {
                        line.push(byte[0]);
                    }
                    continue;
                }
                Ok(1) => {}
                // Nothing more comes.
                Ok(_) | Err(_) if line.is_empty() => return Ok(Ok(Word::Quit)),
                Ok(_) | Err(_) => {}
            }
            return Ok(Word::of(&String::from_utf8_lossy(&line)));
        }
    }
}

/// What a word leads to.
enum Next {
    /// The run stands somewhere else, or in the same place.
    Moves,
    /// It is driven again, to stand before this tick.
    Again(u64),
}

fn over(ended: Result<Over, String>) -> End {
    ended.map_or_else(End::Failed, End::Over)
}

/// Where a run stands, and its processes.
fn stands(report: &RunReport, after: Duration) -> String {
    let RunReport { tick, time_s, .. } = report;
    let mut text = format!(
        "{} is paused before tick {} (run time {time_s:.3} s, reached in {:.2} s)\n",
        printable(&report.scenario),
        tick + 1,
        after.as_secs_f64()
    );
    for service in &report.services {
        let binary = printable(&service.binary);
        let _ = writeln!(text, "  {:<16} {:>8}  {binary}", service.role, service.pid);
    }
    text
}

/// How a run ended.
fn in_words(over: &Over) -> String {
    let outcome = over.ending.outcome();
    let mut text = format!(
        "the run has ended: {outcome}, tick {}, run_hash {}\n",
        over.end_tick, over.run_hash
    );
    for why in &over.not_reproducible {
        let _ = writeln!(text, "not reproducible: {}", printable(why));
    }
    text
}
