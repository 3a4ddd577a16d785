//! `trace.json`: the records of a run as a trace that Perfetto opens.
//!
//! A track per process with its cycles (wait, read, compute with its stages), a track per topic and
//! reader with the time that each message lay there, the commands at the wheels, flows from scan to
//! wheel, and counters. Only the stages are timed for it; the rest lies in the records that are kept
//! anyway.

mod flows;
mod format;
mod layout;
mod processes;
#[cfg(test)]
mod tests;
mod topics;

use crate::Records;
use format::Trace;
pub use layout::About;
use serde_json::Map;
use std::collections::BTreeMap;

/// Records in a trace at most, the newest: about a minute and a half of a stack, and 10 MB.
const SPANS_MAX: usize = 20_000;

/// The trace of the newest records, as JSON.
///
/// # Errors
/// One line when there is no JSON form.
pub fn trace(records: &Records, about: &About) -> Result<String, String> {
    let dropped = records.spans.len().saturating_sub(SPANS_MAX);
    let kept = Records {
        spans: records.spans[dropped..].to_vec(),
        paths: records.paths.clone(),
        sightings: records.sightings.clone(),
    };
    let mut events = Vec::new();
    let mut slices = BTreeMap::new();
    processes::write(&kept, about, &mut events, &mut slices);
    topics::write(&kept, about, &mut events);
    flows::write(&kept, about, &slices, &mut events);
    let mut other_data = Map::new();
    other_data.insert("scenario".to_owned(), about.scenario.clone().into());
    other_data.insert("records left out".to_owned(), dropped.into());
    let trace = Trace {
        time_unit: "ms",
        about: other_data,
        events,
    };
    serde_json::to_string(&trace).map_err(|error| error.to_string())
}
