//! A row of a table.

use crate::stats::Estimate;
use crate::verdict::{Printed, Standing, Verdict, verdict};
use serde::{Deserialize, Serialize};

/// A measured figure beside a printed one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Paper: `TN`, `JU`, `ZM`, `LWX` or `BAO`.
    pub paper: String,
    /// Table or figure of the paper.
    pub table: String,
    /// Claim, such as `C2`; see the registry.
    pub claim: String,
    /// What is measured, with its unit; a change is (ours - base) / base.
    pub metric: String,
    /// Algorithms: which is compared with which.
    pub algorithm: String,
    /// Maps: family, size and share of obstacles.
    pub maps: String,
    /// Printed figure; null when there is none.
    pub printed: Option<f64>,
    /// Mean or share; null when no map could be counted.
    pub ours: Option<f64>,
    /// 95 % interval: bootstrap of a mean, Wilson of a share.
    pub interval: Option<[f64; 2]>,
    /// Maps that count.
    pub n: usize,
    /// Share of the maps left out because not both sides solved them.
    pub excluded: f64,
    /// Share of the drawn maps that could be crossed under the strictest corner rule.
    pub acceptance: f64,
    /// What it means.
    pub verdict: Verdict,
    /// Remarks, such as different corner rules.
    pub note: String,
    /// Parameters that differ from the defaults.
    pub parameters: serde_json::Value,
    /// Lower 64 bits of what the maps were drawn from.
    pub seed: u64,
    /// Said of all maps, so that one against it is enough.
    #[serde(default)]
    pub universal: bool,
}

/// Where a figure belongs.
#[derive(Debug, Clone)]
pub struct Place {
    /// See [`Row`].
    pub paper: &'static str,
    /// See [`Row`].
    pub table: &'static str,
    /// See [`Row`].
    pub maps: String,
    /// See [`Row`].
    pub acceptance: f64,
    /// See [`Row`].
    pub seed: u64,
}

/// A figure before its verdict.
#[derive(Debug, Clone)]
pub struct Figure {
    /// See [`Row`].
    pub claim: &'static str,
    /// See [`Row`].
    pub metric: String,
    /// See [`Row`].
    pub algorithm: String,
    /// See [`Row`].
    pub printed: Printed,
    /// See [`Row`].
    pub ours: Option<Estimate>,
    /// See [`Row`].
    pub excluded: f64,
    /// See [`Standing`].
    pub standing: Standing,
    /// See [`Row`].
    pub note: String,
    /// See [`Row`].
    pub parameters: serde_json::Value,
}

impl Place {
    /// The row of a figure.
    #[must_use]
    pub fn row(&self, figure: Figure) -> Row {
        let printed = match figure.printed {
            Printed::Change(value)
            | Printed::Count(value)
            | Printed::Share(value)
            | Printed::Same(value) => Some(value),
            Printed::Always => Some(1.0),
            Printed::Less | Printed::More | Printed::Nothing => None,
        };
        Row {
            paper: self.paper.to_owned(),
            table: self.table.to_owned(),
            claim: figure.claim.to_owned(),
            metric: figure.metric,
            algorithm: figure.algorithm,
            maps: self.maps.clone(),
            printed,
            ours: figure.ours.map(|ours| ours.mean),
            interval: figure.ours.map(|ours| ours.interval),
            n: figure.ours.map_or(0, |ours| ours.n),
            excluded: figure.excluded,
            acceptance: self.acceptance,
            verdict: verdict(figure.printed, figure.ours, figure.standing),
            note: figure.note,
            parameters: figure.parameters,
            seed: self.seed,
            universal: figure.printed == Printed::Always,
        }
    }
}
