//! What disturbed a measurement, as the kernel counted it: load and steal of the machine, and for
//! each service how long it ran, how long it waited for a processor, and what interrupted it.

use std::collections::BTreeMap;
use zeronav_console::environment;
use zeronav_measure::distribution::to_us;
use zeronav_measure::result::trials::{Disturbance, ServiceDisturbance};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::Span;
use zeronav_observe::usage::Times;

/// Totals of one process, over those of its threads that live: what one ran that has ended since is
/// no longer counted by the kernel's files (services keep theirs until they end).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Counters {
    pid: u32,
    processor_ns: u64,
    queue_ns: u64,
    voluntary: u64,
    involuntary: u64,
    minor_faults: u64,
    major_faults: u64,
}

/// One reading of the kernel's counters.
#[derive(Debug, Clone, Default)]
pub(crate) struct Reading {
    load: f64,
    processor_ticks: (u64, u64),
    services: BTreeMap<Role, Counters>,
}

impl Reading {
    /// Reads the counters of these processes. One that has ended counts nothing.
    #[must_use]
    pub(crate) fn take(processes: impl Iterator<Item = (Role, u32)>) -> Self {
        Self {
            load: environment::load(),
            processor_ticks: environment::processor_ticks(),
            services: processes
                .filter_map(|(role, pid)| Some((role, Counters::read(pid)?)))
                .collect(),
        }
    }

    /// What happened since `before`. `spans` are the records of that time.
    #[must_use]
    pub(crate) fn since<'a>(
        &self,
        before: &Self,
        spans: impl Iterator<Item = &'a Span>,
    ) -> Disturbance {
        let mut longest_ns: BTreeMap<u16, u64> = BTreeMap::new();
        for span in spans {
            let longest = longest_ns.entry(span.role).or_default();
            *longest = (*longest).max(span.off_processor_ns);
        }
        let row = |(role, now): (&Role, &Counters)| {
            // A process that was started in between has counted from zero.
            let same = |then: &&Counters| then.pid == now.pid;
            let then = before.services.get(role).filter(same).copied();
            let then = then.unwrap_or_default();
            let longest_ns = longest_ns.get(&role.code()).copied().unwrap_or(0);
            ServiceDisturbance {
                name: role.to_string(),
                processor_us: to_us(now.processor_ns.saturating_sub(then.processor_ns)),
                queue_us: to_us(now.queue_ns.saturating_sub(then.queue_ns)),
                off_processor_us_max: to_us(longest_ns),
                voluntary_switches: now.voluntary.saturating_sub(then.voluntary),
                involuntary_switches: now.involuntary.saturating_sub(then.involuntary),
                minor_faults: now.minor_faults.saturating_sub(then.minor_faults),
                major_faults: now.major_faults.saturating_sub(then.major_faults),
            }
        };
        Disturbance {
            load_start: before.load,
            load_end: self.load,
            steal: environment::steal(before.processor_ticks, self.processor_ticks),
            services: self.services.iter().map(row).collect(),
        }
    }
}

impl Counters {
    /// `None` when there is no such process.
    fn read(pid: u32) -> Option<Self> {
        let folder = format!("/proc/{pid}");
        let stat = std::fs::read_to_string(format!("{folder}/stat")).ok()?;
        let times = Times::of(pid)?;
        let mut counters = Self {
            pid,
            processor_ns: times.ran_ns,
            queue_ns: times.waited_ns,
            ..Self::default()
        };
        counters.add_faults(&stat);
        // Switches are counted per thread.
        for thread in std::fs::read_dir(format!("{folder}/task")).ok()?.flatten() {
            let status = std::fs::read_to_string(thread.path().join("status"));
            counters.add_switches(&status.unwrap_or_default());
        }
        Some(counters)
    }

    /// From the line of `/proc/PID/stat`: see `proc_pid_stat(5)`, fields 10 and 12.
    fn add_faults(&mut self, stat: &str) {
        // The name in parentheses may hold anything; field 3 follows it.
        let fields = stat.rsplit(") ").next().unwrap_or("");
        let mut fields = fields.split_ascii_whitespace().skip(7);
        let mut next = || {
            fields
                .next()
                .and_then(|word| word.parse().ok())
                .unwrap_or(0)
        };
        self.minor_faults += next();
        next();
        self.major_faults += next();
    }

    /// From `status`.
    fn add_switches(&mut self, status: &str) {
        let count = |key: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(key));
            line.and_then(|rest| rest.trim().parse::<u64>().ok())
                .unwrap_or(0)
        };
        self.voluntary += count("voluntary_ctxt_switches:");
        self.involuntary += count("nonvoluntary_ctxt_switches:");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    #[test]
    fn the_kernels_lines_are_read_by_their_fields() {
        let mut counters = Counters::default();
        counters.add_faults("77 (a ) 9 b) S 1 77 77 0 -1 4194560 1234 11 56 22 300 400 0 0");
        counters.add_switches(
            "Name:\ta\nvoluntary_ctxt_switches:\t40\nnonvoluntary_ctxt_switches:\t6\n",
        );
        let expected = Counters {
            voluntary: 40,
            involuntary: 6,
            minor_faults: 1234,
            major_faults: 56,
            ..Counters::default()
        };
        assert_eq!(counters, expected);
    }

    #[test]
    fn a_reading_tells_differences_and_a_restarted_process_counts_from_zero() {
        let reading = |load, ticks, pid, waited_ns| Reading {
            load,
            processor_ticks: ticks,
            services: [(
                Role::Mapping,
                Counters {
                    pid,
                    queue_ns: waited_ns,
                    involuntary: waited_ns / 1000,
                    ..Counters::default()
                },
            )]
            .into(),
        };
        let before = reading(1.0, (1000, 10), 7, 40_000);
        let span = |role: Role, ns| Span {
            role: role.code(),
            off_processor_ns: ns,
            ..Span::default()
        };
        let spans = [
            span(Role::Mapping, 2_000),
            span(Role::Mapping, 9_000),
            span(Role::Robot, 50_000),
        ];
        let same = reading(3.0, (1200, 60), 7, 100_000).since(&before, spans.iter());
        assert_eq!((same.load_start, same.load_end), (1.0, 3.0));
        assert!((same.steal - 0.25).abs() < 1e-12, "{}", same.steal);
        let service = &same.services[0];
        assert_eq!((service.queue_us, service.involuntary_switches), (60.0, 60));
        assert!((service.off_processor_us_max - 9.0).abs() < 1e-9);
        let other = reading(3.0, (1200, 60), 8, 5_000).since(&before, [].iter());
        assert!((other.services[0].queue_us - 5.0).abs() < 1e-9);
    }

    #[test]
    fn a_running_process_is_read_and_a_missing_one_counts_nothing() {
        // Not this one: threads of other tests end while it is read.
        let mut busy = std::process::Command::new("sh")
            .args(["-c", "while :; do :; done"])
            .spawn()
            .expect("a shell");
        let roles = || [(Role::Mapping, busy.id()), (Role::Robot, u32::MAX)].into_iter();
        let before = Reading::take(roles());
        let until = Instant::now() + Duration::from_secs(60);
        let used = loop {
            std::thread::sleep(Duration::from_millis(5));
            let used = Reading::take(roles()).since(&before, [].iter());
            if used.services[0].processor_us > 0.0 || Instant::now() > until {
                break used;
            }
        };
        busy.kill().and_then(|()| busy.wait()).expect("it ran");
        assert_eq!(before.services.len(), 1, "only what runs is read");
        assert!(used.services[0].processor_us > 0.0, "{used:?}");
    }
}
