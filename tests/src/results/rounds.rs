//! Conditions that take turns, so that what the machine does cancels in the ratio of a round.

use super::record::Row;
use super::spread::Figure;
use serde_json::Value;

/// Columns of the rows of [`in_turn`].
pub(super) const COLUMNS: [&str; 7] = [
    "replanning p50 [us]",
    "ratio",
    "reaction p50 [us]",
    "ratio",
    "reaction p99 [us]",
    "ratio",
    "unanswered",
];

/// Figures of trials in real time.
#[derive(Debug)]
struct Run {
    replanning_us: f64,
    reaction_us: f64,
    reaction_p99_us: f64,
    unanswered: f64,
}

impl Run {
    fn of(result: &Value) -> Result<Self, String> {
        let number = |pointer: &str| {
            let value = result.pointer(pointer).and_then(Value::as_f64);
            value.ok_or_else(|| format!("the result has no {pointer}"))
        };
        Ok(Self {
            replanning_us: number("/latency/replanning/p50_us")?,
            reaction_us: number("/latency/reaction/p50_us")?,
            reaction_p99_us: number("/latency/reaction/p99_us")?,
            unanswered: number("/latency/replanning/censored")?,
        })
    }
}

/// A row for each condition: medians over the rounds, and of the ratios to the first condition in the
/// same round. In each round every condition has a run, and each condition begins a round in turn.
///
/// # Errors
/// Those of `run`, which makes trials under a condition, and a result without latencies.
pub(super) fn in_turn(
    rounds: usize,
    names: &[&str],
    mut run: impl FnMut(usize) -> Result<Value, String>,
) -> Result<Vec<Row>, String> {
    let mut runs: Vec<Vec<Run>> = names.iter().map(|_| Vec::new()).collect();
    for round in 0..rounds {
        for place in 0..names.len() {
            let at = (round + place) % names.len();
            runs[at].push(Run::of(&run(at)?)?);
        }
    }
    let ratios = |at: usize, of: fn(&Run) -> f64| {
        let pairs = runs[at].iter().zip(&runs[0]);
        let ratios: Vec<f64> = pairs.map(|(one, first)| of(one) / of(first)).collect();
        Figure::median(&ratios)
    };
    let row = |(at, name): (usize, &&str)| {
        let of = |of: fn(&Run) -> f64| -> Vec<f64> { runs[at].iter().map(of).collect() };
        Row {
            name: (*name).to_owned(),
            n: rounds as u64,
            figures: vec![
                Figure::median(&of(|run| run.replanning_us)),
                ratios(at, |run| run.replanning_us),
                Figure::median(&of(|run| run.reaction_us)),
                ratios(at, |run| run.reaction_us),
                Figure::median(&of(|run| run.reaction_p99_us)),
                ratios(at, |run| run.reaction_p99_us),
                Figure::plain(Some(of(|run| run.unanswered).iter().sum())),
            ],
        }
    };
    Ok(names.iter().enumerate().map(row).collect())
}
