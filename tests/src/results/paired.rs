//! Latencies under conditions that take turns: timed stages, the kernel's scheduling.

use super::bench::{Bench, Measured};
use super::record::Row;
use super::{extract, rounds};
use crate::workspace;
use std::fmt::Write;
use zeronav_msgs::Role;

/// Rounds of [`stages`] and of [`placement`].
const ROUNDS: [usize; 2] = [8, 4];

/// Name, and the lines of a service's scheduling.
type Condition = (&'static str, fn(Role) -> &'static str);

const CONDITIONS: [Condition; 4] = [
    ("all on both, as the kernel likes", |_| ""),
    ("all on one", |_| "cpus = [0]"),
    (
        "planners on one, the others on the other",
        |role| match role {
            Role::GlobalPlanner | Role::LocalPlanner => "cpus = [1]",
            _ => "cpus = [0]",
        },
    ),
    (
        "all with `fifo` 10 (root)",
        |_| "policy = \"fifo\"\npriority = 10",
    ),
];

/// With and without timed stages.
pub(super) fn stages(bench: &mut Bench) -> Result<Measured, String> {
    let arguments = ["run", "blocked_aisle", "--trials", "20", "--no-stages"];
    let names = ["not timed (--no-stages)", "timed"];
    let rows = rounds::in_turn(ROUNDS[0], &names, |at| bench.zeronav(&arguments[..5 - at]))?;
    Ok(measured("stages", rows))
}

/// By how the kernel schedules the services.
pub(super) fn placement(bench: &mut Bench) -> Result<Measured, String> {
    let files = CONDITIONS.iter().enumerate();
    let files: Vec<String> = files
        .map(|(at, (_, lines))| write(at, *lines))
        .collect::<Result<_, _>>()?;
    let rows = rounds::in_turn(ROUNDS[1], &CONDITIONS.map(|(name, _)| name), |at| {
        bench.zeronav(&["run", &files[at], "--trials", "20"])
    })?;
    Ok(measured("services", rows))
}

fn measured(title: &str, rows: Vec<Row>) -> Measured {
    Measured {
        tables: vec![extract::table(title, &rounds::COLUMNS, rows)],
        text: None,
    }
}

/// Writes `blocked_aisle` with these lines of each service; its name from the workspace.
fn write(at: usize, lines: fn(Role) -> &'static str) -> Result<String, String> {
    let file = format!("target/placement/{at}.toml");
    let write = || {
        let shipped = workspace().join("launch/scenarios/blocked_aisle.toml");
        let mut text = std::fs::read_to_string(shipped)?;
        for role in Role::SERVICES {
            let _ = write!(text, "\n[services.{role}.scheduling]\n{}\n", lines(role));
        }
        std::fs::create_dir_all(workspace().join("target/placement"))?;
        std::fs::write(workspace().join(&file), text)
    };
    write().map_err(|error: std::io::Error| format!("{file}: {error}"))?;
    Ok(file)
}
