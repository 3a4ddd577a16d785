//! Latencies under conditions that take turns: timed stages, the kernel's scheduling, kept detours.

use super::bench::{Bench, Measured, on_shipped, write_scenario};
use super::record::Row;
use super::{extract, rounds};
use crate::shipped;
use std::fmt::Write;
use zeronav_msgs::Role;

/// Rounds; in each every condition has a run, and each begins one in turn.
const STAGES_ROUNDS: usize = 8;
const PLACEMENT_ROUNDS: usize = 4;
const SEARCH_ROUNDS: usize = 4;

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
    let rows = rounds::in_turn(STAGES_ROUNDS, &names, |at| {
        bench.zeronav(&arguments[..5 - at])
    })?;
    Ok(measured("stages", rows))
}

/// Where a detour is kept ready, and where every change of the map is searched from scratch.
pub(super) fn full_search(bench: &mut Bench) -> Result<Measured, String> {
    let planners = [
        ("`mpgaa`, a detour kept ready", "mpgaa"),
        ("`c_astar`, a full search", "c_astar"),
    ];
    let mut files = Vec::new();
    for (_, planner) in planners {
        let text = format!(
            "{}services.global_planner.config.planner = \"{planner}\"\n",
            on_shipped("blocked_aisle")
        );
        files.push(write_scenario(&format!("search_{planner}"), &text)?);
    }
    let rows = rounds::in_turn(SEARCH_ROUNDS, &planners.map(|(name, _)| name), |at| {
        bench.trials(&files[at], 20)
    })?;
    Ok(measured("planner", rows))
}

/// By how the kernel schedules the services.
pub(super) fn placement(bench: &mut Bench) -> Result<Measured, String> {
    let mut files = Vec::new();
    for (at, (_, lines)) in CONDITIONS.iter().enumerate() {
        let mut text = shipped("blocked_aisle");
        for role in Role::SERVICES {
            let _ = write!(text, "\n[services.{role}.scheduling]\n{}\n", lines(role));
        }
        files.push(write_scenario(&format!("placement{at}"), &text)?);
    }
    let rows = rounds::in_turn(PLACEMENT_ROUNDS, &CONDITIONS.map(|(name, _)| name), |at| {
        bench.zeronav(&["run", &files[at], "--trials", "20"])
    })?;
    Ok(measured("services", rows))
}

fn measured(title: &str, rows: Vec<Row>) -> Measured {
    Measured::tables(vec![extract::table(title, &rounds::COLUMNS, rows)])
}
