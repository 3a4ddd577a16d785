//! What a second computer costs: the same drive with every seat on one host and with mapping and planners on another one,
//! and drives over ways that are cut, late, lossy and narrow.

use super::bench::{Bench, Measured, write_scenario};
use super::extract::{list, table};
use super::record::{Row, Table};
use super::spread::Figure;
use crate::hosts::{Way, inside, scenario};
use crate::{is_alive, report_of, send_signal};
use rustix::process::Signal;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Drives of either kind, in turn.
const ROUNDS: usize = 5;

/// Drives over each kind of way, and how many of them at a time.
const DRIVES: usize = 20;
const AT_ONCE: usize = 4;

/// Run time at which a way becomes bad [s], and time between two looks at it.
const BEGINS_S: f64 = 2.0;
const LOOK: Duration = Duration::from_millis(20);

/// Ways that are bad for so long in a drive [s], or all the time, and how.
fn ways() -> [(&'static str, Value, Option<f64>); 8] {
    [
        ("cut for 0.1 s", json!({ "cut": true }), Some(0.1)),
        ("cut for 1 s", json!({ "cut": true }), Some(1.0)),
        ("cut for 10 s", json!({ "cut": true }), Some(10.0)),
        (
            "nothing from the robot for 3 s",
            json!({ "half": true }),
            Some(3.0),
        ),
        ("2 % lost", json!({ "loss": 0.02 }), None),
        ("20 % lost", json!({ "loss": 0.2 }), None),
        (
            "20 ms +- 10 ms late, reordered",
            json!({ "delay_s": 0.02, "jitter_s": 0.01 }),
            None,
        ),
        ("1 Mbit/s", json!({ "bytes_per_s": 125_000 }), None),
    ]
}

/// A process that is ended when nobody needs it any more.
struct Base(Child);

impl Base {
    fn start(bench: &mut Bench, namespace: &str, file: &str) -> Result<Self, String> {
        let mut command = inside(
            namespace,
            &bench.command(&["up", file, "--host", "base"], &[]),
        );
        spawn(command.stdout(Stdio::null())).map(Self)
    }
}

impl Drop for Base {
    fn drop(&mut self) {
        let _ = send_signal(self.0.id(), Signal::INT);
        let _ = self.0.wait();
    }
}

fn spawn(command: &mut Command) -> Result<Child, String> {
    let command = command.current_dir(crate::workspace()).stdin(Stdio::null());
    let started = command.stderr(Stdio::null()).spawn();
    started.map_err(|error| format!("{command:?}: {error}"))
}

/// The result of a drive, whatever came of it.
fn result(drive: Child) -> Result<Value, String> {
    let output = drive
        .wait_with_output()
        .map_err(|error| error.to_string())?;
    serde_json::from_slice(&output.stdout).map_err(|error| format!("a drive on two hosts: {error}"))
}

/// All tables.
pub(super) fn make(bench: &mut Bench) -> Result<Measured, String> {
    let (alone, both) = in_turn(bench)?;
    let mut tables = vec![hops(&alone, &both)?, topics(&both), link(&both)];
    let mut rows = Vec::new();
    for (name, how, lasts_s) in ways() {
        rows.push(over(bench, name, &how, lasts_s)?);
    }
    let columns = [
        "arrived",
        "did not arrive",
        "contacts",
        "restarts",
        "time [s]",
    ];
    tables.push(table("way", &columns, rows));
    Ok(Measured::tables(tables))
}

/// Drives on one host and on two, which are two network namespaces with a pair of devices between them.
fn in_turn(bench: &mut Bench) -> Result<(Vec<Value>, Vec<Value>), String> {
    let way = Way::plain();
    let file = write_scenario("hosts", &scenario("open_aisle", Way::end()))?;
    let (mut alone, mut both) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        alone.push(bench.zeronav(&["run", "open_aisle"])?);
        let [robot, base] = way.names();
        let _base = Base::start(bench, base, &file)?;
        let arguments = ["run", &file, "--host", "robot"];
        both.push(result(spawn(
            inside(robot, &bench.command(&arguments, &["--json"])).stdout(Stdio::piped()),
        )?)?);
    }
    Ok((alone, both))
}

fn figures(results: &[Value], of: impl Fn(&Value) -> Option<f64>) -> Figure {
    let all: Vec<f64> = results.iter().filter_map(of).collect();
    Figure::median(&all)
}

fn number(n: usize) -> f64 {
    u32::try_from(n).map_or(f64::INFINITY, f64::from)
}

fn samples(results: &[Value], of: impl Fn(&Value) -> Option<u64>) -> u64 {
    results.iter().filter_map(of).sum()
}

/// Hops of every scan on one host beside those on two.
fn hops(alone: &[Value], both: &[Value]) -> Result<Table, String> {
    let first = alone.first().ok_or("no drive")?;
    let mut rows = Vec::new();
    for way in ["direct", "through_map"] {
        for name in list(&first["latency"]["every_scan"], way) {
            let name = name["name"].as_str().unwrap_or_default();
            let hop = |result: &Value| {
                let hops = list(&result["latency"]["every_scan"], way).iter();
                hops.into_iter().find(|hop| hop["name"] == name).cloned()
            };
            rows.push(Row {
                name: format!("{way}: `{name}`"),
                n: samples(both, |it| hop(it)?["n"].as_u64()),
                figures: vec![
                    figures(alone, |it| hop(it)?["p50_us"].as_f64()),
                    figures(alone, |it| hop(it)?["p99_us"].as_f64()),
                    figures(both, |it| hop(it)?["p50_us"].as_f64()),
                    figures(both, |it| hop(it)?["p99_us"].as_f64()),
                    figures(both, |it| hop(it)?["clock_uncertainty_us"].as_f64()),
                ],
            });
        }
    }
    let reaction = |result: &Value, key: &str| result["latency"]["reaction"][key].as_f64();
    let n = |result: &Value| result["latency"]["reaction"]["n"].as_u64();
    rows.push(Row {
        name: "**reaction**".to_owned(),
        n: samples(both, n),
        figures: vec![
            figures(alone, |it| reaction(it, "p50_us")),
            figures(alone, |it| reaction(it, "p99_us")),
            figures(both, |it| reaction(it, "p50_us")),
            figures(both, |it| reaction(it, "p99_us")),
            Figure::plain(None),
        ],
    });
    let columns = [
        "one host p50 [us]",
        "p99 [us]",
        "two hosts p50 [us]",
        "p99 [us]",
        "uncertainty of the clocks [us]",
    ];
    Ok(table("", &columns, rows))
}

/// What crosses the link.
fn topics(both: &[Value]) -> Table {
    let mut sums: BTreeMap<&str, u64> = BTreeMap::new();
    for result in both {
        for (topic, carried) in result["link"]["topics"].as_object().into_iter().flatten() {
            let bytes = |key: &str| carried[key].as_u64().unwrap_or(0);
            *sums.entry(topic).or_default() += bytes("sent_bytes") + bytes("received_bytes");
        }
    }
    let mut names: Vec<(&str, u64)> = sums.into_iter().collect();
    names.sort_by_key(|(_, bytes)| core::cmp::Reverse(*bytes));
    let row = |(topic, _): (&str, u64)| {
        let rate = |key: &str, unit: f64| {
            figures(both, |result| {
                let link = &result["link"];
                Some(link["topics"][topic][key].as_f64()? / link["time_s"].as_f64()? / unit)
            })
        };
        Row {
            name: format!("`{topic}`"),
            n: both.len() as u64,
            figures: vec![
                rate("sent", 1.0),
                rate("sent_bytes", 1.0e3),
                rate("received", 1.0),
                rate("received_bytes", 1.0e3),
            ],
        }
    };
    let columns = [
        "to the base [1/s]",
        "[kB/s]",
        "to the robot [1/s]",
        "[kB/s]",
    ];
    table("topic", &columns, names.into_iter().map(row).collect())
}

/// What the robot's link takes and knows.
fn link(both: &[Value]) -> Table {
    let of = |key: &'static str| move |result: &Value| result["link"][key].as_f64();
    let share = |result: &Value| {
        let (used, time) = (of("processor_s")(result)?, of("time_s")(result)?);
        Some(100.0 * used / time)
    };
    let row = Row {
        name: "on the robot's host".to_owned(),
        n: both.len() as u64,
        figures: vec![
            figures(both, share),
            figures(both, of("uncertainty_us")),
            figures(both, of("uncertainty_us_max")),
            figures(both, of("lost")),
        ],
    };
    let columns = [
        "processor [%]",
        "uncertainty of the other clock at the end [us]",
        "the worst [us]",
        "messages lost",
    ];
    table("link", &columns, vec![row])
}

/// Drives over one kind of way.
fn over(bench: &mut Bench, name: &str, how: &Value, lasts_s: Option<f64>) -> Result<Row, String> {
    let text = scenario("unsealed", Way::end());
    let shorter = text.replace("time_limit_s = 90.0", "time_limit_s = 60.0");
    if shorter == text {
        return Err("the scenario has another time limit".to_owned());
    }
    let file = write_scenario("hosts_way", &shorter)?;
    let mut results = Vec::new();
    while results.len() < DRIVES {
        let n = AT_ONCE.min(DRIVES - results.len());
        let mut drives = Vec::new();
        for _ in 0..n {
            let way = Way::new();
            let [robot, base] = way.names().clone();
            let base = Base::start(bench, &base, &file)?;
            let arguments = ["run", &file, "--host", "robot"];
            let drive = spawn(
                inside(&robot, &bench.command(&arguments, &["--json"])).stdout(Stdio::piped()),
            )?;
            drives.push((way, base, drive));
        }
        results.extend(disturbed(drives, how, lasts_s)?);
    }
    let count = |is: &dyn Fn(&Value) -> bool| results.iter().filter(|it| is(it)).count();
    let sum = |of: &dyn Fn(&Value) -> Option<f64>| Some(results.iter().filter_map(of).sum());
    Ok(Row {
        name: name.to_owned(),
        n: results.len() as u64,
        figures: vec![
            Figure::rate(count(&|it| it["reached"] == true), results.len()),
            Figure::plain(Some(number(count(&|it| it["reached"] != true)))),
            Figure::plain(sum(&|it| it["contacts"].as_f64())),
            Figure::plain(sum(&|it| {
                it["restarts"].as_array().map(|all| number(all.len()))
            })),
            figures(&results, |it| it["time_s"].as_f64()),
        ],
    })
}

/// The results of drives side by side.
fn disturbed(
    drives: Vec<(Way, Base, Child)>,
    how: &Value,
    lasts_s: Option<f64>,
) -> Result<Vec<Value>, String> {
    std::thread::scope(|scope| {
        let drive = |(way, base, drive)| {
            scope.spawn(move || {
                let result = drive_over(way, drive, how, lasts_s);
                drop::<Base>(base);
                result
            })
        };
        let drives: Vec<_> = drives.into_iter().map(drive).collect();
        let joined = drives.into_iter().map(std::thread::ScopedJoinHandle::join);
        joined
            .map(|ended| ended.map_err(|_| "a drive on two hosts panicked".to_owned())?)
            .collect()
    })
}

/// The result of a drive whose way is bad from t = 2 s on.
fn drive_over(
    mut way: Way,
    drive: Child,
    how: &Value,
    lasts_s: Option<f64>,
) -> Result<Value, String> {
    let await_s = |least_s: f64| {
        let time_s = || report_of(drive.id()).and_then(|run| run["time_s"].as_f64());
        while is_alive(drive.id()) && time_s().is_none_or(|now_s| now_s < least_s) {
            std::thread::sleep(LOOK);
        }
    };
    await_s(BEGINS_S);
    way.set(how);
    if let Some(lasts_s) = lasts_s {
        await_s(BEGINS_S + lasts_s);
        way.mend();
    }
    result(drive)
}
