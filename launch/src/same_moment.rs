//! One moment of a stack, as `zeronav top`, `zeronav why`, the page and the result of a run tell it: the same.

use crate::top::model::{Heard, Model};
use crate::why::live::missing;
use serde_json::Value;
use zeronav_measure::result::latency::{Hop, Latency};
use zeronav_measure::{DEADLINE_NS, Records};
use zeronav_msgs::header::{Header, Id};
use zeronav_msgs::health::{
    Health, HealthState, REASON_CLOCK, REASON_MAP, REASON_PATH, REASON_SCAN, SILENT_AFTER_NS,
};
use zeronav_msgs::path::{Path, PathCause, PathStatus};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_observe::health::Heart;
use zeronav_observe::hop_chain::{DIRECT, HOPS, THROUGH_MAP};
use zeronav_viewer::model::Model as Page;

const US: u64 = 1_000;
const MS: u64 = 1_000_000;

/// The moment. [ns]
const NOW_NS: u64 = 10_000 * MS;

/// Length of each hop of five scans, the first of which is captured before a path is followed. [us]
const HOPS_US: [u64; 5] = [50, 100, 200, 400, 800];

/// The scan that a new path comes of: in the middle, so that its hops are the medians of all.
const REPLANNED: u64 = 3;

/// How `top`, the page and `why` tell of a seat: state and reasons, twice, and how it is missing.
type Told = [(String, Vec<String>); 2];

fn header(role: Role, count: u64, at_ns: u64) -> Header {
    let mut header = Header {
        role: role.code(),
        id: Id::new(1, count).0,
        tick: count,
        run_ns: at_ns,
        ..Header::default()
    };
    header.stamps.published_ns = at_ns;
    header.parents.map = header.id;
    header
}

/// What is told of a seat whose process has beaten so long before the moment, or never.
fn told(role: Role, beat: Option<(u64, HealthState, u32)>) -> (Told, Option<String>) {
    let (mut top, mut page) = (Model::new(vec!["a"], false), Page::default());
    let mut heart = Heart::default();
    page.obeyed(role, 1, 0);
    if let Some((age_ns, state, reasons)) = beat {
        let header = header(role, 1, NOW_NS - age_ns);
        let beat = Health {
            state: state.code(),
            reasons,
            ..Health::default()
        };
        top.ingest(&Heard::Beat(header, beat));
        page.beat(&header, &beat);
        heart = Heart::of(&header, &beat);
    }
    let services = top.view(NOW_NS).services.into_iter();
    let top = services.filter(|line| line.role == role.label());
    let words = |word: &str| word.to_owned();
    let mut top = top.map(|line| {
        let reasons = line.reasons.into_iter();
        (words(line.state), reasons.map(words).collect::<Vec<_>>())
    });
    let services = page.services(NOW_NS);
    let services = services.as_array().expect("a list").iter();
    let mut page = services.filter(|line| line["role"] == role.label());
    let page = page.next().expect("its line");
    let reasons = page["reasons"].as_array().expect("a list").iter();
    let text = |value: &Value| value.as_str().expect("a word").to_owned();
    let page = (text(&page["state"]), reasons.map(text).collect());
    let how = missing(role, &heart, NOW_NS).map(|missing| missing.how);
    ([top.next().expect("its line"), page], how)
}

#[test]
fn a_service_is_silent_for_all_or_for_none() {
    for age_ms in [0, 100, 299, 301, 399, 401, 499, 500, 501, 700, 3_000] {
        let beat = Some((age_ms * MS, HealthState::Ready, 0));
        let (told, how) = told(Role::Mapping, beat);
        let is_silent = age_ms * MS > SILENT_AFTER_NS;
        let state = if is_silent { "silent" } else { "ready" };
        assert!(
            told.iter().all(|(told, _)| told == state),
            "{age_ms}: {told:?}"
        );
        let expected = is_silent.then_some("does not answer any more");
        assert_eq!(how.as_deref(), expected, "{age_ms} ms");
    }
}

#[test]
fn state_and_reasons_are_told_in_the_same_words() {
    let seats = [
        (
            Role::GlobalPlanner,
            None,
            "absent",
            vec![],
            Some("has not answered yet"),
        ),
        (
            Role::CollisionGuard,
            Some((0, HealthState::Starting, 0)),
            "starting",
            vec![],
            Some("is starting"),
        ),
        (
            Role::LocalPlanner,
            Some((0, HealthState::Degraded, REASON_MAP | REASON_PATH)),
            "degraded",
            vec!["map", "path"],
            None,
        ),
        (
            Role::Robot,
            Some((0, HealthState::Degraded, REASON_SCAN | REASON_CLOCK)),
            "degraded",
            vec!["scan", "clock"],
            Some("has a clock that was set or stands still, and stands"),
        ),
    ];
    for (role, beat, state, reasons, how) in seats {
        let (told, missing) = told(role, beat);
        for (told_state, told_reasons) in &told {
            assert_eq!(told_state, state, "{role}: {told:?}");
            assert_eq!(told_reasons, &reasons, "{role}: {told:?}");
        }
        assert_eq!(missing.as_deref(), how, "{role}");
    }
}

/// The records of the scans on their way through map and path to the wheels.
fn records() -> Vec<Span> {
    let mut spans = Vec::new();
    for (hop_us, n) in HOPS_US.into_iter().zip(1..) {
        let (id, from_ns) = (Id::new(1, n).0, NOW_NS - (10 - n) * 100 * MS);
        let at_ns = |boundary: u64| from_ns + boundary * hop_us * US;
        let span = |role: Role, from: u64| Span {
            role: role.code(),
            kind: SpanKind::Answer.code(),
            epoch: 1,
            tick: n,
            output: id,
            started_ns: at_ns(from),
            published_ns: at_ns(from + 1),
            ..Span::default()
        };
        spans.extend([
            Span {
                scan: id,
                capture_ns: at_ns(0),
                ..span(Role::Robot, 0)
            },
            Span {
                scan: id,
                ..span(Role::Mapping, 2)
            },
            Span {
                map: id,
                ..span(Role::GlobalPlanner, 4)
            },
            Span {
                scan: id,
                path: id,
                ..span(Role::LocalPlanner, 6)
            },
            Span {
                request: id,
                ..span(Role::CollisionGuard, 8)
            },
            Span {
                kind: SpanKind::Applied.code(),
                output: 0,
                request: id,
                ..span(Role::Robot, 10)
            },
        ]);
    }
    spans
}

#[track_caller]
fn near(value_us: Option<f64>, expected_us: Option<f64>, what: &str) {
    let (value_us, expected_us) = value_us.zip(expected_us).expect(what);
    // Results count in a histogram that is exact to a thousandth.
    let near = (value_us - expected_us).abs() <= 2.0e-3 * expected_us;
    assert!(near, "{what}: {value_us} us, not {expected_us} us");
}

/// The hops of a way of the page are those of the result, by name and length.
#[track_caller]
fn same_hops(page: &Value, result: &[Hop], of: fn(&Hop) -> Option<f64>, places: &[usize]) {
    let hops = page["hops_us"].as_array().expect("hops");
    assert_eq!((hops.len(), result.len()), (places.len(), places.len()));
    for ((hop, row), place) in hops.iter().zip(result).zip(places) {
        assert_eq!(
            (&hop[0], row.name.as_str()),
            (&Value::from(HOPS[*place]), HOPS[*place])
        );
        near(hop[1].as_f64(), of(row), &row.name);
    }
}

#[test]
fn hops_and_percentiles_are_the_same_live_and_in_the_result() {
    let records = Records {
        spans: records(),
        ..Records::default()
    };
    let result = Latency::of(&[], &records, DEADLINE_NS);
    let (mut top, mut page) = (Model::new(vec!["a"], false), Page::default());
    let header = header(Role::GlobalPlanner, REPLANNED, NOW_NS);
    let mut path = Path::new("jps", PathStatus::Found, PathCause::Obstacle, 1, &[]);
    path.geometry = header.id;
    top.ingest(&Heard::Path(header, path));
    page.new_path(header.id());
    for span in &records.spans {
        top.span(span);
        page.record(span);
    }
    top.refresh(NOW_NS);
    // What a command rests on may come one look after it.
    let settled = [page.settle(), page.settle()];
    let (top, page) = (top.view(NOW_NS), page.latency());

    let reaction = &page["reaction"];
    assert_eq!((top.reaction.n, &reaction["n"]), (4, &Value::from(4)));
    assert_eq!(top.reaction, result.reaction);
    near(result.reaction.p50_us, Some(1800.0), "the second of four");
    near(reaction["p50_us"].as_f64(), result.reaction.p50_us, "p50");
    near(reaction["p90_us"].as_f64(), result.reaction.p90_us, "p90");
    near(reaction["p99_us"].as_f64(), result.reaction.p99_us, "p99");
    near(reaction["max_us"].as_f64(), result.reaction.max_us, "max");

    let every = &result.every_scan;
    let replanning = &page["replanning"];
    same_hops(
        replanning,
        &every.through_map,
        |hop| hop.figures.p50_us,
        &THROUGH_MAP,
    );
    same_hops(
        &page["direct"],
        &every.direct,
        |hop| hop.figures.max_us,
        &DIRECT,
    );
    let hops = &top.replanning.as_ref().expect("it is followed").hops;
    let hops: Vec<(&str, f64)> = hops.iter().map(|hop| (hop.hop, hop.us)).collect();
    assert_eq!(settled, [None, Some(hops.clone())]);
    assert_eq!(replanning["hops_us"], serde_json::json!(hops));
}
