//! Each service and each fault: how long until it answers again, and what the robot did meanwhile.

use super::bench::{Bench, Measured};
use super::extract::table;
use super::record::Row;
use super::spread::Figure;
use crate::faults::{Effect, KINDS, SERVICES, effect, fault, scenario};
use crate::workspace;
use serde_json::Value;

/// Run times of the fault in the runs in real time. [s]
const AT_S: [f64; 3] = [3.0, 3.3, 3.7];

/// The experiment.
pub(super) fn make(bench: &mut Bench) -> Result<Measured, String> {
    let mut rows = Vec::new();
    for service in SERVICES {
        for kind in KINDS {
            let exact = run(bench, kind, service, AT_S[0], true)?;
            let mut timed = Vec::new();
            for at_s in AT_S {
                timed.push(run(bench, kind, service, at_s, false)?);
            }
            rows.push(row(&format!("`{kind}` `{service}`"), &exact, &timed));
        }
    }
    let columns = [
        "passed",
        "answers again, real time [ms]",
        "lowest speed within 5 s [m/s]",
        "way to the stop [m]",
        "stood [s]",
        "guard interventions",
    ];
    Ok(Measured {
        tables: vec![table("fault", &columns, rows)],
        text: None,
    })
}

fn run(
    bench: &mut Bench,
    kind: &str,
    service: &str,
    at_s: f64,
    lockstep: bool,
) -> Result<Value, String> {
    let file = format!("target/faults/{kind}_{service}.toml");
    let path = workspace().join(&file);
    let write = || {
        std::fs::create_dir_all(workspace().join("target/faults"))?;
        std::fs::write(&path, scenario(1, &fault(kind, service, at_s)))
    };
    write().map_err(|error| format!("{file}: {error}"))?;
    let arguments = ["run", file.as_str(), "--lockstep"];
    bench.zeronav(&arguments[..2 + usize::from(lockstep)])
}

fn row(name: &str, exact: &Value, timed: &[Value]) -> Row {
    let all = || timed.iter().chain([exact]);
    let safe = |result: &&Value| result["verdict"] == "pass" && result["contacts"] == 0;
    let recoveries: Vec<f64> = timed
        .iter()
        .filter_map(|result| result["faults"][0]["recovery_ms"].as_f64())
        .collect();
    let Effect {
        stop_m,
        stood_s,
        v_mps_min,
    } = effect(exact);
    Row {
        name: name.to_owned(),
        n: all().count() as u64,
        figures: vec![
            Figure::rate(all().filter(safe).count(), all().count()),
            Figure::median(&recoveries),
            Figure::plain(Some(v_mps_min)),
            Figure::plain(stop_m),
            Figure::plain(Some(stood_s)),
            Figure::plain(exact["interventions"].as_f64()),
        ],
    }
}
