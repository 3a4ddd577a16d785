//! Plays a recording into a stack in which only the open seats are taken, in lockstep: what a tick holds is sent in the
//! order in which it was, and what an open seat owes is waited for where its answer had been.

use super::player::{Player, is_latched};
use super::score::Score;
use crate::companions::Companions;
use crate::configs;
use crate::prepare::Prepared;
use crate::recorded::notes::Note;
use crate::recorder::{self, DrivenBy, RecordedTicks};
use crate::recorder_start::start_recorder;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use zeronav_console::progress::ProgressLine;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunMode};
use zeronav_msgs::span::SpanKind;
use zeronav_supervise::child::Child;
use zeronav_supervise::own_time::Patience;
use zeronav_supervise::stack::{self, Launch, Stack};
use zeronav_supervise::warden;

/// How long a seat may take to be ready, and to answer a tick, of its own time, and in any case.
const READY_LIMIT: Duration = Duration::from_secs(15);
const ANSWER_LIMIT: Duration = Duration::from_secs(10);
const WALL_LIMIT: Duration = Duration::from_secs(300);

const PAUSE: Duration = Duration::from_micros(50);

/// What the recording says of the run, for its end.
const OUTCOME: &str = "replayed";

/// Why a recording was not played to its end.
#[derive(Debug)]
pub(super) enum PlayError {
    /// The stack could not be started.
    Start(String),
    /// An open seat ended, or did not answer.
    Seat(String),
    /// A signal.
    Interrupted,
}

/// Plays `score` until `last_tick` to the seats in `live`.
///
/// # Errors
/// See [`PlayError`].
pub(super) fn play(
    prepared: &Prepared,
    score: &Score,
    live: &[Role],
    last_tick: u64,
    interrupted: &Arc<AtomicBool>,
) -> Result<(), PlayError> {
    let start = |why: String| PlayError::Start(why);
    warden::start();
    let clock = RunClock {
        mode: RunMode::Lockstep.code(),
        seed: prepared.seed,
        tick_ns: prepared.scenario.run.tick_ns(),
        foresight: prepared.scenario.foresight.bits(),
        ..RunClock::default()
    };
    let mut stack = Stack::create(clock).map_err(|error| start(error.to_string()))?;
    stack.scheduling = prepared.scenario.scheduling();
    let mut companions = Companions::default();
    let mut playing = Playing {
        prepared,
        score,
        live,
        answered: BTreeMap::new(),
        recorded: None,
        tick: 0,
        interrupted,
        line: ProgressLine::new(&prepared.scenario.name, prepared.progress),
    };
    let played = playing
        .begin(&mut stack, &mut companions)
        .and_then(|mut player| {
            let played = playing.play(&mut stack, &mut player, last_tick);
            player.leave();
            played
        });
    playing.line.clear();
    if let Some(folder) = stack.folder() {
        recorder::say_end(folder, playing.tick + 1, OUTCOME);
    }
    stack.stop_processes();
    companions.stop();
    stack::close(stack);
    played
}

struct Playing<'a> {
    prepared: &'a Prepared,
    score: &'a Score,
    live: &'a [Role],
    /// The newest tick that each open seat has answered.
    answered: BTreeMap<Role, u64>,
    recorded: Option<RecordedTicks>,
    /// The tick that is played.
    tick: u64,
    interrupted: &'a Arc<AtomicBool>,
    line: ProgressLine,
}

impl Playing<'_> {
    /// Starts the recorder, then the open seats, and tells them what came before the first tick.
    fn begin(
        &mut self,
        stack: &mut Stack,
        companions: &mut Companions,
    ) -> Result<Player, PlayError> {
        let start = |why: String| PlayError::Start(why);
        let prepared = self.prepared;
        let configs = configs::write(&prepared.scenario, &prepared.world, &[], stack.root());
        let configs = configs.map_err(start)?;
        let who = (DrivenBy::Recording, &BTreeMap::new());
        let file = prepared.recording.clone();
        let file = file.ok_or_else(|| start("no file is named".to_owned()))?;
        // Before the recorder, which so knows the topics of users from the beginning.
        let player = Player::open(stack.root(), self.score, self.live);
        let mut player = player.map_err(|error| start(error.to_string()))?;
        let recorded = start_recorder(companions, stack, prepared, file, who);
        self.recorded = Some(recorded.map_err(start)?);
        for role in self.live {
            stack
                .hold_seat(*role)
                .map_err(|error| start(error.to_string()))?;
        }
        for (role, epoch) in &self.score.epochs {
            stack.announce(*role, |seat| seat.epoch = *epoch);
        }
        stack.extend_lease(u64::from(u32::MAX));
        for note in self.prelude().filter(|note| is_latched(note.row)) {
            player.play(note).map_err(start)?;
        }
        for role in self.live {
            let (binary, config) = prepared
                .binaries
                .get(role)
                .zip(configs.get(role))
                .ok_or_else(|| start(format!("{role} has no binary")))?;
            let launch = Launch {
                binary,
                config,
                log_level: &prepared.log_level,
                log: &prepared.log(format!("{role}.log")),
            };
            stack
                .start(*role, &launch)
                .map_err(|error| start(error.to_string()))?;
        }
        self.await_ready(stack, &player)?;
        for note in self.prelude().filter(|note| !is_latched(note.row)) {
            player.play(note).map_err(start)?;
        }
        Ok(player)
    }

    /// What was sent before the robot's first tick: idle outputs, the map, goals.
    fn prelude(&self) -> impl Iterator<Item = &Note> + use<'_> {
        let notes = self.score.notes.iter();
        notes
            .take_while(|note| note.tick == 0)
            .filter(|note| self.is_heard(note))
    }

    /// False for the idle output of a successor.
    fn is_heard(&self, note: &Note) -> bool {
        let first = self.score.epochs.get(&note.role);
        note.tick > 0 || note.role == Role::Launch || first.is_none_or(|first| *first == note.epoch)
    }

    fn await_ready(&mut self, stack: &mut Stack, player: &Player) -> Result<(), PlayError> {
        let mut patience = self.patience(stack);
        let since = Instant::now();
        loop {
            stack.refresh();
            player.refresh();
            let not_ready = stack.not_ready();
            let waits: Vec<&Role> = self
                .live
                .iter()
                .filter(|it| not_ready.contains(it))
                .collect();
            let Some(first) = waits.first() else {
                // To ports that were opened since.
                stack.refresh();
                player.refresh();
                return Ok(());
            };
            self.look(stack)?;
            let is_late = patience
                .get_mut(first)
                .is_some_and(|it| it.is_over(READY_LIMIT));
            if is_late || since.elapsed() > WALL_LIMIT {
                let s = READY_LIMIT.as_secs();
                return Err(PlayError::Seat(format!("{first} is not ready after {s} s")));
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn patience(&self, stack: &Stack) -> BTreeMap<Role, Patience> {
        let children = stack.children.iter();
        children
            .map(|child| (child.role, Patience::with(child.pid())))
            .filter(|(role, _)| self.live.contains(role))
            .collect()
    }

    /// Plays everything behind the prelude.
    fn play(
        &mut self,
        stack: &mut Stack,
        player: &mut Player,
        last_tick: u64,
    ) -> Result<(), PlayError> {
        let score = self.score;
        let behind = score.notes.iter().skip_while(|note| note.tick == 0);
        for note in behind {
            let is_stage = note.tick > 0 && Role::SERVICES.contains(&note.role);
            if is_stage && note.tick > self.tick {
                self.await_answers(stack, self.tick, None)?;
                if note.tick > last_tick {
                    return Ok(());
                }
                self.begin_tick(stack, note.tick)?;
            }
            if is_stage {
                take_over(stack, note);
                self.await_answers(stack, note.tick, Some(note.role))?;
            } else if self.tick > 0 {
                // It comes behind the tick: seats that are still answering that must not see it.
                self.await_answers(stack, self.tick, None)?;
            }
            if self.is_heard(note) {
                player.play(note).map_err(PlayError::Start)?;
            }
        }
        self.await_answers(stack, self.tick, None)
    }

    /// Lets the recorder come closer, and says which seats do not answer this tick.
    fn begin_tick(&mut self, stack: &mut Stack, tick: u64) -> Result<(), PlayError> {
        while let Some(recorded) = &mut self.recorded
            && recorded.last_tick() < tick
        {
            self.look(stack)?;
            std::thread::sleep(PAUSE);
        }
        self.tick = tick;
        for role in Role::SERVICES {
            if self.live.contains(&role) {
                continue;
            }
            if let Some([off_tick, on_tick]) = self.score.gap(role, tick) {
                stack.announce(role, |seat| {
                    if !(seat.off_tick..seat.on_tick).contains(&tick) {
                        (seat.off_tick, seat.on_tick) = (off_tick, on_tick);
                    }
                });
            }
        }
        let s = zeronav_msgs::time::seconds(tick * self.prepared.scenario.run.tick_ns());
        self.line.show(|| format!("{s:.1} s"));
        Ok(())
    }

    /// Waits until the open seats have answered `tick`: all, or those before that of `before` in the data flow.
    fn await_answers(
        &mut self,
        stack: &mut Stack,
        tick: u64,
        before: Option<Role>,
    ) -> Result<(), PlayError> {
        let upstream = Role::SERVICES
            .into_iter()
            .take_while(|role| Some(*role) != before);
        for role in upstream.filter(|role| self.live.contains(role)) {
            if self.score.is_due(role, tick) {
                self.await_answer(stack, role, tick)?;
            }
        }
        Ok(())
    }

    fn await_answer(&mut self, stack: &mut Stack, role: Role, tick: u64) -> Result<(), PlayError> {
        let has = |it: &Self| {
            it.answered
                .get(&role)
                .is_some_and(|answered| *answered >= tick)
        };
        let since = Instant::now();
        let mut patience = None;
        loop {
            self.ingest(stack);
            if has(self) {
                return Ok(());
            }
            self.look(stack)?;
            let child = stack.children.iter().find(|child| child.role == role);
            let Some(pid) = child.map(Child::pid) else {
                return Err(PlayError::Seat(format!("{role} is gone")));
            };
            let patience = patience.get_or_insert_with(|| Patience::with(pid));
            if patience.is_over(ANSWER_LIMIT) || since.elapsed() > WALL_LIMIT {
                let s = ANSWER_LIMIT.as_secs();
                let why = format!("{role} has not answered tick {tick} within {s} s");
                return Err(PlayError::Seat(why));
            }
            std::thread::sleep(PAUSE);
        }
    }

    /// Takes in the records of answers.
    fn ingest(&mut self, stack: &mut Stack) {
        while let Some(span) = stack.taps.spans.take() {
            let role = Role::from_code(span.role).filter(|role| self.live.contains(role));
            if let Some(role) = role.filter(|_| span.kind() == Some(SpanKind::Answer)) {
                let newest = self.answered.entry(role).or_default();
                *newest = span.tick.max(*newest);
            }
        }
    }

    /// What ends the play early: a signal, or a process that ended.
    fn look(&self, stack: &mut Stack) -> Result<(), PlayError> {
        if self.interrupted.load(Ordering::Relaxed) {
            return Err(PlayError::Interrupted);
        }
        let Some(at) = stack.dead(None) else {
            return Ok(());
        };
        let child = &mut stack.children[at];
        let how = child.ended().map_or_else(String::new, Child::end_in_words);
        let (role, said) = (child.role, child.log_tail(1).join(""));
        let tick = self.tick;
        Err(PlayError::Seat(format!(
            "{role} ended at tick {tick} ({how}: {said})"
        )))
    }
}

/// Says that another process is obeyed in the seat of a message's author, from its tick on.
fn take_over(stack: &mut Stack, note: &Note) {
    stack.announce(note.role, |seat| {
        if seat.epoch != note.epoch {
            seat.other = seat.epoch;
            seat.epoch = note.epoch;
            seat.since_tick = note.tick;
        }
    });
}
