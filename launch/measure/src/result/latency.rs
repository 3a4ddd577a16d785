//! The latency part of a result.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use zeronav_observe::statistics;

/// The latency part of a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Latency {
    /// captured(scan) -> published(first command whose request checked that scan's points).
    pub reaction: Figures,
    /// captured(s) -> published(c).
    pub replanning: Figures,
    /// Appearance -> applied(c).
    pub event_to_motion: Figures,
    /// The way from captured(s) to applied(c).
    pub hops: Vec<Hop>,
    /// The same way through five processes that do nothing, at the same pace and with messages of
    /// the same size; measured by trials only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transport_floor: Option<Figures>,
    /// Median of replanning over that of the floor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replanning_to_floor: Option<f64>,
    /// The same hops for every scan.
    pub every_scan: EveryScan,
    /// Stamps that lie before their predecessor, by the hop between the two; of all commands that
    /// reached the wheels and of the events.
    pub hops_out_of_order: BTreeMap<String, u64>,
    /// Commands that were followed back to their scan.
    pub ways: u64,
    /// Commands and events whose way could not be followed because a record is missing.
    pub ways_broken: u64,
    /// The robot's own end-to-end time on its second clock; null when it has left none.
    pub second_clock: Option<SecondClock>,
    /// Events answered before the map showed three beams' worth of the obstacle.
    pub early: u64,
    /// Answered events whose path did not clear all of the obstacle and was corrected later.
    pub revised: u64,
    /// Obstacles that no path led through.
    pub not_in_the_way: u64,
}

/// One hop of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Hop {
    /// Its name.
    pub name: String,
    /// Its figures.
    #[serde(flatten)]
    pub figures: Figures,
    /// It begins on one host and ends on another: each of its times is true to within this. [us]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock_uncertainty_us: Option<f64>,
}

/// The way of every scan to the wheels, hop by hop, whether or not anything had changed: the first
/// command that reached the wheels behind each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct EveryScan {
    /// Through the local planner, which checks the points of the scan itself.
    pub direct: Vec<Hop>,
    /// Through the map and a path that is current as of it.
    pub through_map: Vec<Hop>,
}

/// The robot's own time from capture to application on a second clock, `CLOCK_MONOTONIC_RAW`, for
/// every command, through the ids in its ancestry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SecondClock {
    /// That time.
    pub end_to_end: Figures,
    /// By how much it differs from the sum of the hops.
    pub difference: Figures,
    /// Commands for which that is more than the rates of the two clocks allow.
    pub beyond: u64,
}

/// The figures of a distribution. `n` counts answered and censored samples; censored ones rank
/// as worst. `None` where there is nothing to say. What is shown and serialised is
/// [`Self::supported`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Default)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(into = "Shown")]
pub struct Figures {
    /// Samples, censored ones included.
    pub n: u64,
    /// Samples without an answer before the deadline.
    pub censored: u64,
    /// Median. [us]
    pub p50_us: Option<f64>,
    /// 90th percentile. [us]
    pub p90_us: Option<f64>,
    /// 99th percentile. [us]
    pub p99_us: Option<f64>,
    /// Worst. [us]
    pub max_us: Option<f64>,
}

/// The form in which figures are serialised.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Shown {
    n: u64,
    censored: u64,
    p50_us: Option<f64>,
    p90_us: Option<f64>,
    p99_us: Option<f64>,
    max_us: Option<f64>,
}

impl From<Figures> for Shown {
    fn from(figures: Figures) -> Self {
        let Figures {
            n,
            censored,
            p50_us,
            p90_us,
            p99_us,
            max_us,
        } = figures.supported();
        Self {
            n,
            censored,
            p50_us,
            p90_us,
            p99_us,
            max_us,
        }
    }
}

impl Figures {
    /// Fewest samples that a median, a 90th and a 99th percentile can be said of.
    pub const N_MIN: [u64; 3] = [2, 10, 100];

    /// Without the percentiles above (n - 1) / n: so few samples do not tell them from the worst.
    #[must_use]
    pub fn supported(self) -> Self {
        let from = |n_min: u64, value: Option<f64>| value.filter(|_| self.n >= n_min);
        Self {
            p50_us: from(Self::N_MIN[0], self.p50_us),
            p90_us: from(Self::N_MIN[1], self.p90_us),
            p99_us: from(Self::N_MIN[2], self.p99_us),
            ..self
        }
    }

    /// Several rounds as one: percentiles are the median of the rounds', the worst is the worst
    /// of all, samples are counted together.
    #[must_use]
    pub fn of_rounds(rounds: &[Self]) -> Self {
        let median =
            |of: fn(&Self) -> Option<f64>| statistics::median(rounds.iter().filter_map(of));
        Self {
            n: rounds.iter().map(|round| round.n).sum(),
            censored: rounds.iter().map(|round| round.censored).sum(),
            p50_us: median(|round| round.p50_us),
            p90_us: median(|round| round.p90_us),
            p99_us: median(|round| round.p99_us),
            max_us: rounds
                .iter()
                .filter_map(|round| round.max_us)
                .max_by(f64::total_cmp),
        }
    }
}
