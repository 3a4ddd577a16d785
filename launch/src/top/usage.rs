//! What a process takes: processor time and memory, as the kernel counts them.

use super::view::Usage;
use crate::disturbance::processor_ns;

/// One reading of a process.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Reading {
    /// The process.
    pub pid: u32,
    /// When it was read, monotonic. [ns]
    pub at_ns: u64,
    /// Time that its threads have run. [ns]
    pub processor_ns: u64,
    /// Resident memory. [bytes]
    pub memory_bytes: u64,
}

impl Reading {
    /// Reads a process; `None` when there is none with this id.
    pub(super) fn of(pid: u32, at_ns: u64) -> Option<Self> {
        let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
        Some(Self {
            pid,
            at_ns,
            processor_ns: processor_ns(pid)?,
            memory_bytes: resident_bytes(&status)?,
        })
    }

    /// What the process takes, by this reading and an earlier one.
    pub(super) fn since(&self, before: Option<&Self>) -> Usage {
        let before = before.filter(|before| before.pid == self.pid && before.at_ns < self.at_ns);
        Usage {
            pid: self.pid,
            cpu_percent: before.map(|before| {
                let ran_ns = self.processor_ns.saturating_sub(before.processor_ns);
                percent(ran_ns, self.at_ns - before.at_ns)
            }),
            memory_bytes: Some(self.memory_bytes),
        }
    }
}

/// Share of `of_ns` in per cent, to a tenth.
#[allow(clippy::cast_precision_loss, reason = "times of a session")]
fn percent(ns: u64, of_ns: u64) -> f64 {
    (1.0e3 * ns as f64 / of_ns as f64).round() / 10.0
}

/// From a `/proc/PID/status`; `None` of a process that has ended. [bytes]
fn resident_bytes(status: &str) -> Option<u64> {
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kibibytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_that_of_the_same_process() {
        let reading = |pid, at_ns, processor_ns| Reading {
            pid,
            at_ns,
            processor_ns,
            memory_bytes: 4096,
        };
        let now = reading(7, 2_000_000_000, 260_000_000);
        let usage = now.since(Some(&reading(7, 1_000_000_000, 10_000_000)));
        assert_eq!(usage.cpu_percent, Some(25.0));
        assert_eq!(usage.memory_bytes, Some(4096));
        let other = now.since(Some(&reading(8, 1_000_000_000, 10_000_000)));
        assert_eq!(other.cpu_percent, None, "a process before it");
        assert_eq!(now.since(Some(&now)).cpu_percent, None, "no time between");
        assert_eq!(now.since(None).cpu_percent, None);
    }

    #[test]
    fn a_process_is_read_and_a_missing_one_is_none() {
        let own = Reading::of(std::process::id(), 5).expect("this process");
        assert!(own.memory_bytes > 100_000, "{own:?}");
        assert_eq!(Reading::of(u32::MAX, 5), None);
        assert_eq!(
            resident_bytes("Name:\tx\nVmRSS:\t  12 kB\n"),
            Some(12 * 1024)
        );
        assert_eq!(resident_bytes("Name:\tx\nState:\tZ (zombie)\n"), None);
    }
}
