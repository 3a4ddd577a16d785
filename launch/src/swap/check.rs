//! Whether a newcomer fails.

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

/// Ticks by which a newcomer in office may be behind its predecessor, which has the same inputs.
const TICKS_BEHIND: u64 = 5;

/// The same of a seat that answers scans.
const SCAN_TICKS_BEHIND: u64 = 25;

impl Swap {
    /// Why the newcomer fails; `None` while it does not.
    pub(super) fn failure(&mut self, scene: &mut Scene<'_>) -> Option<String> {
        if let Some(how) = self.death(scene) {
            return Some(how);
        }
        let is_obeyed = matches!(self.phase, Phase::Keep(_));
        let comparison = &self.result.comparison;
        let newcomer = self.newcomer.as_ref()?;
        if comparison.rejected > 0 {
            return Some(format!(
                "{} of its messages were rejected",
                comparison.rejected
            ));
        }
        if newcomer.is_blocked() {
            return Some("its path leads through an obstacle".to_owned());
        }
        if newcomer.is_hung() {
            let condition = self.process(scene).map(|child| child.condition());
            let condition = condition.unwrap_or_default();
            return Some(format!("it made no progress ({condition})"));
        }
        if is_obeyed {
            let mut clauses = self.order.require.iter();
            if let Some(missed) = clauses.find_map(|clause| clause.missed(comparison, false)) {
                return Some(missed);
            }
        }
        self.lateness(scene, is_obeyed)
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
        let before = scene.collector.aside.answered(newcomer.office);
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
        let before = scene.collector.aside.answered(newcomer.office);
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
