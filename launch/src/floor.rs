//! The floor of the transport: the stack's own ring without computation.
//!
//! Five processes in a domain of their own, on the same shell, pass on messages of the size that
//! the stack's have, at the pace of the lidar. What they need from the capture of a scan to the
//! command is what transport, waking and records cost; no stack of these parts can be faster.

use crate::prepare::Prepared;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use zeronav_measure::Series;
use zeronav_measure::result::trials::Load;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunMode};
use zeronav_msgs::span::SpanKind;
use zeronav_supervise::binaries;
use zeronav_supervise::stack::{self, Launch, Stack};

/// Binary of a stage that does nothing.
const EMPTY_STAGE: &str = "zeronav-empty-stage";

/// Fewest and most cycles of one measurement.
const CYCLES: core::ops::RangeInclusive<u64> = 20..=100;

/// Cycles before them that are not counted.
const WARM_UP: u64 = 5;

/// How long the stages may take to be ready.
const READY_LIMIT: Duration = Duration::from_secs(15);

/// Configuration of an empty stage.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageConfig {
    /// Name of the seat that it takes.
    pub seat: String,
    /// What it passes on.
    pub load: Load,
}

/// Measures the floor: captured(scan) -> published(command) of the empty ring, some `cycles` times.
///
/// # Errors
/// One line when the ring could not be started or gave nothing.
pub fn measure(
    prepared: &Prepared,
    load: Load,
    cycles: u64,
    interrupted: &AtomicBool,
) -> Result<Series, String> {
    let cycles = cycles.clamp(*CYCLES.start(), *CYCLES.end());
    let binary = binaries::find(Path::new(EMPTY_STAGE))?;
    let clock = RunClock {
        mode: RunMode::RealTime.code(),
        seed: prepared.seed,
        tick_ns: prepared.scenario.run.tick_ns(),
        ..RunClock::default()
    };
    let mut ring = Stack::create(clock).map_err(|error| error.to_string())?;
    ring.scheduling = prepared.scenario.scheduling();
    let series = start(&mut ring, prepared, load, &binary)
        .and_then(|()| listen(&mut ring, load, cycles, interrupted));
    stack::close(ring);
    series
}

fn start(ring: &mut Stack, prepared: &Prepared, load: Load, binary: &Path) -> Result<(), String> {
    for role in Role::SERVICES {
        let stage = StageConfig {
            seat: role.to_string(),
            load,
        };
        let text = toml::to_string(&stage)
            .map_err(|error| format!("the stage's configuration has no TOML form: {error}"))?;
        let config = ring.root().join(format!("{role}.toml"));
        std::fs::write(&config, text)
            .map_err(|error| format!("writing {}: {error}", config.display()))?;
        if let Some(folder) = ring.folder() {
            let private = folder.make_files_private();
            private.map_err(|error| error.to_string())?;
        }
        let log = prepared.log(format!("floor-{role}.log"));
        let launch = Launch {
            binary,
            config: &config,
            log_level: &prepared.log_level,
            log: &log,
        };
        ring.start(role, &launch)
            .map_err(|error| error.to_string())?;
    }
    let started = Instant::now();
    loop {
        let missing = ring.not_ready();
        if missing.is_empty() {
            return Ok(());
        }
        if started.elapsed() > READY_LIMIT || ring.dead(None).is_some() {
            return Err(format!(
                "the empty ring did not get ready: {}; see {}",
                missing
                    .iter()
                    .map(|role| role.label())
                    .collect::<Vec<_>>()
                    .join(", "),
                prepared.logs.path().display()
            ));
        }
        ring.refresh();
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn listen(
    ring: &mut Stack,
    load: Load,
    cycles: u64,
    interrupted: &AtomicBool,
) -> Result<Series, String> {
    let wanted = WARM_UP + cycles;
    // Twice the time that it takes, and what starting may cost.
    let limit =
        Duration::from_nanos(load.period_ns.saturating_mul(2 * wanted)) + Duration::from_secs(5);
    let started = Instant::now();
    let mut captured_ns = BTreeMap::new();
    let mut commanded_ns = BTreeMap::new();
    let mut last = 0;
    while last < wanted + 1 && started.elapsed() < limit && !interrupted.load(Ordering::Relaxed) {
        ring.taps.spans.drain(|span| {
            if span.kind() != Some(SpanKind::Answer) {
                return;
            }
            match span.role() {
                Some(Role::Robot) => {
                    last = last.max(span.tick);
                    captured_ns.insert(span.tick, span.capture_ns);
                }
                Some(Role::CollisionGuard) => {
                    commanded_ns.insert(span.tick, span.published_ns);
                }
                _ => {}
            }
        });
        ring.refresh();
        std::thread::sleep(Duration::from_millis(10));
    }
    let mut series = Series::default();
    for tick in WARM_UP + 1..=wanted.min(last.saturating_sub(1)) {
        match (captured_ns.get(&tick), commanded_ns.get(&tick)) {
            (Some(from_ns), Some(to_ns)) => series.add(to_ns.saturating_sub(*from_ns)),
            (Some(_), None) => series.censor(),
            _ => {}
        }
    }
    if series.is_empty() && !interrupted.load(Ordering::Relaxed) {
        return Err("the empty ring did not turn".to_owned());
    }
    Ok(series)
}
