//! Latencies of trials in real time: by the rate of the scans and their beams, far into the tail, and
//! those of the global planner alone.

use super::bench::{Bench, Measured, on_shipped, write_scenario};
use super::extract::{list, table};
use super::record::Row;
use super::spread::Figure;
use super::trials;
use serde_json::Value;

/// Scans per second and beams of a scan. [Hz]
const SCANS: [(u32, u32); 6] = [
    (10, 360),
    (10, 1080),
    (40, 360),
    (40, 1080),
    (100, 360),
    (100, 1080),
];

/// Control ticks per second of a scenario that names none; a lidar may not be faster than they come.
/// [Hz]
const TICK_HZ: u32 = 50;

/// Trials at each rate and of each scenario: enough for a 99th percentile, and as many in each of the
/// three rounds.
const TRIALS: usize = 102;

/// Trials far into the tail: the fewest that have a 99.9th percentile.
const TAIL_TRIALS: usize = 1000;

/// By the rate of the scans and their beams.
pub(super) fn rates(bench: &mut Bench) -> Result<Measured, String> {
    let mut rows = Vec::new();
    for (rate_hz, n_beams) in SCANS {
        let tick_hz = rate_hz.max(TICK_HZ);
        let text = format!(
            "{}run.tick_hz = {tick_hz}.0\nrobot.lidar.rate_hz = {rate_hz}.0\n\
             robot.lidar.n_beams = {n_beams}\n",
            on_shipped("blocked_aisle")
        );
        let file = write_scenario(&format!("scans_{rate_hz}hz_{n_beams}"), &text)?;
        let result = bench.trials(&file, TRIALS)?;
        rows.push(rate_row(format!("{rate_hz} Hz, {n_beams} beams"), &result)?);
    }
    let columns = [
        "replanning p50 [us]",
        "p90 [us]",
        "p99 [us]",
        "reaction p50 [us]",
        "p99 [us]",
        "`global_planner` p50 [us]",
        "`local_planner` p50 [us]",
        "transport floor p50 [us]",
        "replanning / floor",
        "unanswered",
        "load of all services [cores]",
    ];
    Ok(Measured::tables(vec![table("scans", &columns, rows)]))
}

fn rate_row(name: String, result: &Value) -> Result<Row, String> {
    let latency = trials::latency(result);
    let row = |name: &str| trials::row(&latency, name);
    let replanning = row("**replanning**")?;
    let reaction = &row("reaction")?.figures;
    let [p50, p90, p99, _, unanswered] = replanning.figures[..] else {
        return Err("replanning has other columns".to_owned());
    };
    Ok(Row {
        name,
        n: replanning.n,
        figures: vec![
            p50,
            p90,
            p99,
            reaction[0],
            reaction[2],
            row("of it `global_planner`")?.figures[0],
            row("of it `local_planner`")?.figures[0],
            row("transport floor")?.figures[0],
            Figure::plain(result["latency"]["replanning_to_floor"].as_f64()),
            unanswered,
            Figure::plain(load_of(result)),
        ],
    })
}

/// Processor time of all services over the time of the rounds. [cores]
fn load_of(result: &Value) -> Option<f64> {
    let (mut busy_s, mut time_s) = (0.0, 0.0);
    for round in list(&result["trials"], "rounds") {
        time_s += round["time_s"].as_f64()?;
        for service in list(&round["disturbance"], "services") {
            busy_s += service["processor_us"].as_f64()? / 1e6;
        }
    }
    (time_s > 0.0).then_some(busy_s / time_s)
}

/// Far into the tail, and what was slow in the ten slowest trials.
pub(super) fn tail(bench: &mut Bench) -> Result<Measured, String> {
    let result = bench.trials("blocked_aisle", TAIL_TRIALS)?;
    Ok(Measured::tables(vec![
        trials::tail(&result),
        trials::slowest(&result, 10),
        trials::checks(&result),
        trials::disturbance(&result),
    ]))
}

/// The hop of the global planner, where the way round is another aisle and where it is another door.
pub(super) fn hops(bench: &mut Bench) -> Result<Measured, String> {
    let mut rows = Vec::new();
    for scenario in ["blocked_aisle", "door_closes"] {
        let latency = trials::latency(&bench.trials(scenario, TRIALS)?);
        let hop = trials::row(&latency, "of it `global_planner`")?;
        rows.push(Row {
            name: format!("`{scenario}`"),
            ..hop.clone()
        });
    }
    Ok(Measured::tables(vec![table(
        "`global_planner`",
        &trials::COLUMNS,
        rows,
    )]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_load_is_that_of_all_services_over_all_rounds() {
        let service = |processor_us: f64| json!({"processor_us": processor_us});
        let round = |time_s: f64, services: [f64; 2]| json!({"time_s": time_s, "disturbance": {"services": services.map(service)}});
        let rounds = [round(2.0, [1e6, 1e6]), round(6.0, [1e6, 3e6])];
        let result = json!({"trials": {"rounds": rounds}});
        assert_eq!(load_of(&result), Some(0.75));
        assert_eq!(load_of(&json!({})), None);
    }
}
