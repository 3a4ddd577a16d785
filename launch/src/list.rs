//! `zeronav list`: what can be started.

use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{say, say_json};
use zeronav_scenario::methods::METHODS;
use zeronav_supervise::binaries;

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
