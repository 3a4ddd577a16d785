//! The README's tables say what the code says: every planner, every parameter, every default.

use std::collections::BTreeMap;
use zeronav_global_planner::{GlobalPlannerConfig, PLANNERS};

/// Cells of the tables' rows that begin with a name in backticks.
fn rows() -> Vec<Vec<&'static str>> {
    include_str!("../../README.md")
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect()
}

fn names(cell: &str) -> impl Iterator<Item = &str> {
    cell.split(',').map(|name| name.trim().trim_matches('`'))
}

#[test]
fn every_planner_has_its_line() {
    for row in PLANNERS {
        let line = rows()
            .into_iter()
            .find(|cells| cells.len() == 4 && names(cells[0]).eq([row.key]))
            .unwrap_or_else(|| panic!("{} is not in the README", row.key));
        assert_eq!(line[3].starts_with("yes"), row.complete, "{}", row.key);
    }
}

/// Dotted names of every value in a table.
fn flatten(prefix: &str, value: &toml::Value, into: &mut BTreeMap<String, String>) {
    match value {
        toml::Value::Table(table) => {
            for (name, value) in table {
                let dot = if prefix.is_empty() { "" } else { "." };
                flatten(&format!("{prefix}{dot}{name}"), value, into);
            }
        }
        value => {
            let text = value.to_string();
            let number = text.strip_suffix(".0").unwrap_or(&text);
            into.insert(prefix.to_owned(), number.to_owned());
        }
    }
}

#[test]
fn every_parameter_has_its_line_and_its_default() {
    let config = toml::Value::try_from(GlobalPlannerConfig::default()).unwrap();
    let mut defaults = BTreeMap::new();
    flatten("", &config, &mut defaults);
    let mut told = BTreeMap::new();
    for cells in rows() {
        let (prefix, default) = match cells[..] {
            [_, _, default, _] if PLANNERS.iter().all(|row| !cells[0].contains(row.key)) => {
                ("", default)
            }
            [_, _, default, _, _] => ("options.papers.", default),
            _ => continue,
        };
        for (name, default) in names(cells[0]).zip(names(default)) {
            told.insert(format!("{prefix}{name}"), default.to_owned());
        }
    }
    // Those without a default are not part of the default configuration.
    assert!(told.remove("budget_expansions").is_some());
    assert_eq!(told, defaults);
}
