//! Processor time and memory of processes, as the kernel counts them.

use std::collections::BTreeMap;
use std::time::Instant;

/// Ticks of the kernel's counters in a second, on every Linux that Rust supports.
const TICKS_PER_S: f64 = 100.0;

/// What a process uses.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Usage {
    /// Share of one processor since the look before. [%]
    pub cpu_percent: f64,
    /// Resident memory. [bytes]
    pub memory_bytes: u64,
}

/// Remembers the last look at each process.
#[derive(Debug, Default)]
pub(crate) struct Usages {
    before: BTreeMap<u32, (u64, Instant)>,
}

impl Usages {
    /// Looks at a process; `None` when it is gone.
    #[allow(
        clippy::cast_precision_loss,
        reason = "ticks of a process's life are far below 2^53"
    )]
    pub(crate) fn look(&mut self, pid: u32) -> Option<Usage> {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
        let (ticks, now) = (ticks(&stat)?, Instant::now());
        let before = self.before.insert(pid, (ticks, now));
        let cpu_percent = before.map_or(0.0, |(before, since)| {
            let elapsed_s = now.duration_since(since).as_secs_f64().max(1.0e-3);
            ticks.saturating_sub(before) as f64 / TICKS_PER_S / elapsed_s * 100.0
        });
        Some(Usage {
            cpu_percent,
            memory_bytes: resident_bytes(&status)?,
        })
    }

    /// Forgets all processes but these.
    pub(crate) fn keep(&mut self, pids: &[u32]) {
        self.before.retain(|pid, _| pids.contains(pid));
    }
}

/// User and system time in a `/proc/PID/stat`, whose name in parentheses may hold anything.
fn ticks(stat: &str) -> Option<u64> {
    let mut words = stat.rsplit(") ").next()?.split(' ').skip(11);
    let user: u64 = words.next()?.parse().ok()?;
    let system: u64 = words.next()?.parse().ok()?;
    Some(user + system)
}

/// Resident memory in a `/proc/PID/status`; `None` of a process that has ended. [bytes]
fn resident_bytes(status: &str) -> Option<u64> {
    let mut lines = status.lines();
    let kibibytes = lines.find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kibibytes: u64 = kibibytes.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_found_behind_any_name() {
        let stat = "7 (a b) c) S 1 7 7 0 -1 4194560 1 0 0 0 31 11 0 0 20 0 1 0 100 0 0";
        assert_eq!(ticks(stat), Some(42));
        assert_eq!(ticks("7"), None);
        let status = "Name:\ta\nVmHWM:\t  9 kB\nVmRSS:\t   12 kB\nThreads:\t1\n";
        assert_eq!(resident_bytes(status), Some(12 * 1024));
        assert_eq!(resident_bytes("Name:\ta\n"), None);
    }

    #[test]
    fn this_process_uses_memory_and_a_foreign_number_nothing() {
        let mut usages = Usages::default();
        let own = std::process::id();
        assert!(usages.look(own).expect("it is there").memory_bytes > 0);
        assert_eq!(usages.look(u32::MAX), None);
        usages.keep(&[]);
        assert!(usages.before.is_empty());
    }
}
