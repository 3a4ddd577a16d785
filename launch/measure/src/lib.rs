//! What a run's records say: which events were answered, how fast, and through which hops.
//!
//! Everything here is a pure function over records that launch collected: spans, ground truth,
//! paths and the sightings of obstacles in the map. Nothing is measured here; every time is a
//! difference of clock readings that the processes took themselves.

pub mod bootstrap;
mod command_gaps;
pub mod command_lag;
pub mod distribution;
pub mod edges;
pub mod event;
pub mod fold;
pub mod index;
pub mod joins;
pub mod latency;
pub mod lints;
pub mod motion;
pub mod paired;
pub mod profile;
pub mod reaction;
pub mod reasons;
pub mod result;
pub mod run_totals;
pub mod series;
pub mod shadow_answers;
pub mod start_up;
pub mod timings;
pub mod trace;
pub mod tracking;
pub mod tracking_score;

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
