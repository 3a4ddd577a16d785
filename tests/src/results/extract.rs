//! From the results of `zeronav` and the samples of criterion to tables.

use super::bench::Timing;
use super::record::{Row, Table};
use super::spread::Figure;
use serde_json::Value;

pub(super) fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

pub(super) fn text(value: &Value) -> String {
    value.as_str().unwrap_or("?").to_owned()
}

pub(super) fn table(title: &str, columns: &[&str], rows: Vec<Row>) -> Table {
    Table {
        title: title.to_owned(),
        columns: columns.iter().map(|&column| column.to_owned()).collect(),
        rows,
    }
}

pub(super) fn count(n: usize) -> u64 {
    n as u64
}

/// Speed and sameness of lockstep runs of one scenario.
#[must_use]
pub fn lockstep(name: &str, results: &[Value]) -> Table {
    let of = |key: &str| -> Vec<f64> {
        let values = results.iter();
        values.filter_map(|result| result[key].as_f64()).collect()
    };
    let mut hashes: Vec<&str> = results
        .iter()
        .filter_map(|result| result["run_hash"].as_str())
        .collect();
    hashes.sort_unstable();
    hashes.dedup();
    let different = u32::try_from(hashes.len()).ok().map(f64::from);
    let row = Row {
        name: name.to_owned(),
        n: count(results.len()),
        figures: vec![
            Figure::median(&of("speed_factor")),
            Figure::median(&of("wall_s")),
            Figure::plain(different),
        ],
    };
    table(
        "lockstep runs",
        &[
            "speed [x real time]",
            "wall time [s]",
            "different run hashes",
        ],
        vec![row],
    )
}

/// Memory of runs of one scenario.
#[must_use]
pub fn memory(results: &[Value]) -> Table {
    let row = |name: String, of: &dyn Fn(&Value) -> Option<f64>| {
        let megabytes: Vec<f64> = results.iter().filter_map(of).map(|b| b / 1e6).collect();
        Row {
            name,
            n: count(megabytes.len()),
            figures: vec![Figure::median(&megabytes)],
        }
    };
    let mut rows = vec![row("shared memory of the run".to_owned(), &|result| {
        result["shared_memory_bytes"].as_f64()
    })];
    let first = results.first().cloned().unwrap_or_default();
    for service in list(&first, "services") {
        let name = text(&service["name"]);
        rows.push(row(format!("peak memory of {name}"), &|result| {
            let services = list(result, "services").iter();
            let mut same = services.filter(|other| other["name"] == service["name"]);
            same.next()?["memory_peak_bytes"].as_f64()
        }));
    }
    table("", &["MB"], rows)
}

/// Drives of scenarios with several seeds: pose, distance, contacts.
#[must_use]
pub fn drives(runs: &[(&str, Vec<Value>)]) -> Table {
    let rows = runs.iter().map(|(name, results)| {
        let of = |pointer: &str| -> Vec<f64> {
            let values = results.iter().filter_map(|result| result.pointer(pointer));
            values.filter_map(Value::as_f64).collect()
        };
        let arrived = results.iter().filter(|result| result["reached"] == true);
        let free = results.iter().filter(|result| result["contacts"] == 0);
        let scaled = |pointer: &str, by: f64| -> Vec<f64> {
            of(pointer).iter().map(|value| value * by).collect()
        };
        Row {
            name: format!("`{name}`"),
            n: count(results.len()),
            figures: vec![
                Figure::rate(arrived.count(), results.len()),
                Figure::rate(free.count(), results.len()),
                Figure::median(&of("/driven_m")),
                Figure::median(&of("/time_s")),
                Figure::median(&of("/clearance_m_min")),
                Figure::median(&scaled("/pose/error_m_max", 100.0)),
                Figure::median(&scaled(
                    "/pose/error_rad_max",
                    180.0 / core::f64::consts::PI,
                )),
                Figure::median(&of("/pose/odometry_error_m_max")),
                Figure::median(&of("/tracking/found")),
                Figure::median(&of("/tracking/missed")),
                Figure::median(&of("/tracking/false_moving")),
            ],
        }
    });
    table(
        "scenario",
        &[
            "arrived",
            "without contact",
            "driven [m]",
            "run time [s]",
            "closest [m]",
            "largest pose error [cm]",
            "largest yaw error [degrees]",
            "odometry alone, largest error [m]",
            "dynamic obstacles found",
            "missed",
            "false",
        ],
        rows.collect(),
    )
}

/// Suites of several controllers on the same worlds with the same seeds.
///
/// # Errors
/// One line when two of them drove different worlds: those are never set side by side.
pub fn suites(reports: &[(&str, Value)]) -> Result<Table, String> {
    let worlds = |report: &Value| -> Vec<(String, String)> {
        let runs = list(report, "runs").iter();
        runs.map(|run| (text(&run["world"]), run["seed"].to_string()))
            .collect()
    };
    let mut rows = Vec::new();
    for (name, report) in reports {
        if worlds(report) != worlds(&reports[0].1) {
            return Err(format!(
                "{name} and {} drove different worlds",
                reports[0].0
            ));
        }
        let runs: Vec<&Value> = list(report, "runs").iter().collect();
        rows.push(suite_row((*name).to_owned(), &runs));
        let mut classes: Vec<&str> = runs
            .iter()
            .filter_map(|run| run["class"].as_str())
            .collect();
        classes.sort_unstable();
        classes.dedup();
        for class in classes.iter().filter(|_| classes.len() > 1) {
            let of_class = runs.iter().filter(|run| run["class"] == **class);
            let of_class: Vec<&Value> = of_class.copied().collect();
            rows.push(suite_row(format!("{name}, {class}"), &of_class));
        }
    }
    let has_ways = |report: &Value| {
        list(report, "runs")
            .iter()
            .any(|run| run["way_exists"].is_boolean())
    };
    let mut columns = SUITE_COLUMNS.to_vec();
    if reports.iter().any(|(_, report)| has_ways(report)) {
        columns.extend(WAY_COLUMNS);
    } else {
        for row in &mut rows {
            row.figures.truncate(columns.len());
        }
    }
    Ok(table("", &columns, rows))
}

/// Where a way of the robot's outline was looked for.
const WAY_COLUMNS: [&str; 3] = [
    "arrived where a way exists",
    "arrivals that were none",
    "run time per time of the way",
];

const SUITE_COLUMNS: [&str; 9] = [
    "success",
    "arrived",
    "contact while moving",
    "contact while stopped",
    "contact by own fault",
    "score (2 OT), mean",
    "clock or time of successes [s]",
    "closest [m]",
    "guard interventions per run",
];

fn suite_row(name: String, runs: &[&Value]) -> Row {
    let rate = |is: &dyn Fn(&Value) -> bool| {
        Figure::rate(runs.iter().filter(|run| is(run)).count(), runs.len())
    };
    let values = |of: &dyn Fn(&Value) -> Option<f64>| -> Vec<f64> {
        runs.iter().filter_map(|run| of(run)).collect()
    };
    let number = |run: &Value, key: &str| run[key].as_f64();
    // Only where the future of everything that moves is known.
    let judged = runs.iter().any(|run| run["unavoidable"].is_u64());
    // Where nothing moves it is not said what was unavoidable: nothing was.
    let own_fault = |run: &Value| {
        let number = |key: &str| run[key].as_u64().unwrap_or(0);
        number("contacts_moving") > number("unavoidable")
    };
    let time_s = |run: &Value| {
        let time = number(run, "clock_s").or_else(|| number(run, "time_s"));
        time.filter(|_| run["success"] == true)
    };
    let with_way: Vec<_> = runs
        .iter()
        .filter(|run| run["way_exists"] == true)
        .collect();
    Row {
        name,
        n: count(runs.len()),
        figures: vec![
            rate(&|run| run["success"] == true),
            rate(&|run| run["arrived"] == true),
            rate(&|run| run["contacts_moving"].as_u64() > Some(0)),
            rate(&|run| run["contacts_standing"].as_u64() > Some(0)),
            if judged {
                rate(&own_fault)
            } else {
                Figure::default()
            },
            Figure::mean(&values(&|run| number(run, "score"))),
            Figure::median(&values(&time_s)),
            Figure::median(&values(&|run| number(run, "clearance_m_min"))),
            Figure::median(&values(&|run| number(run, "interventions"))),
            Figure::rate(
                with_way.iter().filter(|run| run["arrived"] == true).count(),
                with_way.len(),
            ),
            rate(&|run| run["wrong_arrival"] == true),
            Figure::median(&values(&|run| number(run, "time_ratio"))),
        ],
    }
}

/// Criterion's samples.
#[must_use]
pub fn timings(timings: &[Timing]) -> Table {
    let row = |timing: &Timing| Row {
        name: timing.name.clone(),
        n: count(timing.samples_us.len()),
        figures: vec![Figure::median(&timing.samples_us)],
    };
    table("", &["time [us]"], timings.iter().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn suites_on_different_worlds_are_not_compared() {
        let report = |worlds: &[&str]| {
            let run = |world: &&str| json!({"world": world, "seed": 1, "success": true});
            json!({"runs": worlds.iter().map(run).collect::<Vec<_>>()})
        };
        let (ten, other) = (report(&["a", "b"]), report(&["a", "c"]));
        assert!(suites(&[("x", ten.clone()), ("y", ten.clone())]).is_ok());
        let error = suites(&[("x", ten.clone()), ("y", other)]).expect_err("different");
        assert!(error.contains("different worlds"), "{error}");
        assert!(suites(&[("x", ten), ("y", report(&["a"]))]).is_err());
    }

    #[test]
    fn a_run_without_contact_is_at_no_fault_where_nothing_moves() {
        let run = |class: &str, contacts: u32, unavoidable: Option<u32>| {
            json!({"world": class, "seed": 1, "class": class, "contacts_moving": contacts,
                   "unavoidable": unavoidable})
        };
        let runs = [
            run("static", 0, None),
            run("static", 1, None),
            run("walkers", 2, Some(2)),
            run("walkers", 2, Some(1)),
        ];
        let all = suites(&[("dwa", json!({"runs": runs}))]).expect("a table");
        assert_eq!(all.rows[0].figures[4], Figure::rate(2, 4));
        assert_eq!(all.rows[1].figures[4], Figure::default(), "not judged");
        assert_eq!(all.rows[2].figures[4], Figure::rate(1, 2));
    }

    #[test]
    fn suites_count_runs_with_intervals() {
        let run = |success: bool, own: bool, class: &str| {
            json!({"world": class, "seed": 1, "class": class, "success": success,
                   "arrived": true, "contacts_moving": u32::from(own) + 1, "unavoidable": 1,
                   "contacts_standing": 0, "score": 0.5, "clock_s": 6.0, "time_s": 9.0,
                   "interventions": 3})
        };
        let report = json!({"runs": [run(true, false, "easy"), run(false, true, "hard")]});
        let all = suites(&[("beam", report)]).expect("a table");
        let names: Vec<&str> = all.rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names, ["beam", "beam, easy", "beam, hard"]);
        let row = &all.rows[0];
        assert_eq!(row.n, 2);
        assert_eq!(row.figures[0], Figure::rate(1, 2));
        assert_eq!(row.figures[4], Figure::rate(1, 2), "one avoidable contact");
        assert_eq!(
            row.figures[6].value,
            Some(6.0),
            "of successes, by the clock"
        );
        assert_eq!(row.figures.len(), all.columns.len());
    }
}
