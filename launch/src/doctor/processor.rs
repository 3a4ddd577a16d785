//! Whether a process gets a processor when it needs one.

use super::checks::{Finding, Level};
use std::time::{Duration, Instant};
use zeronav_console::environment;
use zeronav_supervise::own_time::Reading;

/// Time that is computed for, at most.
const COMPUTED: Duration = Duration::from_millis(30);

/// Time that the measurement may take.
const LIMIT: Duration = Duration::from_millis(400);

/// Share of the time in the run queue from which a stack is starved.
const WAITED_SHARE_MAX: f64 = 0.2;

/// What became of a process that had something to compute.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measured {
    computed: Duration,
    waited: Duration,
    /// Load average of the last minute.
    load: f64,
    cores: usize,
}

/// Computes for a moment.
pub(super) fn measure() -> Measured {
    let began = Instant::now();
    let read = || Reading::of(std::process::id());
    let before = read();
    let mut used = [Duration::ZERO; 2];
    while began.elapsed() < LIMIT && used[0] < COMPUTED {
        let mut sum = 0_u64;
        for step in 0..100_000 {
            sum = core::hint::black_box(sum.wrapping_add(step));
        }
        if let Some((before, now)) = before.zip(read()) {
            let since =
                |from_ns: u64, to_ns: u64| Duration::from_nanos(to_ns.saturating_sub(from_ns));
            used = [
                since(before.ran_ns, now.ran_ns),
                since(before.waited_ns, now.waited_ns),
            ];
        }
    }
    let [computed, waited] = used;
    Measured {
        computed,
        waited,
        load: environment::load(),
        cores: std::thread::available_parallelism().map_or(1, usize::from),
    }
}

/// Says whether that was enough.
pub(super) fn share(measured: &Measured) -> Finding {
    const CHECK: &str = "processor";
    let Measured {
        computed,
        waited,
        load,
        cores,
    } = *measured;
    let whole_s = (computed + waited).as_secs_f64();
    let share = if whole_s > 0.0 {
        waited.as_secs_f64() / whole_s
    } else {
        0.0
    };
    let on = format!("load average {load:.1} on {cores} cores");
    if share <= WAITED_SHARE_MAX {
        return Finding::ok(CHECK, format!("at once; {on}"));
    }
    Finding::bad(
        CHECK,
        Level::Warning,
        format!(
            "starved: to compute for {:.0} ms a process waited {:.0} ms for a processor; {on}",
            1.0e3 * computed.as_secs_f64(),
            1.0e3 * waited.as_secs_f64()
        ),
        "end what else runs, give the services a real-time policy ([services.X.scheduling]), or run \
         with --lockstep, which only takes longer",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_that_waits_for_a_processor_is_starved() {
        let measured = |computed_ms, waited_ms| Measured {
            computed: Duration::from_millis(computed_ms),
            waited: Duration::from_millis(waited_ms),
            load: 16.0,
            cores: 2,
        };
        let idle = share(&measured(30, 2));
        assert_eq!((idle.level, idle.fix), (Level::Ok, None));
        assert_eq!(share(&measured(0, 0)).level, Level::Ok);
        let starved = share(&measured(12, 48));
        assert_eq!(starved.level, Level::Warning);
        let words = "starved: to compute for 12 ms a process waited 48 ms";
        assert!(starved.seen.starts_with(words), "{}", starved.seen);
        assert!(starved.seen.ends_with("load average 16.0 on 2 cores"));
    }
}
