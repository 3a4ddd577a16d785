//! The swap that goes on, and those before it.

use crate::swap::Swap;
use std::collections::VecDeque;
use zeronav_measure::result::swap::SwapResult;
use zeronav_msgs::role::Role;

/// Swaps that are remembered; the oldest go first.
const REMEMBERED_MAX: usize = 100;

/// The swap that goes on, and those before it.
#[derive(Debug, Default)]
pub(super) struct Swaps {
    pub(super) current: Option<Swap>,
    pub(super) done: VecDeque<SwapResult>,
    pub(super) last_id: u64,
    /// What the clock has decided of swaps that are over, one line each; the oldest go first.
    decided_by_clock: VecDeque<String>,
    /// Swaps of the scenario that have begun.
    pub(super) begun: usize,
}

impl Swaps {
    /// The seat that a swap looks after itself.
    pub(super) fn keeps(&self) -> Option<Role> {
        let current = self.current.as_ref()?;
        current.keeps_seat().then(|| current.role())
    }

    /// The seat of the swap that goes on.
    pub(super) fn role(&self) -> Option<Role> {
        self.current.as_ref().map(Swap::role)
    }

    /// True while a swap goes on.
    pub(super) fn is_busy(&self) -> bool {
        self.current.is_some()
    }

    /// The swap with this number; without one, the newest.
    pub(super) fn result(&self, id: Option<u64>) -> Option<&SwapResult> {
        let results = self
            .done
            .iter()
            .chain(self.current.iter().map(|swap| &swap.result));
        results
            .rev()
            .find(|result| id.is_none_or(|id| result.id == id))
    }

    /// Every swap that is remembered, the oldest first.
    pub(super) fn results(&self) -> Vec<SwapResult> {
        let current = self.current.iter().map(Swap::decided);
        self.done.iter().cloned().chain(current).collect()
    }

    /// What the clock has decided of swaps, one line each.
    pub(super) fn decided_by_clock(&self) -> impl Iterator<Item = String> {
        let current = self.current.as_ref().and_then(Swap::by_clock);
        let before = self.decided_by_clock.iter().map(String::as_str);
        before.chain(current).map(str::to_owned)
    }

    /// True while the robot is held after each tick, to judge a newcomer; lockstep only.
    pub(super) fn steps(&self) -> bool {
        self.current.as_ref().is_some_and(Swap::steps)
    }

    /// Goes on with a swap, or remembers what became of it.
    pub(super) fn put_back(&mut self, swap: Swap) {
        if swap.is_over() {
            if let Some(line) = swap.by_clock() {
                if self.decided_by_clock.len() == REMEMBERED_MAX {
                    self.decided_by_clock.pop_front();
                }
                self.decided_by_clock.push_back(line.to_owned());
            }
            self.remember(swap.result);
        } else {
            self.current = Some(swap);
        }
    }

    /// Remembers what became of a swap.
    pub(super) fn remember(&mut self, result: SwapResult) {
        if self.done.len() == REMEMBERED_MAX {
            self.done.pop_front();
        }
        self.done.push_back(result);
    }
}
