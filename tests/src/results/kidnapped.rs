//! Robots that do not know where on a map they are: how many find themselves, when, and how exactly.

use super::bench::{Bench, Measured};
use super::extract::{count, list, table};
use super::record::{Row, Table};
use super::spread::Figure;
use serde_json::Value;

const COLUMNS: [&str; 8] = [
    "found",
    "wrong and certain",
    "lost",
    "contacts",
    "run time [s]",
    "at most [s]",
    "pose error [cm]",
    "yaw error [deg]",
];

/// Every map of the data set.
pub(super) fn make(bench: &mut Bench) -> Result<Measured, String> {
    let report = bench.zeronav(&["suite", "kidnapped"])?;
    Ok(Measured::tables(vec![found(&report)]))
}

/// What became of the robots: all of them by what they were told, and those of every map.
pub(super) fn found(report: &Value) -> Table {
    let runs: Vec<&Value> = list(report, "runs").iter().collect();
    let class = |run: &Value| run["class"].as_str().unwrap_or("?").replace('_', " ");
    let map = |run: &Value| {
        let world = run["world"].as_str().unwrap_or("?");
        world
            .rsplit_once('_')
            .map_or(world, |(map, _)| map)
            .to_owned()
    };
    let mut names: Vec<String> = runs.iter().map(|run| class(run)).collect();
    names.extend(
        runs.iter()
            .map(|run| format!("{}, {}", class(run), map(run))),
    );
    names.sort();
    names.dedup();
    let of = |name: &str| -> Vec<&Value> {
        let is =
            |run: &&&Value| class(run) == name || format!("{}, {}", class(run), map(run)) == name;
        runs.iter().filter(is).copied().collect()
    };
    let rows = names.iter().map(|name| row(name, &of(name)));
    table("", &COLUMNS, rows.collect())
}

fn row(name: &str, runs: &[&Value]) -> Row {
    let rate = |is: &dyn Fn(&Value) -> bool| {
        Figure::rate(runs.iter().filter(|run| is(run)).count(), runs.len())
    };
    let of_found = |key: &str, scale: f64| -> Vec<f64> {
        let found = runs.iter().filter(|run| run["success"] == true);
        found
            .filter_map(|run| Some(scale * run[key].as_f64()?))
            .collect()
    };
    let times_s = of_found("time_s", 1.0);
    let most_s = times_s.iter().copied().reduce(f64::max);
    let touches = |run: &Value, key: &str| run[key].as_u64() > Some(0);
    Row {
        name: name.to_owned(),
        n: count(runs.len()),
        figures: vec![
            rate(&|run| run["success"] == true),
            rate(&|run| run["wrong_arrival"] == true),
            rate(&|run| touches(run, "lost")),
            rate(&|run| touches(run, "contacts_moving") || touches(run, "contacts_standing")),
            Figure::median(&times_s),
            Figure::plain(most_s),
            Figure::median(&of_found("pose_error_m", 100.0)),
            Figure::median(&of_found("pose_error_rad", 1.0_f64.to_degrees())),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn robots_are_counted_by_what_they_were_told_and_by_map() {
        let run = |world: &str, class: &str, success: bool, wrong: bool| {
            json!({"world": world, "class": class, "success": success, "wrong_arrival": wrong, "time_s": 2.0,
                   "lost": u32::from(class == "told_wrong"), "contacts_moving": 0, "contacts_standing": 0, "pose_error_m": 0.02, "pose_error_rad": 0.01})
        };
        let runs = [
            run("hall_a_00", "told_nothing", true, false),
            run("hall_a_20", "told_wrong", false, true),
            run("depot_40", "told_nothing", false, false),
        ];
        let table = found(&json!({"runs": runs}));
        let names: Vec<&str> = table.rows.iter().map(|row| row.name.as_str()).collect();
        let expected = [
            "told nothing",
            "told nothing, depot",
            "told nothing, hall_a",
            "told wrong",
            "told wrong, hall_a",
        ];
        assert_eq!(names, expected);
        assert_eq!(table.rows[0].n, 2);
        assert_eq!(table.rows[0].figures[0], Figure::rate(1, 2));
        assert_eq!(table.rows[0].figures[6], Figure::median(&[2.0]));
        assert_eq!(table.rows[3].figures[1], Figure::rate(1, 1));
        assert_eq!(table.rows[0].figures[2], Figure::rate(0, 2));
        assert_eq!(table.rows[3].figures[2], Figure::rate(1, 1));
    }
}
