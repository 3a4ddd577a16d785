//! The commands that start nothing: what there is, and whether it can work.

use crate::prepare::{self, Checked};
use crate::run_plan::Source;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use zeronav_console::exit::{EXIT_PASS, EXIT_USAGE};
use zeronav_console::terminal::{say, say_json, usage};
use zeronav_msgs::role::Role;
use zeronav_scenario::methods::METHODS;
use zeronav_supervise::algorithms;
use zeronav_supervise::binaries::{self, Needed};

/// `zeronav list`.
#[must_use]
pub fn list(json: bool) -> ExitCode {
    let (scenarios, left_out) = offered(zeronav_scenario::list());
    if json {
        let rows: Vec<_> = scenarios
            .iter()
            .map(
                |listed| json!({ "group": listed.group, "name": listed.name, "title": listed.title, "file": listed.file }),
            )
            .collect();
        let methods: Vec<_> = METHODS
            .iter()
            .map(|it| json!({ "key": it.key, "title": it.title, "set": it.keys }))
            .collect();
        say_json(&json!({ "scenarios": rows, "methods": methods }));
        return ExitCode::from(EXIT_PASS);
    }
    let names = scenarios.iter().map(|listed| listed.name.len());
    let width = names.max().unwrap_or(0);
    let mut group = None;
    for listed in &scenarios {
        if group.replace(&listed.group) != Some(&listed.group) && !listed.group.is_empty() {
            say(&format!("{}\n", listed.group));
        }
        let (name, title) = (&listed.name, &listed.title);
        say(&format!("  {name:width$}  {title}\n"));
    }
    say("methods of papers, any scenario with --as KEY\n");
    for method in METHODS {
        let (key, title) = (method.key, method.title);
        say(&format!("  {key:width$}  {title}\n"));
    }
    for (binary, names) in left_out {
        let (binary, names) = (binary.display(), names.join(", "));
        say(&format!(
            "\nleft out, as {binary} is not installed: {names}\n"
        ));
    }
    ExitCode::from(EXIT_PASS)
}

/// What can be started, and by the first binary that each of the others lacks, their names. Under cargo
/// binaries are built when they are needed.
fn offered(
    all: Vec<zeronav_scenario::Listed>,
) -> (
    Vec<zeronav_scenario::Listed>,
    BTreeMap<PathBuf, Vec<String>>,
) {
    let builds = std::env::var_os("CARGO").is_some();
    let mut left_out = BTreeMap::<PathBuf, Vec<String>>::new();
    let mut rest = all;
    rest.retain(|listed| {
        let is_missing = |binary: &&PathBuf| !builds && binaries::find(binary).is_err();
        let missing = listed.binaries.iter().find(is_missing);
        if let Some(binary) = missing {
            let names = left_out.entry(binary.clone()).or_default();
            names.push(listed.name.clone());
        }
        missing.is_none()
    });
    (rest, left_out)
}

/// `zeronav check`: everything that can be known without starting the stack.
#[must_use]
pub fn check(name: &str, json: bool) -> ExitCode {
    let plan = match prepare::check(&Source::Named(name.to_owned()), &[]) {
        Ok(plan) => plan,
        Err(problem) if json => {
            let errors: Vec<&str> = problem.lines().collect();
            say_json(
                &json!({ "scenario": name, "ok": false, "error": errors[0], "errors": errors }),
            );
            return ExitCode::from(EXIT_USAGE);
        }
        Err(problem) => return usage(&problem),
    };
    let Checked {
        scenario,
        world,
        warnings,
        ..
    } = plan;
    let geometry = world.geometry();
    if json {
        say_json(&json!({
            "scenario": scenario.name,
            "ok": true,
            "width": geometry.width,
            "height": geometry.height,
            "resolution_m": geometry.resolution_m,
            "goals": scenario.goals.len(),
            "obstacles": world.obstacles().len(),
            "warnings": warnings,
        }));
        return ExitCode::from(EXIT_PASS);
    }
    for warning in &warnings {
        say(&format!("warning: {warning}\n"));
    }
    say(&format!(
        "{}: ok, {} x {} cells of {} m, {} goals, {} obstacles\n",
        scenario.name,
        geometry.width,
        geometry.height,
        geometry.resolution_m,
        scenario.goals.len(),
        world.obstacles().len()
    ));
    ExitCode::from(EXIT_PASS)
}

/// `zeronav planners` and `zeronav controllers`: what the stock service in this seat can do, in its
/// own words.
#[must_use]
pub fn algorithms_of(role: Role, json: bool) -> ExitCode {
    let listed = binaries::refresh_under_cargo(Needed::Stock);
    let rows = match listed.and_then(|()| algorithms::of(role)) {
        Ok(rows) => rows,
        Err(problem) => return usage(&problem),
    };
    if json {
        let rows: Vec<_> = rows
            .iter()
            .map(|row| json!({ "key": row.key, "title": row.title }))
            .collect();
        say_json(&json!({ "algorithms": rows }));
    } else {
        let width = rows.iter().map(|row| row.key.len()).max().unwrap_or(0);
        for row in rows {
            let (key, title) = (row.key, row.title);
            say(&format!("{key:width$}  {title}\n"));
        }
    }
    ExitCode::from(EXIT_PASS)
}
