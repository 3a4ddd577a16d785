//! What the link between two hosts carried, and how well the clock of the other one is known.

use super::latency::{Hop, Latency};
use core::fmt;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use zeronav_casts::Cast;

/// What the link of the robot's host says of a run: since its last start, if it was started again.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct LinkResult {
    /// The other host.
    pub other: String,
    /// By how much its clock is ahead; null while no beat came back. [us]
    pub ahead_us: Option<f64>,
    /// The true value lies within this of it, at the end. [us]
    pub uncertainty_us: Option<f64>,
    /// The same when it was known worst while messages came. [us]
    pub uncertainty_us_max: Option<f64>,
    /// How many times the other host fell silent.
    pub cuts: u64,
    /// Frames of the other host that were lost: messages, rings and beats.
    pub lost: u64,
    /// Time over which all of this was counted. [s]
    pub time_s: f64,
    /// Processor time of the link. [s]
    pub processor_s: f64,
    /// What it carried, by topic.
    pub topics: BTreeMap<String, Carried>,
}

/// Messages of a topic that crossed the link.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Carried {
    /// Messages to the other host.
    pub sent: u64,
    /// Their bytes, without what the transport adds.
    pub sent_bytes: u64,
    /// Messages from the other host.
    pub received: u64,
    /// Their bytes.
    pub received_bytes: u64,
}

impl fmt::Display for LinkResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bytes = |of: fn(&Carried) -> u64| -> u64 { self.topics.values().map(of).sum() };
        let rate = |bytes: u64| bytes.to_f64() / self.time_s.max(1.0e-3) / 1.0e3;
        write!(
            f,
            "to {}: {:.0} kB/s sent, {:.0} kB/s received, {} frames lost, {} cuts",
            self.other,
            rate(bytes(|carried| carried.sent_bytes)),
            rate(bytes(|carried| carried.received_bytes)),
            self.lost,
            self.cuts
        )?;
        match self.uncertainty_us_max {
            Some(us) => write!(f, ", clocks known within {us:.0} us"),
            None => write!(f, ", clocks not compared"),
        }
    }
}

impl Latency {
    /// Says how uncertain the hops are that begin on one host and end on the other. Reaction and replanning begin and
    /// end on the robot's clock. `host_of` names the host of a seat by its label.
    pub fn add_clock_uncertainty<'a>(
        &mut self,
        us: f64,
        host_of: impl Fn(&str) -> Option<&'a str>,
    ) {
        let ways = [
            &mut self.hops,
            &mut self.every_scan.direct,
            &mut self.every_scan.through_map,
        ];
        for hops in ways {
            let crossing: Vec<bool> = hops
                .iter()
                .map(|hop| &hop.name[..])
                .scan("robot", |before, name| {
                    let crosses = name
                        .strip_prefix("to_")
                        .is_some_and(|to| host_of(before) != host_of(to));
                    if host_of(name).is_some() {
                        *before = name;
                    }
                    Some(crosses)
                })
                .collect();
            for (hop, _) in hops
                .iter_mut()
                .zip(crossing)
                .filter(|(_, crosses)| *crosses)
            {
                hop.clock_uncertainty_us = Some(us);
            }
        }
    }
}

impl Hop {
    /// Its name, with the uncertainty of the clocks where it crosses hosts.
    #[must_use]
    pub fn title(&self) -> String {
        match self.clock_uncertainty_us {
            Some(us) => format!("{} ± {us:.0} us", self.name),
            None => self.name.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::index::Records;
    use crate::latency::measure;
    use crate::result::latency::Hop;

    #[test]
    fn hops_that_cross_hosts_have_the_uncertainty_of_the_clocks() {
        let (_, mut latency) = measure(&Records::default(), &|_, _| 1.0, 0.3, 1_000_000);
        latency.add_clock_uncertainty(80.0, |seat| match seat {
            "robot" | "collision_guard" => Some("robot"),
            "mapping" | "global_planner" | "local_planner" => Some("base"),
            _ => None,
        });
        let uncertain = |hops: &[Hop]| -> Vec<String> {
            let hops = hops
                .iter()
                .filter(|hop| hop.clock_uncertainty_us == Some(80.0));
            hops.map(|hop| hop.name.clone()).collect()
        };
        assert_eq!(
            uncertain(&latency.hops),
            ["to_mapping", "to_collision_guard"]
        );
        let every = &latency.every_scan;
        assert_eq!(
            uncertain(&every.direct),
            ["to_local_planner", "to_collision_guard"]
        );
        assert_eq!(
            uncertain(&every.through_map),
            ["to_mapping", "to_collision_guard"]
        );
        assert_eq!(latency.hops[2].title(), "to_mapping ± 80 us");
    }
}
