//! What a process does with its time: it computes, it is blocked, or it waits for a processor.
//!
//! A process that waits for a processor is not to blame for it: the machine is busy. So what a process
//! may take is judged by its own time, which is what it computed and what it was blocked. [`OwnTime`]
//! is pure over readings of the kernel's counters. Time in which a debugger holds a process is nobody's.

use core::time::Duration;
use std::path::Path;
use std::time::Instant;

/// Longest time between two looks that counts as blocked: beyond it launch itself was kept waiting.
const LOOK_MAX: Duration = Duration::from_millis(20);

/// The same where launch looks less often.
const SLOW_LOOK_MAX: Duration = Duration::from_millis(200);

/// Between two readings: the kernel counts computing at its ticks, up to 10 ms late.
const READ_EVERY: Duration = Duration::from_millis(20);

/// Unit of the times in `/proc/PID/stat`. [ns]
const JIFFY_NS: u64 = 10_000_000;

/// What a process was doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Doing {
    /// It sleeps until something happens.
    Blocked,
    /// The kernel lets it wait for a device, such as a page from a disk.
    Device,
    /// A signal has stopped it.
    Stopped,
    /// It runs, or waits for a processor.
    Runnable,
    /// A debugger has stopped it: for as long as somebody likes to look at it.
    Traced,
}

/// One reading of the kernel's counters of a process, all threads together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reading {
    /// Process id, and when the process began, in the kernel's units: ids are used again.
    pub id: (u32, u64),
    /// Its process group.
    pub group: u32,
    /// What it was doing: of several threads, that of the busiest.
    pub doing: Doing,
    /// Processor time. [ns]
    pub ran_ns: u64,
    /// Time in a run queue, as far as that has ended. [ns]
    pub waited_ns: u64,
}

impl Reading {
    /// What the kernel says of a process; `None` when it is not there, or cannot be seen.
    #[must_use]
    pub fn of(pid: u32) -> Option<Self> {
        let process = Path::new("/proc").join(pid.to_string());
        let stat = std::fs::read_to_string(process.join("stat")).ok()?;
        let whole = Thread::parse(&stat, None)?;
        let mut reading = Self {
            id: (pid, whole.began),
            group: whole.group,
            doing: Doing::Blocked,
            ran_ns: 0,
            waited_ns: 0,
        };
        for task in std::fs::read_dir(process.join("task")).ok()?.flatten() {
            let read = |name: &str| std::fs::read_to_string(task.path().join(name)).ok();
            // A thread may end meanwhile.
            let thread =
                read("stat").and_then(|stat| Thread::parse(&stat, read("schedstat").as_deref()));
            let Some(thread) = thread else { continue };
            reading.doing = reading.doing.max(thread.doing?);
            reading.ran_ns += thread.ran_ns;
            reading.waited_ns += thread.waited_ns;
        }
        Some(reading)
    }
}

/// What the kernel says of a thread.
#[derive(Debug)]
struct Thread {
    /// `None` when it has ended.
    doing: Option<Doing>,
    group: u32,
    began: u64,
    ran_ns: u64,
    waited_ns: u64,
}

impl Thread {
    /// Reads `stat`, and `schedstat` where the kernel has one.
    fn parse(stat: &str, schedstat: Option<&str>) -> Option<Self> {
        // The name in brackets may hold anything.
        let fields: Vec<&str> = stat.rsplit_once(") ")?.1.split_ascii_whitespace().collect();
        let number = |at: usize| fields.get(at)?.parse::<u64>().ok();
        let doing = match *fields.first()? {
            "R" => Some(Doing::Runnable),
            "T" => Some(Doing::Stopped),
            "t" => Some(Doing::Traced),
            "D" => Some(Doing::Device),
            "Z" | "X" | "x" => None,
            _ => Some(Doing::Blocked),
        };
        let times: Option<Vec<u64>> = schedstat.and_then(|text| {
            let numbers = text.split_ascii_whitespace().take(2);
            numbers.map(|number| number.parse().ok()).collect()
        });
        let (ran_ns, waited_ns) = match times.as_deref() {
            Some([ran_ns, waited_ns]) => (*ran_ns, *waited_ns),
            _ => ((number(11)? + number(12)?).saturating_mul(JIFFY_NS), 0),
        };
        Some(Self {
            doing,
            group: u32::try_from(number(2)?).ok()?,
            began: number(19)?,
            ran_ns,
            waited_ns,
        })
    }
}

/// Where the time of a process went since it began to be looked at.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OwnTime {
    last: Option<Reading>,
    /// Time since the last reading, and how much of it launch was awake.
    pending: (Duration, Duration),
    /// What it computed more than there was time: the kernel counts late.
    carry: Duration,
    /// It computed.
    pub ran: Duration,
    /// It slept or was stopped, while launch was awake.
    pub blocked: Duration,
    /// It waited for a device, while launch was awake.
    pub device: Duration,
    /// It waited for a processor.
    pub waited: Duration,
}

impl OwnTime {
    /// Begins with this reading.
    #[must_use]
    pub fn since(reading: Option<Reading>) -> Self {
        Self {
            last: reading,
            ..Self::default()
        }
    }

    /// The same after it was blocked for so long.
    #[must_use]
    pub fn after(blocked: Duration, reading: Option<Reading>) -> Self {
        Self {
            blocked,
            ..Self::since(reading)
        }
    }

    /// One look, `elapsed` after the one before, of which launch was awake for `awake`. The kernel is
    /// asked every `READ_EVERY`. A process that cannot be seen counts as blocked. Between readings of
    /// which one is of another process, or whose counters went backwards because a thread has ended,
    /// nothing counts.
    pub fn add(
        &mut self,
        elapsed: Duration,
        awake: Duration,
        reading: impl FnOnce() -> Option<Reading>,
    ) {
        self.pending.0 += elapsed;
        self.pending.1 += awake;
        if self.pending.0 < READ_EVERY {
            return;
        }
        let (elapsed, awake) = core::mem::take(&mut self.pending);
        let now = reading();
        match (core::mem::replace(&mut self.last, now), now) {
            (Some(before), Some(now)) if now.id == before.id => {
                let ran = now.ran_ns.checked_sub(before.ran_ns);
                let waited = now.waited_ns.checked_sub(before.waited_ns);
                if let Some((ran_ns, waited_ns)) = ran.zip(waited) {
                    let [ran, waited] = [ran_ns, waited_ns].map(Duration::from_nanos);
                    self.count(elapsed, awake, [ran, waited], now.doing);
                }
            }
            (None, None) => self.blocked += awake,
            _ => {}
        }
    }

    fn count(&mut self, elapsed: Duration, awake: Duration, used: [Duration; 2], doing: Doing) {
        let [ran, waited] = used;
        let whole = self.carry + ran;
        // Several threads do not make the time longer.
        let ran = whole.min(elapsed);
        self.carry = whole.saturating_sub(ran).min(READ_EVERY);
        let waited = waited.min(elapsed.saturating_sub(ran));
        let still = awake.saturating_sub(ran + waited);
        self.ran += ran;
        self.waited += match doing {
            // The kernel counts a wait when it is over.
            Doing::Runnable => elapsed.saturating_sub(ran),
            _ => waited,
        };
        match doing {
            Doing::Runnable | Doing::Traced => {}
            Doing::Blocked | Doing::Stopped => self.blocked += still,
            Doing::Device => self.device += still,
        }
    }

    /// What counts against a limit: its own time, without that in the run queue.
    #[must_use]
    pub fn total(&self) -> Duration {
        self.ran + self.blocked + self.device
    }
}

/// How much of `since` launch can have been awake when it looks all the time.
#[must_use]
pub fn awake(since: Duration) -> Duration {
    since.min(LOOK_MAX)
}

/// Own time of a process that has to get something done, such as to start.
#[derive(Debug, Clone)]
pub struct Patience {
    pid: u32,
    looked: Instant,
    spent: OwnTime,
}

impl Patience {
    /// With the process `pid`, from now on.
    #[must_use]
    pub fn with(pid: u32) -> Self {
        Self {
            pid,
            looked: Instant::now(),
            spent: OwnTime::since(Reading::of(pid)),
        }
    }

    /// One look; true when it has spent more than `limit` of its own time.
    pub fn is_over(&mut self, limit: Duration) -> bool {
        let since = self.looked.elapsed();
        self.looked = Instant::now();
        let reading = || Reading::of(self.pid);
        self.spent.add(since, since.min(SLOW_LOOK_MAX), reading);
        self.spent.total() > limit
    }
}

#[cfg(test)]
mod tests;
