//! A planner in a package of its own, outside the workspace: it builds, and it drives.

use std::collections::BTreeSet;
use std::path::Path;
use zeronav_tests::{Zeronav, background, binaries, quick_profile, workspace};

const PACKAGE: &str = "services/shell/examples/own_planner";

/// Name and version of every package in a lock file.
fn locked(file: &Path) -> BTreeSet<(String, String)> {
    let text = std::fs::read_to_string(file).expect("a lock file");
    let lock: toml::Table = text.parse().expect("TOML");
    let packages = lock["package"].as_array().expect("packages");
    let text = |package: &toml::Value, key: &str| package[key].as_str().expect("text").to_owned();
    packages
        .iter()
        .map(|package| (text(package, "name"), text(package, "version")))
        .collect()
}

#[test]
fn own_planner_has_the_versions_of_the_workspace() {
    let own = locked(&workspace().join(PACKAGE).join("Cargo.lock"));
    assert!(own.iter().any(|(name, _)| name == "iceoryx2"));
    let workspace = locked(&workspace().join("Cargo.lock"));
    let other: Vec<_> = own.difference(&workspace).collect();
    assert_eq!(other.len(), 1, "{other:?}");
    assert_eq!(other[0].0, "own_planner");
}

/// Builds it into the target folder of the workspace, beside the stock services.
fn build() {
    let folder = binaries();
    let profile = match folder.file_name().and_then(|name| name.to_str()) {
        Some("debug") | None => "dev",
        Some(name) => name,
    };
    let quick = tempfile::tempdir().expect("a folder");
    let config = quick.path().join("config.toml");
    std::fs::write(&config, quick_profile("own_planner")).expect("written");
    let status = background(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["build", "--quiet", "--locked", "--profile", profile])
        .arg("--config")
        .arg(&config)
        .arg("--target-dir")
        .arg(folder.parent().expect("a target folder"))
        .current_dir(workspace().join(PACKAGE))
        .status()
        .expect("cargo runs");
    assert!(status.success(), "own_planner does not build");
}

#[test]
fn own_planner_drives_the_blocked_aisle() {
    build();
    let text = zeronav_tests::shipped("blocked_aisle");
    let text = format!("{text}\n[services.global_planner]\nbinary = \"own_planner\"\n");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let result = Zeronav::start_in(folder, &arguments).finish().expect(0);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    let plans = result["plans"].as_array().expect("plans");
    assert!(plans.len() >= 2, "it plans again for the load: {plans:#?}");
    for plan in plans {
        assert_eq!(plan["planner"], "own_planner", "{plan:#}");
        assert_eq!(plan["status"], "found", "{plan:#}");
    }
}
