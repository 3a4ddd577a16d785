//! Live swap: a newcomer runs warm beside the process in a seat, is compared with it, takes over
//! between two ticks, and gives the seat back when it fails.
//!
//! | phase | what happens | ends with |
//! |---|---|---|
//! | asking | the binary is asked whether it can work with its configuration | `rejected` when not |
//! | starting | the newcomer is started; in lockstep the tick is held | `rejected` when it dies, hangs or is not ready in time |
//! | shadow | it hears and answers everything and is compared | `rejected`, `compared`, or the cut-over |
//! | keep | it is obeyed, its predecessor stays warm | `rolled_back` when it fails, else `swapped` |
//!
//! In lockstep every phase begins and ends at a tick that is known before, and the newcomer is judged
//! after each tick while the robot is held there, by what was sent up to that tick. So a run with a swap
//! is as reproducible as one without, also when the newcomer is rolled back for what it sends. What the
//! clock decides, such as a death, is named ([`Swap::by_clock`]).

mod candidate_readers;
mod check;
pub(crate) mod config;
mod failure;
mod newcomer;
mod owing;
mod scene;
mod scores;
mod steps;

use crate::swap_order::SwapOrder;
pub(crate) use failure::Failure;
use newcomer::Newcomer;
use owing::Owing;
pub(crate) use scene::Scene;
use std::path::PathBuf;
use std::thread::JoinHandle;
use std::time::Instant;
use zeronav_measure::result::swap::SwapResult;
use zeronav_msgs::role::Role;
use zeronav_supervise::child_log::LogPlace;
use zeronav_supervise::cleaner::Ticket;
use zeronav_supervise::occupant::file_name;
use zeronav_supervise::process::hint;

/// What a newcomer is started with.
#[derive(Debug, Clone)]
pub(crate) struct Files {
    /// Its binary.
    pub binary: PathBuf,
    /// Its configuration.
    pub config: PathBuf,
    /// Where its log goes.
    pub log: LogPlace,
    /// What it logs.
    pub log_level: String,
}

/// What is known of a newcomer that was killed.
#[derive(Debug, Clone, Copy)]
struct Settling {
    /// Its predecessor is waited for.
    owing: Owing,
    /// It was dead at an earlier look: everything that it has answered was heard since.
    was_dead: bool,
}

/// Where a swap is.
#[derive(Debug)]
enum Phase {
    /// The binary is asked whether it can work with its configuration.
    Asking(JoinHandle<Result<(), Failure>>),
    /// The newcomer cannot answer yet.
    Starting,
    /// It is compared from a tick on, before another one.
    Shadow(Option<u64>),
    /// It is obeyed; its predecessor stays warm before this tick.
    Keep(u64),
    /// Lockstep: the newcomer is killed, and the robot comes to the tick that it has not answered.
    Settling(Settling),
    /// The process beside ends. Until the tick, its messages may still be in use.
    Leaving(Instant, u64),
    /// Nothing is left to do.
    Over,
}

/// One swap, or one comparison.
#[derive(Debug)]
pub(crate) struct Swap {
    order: SwapOrder,
    role: Role,
    files: Files,
    phase: Phase,
    newcomer: Option<Newcomer>,
    /// Removes what the process beside has left.
    cleaning: Option<Ticket>,
    /// How it ends, once the process beside has ended.
    outcome: &'static str,
    /// Tick at which the robot waits before the newcomer hears its first one, lockstep only.
    hold_tick: u64,
    /// The tick after which the newcomer is judged next, lockstep only: the robot's lease ends there.
    judged_tick: u64,
    /// True at a look at which the newcomer is judged by what it has sent.
    is_judging: bool,
    /// What the clock has decided.
    by_clock: Option<String>,
    /// What became of it so far.
    pub result: SwapResult,
}

impl Swap {
    /// Begins: `ask` says whether the binary can work with its configuration. In lockstep the robot
    /// waits at `hold_tick` until the newcomer is ready.
    pub(crate) fn begin(
        id: u64,
        role: Role,
        order: SwapOrder,
        files: Files,
        hold_tick: u64,
        ask: impl FnOnce() -> Result<(), Failure> + Send + 'static,
    ) -> Self {
        let result = SwapResult {
            id,
            role: role.to_string(),
            binary: file_name(&files.binary),
            state: "asking".to_owned(),
            ..SwapResult::default()
        };
        let asking = std::thread::Builder::new().spawn(ask);
        let (phase, no_room) = match asking {
            Ok(asking) => (Phase::Asking(asking), None),
            Err(error) => {
                let why = format!("no thread to ask it: {error}{}", hint(&error));
                (Phase::Over, Some(Failure::by_clock(why)))
            }
        };
        let mut swap = Self {
            order,
            role,
            files,
            phase,
            newcomer: None,
            cleaning: None,
            outcome: "",
            hold_tick,
            judged_tick: 0,
            is_judging: false,
            by_clock: None,
            result,
        };
        if let Some(failure) = no_room {
            swap.reject(failure);
        }
        swap
    }

    /// Its seat.
    pub(crate) fn role(&self) -> Role {
        self.role
    }

    /// What the newcomer is started with.
    pub(crate) fn files(&self) -> &Files {
        &self.files
    }

    /// What became of it, as far as that is decided.
    pub(crate) fn decided(&self) -> SwapResult {
        let mut result = self.result.clone();
        if matches!(self.phase, Phase::Leaving(..)) {
            self.outcome.clone_into(&mut result.state);
        }
        result
    }

    /// What the clock has decided of it, one line: the same command may decide otherwise the next time.
    pub(crate) fn by_clock(&self) -> Option<&str> {
        self.by_clock.as_deref()
    }

    /// True when nothing is left of it.
    pub(crate) fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Over)
    }

    /// True while the robot is held after each tick, to judge the newcomer; lockstep only.
    pub(crate) fn steps(&self) -> bool {
        matches!(self.phase, Phase::Shadow(Some(_)) | Phase::Keep(_))
    }

    /// True while it looks after both processes of its seat itself.
    pub(crate) fn keeps_seat(&self) -> bool {
        matches!(self.phase, Phase::Keep(_) | Phase::Settling(_))
    }

    /// The tick beyond which the robot may not go yet, lockstep only. The swap after this one begins
    /// at the tick `next`, or when this one is over.
    pub(crate) fn lease_limit(&self, next: u64) -> u64 {
        match self.phase {
            Phase::Asking(_) | Phase::Starting => self.hold_tick,
            Phase::Shadow(Some(until)) | Phase::Keep(until) => {
                self.judged_tick.min(until.saturating_sub(1))
            }
            Phase::Settling(_) => 0,
            Phase::Shadow(None) => u64::MAX,
            Phase::Leaving(_, until) => next.max(until),
            Phase::Over => next,
        }
    }

    /// Ends it early: before the cut-over the newcomer leaves, after it the predecessor comes back.
    ///
    /// # Errors
    /// When its end is decided already.
    pub(crate) fn cancel(&mut self, scene: &mut Scene<'_>) -> Result<(), String> {
        match self.phase {
            Phase::Asking(_) => self.end("cancelled", None),
            Phase::Shadow(None) => self.leave(scene, "compared", None),
            Phase::Starting | Phase::Shadow(_) => self.leave(scene, "cancelled", None),
            Phase::Keep(_) => {
                self.roll_back(scene, Failure::by_clock("it was cancelled".to_owned()));
            }
            Phase::Settling(_) | Phase::Leaving(..) | Phase::Over => {
                let (role, outcome) = (self.role, self.decided().state);
                return Err(format!("the swap of {role} ends already: {outcome}"));
            }
        }
        Ok(())
    }

    /// One look. True once the newcomer has the seat for good.
    pub(crate) fn look(&mut self, scene: &mut Scene<'_>) -> bool {
        self.is_judging = self.may_judge(scene);
        if let Some(newcomer) = &mut self.newcomer {
            newcomer.listen(self.role, scene);
            if self.is_judging {
                newcomer.compare(scene, &mut self.result.comparison);
            }
        }
        if !matches!(self.phase, Phase::Asking(_)) {
            self.result.command_gap_ticks = scene.collector.aside.command_gap_ticks();
        }
        match &self.phase {
            Phase::Asking(_) => self.ingest_answer(scene),
            Phase::Starting => self.wait_until_ready(scene),
            Phase::Shadow(until) => {
                let until = *until;
                self.compare(scene, until);
            }
            Phase::Keep(until) => {
                let until = *until;
                return self.keep(scene, until);
            }
            Phase::Settling(settling) => {
                let settling = *settling;
                self.settle(scene, settling);
            }
            Phase::Leaving(since, until) => {
                let (since, until) = (*since, *until);
                self.see_off(scene, since, until);
            }
            Phase::Over => {}
        }
        false
    }

    /// The newcomer fails before it was started.
    fn reject(&mut self, failure: Failure) {
        self.note_clock("rejected", &failure);
        self.end("rejected", Some(failure.why));
    }

    /// Remembers what became of the newcomer when the clock has decided that.
    fn note_clock(&mut self, outcome: &str, failure: &Failure) {
        if failure.by_clock {
            let outcome = outcome.replace('_', " ");
            let (role, why) = (self.role, &failure.why);
            self.by_clock = Some(format!("a newcomer of {role} was {outcome}: {why}"));
        }
    }

    fn end(&mut self, state: &'static str, why: Option<String>) {
        state.clone_into(&mut self.result.state);
        self.result.why = why;
        self.phase = Phase::Over;
    }
}
