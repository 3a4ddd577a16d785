//! Starts the recorder of a run, and waits until it records.

mod parameters;

use crate::companions::{Companions, Invocation, Plan};
use crate::prepare::Prepared;
use crate::recorder::{BINARY, DrivenBy, RecordedTicks, START_LIMIT, WALL_LIMIT, last_words};
use parameters::Asked;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use zeronav_console::artifacts;
use zeronav_scenario::companions::RECORDER;
use zeronav_supervise::binaries;
use zeronav_supervise::own_time::Patience;
use zeronav_supervise::stack::Stack;

/// Starts the recorder of the run that is prepared, which is to be recorded in `file`, and waits until it records: a run
/// that shall be recorded and cannot be does not begin. The configurations are those of companions.
///
/// # Errors
/// One line when the recorder does not work.
pub(crate) fn start_recorder(
    companions: &mut Companions,
    stack: &mut Stack,
    prepared: &Prepared,
    file: PathBuf,
    (driven_by, configs): (DrivenBy, &BTreeMap<String, PathBuf>),
) -> Result<RecordedTicks, String> {
    let log = prepared.log(format!("{RECORDER}.log"));
    let plan = Plan {
        name: RECORDER.to_owned(),
        binary: binaries::find(Path::new(BINARY))?,
        restarts: 0,
        log: log.clone(),
        invocation: Invocation::Recording {
            scenario: write_scenario(prepared)?,
            driven_by,
            parameters: write_parameters(stack, prepared, configs)?,
            logs: prepared.logs.path().to_owned(),
            // A bag has one recording.
            is_bag: Some(&file) == prepared.recording.as_ref()
                && file.parent() == Some(prepared.folder.path()),
            file,
        },
    };
    companions.start(stack, plan);
    let (pid, began) = (companions.pid_of(RECORDER), Instant::now());
    let mut patience = pid.map(Patience::with);
    loop {
        if let Some(progress) = stack.folder().and_then(RecordedTicks::open) {
            return Ok(progress);
        }
        if let Some(end) = companions.end_of(RECORDER) {
            let said = last_words(&log).unwrap_or_default();
            return Err(format!("the recorder does not work ({end}: {said})"));
        }
        let is_late = patience.as_mut().is_some_and(|it| it.is_over(START_LIMIT));
        if is_late || began.elapsed() > WALL_LIMIT {
            let limit_s = START_LIMIT.as_secs();
            return Err(format!("the recorder does not begin within {limit_s} s"));
        }
        // What was said before it joined reaches it so.
        stack.refresh();
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Leaves the scenario, with all that it builds on, in the run's folder.
fn write_scenario(prepared: &Prepared) -> Result<PathBuf, String> {
    let name = format!("{}.toml", prepared.scenario.name);
    let text = prepared.scenario.to_toml(prepared.seed)?;
    artifacts::write_in(&prepared.folder, &name, &text)?;
    Ok(prepared.folder.path().join(name))
}

/// Leaves what services and companions are started with in the run's folder.
fn write_parameters(
    stack: &Stack,
    prepared: &Prepared,
    configs: &BTreeMap<String, PathBuf>,
) -> Result<PathBuf, String> {
    let of_seats = prepared.binaries.iter().map(|(role, binary)| Asked {
        name: role.to_string(),
        binary,
        config: stack.root().join(format!("{role}.toml")),
    });
    let of_companions = prepared.companions.iter().filter_map(|(name, binary)| {
        Some(Asked {
            name: name.clone(),
            binary,
            config: configs.get(name)?.clone(),
        })
    });
    let asked: Vec<Asked<'_>> = of_seats.chain(of_companions).collect();
    parameters::write(&prepared.folder, &asked)
}
