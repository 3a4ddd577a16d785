use super::{About, trace};
use crate::Records;
use crate::index::{PathRecord, Sighting};
use serde_json::Value;
use std::collections::BTreeMap;
use zeronav_casts::Cast;
use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::stages::{STAGES_MAX, Stage};

const US: u64 = 1000;
const ZERO_NS: u64 = 1_000_000 * US;

/// One turn of the ring from a scan captured at `t_us`: 10 us on the way, 5 us to read, 100 us of work,
/// of which each of its stages takes 20 us.
fn turn(records: &mut Records, n: u64, t_us: u64) {
    let mut at_us = t_us;
    let mut cycle = |role: Role| {
        let span = Span {
            role: role.code(),
            kind: SpanKind::Answer.code(),
            epoch: 1,
            tick: n,
            output: n,
            scan: n,
            odometry: n,
            map: n,
            path: n,
            request: n,
            capture_ns: ZERO_NS + t_us * US,
            woken_ns: ZERO_NS + (at_us + 10) * US,
            started_ns: ZERO_NS + (at_us + 15) * US,
            published_ns: ZERO_NS + (at_us + 115) * US,
            stages_ns: [20_000; STAGES_MAX],
            ..Span::default()
        };
        at_us += 115;
        span
    };
    let spans = Role::SERVICES.map(&mut cycle);
    let applied = Span {
        kind: SpanKind::Applied.code(),
        output: 0,
        woken_ns: ZERO_NS + (at_us + 10) * US,
        started_ns: ZERO_NS + (at_us + 20) * US,
        published_ns: 0,
        ..spans[0]
    };
    records.spans.extend(spans);
    records.spans.push(applied);
}

fn records() -> Records {
    let mut records = Records::default();
    for n in 1..=4 {
        turn(&mut records, n, n * 10_000);
    }
    // A second answer of the same wake.
    let mut again = records.spans[3];
    again.kind = SpanKind::Extra.code();
    again.output = 9;
    again.started_ns = again.published_ns + 5 * US;
    again.published_ns = again.started_ns + 20 * US;
    again.stages_ns = [1, 0, 19_998, 1];
    records.spans.push(again);
    records.paths.push(PathRecord {
        id: 2,
        map: 2,
        run_ns: 0,
        status: PathStatus::Found,
        cause: PathCause::Obstacle,
        planner: "test".to_owned(),
        length_m: 1.0,
        beside_goal_m: 0.0,
        expanded: 1,
        points_m: Vec::new(),
    });
    records.sightings.push(Sighting {
        appeared_ns: ZERO_NS + 19_900 * US,
        ..Sighting::default()
    });
    records
}

fn events(records: &Records) -> Vec<Value> {
    let about = About {
        scenario: "test".to_owned(),
        zero_ns: ZERO_NS,
        pids: [("mapping".to_owned(), 77)].into(),
    };
    let text = trace(records, &about).expect("a trace");
    let trace: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(trace["displayTimeUnit"], "ms");
    trace["traceEvents"].as_array().expect("events").clone()
}

fn is(event: &Value, ph: &str) -> bool {
    event["ph"] == ph
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// Slices by process and thread, in order, an outer one before those in it: beginning, end [us] and name.
type Tracks = BTreeMap<(u64, u64), Vec<(f64, f64, String)>>;

fn tracks(events: &[Value]) -> Tracks {
    let mut tracks = Tracks::new();
    for event in events.iter().filter(|event| is(event, "X")) {
        let track = (
            event["pid"].as_u64().expect("a process"),
            event["tid"].as_u64().expect("a thread"),
        );
        let from = number(&event["ts"]);
        let name = event["name"].as_str().expect("a name").to_owned();
        let slice = (from, from + number(&event["dur"]), name);
        tracks.entry(track).or_default().push(slice);
    }
    for slices in tracks.values_mut() {
        slices.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    }
    tracks
}

/// The same without the stages in the cycles.
fn outer(mut tracks: Tracks) -> Tracks {
    for slices in tracks.values_mut() {
        slices.retain(|(.., name)| !is_stage(name));
    }
    tracks
}

fn is_stage(name: &str) -> bool {
    let mut stages = Role::SERVICES.into_iter().flat_map(Stage::of);
    stages.any(|stage| stage.label() == name)
}

/// As Perfetto reads it. [ns]
fn ns(time_us: f64) -> i64 {
    (time_us * 1.0e3).round().to_i64()
}

#[test]
fn every_event_has_what_its_kind_asks_for() {
    let events = events(&records());
    for event in &events {
        let ph = event["ph"].as_str().expect("a kind");
        assert!(
            event["name"].is_string() && event["pid"].is_u64(),
            "{event}"
        );
        assert!(event["tid"].is_u64(), "{event}");
        assert_eq!(event["ts"].is_number(), ph != "M", "{event}");
        assert_eq!(event["dur"].is_number(), ph == "X", "{event}");
        assert_eq!(event["id"].is_u64(), "stf".contains(ph), "{event}");
        assert_eq!(event["bp"] == "e", ph == "f", "{event}");
        let needs_args = "MC".contains(ph);
        assert!(!needs_args || event["args"].is_object(), "{event}");
        assert!("MXstfCi".contains(ph), "{event}");
        if ph == "X" {
            assert!(
                number(&event["ts"]) >= 0.0 && number(&event["dur"]) >= 0.0,
                "{event}"
            );
        }
    }
    let named = |name: &str| events.iter().any(|event| event["args"]["name"] == name);
    assert!(named("mapping (pid 77)") && named("robot/scan -> mapping") && named("wheels"));
    let said = |name: &str| {
        events
            .iter()
            .any(|event| is(event, "i") && event["name"] == name)
    };
    assert!(said("an obstacle appears") && said("path: found, cause obstacle"));
}

#[test]
fn slices_of_a_track_follow_each_other() {
    let events = events(&records());
    let tracks = outer(tracks(&events));
    // Five processes, the wheels, nine edges.
    assert_eq!(tracks.len(), 15);
    for (track, slices) in &tracks {
        for pair in slices.windows(2) {
            assert!(pair[0].1 <= pair[1].0 + 1.0e-6, "{track:?}: {pair:?}");
        }
    }
    let mapping = &tracks[&(u64::from(Role::Mapping.code()), 1)];
    let names: Vec<&str> = mapping
        .iter()
        .take(5)
        .map(|slice| slice.2.as_str())
        .collect();
    assert_eq!(names, ["read", "compute", "wait", "read", "compute"]);
    assert!(
        (mapping[1].1 - mapping[1].0 - 100.0).abs() < 1.0e-6,
        "{mapping:?}"
    );
    // From the robot's answer to the beginning of mapping's work.
    let queued = &tracks[&(100, 1)][0];
    assert!((queued.1 - queued.0 - 15.0).abs() < 1.0e-6, "{queued:?}");
}

#[test]
fn stages_lie_in_their_cycle_in_their_order() {
    let events = events(&records());
    let all = tracks(&events);
    let mut n_cycles = 0;
    for role in Role::SERVICES {
        let slices = &all[&(u64::from(role.code()), 1)];
        for (from, to, _) in slices.iter().filter(|slice| slice.2 == "compute") {
            let is_inside = |slice: &&(f64, f64, String)| {
                slice.0 >= *from && slice.1 <= *to && slice.2 != "compute"
            };
            let inside = slices.iter().filter(is_inside);
            let times: Vec<(&str, i64, i64)> = inside
                .map(|slice| (slice.2.as_str(), ns(slice.0 - from), ns(slice.1 - slice.0)))
                .collect();
            // The second answer of the same wake: one stage did not run, and two were short.
            let expected: Vec<(&str, i64, i64)> = if ns(to - from) == 20_000 {
                vec![
                    ("prepare", 0, 1),
                    ("rollouts", 1, 19_998),
                    ("verify", 19_999, 1),
                ]
            } else {
                (0..)
                    .zip(Stage::of(role))
                    .map(|(place, stage)| (stage.label(), 20_000 * place, 20_000))
                    .collect()
            };
            assert_eq!(times, expected, "{role}");
            n_cycles += 1;
        }
    }
    assert_eq!(n_cycles, 4 * 5 + 1);
}

#[test]
fn slices_of_a_track_nest_to_the_nanosecond() {
    let mut records = records();
    // Times that are no whole number of microseconds, far from zero, and stages up to the very end.
    for (n, span) in (0..).zip(&mut records.spans) {
        let shift_ns = 3_600_000_000_000 + n * 7;
        for at_ns in [&mut span.woken_ns, &mut span.started_ns] {
            *at_ns += shift_ns;
        }
        if span.published_ns > 0 {
            span.published_ns += shift_ns;
            span.stages_ns = [33_333, 33_333, 33_333, 1];
        }
    }
    // What no service of this project writes: stages that are longer than their cycle.
    records.spans[1].stages_ns = [u32::MAX; STAGES_MAX];
    let mut n_inner = 0;
    for (track, slices) in tracks(&events(&records)) {
        let mut open: Vec<i64> = Vec::new();
        for (from, to, name) in slices {
            let (from_ns, to_ns) = (ns(from), ns(from) + ns(to - from));
            open.retain(|end_ns| *end_ns > from_ns);
            let fits = open.iter().all(|end_ns| to_ns <= *end_ns);
            assert!(fits, "{track:?}: {name} until {to_ns} ends after {open:?}");
            assert_eq!(!open.is_empty(), is_stage(&name), "{track:?}: {name}");
            n_inner += usize::from(!open.is_empty());
            open.push(to_ns);
        }
    }
    assert!(n_inner > 4 * 10, "{n_inner}");
}

#[test]
fn a_flow_leads_from_every_scan_to_the_wheels() {
    let events = events(&records());
    let tracks = tracks(&events);
    let mut flows: BTreeMap<u64, Vec<&Value>> = BTreeMap::new();
    for event in events.iter().filter(|event| event["cat"] == "flow") {
        let id = event["id"].as_u64().expect("an id");
        flows.entry(id).or_default().push(event);
    }
    let names = |name: &str| {
        flows
            .values()
            .filter(|flow| flow[0]["name"] == name)
            .count()
    };
    // The last command's slice has no end.
    assert_eq!((names("scan to wheel"), names("new path")), (3, 1));
    let robot = u64::from(Role::Robot.code());
    for flow in flows.values() {
        let kinds: String = flow
            .iter()
            .map(|event| event["ph"].as_str().expect("a kind"))
            .collect();
        assert!(kinds == "sttf" || kinds == "sttttf", "{kinds}");
        assert!(
            flow.windows(2)
                .all(|pair| number(&pair[0]["ts"]) < number(&pair[1]["ts"]))
        );
        let ends = [flow.first(), flow.last()].map(|end| end.expect("an end")["tid"].as_u64());
        assert_eq!(ends, [Some(1), Some(2)], "from a cycle to the wheels");
        for event in flow {
            let track = (
                event["pid"].as_u64().expect("a process"),
                event["tid"].as_u64().expect("a thread"),
            );
            let ts = number(&event["ts"]);
            let slices = tracks.get(&track).expect("a track");
            let bound = slices.iter().find(|slice| slice.0 < ts && ts < slice.1);
            let name = bound.map(|slice| slice.2.as_str());
            let expected = if track == (robot, 2) {
                "command"
            } else {
                "compute"
            };
            assert_eq!(name, Some(expected), "{event}");
        }
    }
}

#[test]
fn a_flow_against_the_clock_is_left_out() {
    let mut records = records();
    let flows = |records: &Records| {
        let events = events(records);
        events.iter().filter(|event| is(event, "s")).count()
    };
    assert_eq!(flows(&records), 4);
    // The local planner of the second turn begins before the scan that it names.
    let local = &mut records.spans[6 + 3];
    assert_eq!(local.role(), Some(Role::LocalPlanner));
    local.woken_ns -= 5000 * US;
    local.started_ns -= 5000 * US;
    local.published_ns -= 5000 * US;
    assert_eq!(flows(&records), 2, "the scan's and the path's are gone");
}

#[test]
fn ages_at_the_wheels_are_counted_from_capture_and_plan() {
    let events = events(&records());
    let ages = events
        .iter()
        .find(|event| event["name"] == "age at the wheels [ms]");
    let args = &ages.expect("ages")["args"];
    // Five cycles of 115 us and 20 us; the plan's command comes two cycles later.
    assert!((number(&args["scan"]) - 0.595).abs() < 1.0e-9, "{args}");
    assert!((number(&args["plan"]) - 0.250).abs() < 1.0e-9, "{args}");
}

#[test]
fn an_empty_and_an_overlong_run_have_a_trace() {
    assert!(
        events(&Records::default())
            .iter()
            .all(|event| is(event, "M"))
    );
    let mut long = Records::default();
    for n in 1..=5000 {
        turn(&mut long, n, n * 1000);
    }
    let events = events(&long);
    let slices = events
        .iter()
        .filter(|event| event["name"] == "compute")
        .count();
    assert!((15_000..=super::SPANS_MAX).contains(&slices), "{slices}");
}
