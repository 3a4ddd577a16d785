//! What a run waits for, and what has decided about it beside its scenario.

use super::session::Session;
use super::standstill::{Held, WALL_LIMIT};
use crate::ending::Ending;
use std::time::{Duration, Instant};
use zeronav_console::terminal::note;
use zeronav_msgs::role::Role;
use zeronav_supervise::stack::Stack;

impl Session<'_> {
    /// Waits until every service can answer; how the run ends when one cannot.
    pub(super) fn wait_until_ready(&mut self, stack: &mut Stack) -> Option<Ending> {
        let started = Instant::now();
        let remote = &self.prepared.remote;
        if let Some(host) = remote.first().and_then(|seat| self.prepared.host_of(*seat)) {
            let seats: Vec<&str> = remote.iter().map(|role| role.label()).collect();
            note(&format!(
                "waits for {host}, which fills {}",
                seats.join(", ")
            ));
        }
        loop {
            self.listen(stack);
            self.serve(stack);
            let missing = stack.not_ready();
            if missing.is_empty() {
                stack.was_ready = true;
                return None;
            }
            if let Some(ending) = self.keep(stack) {
                return Some(ending);
            }
            self.companions.look(stack);
            if let Some(ending) = self.asked_to_end(stack) {
                return Some(ending);
            }
            // A service that is started by hand, or on another host, takes the time that it takes, and one that gets
            // no processor is not late by its own doing.
            let mut late: Vec<Role> = missing;
            let remote = &self.prepared.remote;
            late.retain(|role| self.prepared.binaries.contains_key(role) && !remote.contains(role));
            let is_over = started.elapsed() > WALL_LIMIT;
            if late.iter().any(|role| self.restarter.is_late(*role))
                || (is_over && !late.is_empty())
            {
                return Some(Ending::NotReady(late));
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Why the robot does not tick, as far as launch holds it.
    pub(super) fn held(&self, stack: &Stack, tick: u64, hold_tick: u64) -> Held {
        // Before a newcomer is judged, everybody has to answer.
        let is_owed = || self.swaps.steps() && self.collector.owing(&stack.roster).is_some();
        if self.run_time.is_paused {
            Held::ByClient
        } else if self.lockstep() && self.restarter.is_busy() {
            // A successor has to be started first, as often as its budget allows.
            Held::ByLaunch
        } else if !self.lockstep() || hold_tick > tick || is_owed() {
            Held::Not
        } else if self.swap_limit().min(self.fault_limit()) <= tick {
            Held::ByLaunch
        } else {
            Held::ByClient
        }
    }

    /// The first role in the flow of data that owes an answer, or whose seat the robot waits for.
    pub(super) fn silent(&self, stack: &Stack) -> Role {
        let owing = self.collector.owing(&stack.roster);
        let hold = self.faults.hold.map(|hold| hold.role);
        owing.or(hold).or(self.swaps.role()).unwrap_or(Role::Robot)
    }

    /// Why the same command may give another run, one line each; empty in real time, which never gives
    /// the same.
    pub(super) fn not_reproducible(&self, ending: &Ending) -> Vec<String> {
        if !self.lockstep() {
            return Vec::new();
        }
        let by_hand = self
            .clients
            .interferences
            .iter()
            .map(|what| (*what).to_owned());
        let unasked = self.restarter.unasked().iter().cloned();
        (unasked.chain(self.swaps.decided_by_clock()))
            .chain(by_hand)
            .chain(ending.cut_short())
            .collect()
    }
}
