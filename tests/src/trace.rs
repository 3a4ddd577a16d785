//! `trace.json` held against the Chrome trace event format, and what is in it.

use serde_json::Value;
use std::collections::BTreeMap;
use zeronav_casts::Cast;
use zeronav_msgs::role::Role;
use zeronav_msgs::stages::Stage;

/// A slice; its times are in nanoseconds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Slice {
    /// Beginning.
    pub from_ns: u64,
    /// End.
    pub to_ns: u64,
    /// Name.
    pub name: String,
    /// How many others it lies in.
    pub depth: usize,
}

/// Slices by process and thread, in order, an outer one before those in it.
pub type Tracks = BTreeMap<(u64, u64), Vec<Slice>>;

/// What a trace holds.
#[derive(Debug)]
pub struct Trace {
    /// The slices.
    pub tracks: Tracks,
    /// Name and kinds of the events of each flow.
    pub flows: Vec<(String, String)>,
}

impl Trace {
    /// How many slices of the cycles of `role` have this name.
    #[must_use]
    pub fn count(&self, role: Role, name: &str) -> usize {
        let track = self.tracks.get(&(u64::from(role.code()), 1));
        let named = |slices: &Vec<Slice>| slices.iter().filter(|slice| slice.name == name).count();
        track.map_or(0, named)
    }

    /// How many flows have this name.
    #[must_use]
    pub fn n_flows(&self, name: &str) -> usize {
        self.flows.iter().filter(|flow| flow.0 == name).count()
    }
}

/// Reads a whole trace and holds every event against the format: what its kind asks for is there, times
/// are no less than 0, the slices of a track lie in or beside each other, and a flow leads from slice
/// to slice and forward in time.
///
/// # Panics
/// When it does not hold.
#[must_use]
pub fn checked(text: &str) -> Trace {
    let trace: Value = serde_json::from_str(text).expect("JSON");
    let events = trace["traceEvents"].as_array().expect("events");
    for event in events {
        check_event(event);
    }
    let tracks = tracks(events);
    let mut flows: BTreeMap<u64, Vec<&Value>> = BTreeMap::new();
    for event in events.iter().filter(|event| event["cat"] == "flow") {
        let id = event["id"].as_u64().expect("an id");
        flows.entry(id).or_default().push(event);
    }
    let flows = flows.values().map(|flow| checked_flow(flow, &tracks));
    Trace {
        flows: flows.collect(),
        tracks,
    }
}

/// Stages lie in a cycle of their role, in their order, and nowhere else.
///
/// # Panics
/// When they do not.
pub fn check_stages(trace: &Trace) {
    for role in Role::SERVICES {
        let labels: Vec<&str> = Stage::of(role).iter().map(|stage| stage.label()).collect();
        let slices = trace.tracks.get(&(u64::from(role.code()), 1));
        let mut place = 0;
        for slice in slices.into_iter().flatten() {
            if slice.depth == 0 {
                let is_outer = ["wait", "read", "compute"].contains(&slice.name.as_str());
                assert!(is_outer, "{role}: {slice:?}");
                place = 0;
                continue;
            }
            let at = labels[place..]
                .iter()
                .position(|label| *label == slice.name);
            let at = at.unwrap_or_else(|| panic!("{role}: {slice:?} is no stage from {place} on"));
            assert_eq!(slice.depth, 1, "{role}: {slice:?}");
            place += at + 1;
        }
    }
}

/// Microseconds as nanoseconds, as Perfetto reads them.
fn ns(value: &Value) -> u64 {
    let time_us = value.as_f64().expect("a time");
    assert!((0.0..1.0e12).contains(&time_us), "{time_us} us");
    (time_us * 1.0e3).round().to_u64()
}

fn track_of(event: &Value) -> (u64, u64) {
    let number = |name: &str| event[name].as_u64().expect("a number");
    (number("pid"), number("tid"))
}

fn check_event(event: &Value) {
    let kind = event["ph"].as_str().expect("a kind");
    let has = |name: &str| !event[name].is_null();
    let needed: &[&str] = match kind {
        "X" => &["ts", "dur"],
        "s" | "t" => &["ts", "cat", "id"],
        "f" => &["ts", "cat", "id", "bp"],
        "C" => &["ts", "args"],
        "i" => &["ts", "s"],
        "M" => &["args"],
        _ => panic!("an event of an unknown kind: {event}"),
    };
    for name in ["ts", "dur", "cat", "id", "bp", "s"] {
        assert_eq!(has(name), needed.contains(&name), "{name} of {event}");
    }
    assert!(has("args") || !needed.contains(&"args"), "{event}");
    assert!(event["name"].is_string(), "{event}");
    track_of(event);
    for time in ["ts", "dur"].iter().filter(|time| has(time)) {
        ns(&event[time]);
    }
    let args = event["args"].as_object();
    match kind {
        "C" => assert!(args.is_some_and(|args| args.values().all(Value::is_number))),
        "M" => assert!(args.is_some_and(|args| args.len() == 1), "{event}"),
        "i" => assert_eq!(event["s"], "g"),
        "f" => assert_eq!(event["bp"], "e"),
        _ => {}
    }
}

fn tracks(events: &[Value]) -> Tracks {
    let mut tracks = Tracks::new();
    for event in events.iter().filter(|event| event["ph"] == "X") {
        let from_ns = ns(&event["ts"]);
        let slice = Slice {
            from_ns,
            to_ns: from_ns + ns(&event["dur"]),
            name: event["name"].as_str().expect("a name").to_owned(),
            depth: 0,
        };
        tracks.entry(track_of(event)).or_default().push(slice);
    }
    for (track, slices) in &mut tracks {
        slices.sort_by_key(|slice| (slice.from_ns, u64::MAX - slice.to_ns));
        let mut open: Vec<u64> = Vec::new();
        for slice in slices {
            open.retain(|end_ns| *end_ns > slice.from_ns);
            let fits = open.iter().all(|end_ns| slice.to_ns <= *end_ns);
            assert!(fits, "{track:?}: {slice:?} ends after {open:?}");
            slice.depth = open.len();
            open.push(slice.to_ns);
        }
    }
    tracks
}

fn checked_flow(flow: &[&Value], tracks: &Tracks) -> (String, String) {
    let kinds: String = flow
        .iter()
        .filter_map(|event| event["ph"].as_str())
        .collect();
    let middle = kinds.strip_prefix('s').and_then(|k| k.strip_suffix('f'));
    let is_whole = middle.is_some_and(|middle| middle.chars().all(|kind| kind == 't'));
    assert!(is_whole, "{kinds}: {flow:#?}");
    for event in flow {
        assert_eq!(event["name"], flow[0]["name"], "{flow:#?}");
        let at_ns = ns(&event["ts"]);
        let slices = tracks.get(&track_of(event)).expect("a track");
        let encloses = |slice: &Slice| (slice.from_ns..=slice.to_ns).contains(&at_ns);
        assert!(
            slices.iter().any(encloses),
            "a flow that binds to nothing: {event:#}"
        );
    }
    let times: Vec<u64> = flow.iter().map(|event| ns(&event["ts"])).collect();
    assert!(times.is_sorted(), "{flow:#?}");
    let name = flow[0]["name"].as_str().expect("a name");
    (name.to_owned(), kinds)
}
