//! The house keeps its floor plan: which rooms there are, and who may lean on whom.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zeronav_tests::workspace;

/// Who may depend on whom, inside the workspace. `services` stands for every service library.
fn allowed(from: &str) -> &'static [&'static str] {
    match from {
        "zeronav-msgs" | "zeronav-params" => &[],
        "zeronav-shell" => &["zeronav-msgs", "zeronav-params"],
        "zeronav-world" => &["zeronav-msgs"],
        "zeronav-mapping" | "zeronav-robot-sim" => &[
            "zeronav-msgs",
            "zeronav-params",
            "zeronav-world",
            "zeronav-shell",
        ],
        "zeronav-global-planner" | "zeronav-local-planner" | "zeronav-collision-guard" => {
            &["zeronav-msgs", "zeronav-params", "zeronav-shell"]
        }
        "zeronav" => &[
            "zeronav-msgs",
            "zeronav-params",
            "zeronav-shell",
            "zeronav-world",
        ],
        _ => panic!("{from} has no place on the floor plan"),
    }
}

fn manifests() -> BTreeMap<String, toml::Table> {
    let root: toml::Table = read(&workspace().join("Cargo.toml"));
    let members = root["workspace"]["members"].as_array().expect("members");
    members
        .iter()
        .map(|member| {
            let folder = workspace().join(member.as_str().expect("a path"));
            let manifest = read(&folder.join("Cargo.toml"));
            let name = manifest["package"]["name"]
                .as_str()
                .expect("a name")
                .to_owned();
            (name, manifest)
        })
        .collect()
}

fn read(file: &Path) -> toml::Table {
    std::fs::read_to_string(file)
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
        .parse()
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

#[test]
fn nobody_leans_on_whom_he_may_not() {
    let manifests = manifests();
    let mut extra = Vec::new();
    for (name, manifest) in manifests
        .iter()
        .filter(|(name, _)| *name != "zeronav-tests")
    {
        let Some(dependencies) = manifest.get("dependencies").and_then(toml::Value::as_table)
        else {
            continue;
        };
        for dependency in dependencies
            .keys()
            .filter(|key| manifests.contains_key(*key))
        {
            if !allowed(name).contains(&dependency.as_str()) {
                extra.push(format!("{name} -> {dependency}"));
            }
        }
    }
    assert!(
        extra.is_empty(),
        "arrows that are not on the floor plan: {extra:?}"
    );
}

#[test]
fn the_libraries_of_services_do_without_processes() {
    for (name, manifest) in manifests() {
        let features = manifest.get("features");
        if features.is_none_or(|features| features.get("process").is_none()) {
            continue;
        }
        let dependencies = manifest["dependencies"].as_table().expect("dependencies");
        assert!(
            !dependencies.contains_key("iceoryx2"),
            "{name} uses the middleware itself"
        );
        for process_only in ["zeronav-shell", "tracing"] {
            let optional = dependencies.get(process_only).is_none_or(|dependency| {
                dependency.get("optional").and_then(toml::Value::as_bool) == Some(true)
            });
            assert!(optional, "{name}: {process_only} is not optional");
        }
    }
}

#[test]
fn the_top_level_is_as_given() {
    let mut rooms: BTreeSet<String> = std::fs::read_dir(workspace())
        .expect("the workspace")
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| !name.starts_with('.'))
        .collect();
    // Made by cargo, by runs and by the version control, not by us.
    for made in ["target", "runs", "Cargo.lock"] {
        rooms.remove(made);
    }
    let given = [
        "Cargo.toml",
        "README.md",
        "launch",
        "msgs",
        "services",
        "tests",
    ];
    assert_eq!(rooms, given.into_iter().map(str::to_owned).collect());
}

#[test]
fn topic_names_are_strings_in_one_file_only() {
    let names: Vec<&str> = zeronav_msgs::topics::topics()
        .iter()
        .map(|row| row.name)
        .collect();
    // The table itself, and the layouts that it is compared with.
    let homes = ["msgs/src/topics.rs", "msgs/tests/layout.rs"].map(|file| workspace().join(file));
    let mut found = Vec::new();
    let rooms = ["services", "launch", "msgs", "tests"];
    let files: Vec<PathBuf> = rooms
        .iter()
        .flat_map(|room| sources(&workspace().join(room)))
        .collect();
    assert!(
        homes.iter().all(|home| files.contains(home)),
        "{homes:?} have moved"
    );
    for file in files.iter().filter(|file| !homes.contains(file)) {
        let text = std::fs::read_to_string(file).expect("a source file");
        for line in text
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"))
        {
            for name in &names {
                if line.contains(&format!("\"{name}\"")) {
                    found.push(format!("{}: {name}", file.display()));
                }
            }
        }
    }
    assert!(
        found.is_empty(),
        "topic names outside msgs/src/topics.rs: {found:?}"
    );
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let entries =
        std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    for entry in entries {
        let path = entry.expect("an entry of a folder").path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files
}
