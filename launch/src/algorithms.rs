//! `zeronav planners` and `zeronav controllers`: what the stock services can do.

use serde_json::json;
use std::process::ExitCode;
use zeronav_console::exit::EXIT_PASS;
use zeronav_console::terminal::{say, say_json, usage};
use zeronav_msgs::role::Role;
use zeronav_supervise::algorithms;
use zeronav_supervise::binaries::{self, Needed};

/// `zeronav planners` and `zeronav controllers`: what the stock service in this seat can do, in its
/// own words.
#[must_use]
pub fn list(role: Role, json: bool) -> ExitCode {
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
