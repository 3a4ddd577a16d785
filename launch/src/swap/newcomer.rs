//! The newcomer as launch sees it: its heart, its answers, its times.

use super::candidate_readers::{CandidateReaders, roster_of};
use super::owing::Owing;
use super::scene::Scene;
use super::scores::Scores;
use std::time::{Duration, Instant};
use zeronav_measure::result::swap::Comparison;
use zeronav_msgs::health::HealthState;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::HealthTopic;
use zeronav_shell::{Latest, Roster, StartError};
use zeronav_supervise::child::Child;
use zeronav_supervise::hang::HangWatch;
use zeronav_supervise::own_time::{Patience, Reading};
use zeronav_supervise::stack::Stack;

/// A process that was started beside the one in a seat.
#[derive(Debug)]
pub(super) struct Newcomer {
    /// Its epoch.
    pub epoch: u32,
    /// Epoch of the process that was in the seat before it.
    pub incumbent: u32,
    /// First tick that counts.
    pub from_tick: u64,
    candidate_readers: CandidateReaders,
    scores: Scores,
    health: Latest<HealthTopic>,
    roster: Roster,
    hangs: HangWatch,
    looked: Instant,
    is_hung: bool,
    is_ready: bool,
    pid: u32,
    start: Patience,
    /// The newest tick that its predecessor has answered and it has not, and for how long.
    pub owed: Option<(u64, Owing)>,
    /// For how long its predecessor has owed an answer that it has given.
    pub predecessor_owes: Option<Owing>,
}

impl Newcomer {
    /// Opens what is needed to hear it.
    ///
    /// # Errors
    /// When there is no place left for a reader.
    pub(super) fn open(stack: &Stack, role: Role, epoch: u32) -> Result<Self, StartError> {
        let pid = stack.beside.as_ref().map_or(0, Child::pid);
        Ok(Self {
            epoch,
            incumbent: stack.epoch(role),
            from_tick: u64::MAX,
            candidate_readers: CandidateReaders::open(stack, role, epoch)?,
            scores: Scores::default(),
            health: stack.health_of(role)?,
            roster: roster_of(role, epoch),
            hangs: HangWatch::default(),
            looked: Instant::now(),
            is_hung: false,
            is_ready: false,
            pid,
            start: Patience::with(pid),
            owed: None,
            predecessor_owes: None,
        })
    }

    /// Looks at its heart.
    pub(super) fn listen(&mut self, role: Role, scene: &mut Scene<'_>) {
        let since = self.looked.elapsed();
        self.looked = Instant::now();
        self.health.poll(&self.roster);
        // A process that has not beaten yet still starts.
        if let Some(beat) = self.health.get() {
            let beat_of = (self.epoch, beat.meta.progress);
            let reading = || Reading::of(self.pid);
            self.is_hung = self.hangs.look(role, beat_of, since, scene.hang, reading);
            let state = beat.meta.state();
            self.is_ready = matches!(state, Some(HealthState::Ready | HealthState::Degraded));
        }
        let incumbent = scene.stack.epoch(role);
        if incumbent != self.incumbent && incumbent != self.epoch {
            // It was restarted.
            self.incumbent = incumbent;
            self.candidate_readers.incumbent_is(incumbent);
            scene.collector.aside.watch(role, &[incumbent, self.epoch]);
        }
    }

    /// Takes in what has come of it, and of the incumbent.
    pub(super) fn compare(&mut self, scene: &mut Scene<'_>, comparison: &mut Comparison) {
        let map = scene.collector.replica.view();
        let is_missing =
            self.candidate_readers
                .listen(self.from_tick, map.as_ref(), &mut self.scores);
        if is_missing {
            scene.collector.ask_for_keyframe();
        }
        self.scores.report(comparison);
        comparison.rejected = self.candidate_readers.rejected();
        comparison.office = scene.collector.aside.times(self.incumbent);
        comparison.newcomer = scene.collector.aside.times(self.epoch);
    }

    /// True once its heartbeat says that it can answer.
    pub(super) fn is_ready(&self) -> bool {
        self.is_ready
    }

    /// True when it has spent more than `limit` of its own time since it was started.
    pub(super) fn is_late(&mut self, limit: Duration) -> bool {
        self.start.is_over(limit)
    }

    /// True when its heartbeat has shown no progress for too long.
    pub(super) fn is_hung(&self) -> bool {
        self.is_hung
    }

    /// Newest tick that it has answered; it owes nothing from before it came.
    pub(super) fn answered(&self, scene: &Scene<'_>) -> u64 {
        let answered = scene.collector.aside.answered(self.epoch);
        answered.max(self.from_tick.saturating_sub(1))
    }

    /// True when its paths lead through obstacles.
    pub(super) fn is_blocked(&self) -> bool {
        self.candidate_readers.is_blocked()
    }
}
