//! The Chrome trace event format, as far as it is written here.
//!
//! One JSON object with `traceEvents`; Perfetto and `chrome://tracing` open it. Times are in
//! microseconds; a slice (`X`) nests in the slices of its thread that contain it, and a flow (`s`, `t`,
//! `f`) binds to the slice of its thread that encloses its time.

use serde::Serialize;
use serde_json::{Map, Value};
use zeronav_casts::Cast;

/// A process of the trace and a thread in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Track {
    pub pid: u32,
    pub tid: u32,
}

/// One event.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct TraceEvent {
    ph: &'static str,
    name: String,
    /// [us]
    #[serde(skip_serializing_if = "Option::is_none")]
    ts: Option<f64>,
    /// [us]
    #[serde(skip_serializing_if = "Option::is_none")]
    dur: Option<f64>,
    pid: u32,
    tid: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    cat: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<u64>,
    /// A flow ends in the slice that encloses its time.
    #[serde(skip_serializing_if = "Option::is_none")]
    bp: Option<&'static str>,
    /// An instant is drawn over all tracks.
    #[serde(skip_serializing_if = "Option::is_none")]
    s: Option<&'static str>,
    #[serde(skip_serializing_if = "Map::is_empty")]
    args: Map<String, Value>,
}

/// A whole trace.
#[derive(Debug, Serialize)]
pub(super) struct Trace {
    #[serde(rename = "displayTimeUnit")]
    pub time_unit: &'static str,
    #[serde(rename = "otherData")]
    pub about: Map<String, Value>,
    #[serde(rename = "traceEvents")]
    pub events: Vec<TraceEvent>,
}

/// Which part of a flow an event is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FlowPart {
    Start,
    Step,
    Finish,
}

/// Nanoseconds as microseconds, exactly.
fn us(time_ns: u64) -> f64 {
    time_ns.to_f64() / 1.0e3
}

impl TraceEvent {
    fn new(ph: &'static str, name: &str, track: Track) -> Self {
        Self {
            ph,
            name: name.to_owned(),
            ts: None,
            dur: None,
            pid: track.pid,
            tid: track.tid,
            cat: None,
            id: None,
            bp: None,
            s: None,
            args: Map::new(),
        }
    }

    /// The name of a process, and its place among the others.
    pub(super) fn process(pid: u32, name: &str) -> [Self; 2] {
        let track = Track { pid, tid: 0 };
        [
            Self::new("M", "process_name", track).arg("name", name.into()),
            Self::new("M", "process_sort_index", track).arg("sort_index", pid.into()),
        ]
    }

    /// The name of a thread.
    pub(super) fn thread(track: Track, name: &str) -> Self {
        Self::new("M", "thread_name", track).arg("name", name.into())
    }

    /// A slice from `from_ns` to `to_ns`.
    pub(super) fn slice(track: Track, name: &str, from_ns: u64, to_ns: u64) -> Self {
        Self {
            ts: Some(us(from_ns)),
            dur: Some(us(to_ns.saturating_sub(from_ns))),
            ..Self::new("X", name, track)
        }
    }

    /// A part of flow `id`.
    pub(super) fn flow(track: Track, name: &str, at_ns: u64, id: u64, part: FlowPart) -> Self {
        let ph = match part {
            FlowPart::Start => "s",
            FlowPart::Step => "t",
            FlowPart::Finish => "f",
        };
        Self {
            ts: Some(us(at_ns)),
            cat: Some("flow"),
            id: Some(id),
            bp: (part == FlowPart::Finish).then_some("e"),
            ..Self::new(ph, name, track)
        }
    }

    /// A value that holds until the next one of its name.
    pub(super) fn counter(pid: u32, name: &str, at_ns: u64) -> Self {
        Self {
            ts: Some(us(at_ns)),
            ..Self::new("C", name, Track { pid, tid: 0 })
        }
    }

    /// A moment for all tracks.
    pub(super) fn instant(pid: u32, name: &str, at_ns: u64) -> Self {
        Self {
            ts: Some(us(at_ns)),
            s: Some("g"),
            ..Self::new("i", name, Track { pid, tid: 0 })
        }
    }

    /// With an argument.
    pub(super) fn arg(mut self, name: &str, value: Value) -> Self {
        self.args.insert(name.to_owned(), value);
        self
    }
}
