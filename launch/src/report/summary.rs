//! The head of a report: verdict, key figures, expectations.

use super::folder::{Outcome, RunFolder};
use super::html::{Cell, number, pairs, table, text_of, words};
use zeronav_measure::result::stay::StayResult;
use zeronav_measure::result::{Expectation, RunResult};

/// Title and verdict.
pub(super) fn head(run: &RunFolder) -> String {
    let (class, verdict, reason) = match &run.outcome {
        Outcome::Run(result) => {
            let class = if result.verdict == "pass" {
                "pass"
            } else {
                "fail"
            };
            (class, result.verdict.clone(), result.reason.clone())
        }
        Outcome::Stay(result) => ("stay", words(&result.outcome), goals_reached(result)),
    };
    let title = (run.recording.as_ref()).map_or("", |recording| &recording.title);
    format!(
        "<header><h1>{}</h1><p class=\"title\">{}</p><p class=\"verdict\"><b class=\"{class}\">{}</b> {}</p></header>\n",
        text_of(run.scenario()),
        text_of(title),
        text_of(&verdict),
        text_of(&reason)
    )
}

fn goals_reached(result: &StayResult) -> String {
    let reached = result.goals.iter().filter(|goal| goal.outcome == "reached");
    format!(
        "{} of {} goals reached",
        reached.count(),
        result.goals.len()
    )
}

/// The key figures.
pub(super) fn figures(run: &RunFolder) -> String {
    match &run.outcome {
        Outcome::Run(result) => of_run(result),
        Outcome::Stay(result) => pairs(&[
            ("run time", format!("{:.1} s", result.time_s)),
            ("wall time", format!("{:.1} s", result.wall_s)),
            ("goals", result.goals.len().to_string()),
            ("contacts", result.contacts.to_string()),
            ("restarts", result.restarts.len().to_string()),
            ("faults", result.faults.len().to_string()),
        ]),
    }
}

fn of_run(result: &RunResult) -> String {
    let metres = |value: Option<f64>, digits| {
        value.map_or_else(|| "–".to_owned(), |m| format!("{} m", number(m, digits)))
    };
    let mut all = vec![
        ("run time", format!("{:.1} s", result.time_s)),
        ("distance", format!("{:.1} m", result.driven_m)),
        ("contacts", result.contacts.to_string()),
        ("closest", metres(result.clearance_m_min, 2)),
        ("new paths", result.replans.len().to_string()),
        ("recoveries", result.recoveries.to_string()),
        ("guard stepped in", interventions(result)),
        ("mode", words(&result.mode)),
        ("speed", format!("{:.1} × real time", result.speed_factor)),
        ("seed", result.seed.to_string()),
    ];
    if let Some(jerk_mps3) = result.jerk_mps3 {
        all.push(("mean jerk", format!("{jerk_mps3:.2} m/s³")));
    }
    if let Some(pose) = &result.pose {
        all.push((
            "largest pose error",
            format!("{:.1} cm", 100.0 * pose.error_m_max),
        ));
    }
    if let Some(tracking) = &result.tracking {
        let found = tracking.found;
        let text = format!(
            "{found} found, {} missed, {} made up",
            tracking.missed, tracking.false_moving
        );
        all.push(("moving obstacles", text));
    }
    if let Some(cause) = &result.stuck_cause {
        all.push(("stuck because", words(cause)));
    }
    if result.slipped_ms > 0.0 {
        all.push(("run time slipped", format!("{:.1} ms", result.slipped_ms)));
    }
    if let Some(trials) = &result.trials {
        all.push(("trials", format!("{} of {}", trials.made, trials.wanted)));
    }
    for (seat, us) in &result.injected_us {
        all.push((
            "injected delay",
            format!("{} {:.2} ms", words(seat), us / 1.0e3),
        ));
    }
    pairs(&all)
}

fn interventions(result: &RunResult) -> String {
    if result.interventions == 0 {
        return "0".to_owned();
    }
    let by_reason = result.interventions_by_reason.iter();
    let by_reason: Vec<String> = by_reason
        .map(|(why, n)| format!("{n} {}", words(why)))
        .collect();
    by_reason.join(", ")
}

/// What was expected, and whether it came.
pub(super) fn expectations(expectations: &[Expectation]) -> String {
    let row = |expectation: &Expectation| {
        let (class, word) = if expectation.met {
            ("pass", "met")
        } else {
            ("fail", "missed")
        };
        vec![
            Cell::Html(format!("<b class=\"{class}\">{word}</b>")),
            Cell::text(words(&expectation.name)),
            Cell::text(expectation.expected.clone()),
            Cell::text(expectation.actual.clone()),
        ]
    };
    let rows: Vec<Vec<Cell>> = expectations.iter().map(row).collect();
    table(&["", "what", "expected", "came"], &rows)
}
