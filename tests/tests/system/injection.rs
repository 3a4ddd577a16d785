//! The self-test of the hops: milliseconds put into a service appear in its hop and nowhere else.
//!
//! Every scan of a short drive gives one sample per hop, so that medians of some hundred samples
//! are compared with those of the same drive without a delay, made before, between and after. Two
//! services that do not wait for each other are delayed in one drive, by different times. A
//! machine on which the drives without a delay differ among themselves says nothing; then all is
//! measured again.

use serde_json::Value;
use std::collections::BTreeMap;
use zeronav_observe::statistics::median;
use zeronav_tests::{Zeronav, assert_latencies_add_up, quiet_turn};

/// What is put into which services in one drive. [ms]
const DELAYED: [[(&str, u32); 2]; 2] = [
    [("mapping", 5), ("local_planner", 7)],
    [("global_planner", 7), ("collision_guard", 5)],
];

/// How far a median may be from where it should be. [us]
const TOLERANCE_US: f64 = 500.0;

/// Medians that differ by more without any delay come from a busy machine. [us]
const QUIET_US: f64 = 250.0;

/// How often all is measured at most.
const ATTEMPTS: usize = 3;

/// An empty hall, a lidar that turns so often that half of its scans fall between two ticks.
const SCENARIO: &str = r#"
title = "A short way through an empty hall"
base = ["hall", "porter"]
start = [1.5, 4.0, 0.0]
[run]
time_limit_s = 60.0
[robot.lidar]
rate_hz = 20.0
[[goals]]
pose = [5.5, 4.0, 0.0]
"#;

/// The tables of `every_scan`: by table and hop, the median. [us]
type Medians = BTreeMap<(&'static str, String), f64>;

/// One drive with these delays.
fn drive(delayed: &[(&str, u32)]) -> Medians {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("hall.toml"), SCENARIO).expect("written");
    let mut arguments = vec!["run", "./hall.toml", "--headless", "--json"];
    let injected = delayed.iter().map(|(role, ms)| format!("{role}={ms}ms"));
    let injected: Vec<String> = injected.collect();
    arguments.extend(injected.iter().flat_map(|delay| ["--inject", delay]));
    let result = Zeronav::start_in(folder, &arguments).finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    let latency = &result["latency"];
    assert_latencies_add_up(latency);
    let mut medians = Medians::new();
    for table in ["direct", "through_map"] {
        for hop in latency["every_scan"][table].as_array().expect("hops") {
            let name = hop["name"].as_str().expect("a name").to_owned();
            assert!(hop["n"].as_u64() >= Some(80), "{table} {hop:#}");
            medians.insert((table, name), number(&hop["p50_us"]));
        }
    }
    assert_eq!(medians.len(), 16, "{medians:?}");
    medians
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// What is wrong with a drive with these delays.
fn wrong(delays: &[(&str, u32)], base: &Medians, delayed: &Medians) -> Vec<String> {
    let delay_us = |role: &str| {
        let found = delays.iter().find(|(delayed, _)| *delayed == role);
        found.map_or(0.0, |(_, ms)| 1000.0 * f64::from(*ms))
    };
    let mut wrong = Vec::new();
    for ((table, hop), before_us) in base {
        let moved_us = delayed[&(*table, hop.clone())] - before_us;
        let expected_us = delay_us(hop);
        // The path of a scan finds these two at work on their answer to the scan itself.
        let reader = hop.strip_prefix("to_").unwrap_or_default();
        let waits =
            *table == "through_map" && ["local_planner", "collision_guard"].contains(&reader);
        let fine = if waits {
            (-TOLERANCE_US..=delay_us(reader) + TOLERANCE_US).contains(&moved_us)
        } else {
            (moved_us - expected_us).abs() <= TOLERANCE_US
        };
        if !fine {
            wrong.push(format!(
                "{delays:?}: {table} {hop} moved by {moved_us:.0} us"
            ));
        }
    }
    wrong
}

#[test]
fn injected_delay_appears_in_its_hop_only() {
    let _turn = quiet_turn();
    let mut wrongs = Vec::new();
    for attempt in 1..=ATTEMPTS {
        let mut bases = vec![drive(&[])];
        let mut delayed = Vec::new();
        for delays in DELAYED {
            delayed.push((delays, drive(&delays)));
            bases.push(drive(&[]));
        }
        let middle: Medians = bases[0]
            .keys()
            .map(|hop| {
                let each = bases.iter().map(|base| base[hop]);
                (hop.clone(), median(each).expect("drives without a delay"))
            })
            .collect();
        let unrest_us = bases
            .iter()
            .flat_map(|base| middle.iter().map(|(hop, us)| (base[hop] - us).abs()))
            .fold(0.0, f64::max);
        wrongs = delayed
            .iter()
            .flat_map(|(delays, delayed)| wrong(delays, &middle, delayed))
            .collect();
        eprintln!(
            "attempt {attempt}: without a delay medians differ by {unrest_us:.0} us; {wrongs:?}"
        );
        if wrongs.is_empty() || unrest_us <= QUIET_US {
            break;
        }
    }
    assert!(wrongs.is_empty(), "{wrongs:#?}");
}
