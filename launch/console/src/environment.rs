//! The machine under a run.

use crate::terminal::note;
use crate::version::VERSION;
use zeronav_casts::Cast;
use zeronav_measure::result::Environment;

/// Readings at the start of a run; the rest is read at its end.
#[derive(Debug, Clone, Copy)]
pub struct Before {
    load: f64,
    processor_ticks: (u64, u64),
}

impl Before {
    /// Reads load and processor time.
    #[must_use]
    pub fn read() -> Self {
        Self {
            load: load(),
            processor_ticks: processor_ticks(),
        }
    }

    /// What the run was made with and on.
    #[must_use]
    pub fn environment(self) -> Environment {
        Environment {
            version: VERSION.to_owned(),
            build: if cfg!(debug_assertions) {
                "debug"
            } else {
                "release"
            }
            .to_owned(),
            cpu: line_of("/proc/cpuinfo", "model name"),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            kernel: read("/proc/sys/kernel/osrelease").trim().to_owned(),
            load_start: self.load,
            load_end: load(),
            steal: steal(self.processor_ticks, processor_ticks()),
        }
    }
}

fn read(file: &str) -> String {
    std::fs::read_to_string(file).unwrap_or_default()
}

fn line_of(file: &str, key: &str) -> String {
    read(file)
        .lines()
        .find_map(|line| line.strip_prefix(key))
        .map_or_else(String::new, |rest| {
            rest.trim_start_matches([' ', '\t', ':']).to_owned()
        })
}

/// Load average of the last minute.
#[must_use]
pub fn load() -> f64 {
    read("/proc/loadavg")
        .split(' ')
        .next()
        .and_then(|word| word.parse().ok())
        .unwrap_or(0.0)
}

/// What a busy machine means for times that were measured or kept, for the end of a line; `None` when it
/// has a core for everybody.
pub fn busy() -> Option<String> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    busy_at(load(), cores)
}

/// Warns before times are measured on a busy machine.
pub fn warn_when_busy() {
    if let Some(busy) = busy() {
        note(&format!("warning: {busy}"));
    }
}

fn busy_at(load: f64, cores: usize) -> Option<String> {
    let most = u32::try_from(cores).map_or(f64::MAX, f64::from);
    (load > most).then(|| {
        format!(
            "load average {load:.1} on {cores} cores: on an idle machine it may come out otherwise"
        )
    })
}

/// Ticks of all processors together, and those that the host gave to others.
#[must_use]
pub fn processor_ticks() -> (u64, u64) {
    let text = read("/proc/stat");
    let fields: Vec<u64> = text
        .lines()
        .next()
        .unwrap_or("")
        .split_ascii_whitespace()
        .skip(1)
        .filter_map(|word| word.parse().ok())
        .collect();
    (
        fields.iter().take(8).sum(),
        fields.get(7).copied().unwrap_or(0),
    )
}

/// Share of the processors' time that the host gave to others between two readings of
/// [`processor_ticks`], 0 to 1.
#[must_use]
pub fn steal(before: (u64, u64), after: (u64, u64)) -> f64 {
    let all = after.0.saturating_sub(before.0);
    let stolen = after.1.saturating_sub(before.1);
    if all == 0 {
        0.0
    } else {
        stolen.to_f64() / all.to_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::busy_at;

    #[test]
    fn a_machine_with_more_to_do_than_cores_is_busy() {
        assert_eq!(busy_at(2.0, 2), None);
        let said = busy_at(8.04, 2).expect("busy");
        assert!(said.starts_with("load average 8.0 on 2 cores: "), "{said}");
    }
}
