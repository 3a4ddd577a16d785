//! `zeronav check`: whether a scenario can work.

use crate::prepare::{self, Checked};
use crate::run_plan::Source;
use serde_json::json;
use std::process::ExitCode;
use zeronav_console::exit::{EXIT_PASS, EXIT_USAGE};
use zeronav_console::terminal::{say, say_json, usage};

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
