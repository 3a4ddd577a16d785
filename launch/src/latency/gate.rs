//! Holds assertions against measurements and a baseline.

use super::assertion::{Clause, Figure, Limit};
use super::report::{Assertion, Cell, Report};

/// What a clause needs of the baseline; looked for before anything is measured.
///
/// # Errors
/// One line with what is missing.
pub(super) fn check_baseline(
    clauses: &[Clause],
    baseline: Option<&Report>,
    cells: &[(Option<f64>, &str)],
) -> Result<(), String> {
    let ratios = || {
        let is_ratio = |clause: &&Clause| matches!(clause.limit, Limit::Ratio(_));
        clauses.iter().filter(is_ratio)
    };
    let Some(first) = ratios().next() else {
        return Ok(());
    };
    let Some(baseline) = baseline else {
        return Err(format!(
            "--assert: `{first}` is a ratio to a baseline: add --baseline FILE"
        ));
    };
    for (rate_hz, load) in cells {
        // Without a rate it is the scenario's, which the measurement tells.
        let of_load = || baseline.cells.iter().find(|cell| cell.load == *load);
        let rate_hz = rate_hz.or_else(|| of_load().map(|cell| cell.rate_hz));
        let Some(rate_hz) = rate_hz else {
            return Err(format!(
                "--assert: the baseline has no measurement of a machine that is {load}"
            ));
        };
        for clause in ratios() {
            reference(clause, baseline, rate_hz, load)?;
        }
    }
    Ok(())
}

/// The figure of the baseline that a clause is a ratio to.
fn reference(clause: &Clause, baseline: &Report, rate_hz: f64, load: &str) -> Result<f64, String> {
    let cell = baseline.cell(rate_hz, load).ok_or_else(|| {
        format!("--assert: the baseline has no measurement at {rate_hz} Hz, {load}")
    })?;
    let row = cell.row(&clause.row);
    let value = row.and_then(|row| clause.figure.of(&row.figures));
    value.filter(|value| *value > 0.0).ok_or_else(|| {
        format!(
            "--assert: the baseline has no {} at {rate_hz} Hz, {load}",
            clause.subject()
        )
    })
}

/// The first clause that no `trials` trials can tell.
pub(super) fn untold(clauses: &[Clause], trials: u32) -> Option<String> {
    let of_trials = |clause: &&Clause| {
        let name = clause.row.as_str();
        !name.starts_with("reaction") && !name.contains('.') && name != "transport_floor"
    };
    let mut few = clauses
        .iter()
        .filter(of_trials)
        .filter(|clause| u64::from(trials) < clause.figure.n_min());
    few.next().map(|clause| {
        format!(
            "--assert: {} cannot be said of {trials} trials: add --trials {}",
            clause.subject(),
            clause.figure.n_min()
        )
    })
}

/// Holds every clause against every measurement.
///
/// # Errors
/// One line when the baseline lacks what a ratio needs.
pub(super) fn hold(
    clauses: &[Clause],
    cells: &[Cell],
    baseline: Option<&Report>,
) -> Result<Vec<Assertion>, String> {
    let mut held = Vec::new();
    for cell in cells {
        for clause in clauses {
            held.push(hold_one(clause, cell, baseline)?);
        }
    }
    Ok(held)
}

fn hold_one(clause: &Clause, cell: &Cell, baseline: Option<&Report>) -> Result<Assertion, String> {
    let figures = cell.row(&clause.row).map(|row| row.figures);
    let figures = figures.unwrap_or_default();
    let measured = clause.figure.of(&figures);
    let is_ratio = matches!(clause.limit, Limit::Ratio(_));
    let reference = match baseline.filter(|_| is_ratio) {
        Some(baseline) => Some(reference(clause, baseline, cell.rate_hz, &cell.load)?),
        None => None,
    };
    let compared = match reference {
        Some(reference) => measured.map(|measured| measured / reference),
        None => measured.filter(|_| !is_ratio),
    };
    let n = figures.n;
    let said = match (measured, compared, reference) {
        (Some(measured), Some(ratio), Some(reference)) => format!(
            "{ratio:.3}x, {} against {}",
            value(clause.figure, measured),
            value(clause.figure, reference)
        ),
        (Some(measured), ..) => value(clause.figure, measured),
        (None, ..) => format!(
            "cannot be said of {n} samples, it takes {}",
            clause.figure.n_min()
        ),
    };
    Ok(Assertion {
        clause: clause.to_string(),
        rate_hz: cell.rate_hz,
        load: cell.load.clone(),
        met: compared.is_some_and(|compared| clause.is_met_by(compared)),
        measured,
        baseline: reference,
        n,
        said,
    })
}

/// A figure for people.
fn value(figure: Figure, value: f64) -> String {
    if figure.is_count() {
        format!("{value:.0}")
    } else {
        format!("{value:.0} us")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use zeronav_measure::result::RunResult;
    use zeronav_measure::result::latency::Figures;
    use zeronav_measure::result::profile::{CommandGaps, Profile, ProfileRow};

    /// A measurement in which replanning took `p50_us` at the median of `n` samples.
    fn report(n: u64, p50_us: f64) -> Report {
        let text = include_str!("../../measure/tests/data/result_trials.json");
        let mut result: RunResult = serde_json::from_str(text).expect("a result");
        let row = ProfileRow {
            name: "replanning".to_owned(),
            figures: Figures {
                n,
                censored: 0,
                p50_us: Some(p50_us),
                p90_us: Some(2.0 * p50_us),
                p99_us: Some(3.0 * p50_us),
                max_us: Some(4.0 * p50_us),
            },
            p50_interval_us: Some([0.9 * p50_us, 1.1 * p50_us]),
            p90_interval_us: None,
            p99_interval_us: None,
            p999_us: None,
        };
        result.profile = Some(Profile {
            rate_hz: 10.0,
            load: "idle".to_owned(),
            rows: vec![row],
            edges: Vec::new(),
            commands: CommandGaps::default(),
            answers: BTreeMap::default(),
        });
        let mut report = Report::new();
        report.cells.push(Cell::of(&result).expect("a measurement"));
        report
    }

    fn clauses(text: &str) -> Vec<Clause> {
        Clause::parse_all(text, &["replanning".to_owned()]).expect("an expression")
    }

    fn met(text: &str, report: &Report, baseline: Option<&Report>) -> Vec<bool> {
        let held = hold(&clauses(text), &report.cells, baseline).expect("held");
        held.iter().map(|one| one.met).collect()
    }

    #[test]
    fn a_clause_holds_or_names_what_was_measured() {
        let now = report(200, 2000.0);
        let text = "replanning.p50 < 2.1ms, replanning.p99 < 5ms, replanning.n >= 200";
        assert_eq!(met(text, &now, None), [true, false, true]);
        let held = hold(&clauses(text), &now.cells, None).expect("held");
        assert_eq!((held[1].said.as_str(), held[1].n), ("6000 us", 200));
        // What so few samples do not tell holds nothing, whatever the limit.
        let few = report(30, 2000.0);
        let text = "replanning.p99 < 1s, replanning.p99 > 0us";
        assert_eq!(met(text, &few, None), [false, false]);
        let held = hold(&clauses(text), &few.cells, None).expect("held");
        assert_eq!(held[0].said, "cannot be said of 30 samples, it takes 100");
    }

    #[test]
    fn a_ratio_is_to_the_same_figure_of_the_baseline() {
        let (now, before) = (report(200, 2300.0), report(200, 2000.0));
        let text = "replanning.p50 < 1.1x, replanning.p50 < 1.2x";
        assert_eq!(met(text, &now, Some(&before)), [false, true]);
        let held = hold(&clauses(text), &now.cells, Some(&before)).expect("held");
        assert_eq!(held[0].said, "1.150x, 2300 us against 2000 us");
        assert_eq!(met(text, &before, Some(&before)), [true, true]);
    }

    #[test]
    fn what_the_baseline_lacks_is_said_before_anything_is_measured() {
        let text = "replanning.p50 < 1.1x";
        let clauses = clauses(text);
        let before = report(200, 2000.0);
        let check = |baseline, cell| check_baseline(&clauses, baseline, &[cell]);
        assert_eq!(check(Some(&before), (Some(10.0), "idle")), Ok(()));
        let missing = check(None, (None, "idle")).expect_err("no baseline");
        assert!(missing.contains("--baseline FILE"), "{missing}");
        let missing = check(Some(&before), (Some(40.0), "idle")).expect_err("no rate");
        assert!(missing.contains("40 Hz"), "{missing}");
        let missing = check(Some(&before), (Some(10.0), "busy")).expect_err("no load");
        assert!(missing.contains("busy"), "{missing}");
        let missing = check(Some(&before), (None, "busy")).expect_err("no load");
        assert!(missing.contains("busy"), "{missing}");
        let few = report(1, 2000.0);
        let missing = check(Some(&few), (None, "idle")).expect_err("no median");
        assert!(missing.contains("replanning.p50"), "{missing}");
    }

    #[test]
    fn too_few_trials_for_a_percentile_are_said_before() {
        let clauses = clauses("replanning.p50 < 1ms, replanning.p99 < 1ms");
        let said = untold(&clauses, 99).expect("too few");
        assert!(said.contains("--trials 100"), "{said}");
        assert_eq!(untold(&clauses, 100), None);
    }
}
