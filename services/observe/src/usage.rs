//! What a process takes: processor time and memory, as the kernel counts them.

use serde::Serialize;
use std::collections::VecDeque;
use zeronav_casts::Cast;

/// Time over which the share of a processor is taken. [ns]
const WINDOW_NS: u64 = 2_000_000_000;

/// Times of a process, over those of its threads that live: what one ran that has ended since is no longer
/// counted by the kernel's files (services keep theirs until they end).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Times {
    /// On a processor. [ns]
    pub ran_ns: u64,
    /// Ready to run, waiting for a processor. [ns]
    pub waited_ns: u64,
}

impl Times {
    /// `None` when there is no such process.
    #[must_use]
    pub fn of(pid: u32) -> Option<Self> {
        let mut times = Self::default();
        for thread in std::fs::read_dir(format!("/proc/{pid}/task"))
            .ok()?
            .flatten()
        {
            let text = std::fs::read_to_string(thread.path().join("schedstat"));
            times.add(&text.unwrap_or_default());
        }
        Some(times)
    }

    /// Adds those of a thread, from its `schedstat`.
    fn add(&mut self, schedstat: &str) {
        let mut numbers = schedstat.split_ascii_whitespace().map(str::parse::<u64>);
        let mut next = || numbers.next().and_then(Result::ok).unwrap_or(0);
        self.ran_ns += next();
        self.waited_ns += next();
    }
}

/// One reading of a process.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Reading {
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
    #[must_use]
    pub fn of(pid: u32, at_ns: u64) -> Option<Self> {
        let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
        Some(Self {
            pid,
            at_ns,
            processor_ns: Times::of(pid)?.ran_ns,
            memory_bytes: resident_bytes(&status)?,
        })
    }
}

/// What a process takes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Usage {
    /// Its process id.
    pub pid: u32,
    /// Share of one processor, to a tenth; `None` before two readings. [%]
    pub cpu_percent: Option<f64>,
    /// Resident memory; `None` when the process is gone. [bytes]
    pub memory_bytes: Option<u64>,
}

/// The readings of a process over the last two seconds.
#[derive(Debug, Clone, Default)]
pub struct Meter {
    readings: VecDeque<Reading>,
}

impl Meter {
    /// Takes in a reading; `None` when the process is gone.
    pub fn read(&mut self, reading: Option<Reading>) {
        let last = self.readings.back();
        if last.map(|last| last.pid) != reading.map(|reading| reading.pid) {
            self.readings.clear();
        }
        let Some(reading) = reading else { return };
        self.readings.push_back(reading);
        while let Some(next) = self.readings.get(1)
            && reading.at_ns.saturating_sub(next.at_ns) >= WINDOW_NS
        {
            self.readings.pop_front();
        }
    }

    /// What the process with this id takes; nothing is known of another one than was read.
    #[must_use]
    pub fn usage(&self, pid: u32) -> Usage {
        let ends = self.readings.front().zip(self.readings.back());
        let ends = ends.filter(|(_, last)| last.pid == pid);
        Usage {
            pid,
            cpu_percent: ends.and_then(|(first, last)| share_percent(first, last)),
            memory_bytes: ends.map(|(_, last)| last.memory_bytes),
        }
    }
}

/// Share of one processor between two readings, to a tenth; `None` without time between them. [%]
fn share_percent(first: &Reading, last: &Reading) -> Option<f64> {
    let elapsed_ns = last.at_ns.checked_sub(first.at_ns).filter(|ns| *ns > 0)?;
    let ran_ns = last.processor_ns.saturating_sub(first.processor_ns);
    Some((1.0e3 * ran_ns.to_f64() / elapsed_ns.to_f64()).round() / 10.0)
}

/// From a `/proc/PID/status`; `None` of a process that has ended. [bytes]
fn resident_bytes(status: &str) -> Option<u64> {
    let mut lines = status.lines();
    let line = lines.find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_that_of_the_same_process_over_the_last_seconds() {
        let reading = |pid, at_s: u64, processor_ns| {
            Some(Reading {
                pid,
                at_ns: at_s * 1_000_000_000,
                processor_ns,
                memory_bytes: 4096,
            })
        };
        let mut meter = Meter::default();
        assert_eq!(meter.usage(7).memory_bytes, None);
        meter.read(reading(7, 1, 10_000_000));
        assert_eq!(meter.usage(7).cpu_percent, None, "no time between");
        meter.read(reading(7, 2, 260_000_000));
        let usage = meter.usage(7);
        assert_eq!(usage.cpu_percent, Some(25.0));
        assert_eq!(usage.memory_bytes, Some(4096));
        assert_eq!(meter.usage(8).memory_bytes, None, "another process");
        for at_s in 3..10 {
            meter.read(reading(7, at_s, 260_000_000));
        }
        assert_eq!(meter.usage(7).cpu_percent, Some(0.0));
        assert_eq!(meter.readings.len(), 3);
        meter.read(reading(8, 10, 0));
        assert_eq!(meter.usage(8).cpu_percent, None, "a process before it");
        meter.read(None);
        assert_eq!(meter.usage(8).memory_bytes, None, "it is gone");
    }

    #[test]
    fn the_kernels_lines_are_read_by_their_fields() {
        let mut times = Times::default();
        times.add("5000000 70000 12\n");
        times.add("1 2 3\n");
        times.add("");
        assert_eq!((times.ran_ns, times.waited_ns), (5_000_001, 70_002));
        let status = "Name:\ta\nVmHWM:\t  9 kB\nVmRSS:\t   12 kB\nThreads:\t1\n";
        assert_eq!(resident_bytes(status), Some(12 * 1024));
        assert_eq!(resident_bytes("Name:\tx\nState:\tZ (zombie)\n"), None);
    }

    #[test]
    fn a_process_is_read_and_a_missing_one_is_none() {
        let own = Reading::of(std::process::id(), 5).expect("this process");
        assert!(own.memory_bytes > 100_000, "{own:?}");
        assert_eq!(Reading::of(u32::MAX, 5), None);
    }
}
