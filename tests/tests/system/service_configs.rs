//! What the services make of configurations that cannot be: every number and every name of the
//! configurations that they print themselves.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};
use toml::{Table, Value};
use zeronav_tests::generated::{COMMAND, PRINTED};
use zeronav_tests::{binaries, command};

/// The stock services but for the robot, whose configuration is a part of the scenario.
const SERVICES: [&str; 4] = [
    "zeronav-mapping",
    "zeronav-global-planner",
    "zeronav-local-planner",
    "zeronav-collision-guard",
];

/// What it takes to have all tables printed.
const AREA: &str = "area_m = [[0.0, 0.0], [10.0, 8.0]]\n";

fn ask(service: &str, folder: &Path, text: &str) -> Output {
    let file = folder.join("it.toml");
    std::fs::write(&file, text).expect("written");
    Command::new(binaries().join(service))
        .args(["--print-config", "--config"])
        .arg(&file)
        .output()
        .expect("it starts")
}

/// What the service prints without any configuration but what it needs.
fn defaults(service: &str, folder: &Path) -> Value {
    let text = if service == "zeronav-mapping" {
        AREA
    } else {
        ""
    };
    let printed = ask(service, folder, text);
    assert!(printed.status.success(), "{service}: {printed:?}");
    let text = String::from_utf8(printed.stdout).expect("TOML");
    Value::Table(text.parse::<Table>().expect("TOML"))
}

/// The keys that lead to all values below `value` but those of lists.
fn ways(value: &Value, way: &[String], all: &mut Vec<Vec<String>>) {
    for (key, value) in value.as_table().into_iter().flatten() {
        let way: Vec<String> = way.iter().chain([key]).cloned().collect();
        ways(value, &way, all);
        all.push(way);
    }
}

fn at<'a>(root: &'a mut Value, way: &[String]) -> &'a mut Value {
    way.iter().fold(root, |value, key| &mut value[key.as_str()])
}

/// Exit 2 and one line with `word`.
#[track_caller]
fn refused(ended: &Output, word: &str) {
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(
        ended.status.code(),
        Some(2),
        "{word}: accepted or crashed: {said}"
    );
    assert_eq!(said.lines().count(), 1, "{word}: {said}");
    assert!(said.contains(word), "{word} is not named: {said}");
    assert!(ended.stdout.is_empty(), "{word}");
}

#[test]
fn every_number_of_a_service_has_a_range() {
    let folder = tempfile::tempdir().expect("a folder");
    for service in SERVICES {
        let printed = defaults(service, folder.path());
        let mut all = Vec::new();
        ways(&printed, &[], &mut all);
        let mut n_numbers = 0;
        for way in all {
            if !at(&mut printed.clone(), &way).is_float() {
                continue;
            }
            n_numbers += 1;
            for wrong in [f64::NAN, f64::INFINITY, -1.0e300] {
                let mut changed = printed.clone();
                *at(&mut changed, &way) = wrong.into();
                let text = toml::to_string(&changed).expect("TOML");
                refused(&ask(service, folder.path(), &text), &way.join("."));
            }
        }
        assert!(n_numbers > 4, "{service} has {n_numbers} numbers");
    }
}

#[test]
fn misspelt_service_keys_are_reported_with_line_and_field() {
    let folder = tempfile::tempdir().expect("a folder");
    for service in SERVICES {
        let printed = defaults(service, folder.path());
        let mut all = Vec::new();
        ways(&printed, &[], &mut all);
        let mut named = BTreeSet::new();
        for way in all {
            let (key, table) = way.split_last().expect("a key");
            if !named.insert(way.clone()) {
                continue;
            }
            let mut changed = printed.clone();
            let misspelt = format!("{key}x");
            let table_at = at(&mut changed, table).as_table_mut().expect("a table");
            let old = table_at.remove(key).expect("the key");
            table_at.insert(misspelt.clone(), old);
            let text = toml::to_string(&changed).expect("TOML");
            let ended = ask(service, folder.path(), &text);
            let field: Vec<&str> = (table.iter().map(String::as_str))
                .chain([misspelt.as_str()])
                .collect();
            refused(&ended, &format!(": {}: ", field.join(".")));
            refused(&ended, &format!("did you mean `{key}`?"));
        }
    }
}

#[test]
fn every_value_of_a_configuration_is_described_with_its_default() {
    let folder = tempfile::tempdir().expect("a folder");
    for service in SERVICES {
        let role = &service["zeronav-".len()..].replace('-', "_");
        let described = command()
            .args(["params", role, "--json", "--binary"])
            .arg(binaries().join(service))
            .output()
            .expect("it starts");
        assert!(described.status.success(), "{described:?}");
        let described: serde_json::Value = serde_json::from_slice(&described.stdout).expect("JSON");
        let described = described["parameters"].as_array().expect("a list");
        let mut printed = defaults(service, folder.path());
        let mut all = Vec::new();
        ways(&printed, &[], &mut all);
        for way in all {
            let value = at(&mut printed, &way);
            if value.is_table() {
                continue;
            }
            let path = way.join(".");
            if path == "area_m" {
                continue; // Required, so that it was given.
            }
            let one = described.iter().find(|one| one["path"] == path.as_str());
            let one = one.unwrap_or_else(|| panic!("{role} does not describe {path}"));
            let default: serde_json::Value = value.clone().try_into().expect("JSON");
            assert_eq!(one["default"], default, "{role} {path}");
            let has_range = one["min"].is_number() && one["max"].is_number();
            assert!(has_range || !value.is_float(), "{role} {path} has no range");
            assert!(
                one["description"]
                    .as_str()
                    .is_some_and(|text| text.len() > 5)
            );
        }
    }
}

#[test]
fn what_zeronav_prints_is_current_in_the_repository() {
    for printed in PRINTED {
        let written = printed.text().expect("printed");
        let stored = std::fs::read_to_string(printed.path()).unwrap_or_default();
        assert!(
            written == stored,
            "{} is not current: {COMMAND}",
            printed.file
        );
    }
}

#[test]
fn the_table_of_all_parameters_has_those_of_every_service() {
    let table = PRINTED[0].text().expect("printed");
    for row in [
        "| `robot.lidar.n_beams` | integer |",
        "| `controller` | string |",
    ] {
        assert!(table.contains(row), "{row} is missing");
    }
}
