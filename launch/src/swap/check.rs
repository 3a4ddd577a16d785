//! Whether a newcomer fails.

use super::failure::Failure;
use super::newcomer::Newcomer;
use super::owing::Owing;
use super::{Phase, Scene, Swap};
use std::time::Duration;
use zeronav_msgs::role::Role;
use zeronav_supervise::child::Child;
use zeronav_supervise::question::headline;

/// How long a lockstep robot may wait for an answer of one of the two processes alone while no process
/// of the stack runs or waits for a processor.
pub(super) const SILENCE_LIMIT: Duration = Duration::from_secs(3);

/// Ticks by which a shadow may be behind.
const SHADOW_TICKS_BEHIND: u64 = 50;

/// Ticks by which a newcomer in the seat may be behind its predecessor, which has the same inputs.
const TICKS_BEHIND: u64 = 5;

/// The same of a seat that answers scans.
const SCAN_TICKS_BEHIND: u64 = 25;

impl Swap {
    /// True when the newcomer can be judged by what it has sent. In lockstep that is so once everybody
    /// has answered the tick at which the robot is held, so that nothing depends on how fast launch reads.
    pub(super) fn may_judge(&self, scene: &Scene<'_>) -> bool {
        let Some(newcomer) = &self.newcomer else {
            return false;
        };
        if !scene.lockstep || !self.steps() {
            return true;
        }
        let tick = self.judged_tick;
        let owed = match self.role {
            Role::Mapping | Role::GlobalPlanner => scene.collector.scan_tick.min(tick),
            _ => tick,
        };
        scene.all_answered(tick)
            && newcomer.answered(scene) >= owed
            && !self.predecessor_owes(newcomer, scene, owed)
    }

    /// True while the process before the newcomer, which stays warm, is still to answer the tick `owed`.
    fn predecessor_owes(&self, newcomer: &Newcomer, scene: &Scene<'_>, owed: u64) -> bool {
        // It may have been restarted shortly before: then it has heard nothing from before the cut-over.
        let is_due = self.result.cut_over_tick.is_some_and(|tick| owed >= tick);
        is_due
            && scene.stack.beside.is_some()
            && scene.collector.aside.answered(newcomer.incumbent) < owed
    }

    /// The newcomer has passed at this look: the next tick after which it is judged.
    pub(super) fn judged_on(&mut self) -> u64 {
        self.judged_tick += u64::from(self.is_judging);
        self.judged_tick
    }

    /// Why the newcomer fails; `None` while it does not.
    pub(super) fn failure(&mut self, scene: &mut Scene<'_>) -> Option<Failure> {
        if let Some(how) = self.death(scene) {
            return Some(Failure::by_clock(how));
        }
        let is_obeyed = matches!(self.phase, Phase::Keep(_));
        if let Some(why) = self.bad_content(is_obeyed) {
            return Some(why);
        }
        if self.newcomer.as_ref()?.is_hung() {
            let condition = self.process(scene).map(|child| child.condition());
            let condition = condition.unwrap_or_default();
            let why = format!("it made no progress ({condition})");
            return Some(Failure::by_clock(why));
        }
        self.lateness(scene, is_obeyed).map(Failure::by_clock)
    }

    /// Why the newcomer fails by what it has sent.
    fn bad_content(&self, is_obeyed: bool) -> Option<Failure> {
        let newcomer = self.newcomer.as_ref().filter(|_| self.is_judging)?;
        let comparison = &self.result.comparison;
        if comparison.rejected > 0 {
            let why = format!("{} of its messages were rejected", comparison.rejected);
            return Some(Failure::by_content(why));
        }
        if newcomer.is_blocked() {
            let why = "its path leads through an obstacle".to_owned();
            return Some(Failure::by_content(why));
        }
        is_obeyed.then(|| self.missed(false)).flatten()
    }

    /// The first requirement that is not met.
    pub(super) fn missed(&self, is_final: bool) -> Option<Failure> {
        let comparison = &self.result.comparison;
        self.order.require.iter().find_map(|clause| {
            Some(Failure {
                why: clause.missed(comparison, is_final)?,
                by_clock: clause.is_timed(),
            })
        })
    }

    /// The newcomer's process.
    fn process<'s>(&self, scene: &'s mut Scene<'_>) -> Option<&'s mut Child> {
        if self.keeps_seat() {
            let children = &mut scene.stack.children;
            return children.iter_mut().find(|child| child.role == self.role);
        }
        scene.stack.beside.as_mut()
    }

    /// How the newcomer ended, if it did.
    fn death(&self, scene: &mut Scene<'_>) -> Option<String> {
        let child = self.process(scene)?;
        let status = child.ended()?;
        let last = child.log_tail(1);
        let said = last
            .first()
            .map_or_else(String::new, |line| format!(": {}", headline(line)));
        Some(format!("{}{said}", Child::end_in_words(status)))
    }

    /// Answers that do not come.
    pub(super) fn lateness(&mut self, scene: &mut Scene<'_>, is_obeyed: bool) -> Option<String> {
        let role = self.role;
        let newcomer = self.newcomer.as_mut()?;
        if !matches!(self.phase, Phase::Shadow(_) | Phase::Keep(_)) {
            return None;
        }
        let before = scene.collector.aside.answered(newcomer.incumbent);
        let own = newcomer.answered(scene);
        if before <= own {
            newcomer.owed = None;
            return None;
        }
        if newcomer.owed.is_none_or(|(owed, _)| owed <= own) {
            newcomer.owed = Some((before, Owing::new()));
        }
        let (_, owing) = newcomer.owed.as_mut()?;
        let behind = before - own;
        let is_late = if scene.lockstep {
            owing.quiet(|| scene.stack.is_quiet()) > SILENCE_LIMIT
        } else if !is_obeyed {
            behind > SHADOW_TICKS_BEHIND
        } else {
            match role {
                // The wheels hear nothing else: less than a tick, so that at most one is missed.
                Role::CollisionGuard => {
                    let limit = Duration::from_nanos(scene.tick_ns / 10 * 6);
                    behind > 1 || owing.elapsed() > limit
                }
                Role::LocalPlanner => behind > TICKS_BEHIND,
                _ => behind > SCAN_TICKS_BEHIND,
            }
        };
        is_late.then(|| format!("it has answered tick {own}, and its predecessor tick {before}"))
    }

    /// True when the predecessor, which stays warm, has not answered for long what the newcomer has.
    pub(super) fn predecessor_is_late(&mut self, scene: &Scene<'_>) -> bool {
        let Some(newcomer) = &mut self.newcomer else {
            return false;
        };
        let own = newcomer.answered(scene);
        // As of the newcomer, what came before does not count.
        let before = scene.collector.aside.answered(newcomer.incumbent);
        let before = before.max(newcomer.from_tick.saturating_sub(1));
        if before >= own {
            newcomer.predecessor_owes = None;
            return false;
        }
        let owing = newcomer.predecessor_owes.get_or_insert_with(Owing::new);
        if scene.lockstep {
            owing.quiet(|| scene.stack.is_quiet()) > SILENCE_LIMIT
        } else {
            own - before > SHADOW_TICKS_BEHIND
        }
    }
}
