//! The structure of the project: folders, dependencies between crates, circles of modules, and the
//! length of files and functions.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zeronav_tests::structure::{Crate, crates_of, length};
use zeronav_tests::workspace;

/// Most lines of a source file.
const FILE_LINES_MAX: usize = 500;

/// Most lines of a function, from `fn` to its closing brace.
const FUNCTION_LINES_MAX: usize = 80;

/// Dependencies that a crate may have inside the workspace, beside the casts that any may have.
// long: a row for each crate
#[allow(clippy::too_many_lines, reason = "a row for each crate")]
fn allowed(from: &str) -> &'static [&'static str] {
    match from {
        "zeronav-casts" | "zeronav-files" | "zeronav-msgs" | "zeronav-params" => &[],
        "zeronav-shell" => &["zeronav-files", "zeronav-msgs", "zeronav-params"],
        "zeronav-world" => &["zeronav-msgs", "zeronav-params"],
        "zeronav-cpp" | "zeronav-link" => &["zeronav-msgs", "zeronav-shell"],
        "zeronav-viewer" => &["zeronav-msgs", "zeronav-observe", "zeronav-shell"],
        "zeronav-motion" | "zeronav-observe" | "zeronav-ros-messages" => &["zeronav-msgs"],
        "zeronav-world-files" => &["zeronav-files", "zeronav-msgs", "zeronav-world"],
        "zeronav-robot-description" => &["zeronav-msgs", "zeronav-params", "zeronav-world"],
        "zeronav-mapping" => &[
            "zeronav-msgs",
            "zeronav-params",
            "zeronav-world",
            "zeronav-world-files",
            "zeronav-shell",
        ],
        "zeronav-robot-sim" => &[
            "zeronav-msgs",
            "zeronav-params",
            "zeronav-motion",
            "zeronav-robot-description",
            "zeronav-world",
            "zeronav-world-files",
            "zeronav-shell",
        ],
        "zeronav-global-planner" => &["zeronav-msgs", "zeronav-params", "zeronav-shell"],
        "zeronav-local-planner" | "zeronav-collision-guard" => &[
            "zeronav-msgs",
            "zeronav-params",
            "zeronav-motion",
            "zeronav-shell",
        ],
        "zeronav-papers" => &[
            "zeronav-msgs",
            "zeronav-observe",
            "zeronav-world",
            "zeronav-global-planner",
            "zeronav-local-planner",
        ],
        "zeronav-measure" => &[
            "zeronav-files",
            "zeronav-msgs",
            "zeronav-observe",
            "zeronav-shell",
        ],
        "zeronav-ros2" => &[
            "zeronav-msgs",
            "zeronav-params",
            "zeronav-robot-description",
            "zeronav-ros-messages",
            "zeronav-shell",
        ],
        "zeronav-recorder" => &[
            "zeronav-files",
            "zeronav-msgs",
            "zeronav-observe",
            "zeronav-ros-messages",
            "zeronav-shell",
        ],
        "zeronav-scenario" => &[
            "zeronav-console",
            "zeronav-files",
            "zeronav-msgs",
            "zeronav-params",
            "zeronav-robot-description",
            "zeronav-shell",
            "zeronav-world",
            "zeronav-world-files",
        ],
        "zeronav-console" => &[
            "zeronav-files",
            "zeronav-measure",
            "zeronav-msgs",
            "zeronav-shell",
        ],
        "zeronav-supervise" => &[
            "zeronav-console",
            "zeronav-files",
            "zeronav-measure",
            "zeronav-msgs",
            "zeronav-params",
            "zeronav-scenario",
            "zeronav-shell",
            "zeronav-world",
        ],
        "zeronav-contract-kit" => &[
            "zeronav-console",
            "zeronav-files",
            "zeronav-msgs",
            "zeronav-observe",
            "zeronav-shell",
            "zeronav-supervise",
        ],
        "zeronav-import" => &[
            "zeronav-files",
            "zeronav-msgs",
            "zeronav-recorder",
            "zeronav-ros-messages",
        ],
        "zeronav-suite" => &[
            "zeronav-console",
            "zeronav-files",
            "zeronav-measure",
            "zeronav-msgs",
            "zeronav-robot-description",
            "zeronav-scenario",
            "zeronav-shell",
            "zeronav-supervise",
            "zeronav-world",
            "zeronav-world-files",
        ],
        "zeronav" => &[
            "zeronav-console",
            "zeronav-contract-kit",
            "zeronav-files",
            "zeronav-import",
            "zeronav-measure",
            "zeronav-msgs",
            "zeronav-observe",
            "zeronav-params",
            "zeronav-recorder",
            "zeronav-robot-description",
            "zeronav-scenario",
            "zeronav-shell",
            "zeronav-suite",
            "zeronav-supervise",
            "zeronav-viewer",
            "zeronav-world",
            "zeronav-world-files",
        ],
        _ => panic!("{from}: its allowed dependencies are not listed here"),
    }
}

/// Name and folder of every package of the workspace.
fn packages() -> BTreeMap<String, PathBuf> {
    let root: toml::Table = read(&workspace().join("Cargo.toml"));
    let members = root["workspace"]["members"].as_array().expect("members");
    let folders = members
        .iter()
        .map(|member| workspace().join(member.as_str().expect("a path")));
    let name = |folder: PathBuf| {
        let manifest = read(&folder.join("Cargo.toml"));
        let name = manifest["package"]["name"].as_str().expect("a name");
        (name.to_owned(), folder)
    };
    folders.map(name).collect()
}

fn manifests() -> BTreeMap<String, toml::Table> {
    let packages = packages().into_iter();
    packages
        .map(|(name, folder)| (name, read(&folder.join("Cargo.toml"))))
        .collect()
}

fn read(file: &Path) -> toml::Table {
    std::fs::read_to_string(file)
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
        .parse()
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

#[test]
fn no_forbidden_dependencies() {
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
        let installed = installed_with(manifest);
        for dependency in dependencies
            .keys()
            .filter(|key| manifests.contains_key(*key) && !installed.contains(key))
        {
            if dependency != "zeronav-casts" && !allowed(name).contains(&dependency.as_str()) {
                extra.push(format!("{name} -> {dependency}"));
            }
        }
    }
    assert!(
        extra.is_empty(),
        "dependencies that are not allowed: {extra:?}"
    );
}

/// Packages that a package depends on only to install their binaries together with its own: its
/// library is built and tested without them.
fn installed_with(manifest: &toml::Table) -> Vec<&String> {
    let feature = manifest.get("features").and_then(|all| all.get("services"));
    let enabled = feature
        .and_then(toml::Value::as_array)
        .into_iter()
        .flatten();
    let enabled: Vec<&str> = enabled.filter_map(toml::Value::as_str).collect();
    let dependencies = manifest["dependencies"].as_table().expect("dependencies");
    let only_there = |(name, dependency): &(&String, &toml::Value)| {
        let optional = dependency.get("optional").and_then(toml::Value::as_bool);
        optional == Some(true) && enabled.contains(&format!("dep:{name}").as_str())
    };
    let names = dependencies.iter().filter(only_there);
    names.map(|(name, _)| name).collect()
}

/// Name, path from the root of the workspace, and required features of the binaries of a package.
fn binaries(folder: &Path, manifest: &toml::Table) -> Vec<(String, PathBuf, String)> {
    let all = manifest.get("bin").and_then(toml::Value::as_array);
    let all = all.into_iter().flatten();
    all.map(|bin| {
        let file = folder.join(bin["path"].as_str().expect("a path"));
        let file = file.canonicalize().expect("the file of a binary");
        let features = bin.get("required-features").map(toml::Value::to_string);
        let name = bin["name"].as_str().expect("a name").to_owned();
        (name, file, features.unwrap_or_default())
    })
    .collect()
}

#[test]
fn one_package_installs_every_service() {
    let packages = packages();
    let folder = &packages["zeronav"];
    let together = binaries(folder, &manifests()["zeronav"]);
    let mut services = 0;
    for (name, manifest) in manifests() {
        if manifest
            .get("features")
            .is_none_or(|all| all.get("process").is_none())
        {
            continue;
        }
        for (binary, file, _) in binaries(&packages[&name], &manifest) {
            let expected = (binary, file, "[\"services\"]".to_owned());
            assert!(
                together.contains(&expected),
                "{expected:?} is not in launch/Cargo.toml"
            );
            services += 1;
        }
    }
    assert_eq!(services, 7, "{together:#?}");
}

#[test]
fn service_libraries_do_not_depend_on_the_middleware() {
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
fn benches_take_the_options_of_criterion() {
    // `cargo bench -- --save-baseline x` also reaches libtest in every target that it benches.
    for (name, manifest) in manifests() {
        let list = |key: &str| manifest.get(key).and_then(toml::Value::as_array);
        if list("bench").is_none() {
            continue;
        }
        let targets = list("bin").into_iter().flatten().chain(manifest.get("lib"));
        for target in targets {
            let bench = target.get("bench").and_then(toml::Value::as_bool);
            assert_eq!(
                bench,
                Some(false),
                "{name}: `bench = false` is missing in {target}"
            );
        }
    }
}

#[test]
fn top_level_folders_are_fixed() {
    let mut rooms: BTreeSet<String> = std::fs::read_dir(workspace())
        .expect("the workspace")
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| !name.starts_with('.'))
        .collect();
    // Made by cargo and by runs.
    for made in ["target", "runs", "Cargo.lock"] {
        rooms.remove(made);
    }
    let given = [
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "Cargo.toml",
        "LICENSE-APACHE",
        "LICENSE-MIT",
        "README.md",
        "deny.toml",
        "launch",
        "msgs",
        "services",
        "tests",
    ];
    assert_eq!(rooms, given.into_iter().map(str::to_owned).collect());
}

#[test]
fn topic_names_are_string_literals_in_one_file_only() {
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

/// Source files of the workspace, relative to its root.
fn all_sources() -> Vec<PathBuf> {
    let folders = ["services", "launch", "msgs", "tests"];
    let files = folders
        .iter()
        .flat_map(|folder| sources(&workspace().join(folder)));
    let relative = |file: PathBuf| file.strip_prefix(workspace()).expect("inside").to_owned();
    let mut files: Vec<PathBuf> = files.map(relative).collect();
    files.sort();
    files
}

/// Of modules nowhere; of rooms, which are files with the folders of their names, not in `launch`.
#[test]
fn no_circles_of_modules_and_none_of_rooms_in_launch() {
    let (mut circles, mut of_rooms) = (Vec::new(), Vec::new());
    for (name, folder) in packages() {
        let crates = crates_of(&folder);
        assert!(!crates.is_empty(), "{name}: no crate roots found");
        let found = crates.iter().flat_map(Crate::circles);
        circles.extend(found.map(|circle| format!("{name}: {circle}")));
        if folder.starts_with(workspace().join("launch")) {
            of_rooms.extend(crates.iter().flat_map(Crate::circles_of_rooms));
        }
    }
    let [modules, rooms] = [circles, of_rooms].map(|found| found.join("\n"));
    assert!(modules.is_empty(), "circles of modules:\n{modules}");
    assert!(rooms.is_empty(), "circles of rooms:\n{rooms}");
}

#[test]
fn files_and_functions_are_short_or_give_a_reason() {
    let mut long = Vec::new();
    for file in all_sources() {
        let (path, name) = (workspace().join(&file), file.display().to_string());
        if let Some(lines) = length::long_file(&path, FILE_LINES_MAX) {
            long.push(format!("{name}: {lines} lines"));
        }
        for (line, function, lines) in length::long_functions(&path, FUNCTION_LINES_MAX) {
            long.push(format!("{name}:{line}: `{function}` has {lines} lines"));
        }
    }
    let rule = "split them, or give the reason in a line `// long: reason`";
    assert!(long.is_empty(), "{rule}:\n{}", long.join("\n"));
}

/// Under cargo `zeronav` builds its workspace before it starts services: a test that lets it do so
/// waits behind all others.
#[test]
fn tests_start_zeronav_without_cargo() {
    let direct = |file: &PathBuf| {
        let text = std::fs::read_to_string(workspace().join(file)).expect("a source file");
        let text = text.replace("zeronav_tests::", "");
        text.contains("Command::new(binaries().join(\"zeronav\"))")
    };
    let mut tests = all_sources();
    tests.retain(|file| file.starts_with("tests/tests") && direct(file));
    assert!(tests.is_empty(), "use `zeronav_tests::command`: {tests:?}");
}

/// Cargo builds a package once for each set of features that is asked of it: what tests and benches alone ask
/// makes everything above it be built twice where tests and `zeronav` are run.
#[test]
fn builds_with_and_without_tests_share_their_packages() {
    let with_tests = features(&["--workspace", "--edges=normal,build,dev"]);
    let install = ["--package=zeronav", "--features=services"];
    for selected in [&["--workspace"][..], &[], &install] {
        let mut alone = features(&[selected, &["--edges=normal,build"]].concat());
        alone.retain(|package| !with_tests.contains(package));
        // The one that has the feature.
        alone
            .retain(|package| !package.starts_with("zeronav v") || !package.ends_with(" services"));
        let fix =
            "ask for the features that are missing where it is used (services/viewer/Cargo.toml)";
        assert!(alone.is_empty(), "{selected:?}: {alone:?}: {fix}");
    }
}

/// Packages with their version and features, as a build of `selected` has them.
fn features(selected: &[&str]) -> BTreeSet<String> {
    let tree = std::process::Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()))
        .args([
            "tree",
            "--locked",
            "--offline",
            "--prefix=none",
            "--no-dedupe",
        ])
        .args(["--format={p} {f}"])
        .args(selected)
        .current_dir(workspace())
        .output()
        .expect("cargo runs");
    let said = String::from_utf8_lossy(&tree.stderr);
    assert!(tree.status.success(), "{said}");
    String::from_utf8_lossy(&tree.stdout)
        .lines()
        .map(str::to_owned)
        .collect()
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
