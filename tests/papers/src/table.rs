//! What the tables share: how much is measured, what comes of it, and figures of paired maps.

use crate::figure::Drawing;
use crate::maps::{Ends, MapFamily, MapSpec, Mazes};
use crate::row::{Figure, Place, Row};
use crate::solve::{Fault, Way, Ways};
use crate::stack::{Stack, StackError};
use crate::stats::{self, Estimate};
use crate::verdict::{Printed, Standing};
use zeronav_casts::Cast;
use zeronav_world::generate::GenerateError;

/// How much is measured.
#[derive(Debug)]
pub struct Context {
    /// Maps of every kind.
    pub seeds: u64,
    /// Scenes of every kind that the stack drives.
    pub drives: u64,
    /// Seed of the first map.
    pub seed: u64,
    /// Families of maps, where a table has several.
    pub families: Vec<MapFamily>,
    /// The stack, once a table has asked for it.
    pub stack: Option<Stack>,
}

impl Context {
    /// The stack, found or built when it is asked for first.
    ///
    /// # Errors
    /// See [`StackError`].
    pub fn stack(&mut self) -> Result<&mut Stack, StackError> {
        if self.stack.is_none() {
            self.stack = Some(Stack::new()?);
        }
        self.stack.as_mut().ok_or(StackError::Build)
    }
}

/// What came of a table.
#[derive(Debug, Default)]
pub struct Outcome {
    /// Its rows.
    pub rows: Vec<Row>,
    /// One map with all ways.
    pub drawing: Option<Drawing>,
}

/// Why a table has no rows.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// A planner broke its own rules or a theorem: a fault of ours.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// No map can be crossed.
    #[error(transparent)]
    Map(#[from] GenerateError),
    /// The stack did not drive.
    #[error(transparent)]
    Stack(#[from] StackError),
}

/// Draws the maps of a kind and names the place of their figures.
pub(crate) fn draw(
    context: &Context,
    paper: &'static str,
    table: &'static str,
    spec: &MapSpec,
) -> Result<(Mazes, Place), GenerateError> {
    draw_from(context, paper, table, spec, context.seed)
}

/// The same with another seed of the first map, for a table with maps of its own.
pub(crate) fn draw_from(
    context: &Context,
    paper: &'static str,
    table: &'static str,
    spec: &MapSpec,
    seed: u64,
) -> Result<(Mazes, Place), GenerateError> {
    let mazes = spec.draw(seed, context.seeds)?;
    let place = Place {
        paper,
        table,
        maps: spec.name(),
        acceptance: mazes.acceptance,
        seed,
    };
    Ok((mazes, place))
}

/// Opposite corners of a square or another map.
pub(crate) const fn corners(family: MapFamily, size: [u32; 2], ratio: f64) -> MapSpec {
    MapSpec {
        family,
        size,
        ratio,
        ends: Ends::Corners,
    }
}

/// Relative changes of a value from `base` to `ours` on the maps that both solved, and the share of
/// the others.
pub(crate) fn paired(base: &Ways, ours: &Ways, value: impl Fn(&Way) -> f64) -> (Vec<f64>, f64) {
    let changes: Vec<f64> = base
        .iter()
        .zip(ours)
        .filter_map(|pair| match pair {
            (Ok(base), Ok(ours)) => Some(value(ours) / value(base) - 1.0),
            _ => None,
        })
        .collect();
    let excluded = excluded(changes.len(), base.len());
    (changes, excluded)
}

/// Share of `of` that is not among the `n` that count.
pub(crate) fn excluded(n: usize, of: usize) -> f64 {
    1.0 - n.to_f64() / of.max(1).to_f64()
}

/// Share of the maps that a method solved.
pub(crate) fn solved(ways: &Ways) -> Option<Estimate> {
    stats::share(ways.iter().filter(|way| way.is_ok()).count(), ways.len())
}

/// How a method failed, for a note.
pub(crate) fn failures(ways: &Ways) -> String {
    let mut kinds: Vec<(String, usize)> = Vec::new();
    for error in ways.iter().filter_map(|way| way.as_ref().err()) {
        let text = error.to_string();
        match kinds.iter_mut().find(|(kind, _)| *kind == text) {
            Some((_, n)) => *n += 1,
            None => kinds.push((text, 1)),
        }
    }
    let kinds = kinds.iter().map(|(kind, n)| format!("{n} x {kind}"));
    kinds.collect::<Vec<_>>().join(", ")
}

/// A figure that needs no more than these.
pub(crate) fn figure(
    claim: &'static str,
    metric: &str,
    algorithm: &str,
    printed: Printed,
    (ours, excluded): (Option<Estimate>, f64),
) -> Figure {
    Figure {
        claim,
        metric: metric.to_owned(),
        algorithm: algorithm.to_owned(),
        printed,
        ours,
        excluded,
        standing: Standing::Fair,
        note: String::new(),
        parameters: serde_json::Value::Null,
    }
}

impl Figure {
    /// The same with a remark.
    pub(crate) fn noting(self, note: impl Into<String>) -> Self {
        Self {
            note: note.into(),
            ..self
        }
    }

    /// The same with another standing.
    pub(crate) fn standing(self, standing: Standing) -> Self {
        Self { standing, ..self }
    }

    /// The same with parameters.
    pub(crate) fn with(self, parameters: serde_json::Value) -> Self {
        Self { parameters, ..self }
    }
}

/// Mean of paired changes with the share left out.
pub(crate) fn change((changes, excluded): (Vec<f64>, f64)) -> (Option<Estimate>, f64) {
    (stats::mean(&changes), excluded)
}

/// The figure of a time, of the changes on the maps that were timed and the share left out.
pub(crate) fn time(
    claim: &'static str,
    name: &str,
    printed: Printed,
    changes: (Vec<f64>, f64),
) -> Figure {
    figure(claim, "time", name, printed, change(changes))
        .noting("ratio of medians of 31, interleaved")
}

/// A counter as a number to calculate with.
pub(crate) fn count(n: u64) -> f64 {
    n.to_f64()
}

/// What every table says of the safety of its ways: nearest approach, and how many touch a corner.
pub(crate) fn safety(claim: &'static str, name: &str, ways: &Ways) -> [Figure; 2] {
    let found: Vec<&Way> = ways.iter().flatten().collect();
    let left = excluded(found.len(), ways.len());
    let clearances: Vec<f64> = found.iter().map(|way| way.clearance).collect();
    let touching = clearances
        .iter()
        .filter(|clearance| **clearance <= 0.0)
        .count();
    [
        figure(
            claim,
            "min_clearance [cells]",
            name,
            Printed::Nothing,
            (stats::mean(&clearances), left),
        ),
        figure(
            claim,
            "collides (share)",
            name,
            Printed::Nothing,
            (stats::share(touching, found.len()), left),
        ),
    ]
}
