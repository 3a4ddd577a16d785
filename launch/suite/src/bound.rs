//! What is possible: `zeronav suite --bound` drives nothing and plans a way through each run's world,
//! with the true future of everything that moves known.
//!
//! The robot is the scenario's with its true outline, its limits of speed and acceleration, and
//! wheels that do exactly what they are told. A way that is found is a proof that the run can be
//! driven without any contact; that none was found proves nothing, because the search is bounded.

mod crowd;
mod search;
mod velocity_pairs;
mod way;

use super::case::{Case, Success};
use super::error::SuiteError;
use super::future::Future;
use super::row::Row;
use super::score::{RULES, score};
use super::track::turning_rad;
use super::turns::Turns;
use core::f64::consts::PI;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};
use way::{Route, Task};
use zeronav_console::progress::{ProgressLine, Tally};
use zeronav_console::terminal::note;
use zeronav_scenario::Outcome;
use zeronav_supervise::process::hint;

/// Between two looks at what was found.
const PAUSE: Duration = Duration::from_millis(100);

/// The row of each case, planned on `jobs` threads.
///
/// # Errors
/// One line when the future of a case is not known, or there is no one goal to plan to; an
/// interruption.
pub(super) fn rows(
    cases: &[Case],
    jobs: usize,
    progress: bool,
    interrupted: &AtomicBool,
) -> Result<Vec<Row>, SuiteError> {
    // Before the first search, which may take long. Seeds may share a scenario.
    let mut seen = BTreeSet::new();
    let own = |case: &&Case| case.rule.way.exists().is_none();
    for case in cases
        .iter()
        .filter(own)
        .filter(|case| seen.insert(&case.scenario))
    {
        target(case, &Future::of(&case.scenario)?)?;
    }
    let mut rows: Vec<Option<Result<Row, String>>> = vec![None; cases.len()];
    let mut line = ProgressLine::new("bound", progress);
    let (began, next) = (Instant::now(), AtomicUsize::new(0));
    let next_case = || {
        let index = next.fetch_add(1, Ordering::Relaxed);
        Some((index, cases.get(index)?))
    };
    let plan = |sender: mpsc::Sender<(usize, Result<Row, String>)>| {
        while let Some((index, case)) = next_case() {
            let row = row_of(case, interrupted);
            // Nobody waits any more when this fails.
            if interrupted.load(Ordering::Relaxed) || sender.send((index, row)).is_err() {
                break;
            }
        }
    };
    std::thread::scope(|scope| {
        let (sender, found) = mpsc::channel();
        let jobs = jobs.min(cases.len());
        for job in 0..jobs {
            let (sender, plan) = (sender.clone(), &plan);
            let planner = std::thread::Builder::new().spawn_scoped(scope, move || plan(sender));
            if let Err(error) = planner {
                // With fewer threads it takes longer, and without any there is nothing.
                if job == 0 {
                    return Err(format!("no thread to plan ways: {error}{}", hint(&error)));
                }
                let hint = hint(&error);
                note(&format!("warning: {job} of {jobs} threads: {error}{hint}"));
                break;
            }
        }
        drop(sender);
        let (mut done, mut passed) = (0, 0);
        loop {
            match found.recv_timeout(PAUSE) {
                Ok((index, row)) => {
                    done += 1;
                    passed += usize::from(row.as_ref().is_ok_and(|row: &Row| row.success));
                    rows[index] = Some(row);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            let done_s = began.elapsed().as_secs_f64();
            let tally = Tally {
                done,
                total: cases.len(),
                each_s: (done > 0).then(|| done_s / f64::from(u32::try_from(done).unwrap_or(1))),
            };
            line.show(|| format!("{}  {passed} found", tally.in_words("ways")));
        }
        Ok(())
    })?;
    line.clear();
    if interrupted.load(Ordering::Relaxed) {
        return Err(SuiteError::Interrupted(None));
    }
    let rows = rows.into_iter().flatten();
    Ok(rows.collect::<Result<Vec<Row>, String>>()?)
}

/// Plans one case.
fn row_of(case: &Case, interrupted: &AtomicBool) -> Result<Row, String> {
    if case.rule.way.exists().is_some() {
        return Ok(of_outline(case, case.rule.way.found()));
    }
    let began = Instant::now();
    let future = Future::of(&case.scenario)?;
    let (goal_m, tolerance_m) = target(case, &future)?;
    let task = Task {
        world: &future.world,
        movers: &future.movers,
        abilities: &future.abilities,
        start: future.scenario.start,
        goal_m,
        tolerance_m,
        time_limit_s: case.time_limit_s,
    };
    let way = search::find(&task, interrupted);
    let row = way.map_or_else(|| not_found(case), |way| found(case, &task, &way));
    Ok(Row {
        unavoidable: case.rule.future_is_known.then_some(0),
        wall_s: Some(began.elapsed().as_secs_f64()),
        ..row
    })
}

/// The row of a case for which the way of the outline among what stands was looked for.
fn of_outline(case: &Case, way: Option<&Turns>) -> Row {
    let Some(way) = way else {
        return not_found(case);
    };
    Row {
        success: true,
        arrived: true,
        outcome: Some("reached".to_owned()),
        time_s: Some(way.time_s),
        driven_m: Some(way.length_m),
        ..Row::of(case)
    }
}

/// Goal and tolerance. [m]
fn target(case: &Case, future: &Future) -> Result<([f64; 2], f64), String> {
    if let Success::Arrival {
        goal_m,
        tolerance_m,
        ..
    } = case.rule.success
    {
        return Ok((goal_m, tolerance_m));
    }
    let arrives = future.scenario.expect.outcome == Outcome::Reached;
    match &future.scenario.goals[..] {
        [only] if arrives && only.yaw_tolerance_rad >= PI => {
            Ok(([only.pose.x_m, only.pose.y_m], only.tolerance_m))
        }
        _ => Err(format!(
            "{}: a way can only be planned where one goal, with any yaw, is to be reached",
            case.world
        )),
    }
}

/// The row of a case through which no way was found.
fn not_found(case: &Case) -> Row {
    let nothing = case.rule.optimal_time_s.map(|_| 0.0);
    Row {
        cause: Some("none found".to_owned()),
        score: nothing,
        score_4ot: nothing,
        ..Row::of(case)
    }
}

/// The row of a case through which this way leads.
fn found(case: &Case, task: &Task<'_>, way: &Route) -> Row {
    let track: Vec<[f64; 2]> = way.states.iter().map(|state| state.at_m).collect();
    let motion: Vec<[f64; 6]> = way
        .states
        .iter()
        .map(|state| {
            let [x, y] = state.at_m;
            [state.t_s, x, y, state.yaw_rad, state.v_mps, state.w_radps]
        })
        .collect();
    let clock_s = case.clock().and_then(|clock| clock.time_s(&motion));
    let by_rule = |fastest| {
        let time_s = clock_s.unwrap_or(f64::INFINITY);
        let optimal_time_s = case.rule.optimal_time_s?;
        Some(score(true, optimal_time_s, time_s, fastest))
    };
    let length_m = way.length_m();
    Row {
        success: true,
        outcome: Some("reached".to_owned()),
        arrived: true,
        time_s: Some(way.time_s()),
        clock_s,
        score: by_rule(RULES[0]),
        score_4ot: by_rule(RULES[1]),
        path_ratio: (case.rule.reference_m).map(|reference_m| length_m / reference_m),
        clearance_m_min: Some(way.clearance_m).filter(|clearance_m| clearance_m.is_finite()),
        turning_rad: Some(turning_rad(&track)),
        driven_m: Some(length_m),
        goal_distance_m: track.last().map(|end_m| task.to_goal_m(*end_m)),
        ..Row::of(case)
    }
}

#[cfg(test)]
mod tests;
