//! What it costs to exchange, kill and compare services of a stack that drives.

use super::bench::{Bench, Measured};
use super::extract::{list, table};
use super::record::Row;
use super::spread::Figure;
use crate::faults::{SERVICES, scenario};
use crate::workspace;
use core::fmt::Write;
use serde_json::Value;
use zeronav_casts::Cast;

/// Swaps of each seat in one drive, and from one to the next. [s]
const SWAPS: usize = 20;
const SWAP_EVERY_S: f64 = 2.5;

/// Times that the planner is killed in one drive, and from one to the next. [s]
const KILLS: usize = 100;
const KILL_EVERY_S: f64 = 5.3;

/// Pairs of drives with and without a shadow.
const PAIRS: usize = 5;

/// A drive takes this long from goal to goal, about. [s]
const LEG_S: f64 = 9.0;

/// A drive in real time with these lines, of enough goals for `time_s`.
fn drive(bench: &mut Bench, name: &str, time_s: f64, lines: &str) -> Result<Value, String> {
    let file = format!("target/standing/{name}.toml");
    let path = workspace().join(&file);
    let n_goals = (time_s / LEG_S).ceil().to_usize() + 1;
    let write = || {
        std::fs::create_dir_all(workspace().join("target/standing"))?;
        std::fs::write(&path, scenario(n_goals, lines))
    };
    write().map_err(|error| format!("{file}: {error}"))?;
    bench.zeronav(&["run", &file])
}

fn count(n: usize) -> f64 {
    f64::from(u32::try_from(n).unwrap_or(u32::MAX))
}

/// Every seat is swapped for its own binary while the robot drives.
pub(super) fn swaps(bench: &mut Bench) -> Result<Measured, String> {
    let mut rows = Vec::new();
    for service in SERVICES {
        let mut lines = String::new();
        for n in 0..SWAPS {
            let at_s = 3.0 + SWAP_EVERY_S * count(n);
            let _ = writeln!(
                lines,
                "[[swaps]]\nservice = \"{service}\"\nat_s = {at_s:?}\nshadow_s = 0.5\nkeep_s = 0.5"
            );
        }
        let time_s = 3.0 + SWAP_EVERY_S * count(SWAPS);
        let result = drive(bench, &format!("swaps_{service}"), time_s, &lines)?;
        let swaps = list(&result, "swaps");
        let swapped = swaps.iter().filter(|swap| swap["state"] == "swapped");
        let gaps = swaps
            .iter()
            .filter_map(|swap| swap["command_gap_ticks"].as_f64());
        rows.push(Row {
            name: format!("`{service}`"),
            n: swaps.len() as u64,
            figures: vec![
                Figure::rate(swapped.count(), SWAPS),
                Figure::plain(gaps.reduce(f64::max)),
                Figure::plain(result["contacts"].as_f64()),
                Figure::plain(Some(f64::from(u8::from(result["reached"] == true)))),
            ],
        });
    }
    let columns = [
        "swapped",
        "longest from command to command [periods]",
        "contacts",
        "every goal reached",
    ];
    Ok(Measured::tables(vec![table("seat", &columns, rows)]))
}

/// The planner is killed again and again while the robot drives.
pub(super) fn restarts(bench: &mut Bench) -> Result<Measured, String> {
    let mut lines = String::new();
    for n in 0..KILLS {
        // Beyond the time for which a death counts as early, and at another moment between two scans.
        let at_s = 3.0 + KILL_EVERY_S * count(n) + 0.013 * count(n % 8);
        let _ = writeln!(
            lines,
            "[[faults]]\nkind = \"kill\"\nservice = \"global_planner\"\nbegins = {{ at_s = {at_s:?} }}"
        );
    }
    let time_s = 3.0 + KILL_EVERY_S * count(KILLS);
    let result = drive(bench, "restarts", time_s, &lines)?;
    let recoveries = list(&result, "faults").iter();
    let recoveries: Vec<f64> = recoveries
        .filter_map(|fault| fault["recovery_ms"].as_f64())
        .collect();
    let row = Row {
        name: "kill -9 of `global_planner` to its next path".to_owned(),
        n: recoveries.len() as u64,
        figures: vec![
            Figure::median(&recoveries),
            Figure::percentile(&recoveries, 0.9),
            Figure::percentile(&recoveries, 0.99),
            Figure::plain(recoveries.iter().copied().max_by(f64::total_cmp)),
            Figure::plain(result["contacts"].as_f64()),
            Figure::plain(Some(f64::from(u8::from(result["reached"] == true)))),
        ],
    };
    let columns = [
        "p50 [ms]",
        "p90 [ms]",
        "p99 [ms]",
        "max [ms]",
        "contacts",
        "every goal reached",
    ];
    Ok(Measured::tables(vec![table("", &columns, vec![row])]))
}

/// The hop of each seat with and without a shadow of it, in pairs of drives.
pub(super) fn shadow(bench: &mut Bench) -> Result<Measured, String> {
    let mut rows = Vec::new();
    for service in ["global_planner", "local_planner", "collision_guard"] {
        let lines = format!("[services.{service}.shadow]\n");
        let mut pairs: [Vec<f64>; 3] = Default::default();
        for n in 0..PAIRS {
            let mut found = [0.0; 2];
            // Each goes first in turn.
            for turn in 0..2 {
                let with = (n + turn) % 2;
                let lines = if with == 1 { lines.as_str() } else { "" };
                let name = format!("shadow_{service}_{with}");
                let result = drive(bench, &name, 2.0 * LEG_S, lines)?;
                found[with] = hop_us(&result, service).ok_or("no hop")?;
            }
            pairs[0].push(found[0]);
            pairs[1].push(found[1]);
            pairs[2].push(found[1] / found[0]);
        }
        rows.push(Row {
            name: format!("`{service}`"),
            n: PAIRS as u64,
            figures: pairs.iter().map(|one| Figure::median(one)).collect(),
        });
    }
    let columns = [
        "p50 alone [us]",
        "p50 with a shadow [us]",
        "ratio of a pair",
    ];
    Ok(Measured::tables(vec![table("seat", &columns, rows)]))
}

/// The median of the seat's own hop over all scans of a run. [us]
fn hop_us(result: &Value, service: &str) -> Option<f64> {
    let ways = result["latency"]["every_scan"].as_object()?;
    let mut hops = ways.values().filter_map(Value::as_array).flatten();
    let hop = hops.find(|hop| hop["name"] == service)?;
    hop["p50_us"].as_f64()
}
