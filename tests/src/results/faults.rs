//! Each service and each fault: how long until it answers again, and what the robot did meanwhile.

use super::bench::{Bench, Measured};
use super::extract::table;
use super::record::Row;
use super::spread::Figure;
use crate::faults::{
    Effect, KINDS, SERVICES, TOPIC_KINDS, TOPICS, clock_fault, effect, fault, scenario, topic_fault,
};
use crate::workspace;
use serde_json::Value;

/// Run times of the fault in the runs in real time. [s]
const AT_S: [f64; 3] = [3.0, 3.3, 3.7];

/// The experiment.
pub(super) fn make(bench: &mut Bench) -> Result<Measured, String> {
    let mut rows = Vec::new();
    for service in SERVICES {
        for kind in KINDS {
            let name = format!("`{kind}` `{service}`");
            let lines = |at_s| fault(kind, service, at_s);
            let exact = run(bench, &name, &lines(AT_S[0]), true)?;
            let timed = timed(bench, &name, &lines)?;
            rows.push(row(&name, &exact, &timed.iter().chain([&exact]), &timed));
        }
    }
    // Lockstep waits for every message and has no clock: of these the first run in real time is shown.
    for topic in TOPICS {
        for kind in TOPIC_KINDS {
            let name = format!("`{}` `{topic}`", kind.0);
            let timed = timed(bench, &name, &|at_s| topic_fault(kind, topic, at_s))?;
            rows.push(row(&name, &timed[0], &timed.iter(), &timed));
        }
    }
    for service in SERVICES {
        for by_ms in [200.0, -200.0] {
            let name = format!("`clock` `{service}` {by_ms:+} ms");
            let timed = timed(bench, &name, &|at_s| clock_fault(service, by_ms, at_s))?;
            rows.push(row(&name, &timed[0], &timed.iter(), &timed));
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

/// Runs in real time, with the fault at each of [`AT_S`].
fn timed(
    bench: &mut Bench,
    name: &str,
    lines: &dyn Fn(f64) -> String,
) -> Result<Vec<Value>, String> {
    let at = AT_S.iter();
    at.map(|at_s| run(bench, name, &lines(*at_s), false))
        .collect()
}

/// One run, whether it passes or not.
fn run(bench: &mut Bench, name: &str, lines: &str, lockstep: bool) -> Result<Value, String> {
    let name = name.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    let file = format!("target/faults/{}.toml", name.trim_matches('_'));
    let path = workspace().join(&file);
    let write = || {
        std::fs::create_dir_all(workspace().join("target/faults"))?;
        std::fs::write(&path, scenario(1, lines))
    };
    write().map_err(|error| format!("{file}: {error}"))?;
    let arguments = ["run", file.as_str(), "--lockstep"];
    bench.zeronav(&arguments[..2 + usize::from(lockstep)])
}

/// A row: what `shown` did, of how many of `all` passed, and how soon the seat answered in `timed`.
fn row<'a>(
    name: &str,
    shown: &Value,
    all: &(impl Iterator<Item = &'a Value> + Clone),
    timed: &[Value],
) -> Row {
    let all = || all.clone();
    let safe = |result: &&Value| result["verdict"] == "pass" && result["contacts"] == 0;
    let recoveries: Vec<f64> = timed
        .iter()
        .filter_map(|result| result["faults"][0]["recovery_ms"].as_f64())
        .collect();
    let Effect {
        stop_m,
        stood_s,
        v_mps_min,
    } = effect(shown);
    Row {
        name: name.to_owned(),
        n: all().count() as u64,
        figures: vec![
            Figure::rate(all().filter(safe).count(), all().count()),
            Figure::median(&recoveries),
            Figure::plain(Some(v_mps_min)),
            Figure::plain(stop_m),
            Figure::plain(Some(stood_s)),
            Figure::plain(shown["interventions"].as_f64()),
        ],
    }
}
