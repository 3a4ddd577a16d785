//! Why the robot did what it did at a moment of a run that is over.

use super::around::{Around, Missing};
use std::path::{Path, PathBuf};
use zeronav_files::read;
use zeronav_measure::result::fault::FaultResult;
use zeronav_measure::result::moment::Moment;
use zeronav_measure::result::{Restart, RunResult};
use zeronav_shell::printable;

/// A restart is told for so long after it. [s]
const RESTART_S: f64 = 1.0;

/// Largest file that is read. [bytes]
const RESULT_BYTES_MAX: u64 = 256 << 20;

/// The result of a run in its folder, or in the file itself.
///
/// # Errors
/// One line that names the file and what is wrong with it.
pub(super) fn read(run: &Path) -> Result<RunResult, String> {
    let file = if run.is_dir() {
        run.join("result.json")
    } else {
        run.to_owned()
    };
    let problem = |what: &str| format!("{}: {what}", printable(&file.display().to_string()));
    let text = read::text(&file, RESULT_BYTES_MAX)
        .map_err(|error| problem(&format!("{error}; give the folder of a run, see `runs/`")))?;
    let result: RunResult = serde_json::from_str(&text)
        .map_err(|error| problem(&format!("not the result of a run: {error}")))?;
    if result.reasons.is_empty() {
        return Err(problem(
            "holds no reasons: it is of trials, of a run without an answer, or of an older version",
        ));
    }
    Ok(result)
}

/// What held at `time_s`, or at the end.
///
/// # Errors
/// One line when the run has no such time.
pub(super) fn at(result: &RunResult, time_s: Option<f64>) -> Result<(Moment, Around), String> {
    let time_s = time_s.unwrap_or(result.time_s);
    if time_s > result.time_s {
        return Err(format!(
            "the run was over after {:.2} s; there is no {time_s} s",
            result.time_s
        ));
    }
    let until = (result.reasons).partition_point(|moment| moment.time_s <= time_s);
    let held = until
        .checked_sub(1)
        .and_then(|last| result.reasons.get(last));
    let Some(moment) = held else {
        let first_s = result.reasons.first().map_or(0.0, |first| first.time_s);
        return Err(format!(
            "no history for {time_s} s; the first moment is at {first_s:.2} s"
        ));
    };
    let mut moment = moment.clone();
    moment.time_s = time_s;
    // Where the robot was as fast as it really was: what was kept is from the begin of the moment.
    let row = result.motion.partition_point(|row| row[0] <= time_s);
    if let (Some(row), Some(command)) = (
        row.checked_sub(1).and_then(|last| result.motion.get(last)),
        &mut moment.command,
    ) {
        (command.v_mps, command.w_radps) = (row[4], row[5]);
    }
    Ok((moment, around(&result.restarts, &result.faults, time_s)))
}

/// What was known besides.
pub(super) fn around(restarts: &[Restart], faults: &[FaultResult], time_s: f64) -> Around {
    let lately = |at_s: f64| (0.0..RESTART_S).contains(&(time_s - at_s));
    let missing = restarts
        .iter()
        .filter(|restart| lately(restart.time_s))
        .map(|restart| Missing {
            role: restart.service.clone(),
            how: format!(
                "ended at {:.2} s ({}) and was started again",
                restart.time_s, restart.how
            ),
        });
    let goes_on = |fault: &&FaultResult| {
        let ends_s = fault.until_s.unwrap_or(fault.time_s + RESTART_S);
        fault.why.is_none() && (fault.time_s..ends_s).contains(&time_s)
    };
    let faults = faults.iter().filter(goes_on);
    Around {
        missing: missing.collect(),
        faults: faults
            .map(|fault| format!("{} {} {}", fault.kind, fault.target, fault.figures))
            .map(|fault| fault.trim_end().to_owned())
            .collect(),
        ..Around::default()
    }
}

/// The newest run in this folder.
///
/// # Errors
/// One line when there is none.
pub(super) fn newest(runs: &Path) -> Result<PathBuf, String> {
    let folders = std::fs::read_dir(runs).into_iter().flatten().flatten();
    let with_time = folders.filter_map(|entry| {
        let file = entry.path().join("result.json");
        Some((
            std::fs::metadata(&file).ok()?.modified().ok()?,
            entry.path(),
        ))
    });
    let newest = with_time.max_by_key(|(time, _)| *time);
    newest.map(|(_, folder)| folder).ok_or_else(|| {
        format!(
            "no run is in {}; give the folder of one",
            printable(&runs.display().to_string())
        )
    })
}
