//! How a stack ends.

use super::Stack;
use crate::child::Child;
use crate::cleaner::Cleaner;
use crate::descendants;
use crate::own_time::{Doing, Patience, Reading};
use rustix::process::Signal;
use std::path::Path;
use std::time::{Duration, Instant};
use zeronav_msgs::role::Role;
use zeronav_shell::Peer;

/// Own time that a process may take to stop before it is killed.
const STOP_LIMIT: Duration = Duration::from_secs(2);

/// The same on a machine that has no time for it, by the clock.
const STARVED_LIMIT: Duration = Duration::from_secs(20);

/// Between two looks at whether one has taken too long.
const LOOK_EVERY: Duration = Duration::from_millis(20);

impl Stack {
    /// Ends the processes: asks, waits, kills. Returns those that had to be killed.
    pub fn stop_processes(&mut self) -> Vec<Role> {
        let asked = Instant::now();
        let ask = |child: &mut Child| {
            child.memory_peak_bytes();
            child.scheduling();
            child.signal(Signal::TERM);
            Patience::with(child.pid())
        };
        let children = self.children.iter_mut().chain(&mut self.beside);
        let mut waiting: Vec<_> = children.map(|child| (ask(child), child)).collect();
        let mut killed = Vec::new();
        loop {
            waiting.retain_mut(|(patience, child)| {
                if child.ended().is_some() {
                    return false;
                }
                // The time in which a debugger holds it is not its own.
                let is_held = Reading::of(child.pid()).is_some_and(|it| it.doing == Doing::Traced);
                let limit = if is_held { STOP_LIMIT } else { STARVED_LIMIT };
                let is_over = patience.is_over(STOP_LIMIT) || asked.elapsed() > limit;
                if is_over {
                    killed.push(child.role);
                    child.signal(Signal::KILL);
                    child.wait(STOP_LIMIT);
                }
                !is_over
            });
            let Some((_, child)) = waiting.first_mut() else {
                return killed;
            };
            child.wait(LOOK_EVERY);
        }
    }
}

impl Drop for Stack {
    fn drop(&mut self) {
        self.stop_processes();
        self.children.clear();
        self.beside = None;
    }
}

/// Ends the processes and removes the domain with everything in it.
///
/// The ports must be gone before the middleware's node, and the node before the lock.
pub fn close(mut stack: Stack) {
    stack.stop_processes();
    stack.children.clear();
    stack.beside = None;
    let strays = descendants::end(stack.root());
    if !strays.is_empty() {
        tracing::warn!(pids = ?strays, "processes that services had started were ended");
    }
    let deleted = stack.is_deleted();
    let (peer, topics) = (stack.peer.take(), stack.topics.take());
    let domain = if deleted || stack.cleaner.has_failed() {
        // Closing a port touches files that may be corrupt or gone. They go with the domain, and the memory
        // with this process.
        stack.cleaner = Cleaner::new(Path::new("/"));
        core::mem::forget((stack, topics));
        peer.map(Peer::abandon)
    } else {
        drop(stack);
        drop(topics);
        peer.map(Peer::leave)
    };
    let Some(domain) = domain else { return };
    let root = domain.root().to_owned();
    if let Err(error) = domain.close() {
        tracing::warn!(root = %root.display(), %error, "the domain could not be removed");
    }
}
