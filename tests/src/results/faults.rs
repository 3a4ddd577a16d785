//! Each service and each fault: how long until it answers again, and what the robot did meanwhile.

use super::bench::{Bench, Measured, write_scenario};
use super::extract::table;
use super::record::Row;
use super::spread::Figure;
use crate::faults::{
    DISTURBED_EVERY_S, Effect, KINDS, SERVICES, disturbed, effect, fault, scenario,
};
use serde_json::Value;

/// Run times of the fault in the runs in real time. [s]
const AT_S: [f64; 3] = [3.0, 3.3, 3.7];

/// Drives in which each topic and each clock is disturbed.
const DISTURBED: usize = 3;

/// The experiment.
pub(super) fn make(bench: &mut Bench) -> Result<Measured, String> {
    let mut rows = Vec::new();
    for service in SERVICES {
        for kind in KINDS {
            let file = format!("{kind}_{service}");
            let exact = run(bench, &file, 1, &fault(kind, service, AT_S[0]), true)?;
            let mut timed = Vec::new();
            for at_s in AT_S {
                timed.push(run(bench, &file, 1, &fault(kind, service, at_s), false)?);
            }
            let all: Vec<&Value> = timed.iter().chain([&exact]).collect();
            let name = format!("`{kind}` `{service}`");
            rows.push(row(&name, &all, &timed, 0, effect(&exact, 0, 5.0)));
        }
    }
    let (lines, names) = disturbed();
    let mut drives = Vec::new();
    for _ in 0..DISTURBED {
        let n_goals = 2 + names.len() / 3;
        drives.push(run(bench, "disturbed", n_goals, &lines, false)?);
    }
    let all: Vec<&Value> = drives.iter().collect();
    for (index, name) in names.iter().enumerate() {
        let seen = effect(&drives[0], index, DISTURBED_EVERY_S);
        rows.push(row(name, &all, &drives, index, seen));
    }
    let columns = [
        "passed",
        "answers again, real time [ms]",
        "lowest speed [m/s]",
        "way to the stop [m]",
        "stood [s]",
    ];
    Ok(Measured::tables(vec![table("fault", &columns, rows)]))
}

fn run(
    bench: &mut Bench,
    name: &str,
    n_goals: usize,
    lines: &str,
    lockstep: bool,
) -> Result<Value, String> {
    let file = write_scenario(name, &scenario(n_goals, lines))?;
    let arguments = ["run", file.as_str(), "--lockstep"];
    bench.zeronav(&arguments[..2 + usize::from(lockstep)])
}

/// How many of `all` passed, how soon the seat answered in `timed` after the fault with this index, and
/// what it did.
fn row(name: &str, all: &[&Value], timed: &[Value], index: usize, seen: Effect) -> Row {
    let safe = |result: &&&Value| result["verdict"] == "pass" && result["contacts"] == 0;
    let recoveries: Vec<f64> = timed
        .iter()
        .filter_map(|result| result["faults"][index]["recovery_ms"].as_f64())
        .collect();
    Row {
        name: name.to_owned(),
        n: all.len() as u64,
        figures: vec![
            Figure::rate(all.iter().filter(safe).count(), all.len()),
            Figure::median(&recoveries),
            Figure::plain(Some(seen.v_mps_min)),
            Figure::plain(seen.stop_m),
            Figure::plain(Some(seen.stood_s)),
        ],
    }
}
