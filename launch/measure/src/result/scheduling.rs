//! How the kernel schedules a process.

use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// What the kernel says of the first thread of a service, and what it did not grant.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Scheduling {
    /// `other`, `batch`, `idle`, `fifo` or `rr`; the kernel's number of another one.
    pub policy: String,
    /// Real-time priority, 1 to 99; 0 for a policy without.
    pub priority: u32,
    /// Nice value, -20 to 19.
    pub nice: i32,
    /// Processors that it may use, such as `0-3,6`.
    pub cpus: String,
    /// True when its memory is locked.
    pub memory_locked: bool,
    /// What the scenario asks for and the kernel did not grant, in words.
    pub refused: Vec<String>,
}

impl Scheduling {
    /// In a few words: `fifo 10 on 0-1, memory locked`.
    #[must_use]
    pub fn in_words(&self) -> String {
        let mut words = self.policy.clone();
        if self.priority > 0 {
            let _ = write!(words, " {}", self.priority);
        }
        if self.nice != 0 {
            let _ = write!(words, ", nice {}", self.nice);
        }
        let _ = write!(words, " on {}", self.cpus);
        if self.memory_locked {
            words += ", memory locked";
        }
        words
    }
}
