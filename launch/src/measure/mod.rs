//! What a run's records say: which events were answered, how fast, and through which hops.
//!
//! Everything here is a pure function over records that launch collected: spans, ground truth,
//! paths and the sightings of obstacles in the map. Nothing is measured here; every time is a
//! difference of clock readings that the processes took themselves.

pub(crate) mod bootstrap;
mod command_gaps;
pub(crate) mod command_lag;
pub(crate) mod distribution;
pub(crate) mod edges;
pub(crate) mod event;
pub(crate) mod fold;
pub mod index;
pub(crate) mod joins;
pub(crate) mod latency;
pub(crate) mod motion;
pub(crate) mod paired;
pub(crate) mod profile;
pub(crate) mod reaction;
pub mod series;
pub(crate) mod start_up;
pub(crate) mod timings;
pub(crate) mod tracking;
mod tracking_score;
pub mod way;

pub use distribution::Distribution;
pub use event::{Event, EventOutcome, judge};
pub use fold::RunHash;
pub use index::Records;
pub use latency::measure;
pub use motion::Motion;
pub use reaction::reactions;
pub use series::Series;
pub use tracking::TruthComparison;
pub use tracking_score::{BEAMS_MIN, MOVING_MPS, SAME_M};

/// Time after which an obstacle or a scan counts as unanswered. [ns]
pub const DEADLINE_NS: u64 = 5_000_000_000;
