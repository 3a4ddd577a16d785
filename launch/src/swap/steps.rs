//! What a swap does in each phase.

use super::check::SILENCE_LIMIT;
use super::failure::Failure;
use super::newcomer::Newcomer;
use super::owing::Owing;
use super::{Phase, Scene, Settling, Swap};
use crate::restarter::READY_LIMIT;
use rustix::process::Signal;
use std::time::{Duration, Instant};
use zeronav_supervise::child::Child;
use zeronav_supervise::stack::Launch;

/// Ticks from the decision to the cut-over in real time: every process reads in time who is obeyed
/// from then on.
const NOTICE_TICKS: u64 = 3;

/// Ticks for which what a rolled back newcomer sent last may still be in use.
const IN_USE_TICKS: u64 = 50;

/// State of a swap whose process beside ends.
const LEAVING: &str = "leaving";

/// Outcome of a swap whose newcomer failed in the seat.
const ROLLED_BACK: &str = "rolled_back";

/// How long a process may take to end.
const STOP_LIMIT: Duration = Duration::from_secs(2);

impl Swap {
    /// The answer of the binary about its configuration; then the newcomer is started.
    pub(super) fn ingest_answer(&mut self, scene: &mut Scene<'_>) {
        let Phase::Asking(asking) = &self.phase else {
            return;
        };
        // In lockstep the newcomer begins with what is known at that tick, such as the map.
        if !asking.is_finished() || (scene.lockstep && !scene.all_answered(self.hold_tick)) {
            return;
        }
        let Phase::Asking(asking) = core::mem::replace(&mut self.phase, Phase::Over) else {
            return;
        };
        let asked = asking.join().unwrap_or_else(|_| {
            let why = "it could not be asked".to_owned();
            Err(Failure::by_clock(why))
        });
        match asked.and_then(|()| self.start(scene).map_err(Failure::by_clock)) {
            Ok(()) => {
                "starting".clone_into(&mut self.result.state);
                self.phase = Phase::Starting;
            }
            Err(failure) if scene.stack.beside.is_some() => self.turn_away(scene, failure),
            Err(failure) => self.reject(failure),
        }
    }

    fn start(&mut self, scene: &mut Scene<'_>) -> Result<(), String> {
        let launch = Launch {
            binary: &self.files.binary,
            config: &self.files.config,
            log_level: &self.files.log_level,
            log: &self.files.log,
        };
        let role = self.role;
        let from_tick = if scene.lockstep { u64::MAX } else { 0 };
        let epoch = scene.stack.start_beside(role, &launch, from_tick);
        let epoch = epoch.map_err(|error| error.to_string())?;
        self.result.epoch = epoch;
        self.result.pid = scene.stack.beside.as_ref().map_or(0, Child::pid);
        let newcomer = Newcomer::open(scene.stack, role, epoch);
        let newcomer = newcomer.map_err(|error| format!("it cannot be heard: {error}"))?;
        let (pid, incumbent) = (self.result.pid, newcomer.incumbent);
        tracing::info!(%role, pid, epoch, incumbent, "a newcomer was started");
        scene.collector.aside.begin(role, epoch, 0);
        scene.collector.aside.watch(role, &[incumbent, epoch]);
        self.newcomer = Some(newcomer);
        Ok(())
    }

    /// Waits until the newcomer can answer; in lockstep also until the robot waits.
    pub(super) fn wait_until_ready(&mut self, scene: &mut Scene<'_>) {
        if let Some(failure) = self.failure(scene) {
            return self.turn_away(scene, failure);
        }
        let Some(newcomer) = &mut self.newcomer else {
            return;
        };
        if !newcomer.is_ready() {
            if newcomer.is_late(READY_LIMIT) {
                let why = format!("it was not ready within {} s", READY_LIMIT.as_secs());
                self.turn_away(scene, Failure::by_clock(why));
            }
            return;
        }
        let first = if scene.lockstep {
            scene
                .stack
                .warm_up(self.role, newcomer.epoch, self.hold_tick + 1);
            self.hold_tick + 1
        } else {
            scene.collector.robot_tick() + 1
        };
        newcomer.from_tick = first;
        self.judged_tick = first;
        scene.collector.aside.restart_times();
        self.result.warm_tick = Some(first);
        "shadow".clone_into(&mut self.result.state);
        let until = self
            .order
            .shadow_s
            .map(|time_s| first + scene.ticks(time_s));
        self.phase = Phase::Shadow(until);
    }

    /// Compares until the time is over, then decides.
    pub(super) fn compare(&mut self, scene: &mut Scene<'_>, until: Option<u64>) {
        if let Some(failure) = self.failure(scene) {
            return self.turn_away(scene, failure);
        }
        let Some(until) = until else {
            return;
        };
        let is_over = if scene.lockstep {
            self.judged_on() >= until
        } else {
            scene.collector.robot_tick() >= until.saturating_sub(1)
        };
        if !is_over {
            return;
        }
        // One that hears nothing before a later tick could not come back: its seat would owe answers to
        // what it never hears.
        let is_absent = scene.lockstep && !scene.stack.roster.answers(self.role, until);
        if scene.is_vacant || is_absent {
            // A seat whose process died gets a successor first; in lockstep that needs the tick at
            // which its answer is due.
            self.phase = Phase::Shadow(Some(until + u64::from(scene.lockstep)));
            return;
        }
        let late = self.lateness(scene, true).map(Failure::by_clock);
        if let Some(failure) = late.or_else(|| self.missed(true)) {
            return self.turn_away(scene, failure);
        }
        match self.order.keep_s {
            None => self.leave(scene, "compared", None),
            Some(keep_s) => {
                let at = if scene.lockstep {
                    until
                } else {
                    scene.collector.robot_tick() + NOTICE_TICKS
                };
                self.cut_over(scene, at, keep_s);
            }
        }
    }

    fn cut_over(&mut self, scene: &mut Scene<'_>, at: u64, keep_s: f64) {
        let Some(newcomer) = &self.newcomer else {
            return;
        };
        let (epoch, incumbent) = (newcomer.epoch, newcomer.incumbent);
        scene.stack.cut_over(self.role, at);
        scene.collector.aside.end(self.role, epoch, at);
        scene.collector.aside.begin(self.role, incumbent, at);
        scene.collector.aside.restart_times();
        tracing::info!(role = %self.role, tick = at, epoch, "the newcomer is obeyed");
        self.result.cut_over_tick = Some(at);
        self.judged_tick = at;
        "keep".clone_into(&mut self.result.state);
        self.phase = Phase::Keep(at + scene.ticks(keep_s));
    }

    /// Looks after both until the predecessor is not needed any more. True when the newcomer has
    /// the seat for good.
    pub(super) fn keep(&mut self, scene: &mut Scene<'_>, until: u64) -> bool {
        let has_fallback = (scene.stack.beside.as_mut()).is_some_and(|old| old.ended().is_none());
        if let Some(failure) = self.failure(scene) {
            if has_fallback {
                self.roll_back(scene, failure);
            } else {
                self.fall_back_by_restart(scene, &failure.why);
            }
            return false;
        }
        if has_fallback && self.predecessor_is_late(scene) {
            tracing::warn!(role = %self.role, "the predecessor does not answer any more, killed");
            kill(&mut scene.stack.beside);
            return false;
        }
        let is_over = if scene.lockstep {
            self.judged_on() >= until
        } else {
            scene.collector.robot_tick() >= until
        };
        if !is_over && !has_fallback {
            let role = self.role;
            let line = format!("a newcomer of {role} was kept early: its predecessor has ended");
            self.by_clock = Some(line);
        }
        if is_over || !has_fallback {
            self.leave(scene, "swapped", None);
            return true;
        }
        false
    }

    /// The predecessor is obeyed again.
    pub(super) fn roll_back(&mut self, scene: &mut Scene<'_>, failure: Failure) {
        self.note_clock(ROLLED_BACK, &failure);
        let why = failure.why;
        tracing::warn!(role = %self.role, why, "swap rolled back");
        self.result.why = Some(why);
        if scene.lockstep {
            // A newcomer that still runs would go on answering.
            let mut children = scene.stack.children.iter_mut();
            if let Some(child) = children.find(|child| child.role == self.role) {
                child.signal(Signal::KILL);
            }
            self.phase = Phase::Settling(Settling {
                owing: Owing::new(),
                was_dead: false,
            });
            return;
        }
        let tick = scene.collector.robot_tick() + 1;
        self.give_back(scene, tick, None);
    }

    /// Both processes have failed: the seat is restarted with the binary of the predecessor.
    fn fall_back_by_restart(&mut self, scene: &mut Scene<'_>, why: &str) {
        let mut children = scene.stack.children.iter_mut();
        if let Some(child) = children.find(|child| child.role == self.role) {
            child.signal(Signal::KILL);
        }
        let why = format!("{why}; its predecessor failed as well and is restarted");
        let failure = Failure::by_clock(why);
        self.note_clock(ROLLED_BACK, &failure);
        self.leave(scene, ROLLED_BACK, Some(failure.why));
    }

    /// Lockstep: waits until the robot waits for the dead newcomer, then gives the seat back.
    pub(super) fn settle(&mut self, scene: &mut Scene<'_>, mut settling: Settling) {
        if (scene.stack.beside.as_mut()).is_none_or(|old| old.ended().is_some()) {
            let why = self.result.why.clone().unwrap_or_default();
            return self.fall_back_by_restart(scene, &why);
        }
        if settling.owing.quiet(|| scene.stack.is_quiet()) > SILENCE_LIMIT {
            kill(&mut scene.stack.beside);
        }
        let mut children = scene.stack.children.iter_mut();
        let child = children.find(|child| child.role == self.role);
        let is_dead = child.is_none_or(|child| child.ended().is_some());
        let lease = scene.stack.roster.control.lease;
        let waits = scene.collector.owing(&scene.stack.roster) == Some(self.role);
        let is_held = waits || scene.all_answered(lease);
        // Both are facts that cannot change any more, once its last records have been heard, which comes
        // first at every look.
        if settling.was_dead && is_held {
            let off_tick = scene.collector.answered_by(self.role) + 1;
            let tick = scene.collector.robot_tick() + 1;
            self.give_back(scene, tick.max(off_tick), Some(off_tick));
            return;
        }
        settling.was_dead = is_dead;
        self.phase = Phase::Settling(settling);
    }

    fn give_back(&mut self, scene: &mut Scene<'_>, tick: u64, off_tick: Option<u64>) {
        let Some(newcomer) = &self.newcomer else {
            return;
        };
        let (epoch, incumbent) = (newcomer.epoch, newcomer.incumbent);
        scene.stack.roll_back(self.role, tick, off_tick);
        scene.collector.aside.end(self.role, incumbent, tick);
        scene.collector.aside.begin(self.role, epoch, tick);
        self.result.roll_back_tick = Some(tick);
        self.outcome = ROLLED_BACK;
        LEAVING.clone_into(&mut self.result.state);
        // One that hangs does not hear that it is asked to end.
        kill(&mut scene.stack.beside);
        self.newcomer = None;
        self.phase = Phase::Leaving(Instant::now(), tick + IN_USE_TICKS);
    }

    /// The newcomer fails before it is obeyed.
    fn turn_away(&mut self, scene: &mut Scene<'_>, failure: Failure) {
        self.note_clock("rejected", &failure);
        self.leave(scene, "rejected", Some(failure.why));
    }

    /// The process beside is asked to end.
    pub(super) fn leave(
        &mut self,
        scene: &mut Scene<'_>,
        outcome: &'static str,
        why: Option<String>,
    ) {
        if let Some(why) = &why {
            tracing::warn!(role = %self.role, why, outcome, "the newcomer leaves");
        } else {
            tracing::info!(role = %self.role, outcome, "the swap ends");
        }
        self.outcome = outcome;
        LEAVING.clone_into(&mut self.result.state);
        self.result.why = why;
        scene.stack.end_pair(self.role);
        if let Some(beside) = &mut scene.stack.beside {
            beside.signal(Signal::TERM);
        }
        self.newcomer = None;
        self.phase = Phase::Leaving(Instant::now(), 0);
    }

    /// Waits for the end of the process beside.
    pub(super) fn see_off(&mut self, scene: &mut Scene<'_>, since: Instant, until: u64) {
        if let Some(beside) = &mut scene.stack.beside {
            if beside.ended().is_none() {
                if since.elapsed() > STOP_LIMIT {
                    beside.signal(Signal::KILL);
                }
                return;
            }
            self.cleaning = Some(scene.stack.bury_beside());
        }
        let is_clean = (self.cleaning).is_none_or(|ticket| scene.stack.is_clean(ticket));
        if !is_clean || until > scene.collector.robot_tick() {
            return;
        }
        if until > 0 {
            scene.stack.end_pair(self.role);
        }
        self.outcome.clone_into(&mut self.result.state);
        self.phase = Phase::Over;
    }
}

fn kill(beside: &mut Option<Child>) {
    if let Some(child) = beside {
        child.signal(Signal::KILL);
    }
}
