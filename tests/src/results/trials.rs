//! From the result of `zeronav run --trials` to tables.

use super::extract::{list, table, text};
use super::record::{Row, Table};
use super::spread::Figure;
use serde_json::Value;

/// Columns of [`latency`].
pub const COLUMNS: [&str; 5] = ["p50 [us]", "p90 [us]", "p99 [us]", "max [us]", "unanswered"];

/// Latencies of `--trials`: behind the median the lowest and highest of the rounds'.
#[must_use]
pub fn latency(result: &Value) -> Table {
    let rounds = list(&result["trials"], "rounds");
    let row = |name: &str, of: &dyn Fn(&Value) -> Value| {
        let figures = of(&result["latency"]);
        let medians = rounds
            .iter()
            .filter_map(|round| of(&round["latency"])["p50_us"].as_f64());
        let median = Figure {
            value: figures["p50_us"].as_f64(),
            low: medians.clone().reduce(f64::min),
            high: medians.reduce(f64::max),
        };
        let plain = |key: &str| Figure::plain(figures[key].as_f64());
        Row {
            name: name.to_owned(),
            n: figures["n"].as_u64().unwrap_or(0),
            figures: vec![
                median,
                plain("p90_us"),
                plain("p99_us"),
                plain("max_us"),
                plain("censored"),
            ],
        }
    };
    let named = |key: &'static str| move |latency: &Value| latency[key].clone();
    let mut rows = vec![row("**replanning**", &named("replanning"))];
    for hop in list(&result["latency"], "hops") {
        let name = text(&hop["name"]);
        let of = |latency: &Value| {
            let hops = list(latency, "hops").iter();
            let mut same = hops.filter(|other| other["name"] == hop["name"]);
            same.next().cloned().unwrap_or_default()
        };
        rows.push(row(&format!("of it `{name}`"), &of));
    }
    rows.push(row("event to motion", &named("event_to_motion")));
    rows.push(row("reaction", &named("reaction")));
    rows.push(row("transport floor", &named("transport_floor")));
    for (name, key) in [
        ("scan to wheels by the robot's second clock", "end_to_end"),
        ("of it not in the hops", "difference"),
    ] {
        let of = move |latency: &Value| latency["second_clock"][key].clone();
        if of(&result["latency"]).is_object() {
            rows.push(row(name, &of));
        }
    }
    table("", &COLUMNS, rows)
}

/// The row of that name.
///
/// # Errors
/// One line when there is none.
pub fn row<'a>(table: &'a Table, name: &str) -> Result<&'a Row, String> {
    let row = table.rows.iter().find(|row| row.name == name);
    row.ok_or_else(|| format!("the trials have no `{name}`"))
}

/// The median over `results` of the median of a hop.
#[must_use]
pub fn hop_p50_us(results: &[Value], name: &str) -> Figure {
    let p50_us = |result: &Value| {
        let mut hops = list(&result["latency"], "hops").iter();
        hops.find(|hop| hop["name"] == name)?["p50_us"].as_f64()
    };
    Figure::median(&results.iter().filter_map(p50_us).collect::<Vec<f64>>())
}

/// Latencies of a thousand `--trials`, far into the tail.
#[must_use]
pub fn tail(result: &Value) -> Table {
    let named = |(name, key): (&str, &str)| {
        let mut rows = list(&result["profile"], "rows").iter();
        let found = rows
            .find(|row| row["name"] == key)
            .cloned()
            .unwrap_or_default();
        let plain = |key: &str| Figure::plain(found[key].as_f64());
        Row {
            name: name.to_owned(),
            n: found["n"].as_u64().unwrap_or(0),
            figures: [
                "p50_us", "p90_us", "p99_us", "p999_us", "max_us", "censored",
            ]
            .map(plain)
            .to_vec(),
        }
    };
    let rows = [("**replanning**", "replanning"), ("reaction", "reaction")].map(named);
    let columns = [
        "p50 [us]",
        "p90 [us]",
        "p99 [us]",
        "p99.9 [us]",
        "max [us]",
        "unanswered",
    ];
    table("", &columns, rows.to_vec())
}

/// What the records of `--trials` were checked for; above 0 is a fault of the measurement.
#[must_use]
pub fn checks(result: &Value) -> Table {
    let latency = &result["latency"];
    let by_hop = latency["hops_out_of_order"].as_object();
    let out_of_order = by_hop.map(|hops| hops.values().filter_map(Value::as_f64).sum());
    let row = Row {
        name: "commands whose way was followed back to their scan".to_owned(),
        n: latency["ways"].as_u64().unwrap_or(0),
        figures: vec![
            Figure::plain(out_of_order),
            Figure::plain(latency["ways_broken"].as_f64()),
            Figure::plain(latency["second_clock"]["beyond"].as_f64()),
            Figure::plain(latency["revised"].as_f64()),
        ],
    };
    table(
        "checks",
        &[
            "stamps before their predecessor",
            "records missing",
            "beyond what the two clocks' rates allow",
            "paths corrected later",
        ],
        vec![row],
    )
}

/// What disturbed the rounds of `--trials`, service by service.
#[must_use]
pub fn disturbance(result: &Value) -> Table {
    let mut rows = Vec::new();
    for (at, round) in list(&result["trials"], "rounds").iter().enumerate() {
        let all = &round["disturbance"];
        for service in list(all, "services") {
            let plain = |value: &Value, scale: f64| {
                Figure::plain(value.as_f64().map(|value| value * scale))
            };
            rows.push(Row {
                name: format!("round {}, {}", at + 1, text(&service["name"])),
                n: round["trials"].as_u64().unwrap_or(0),
                figures: vec![
                    plain(&service["processor_us"], 1e-3),
                    plain(&service["queue_us"], 1e-3),
                    plain(&service["off_processor_us_max"], 1.0),
                    plain(&service["involuntary_switches"], 1.0),
                    plain(&service["major_faults"], 1.0),
                    plain(&all["load_end"], 1.0),
                    plain(&all["steal"], 100.0),
                ],
            });
        }
    }
    table(
        "",
        &[
            "processor time [ms]",
            "waited for a processor [ms]",
            "longest off the processor in a cycle [us]",
            "preemptions",
            "major faults",
            "load at the end",
            "steal [%]",
        ],
        rows,
    )
}

/// The `n` slowest trials, each with its hop and the service that was off the processor longest.
#[must_use]
pub fn slowest(result: &Value, n: usize) -> Table {
    let rows = list(&result["trials"], "worst").iter().take(n).map(|slow| {
        let hop = &slow["hop"];
        let off_us = |service: &&Value| service["off_processor_us_max"].as_f64().unwrap_or(0.0);
        let services = list(&slow["disturbance"], "services").iter();
        let worst = services.max_by(|a, b| off_us(a).total_cmp(&off_us(b)));
        let worst = worst.cloned().unwrap_or_default();
        let plain = |value: &Value| Figure::plain(value.as_f64());
        Row {
            name: format!(
                "round {} trial {}: `{}`; {} off the processor longest",
                slow["round"],
                slow["trial"],
                text(&hop["name"]),
                text(&worst["name"])
            ),
            n: 1,
            figures: vec![
                plain(&slow["replanning_us"]),
                plain(&hop["time_us"]),
                plain(&hop["p50_us"]),
                plain(&worst["off_processor_us_max"]),
                plain(&worst["queue_us"]),
                plain(&worst["involuntary_switches"]),
            ],
        }
    });
    table(
        "slowest trials",
        &[
            "replanning [us]",
            "that hop [us]",
            "its median [us]",
            "off the processor [us]",
            "queued in the trial [us]",
            "preemptions",
        ],
        rows.collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn trials_give_percentiles_and_disturbances() {
        let figures = |p50: f64| {
            json!({"n": 5, "censored": 0, "p50_us": p50, "p90_us": 3.0, "p99_us": null,
                   "max_us": 9.0})
        };
        let latency_of = |p50: f64| {
            let mut hop = figures(p50 / 2.0);
            hop["name"] = json!("mapping");
            json!({"replanning": figures(p50), "hops": [hop], "event_to_motion": figures(4.0),
                   "reaction": figures(2.0), "transport_floor": figures(1.0)})
        };
        let service = json!({"name": "mapping", "processor_us": 1000.0, "queue_us": 500.0,
            "off_processor_us_max": 70.0, "involuntary_switches": 2, "major_faults": 0});
        let disturbance_of = json!({"load_end": 1.5, "steal": 0.01, "services": [service]});
        let round = |p50: f64| json!({"trials": 5, "latency": latency_of(p50), "disturbance": disturbance_of});
        let slow = json!({"round": 2, "trial": 4, "replanning_us": 9.0,
            "hop": {"name": "mapping", "time_us": 7.0, "p50_us": 1.0},
            "disturbance": disturbance_of});
        let result = json!({"latency": latency_of(2.0),
            "trials": {"rounds": [round(1.0), round(2.0), round(5.0)], "worst": [slow]}});
        let latencies = latency(&result);
        let replanning = &latencies.rows[0].figures[0];
        assert_eq!(
            (replanning.value, replanning.low, replanning.high),
            (Some(2.0), Some(1.0), Some(5.0))
        );
        let hop = &latencies.rows[1];
        assert_eq!(
            (hop.name.as_str(), hop.figures[0].high),
            ("of it `mapping`", Some(2.5))
        );
        assert_eq!(
            hop.figures[2],
            Figure::plain(None),
            "no percentile is made up"
        );
        assert_eq!(latencies.rows.len(), 5);
        let rounds = disturbance(&result);
        assert_eq!(rounds.rows.len(), 3);
        assert_eq!(rounds.rows[0].figures[1].value, Some(0.5));
        let unchecked = checks(&result);
        assert_eq!(unchecked.rows[0].figures[0], Figure::plain(None));
        let mut checked = result.clone();
        checked["latency"]["ways"] = json!(70);
        checked["latency"]["hops_out_of_order"] = json!({"mapping": 1, "to_robot": 2});
        checked["latency"]["second_clock"] =
            json!({"end_to_end": figures(3.0), "difference": figures(0.5), "beyond": 0});
        assert_eq!(latency(&checked).rows.len(), 7);
        let checked = checks(&checked);
        assert_eq!(
            (checked.rows[0].n, checked.rows[0].figures[0].value),
            (70, Some(3.0))
        );
        assert_eq!(slowest(&result, 0).rows.len(), 0);
        let slowest = slowest(&result, 5);
        assert!(slowest.rows[0].name.contains("round 2 trial 4: `mapping`"));
        assert_eq!(slowest.rows[0].figures[3].value, Some(70.0));
        assert_eq!(
            hop_p50_us(&[result.clone(), result], "mapping").value,
            Some(1.0)
        );
        assert!(row(&latencies, "reaction").is_ok() && row(&latencies, "rest").is_err());
    }

    #[test]
    fn the_tail_has_a_percentile_more() {
        let replanning = json!({"name": "replanning", "n": 1000, "censored": 1, "p50_us": 1.0,
            "p90_us": 2.0, "p99_us": 3.0, "p999_us": 4.0, "max_us": 5.0});
        let tail = tail(&json!({"profile": {"rows": [replanning]}}));
        let values: Vec<Option<f64>> = tail.rows[0].figures.iter().map(|one| one.value).collect();
        assert_eq!(values, [1.0, 2.0, 3.0, 4.0, 5.0, 1.0].map(Some));
        assert_eq!((tail.rows[0].n, tail.rows[1].n), (1000, 0));
    }
}
