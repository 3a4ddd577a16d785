//! How a stack ends.

use super::Stack;
use crate::cleaner::Cleaner;
use crate::descendants;
use std::path::Path;
use std::time::{Duration, Instant};
use zeronav_msgs::role::Role;
use zeronav_shell::Peer;

/// How long a process may take to stop before it is killed.
const STOP_LIMIT: Duration = Duration::from_secs(2);

impl Stack {
    /// Ends the processes: asks, waits, kills. Returns those that had to be killed.
    pub fn stop_processes(&mut self) -> Vec<Role> {
        let mut killed = Vec::new();
        for child in self.children.iter_mut().chain(&mut self.beside) {
            child.memory_peak_bytes();
            child.scheduling();
            child.signal(rustix::process::Signal::TERM);
        }
        let deadline = Instant::now() + STOP_LIMIT;
        for child in self.children.iter_mut().chain(&mut self.beside) {
            if !child.wait(deadline.saturating_duration_since(Instant::now())) {
                killed.push(child.role);
                child.signal(rustix::process::Signal::KILL);
                child.wait(STOP_LIMIT);
            }
        }
        killed
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
