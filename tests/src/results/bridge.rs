//! What a robot of ROS 2 adds to the ways through the stack: the same drive with the simulator in the seat, and with
//! the bridge in it and the simulator behind a node of rclpy.

use super::bench::{Bench, Measured, write_scenario};
use super::extract::{list, table};
use super::record::Row;
use super::spread::Figure;
use crate::ros2::{Peer, domain, folder_of};
use serde_json::Value;
use zeronav_observe::statistics::percentile;

/// Drives of either kind, in turn.
const ROUNDS: usize = 5;

/// The drive.
const SCENARIO: &str = "open_aisle";

/// The columns that a result has: a hop or a row of latency, and its percentile.
const COLUMNS: [(&str, &str); 6] = [
    ("robot", "p50_us"),
    ("robot", "p99_us"),
    ("to_robot", "p50_us"),
    ("to_robot", "p99_us"),
    ("reaction", "p50_us"),
    ("reaction", "p99_us"),
];

/// Medians over the rounds.
pub(super) fn make(bench: &mut Bench) -> Result<Measured, String> {
    let (mut simulated, mut bridged) = (Vec::new(), Vec::new());
    let mut delays = Vec::new();
    for _ in 0..ROUNDS {
        simulated.push(bench.zeronav(&["run", SCENARIO])?);
        let domain_id = domain();
        let more = "config.ros.cmd_vel_stamped = true\n";
        let (folder, config) = folder_of(SCENARIO, domain_id, more);
        let arguments = ["--laser", "0", "0", "0", "--stamped", "--delays"];
        let robot = Peer::robot(domain_id, &config, &arguments);
        // A name that tells what was driven.
        let text = std::fs::read_to_string(folder.path().join("it.toml"));
        let text = text.map_err(|error| format!("the scenario of the bridge: {error}"))?;
        let file = write_scenario("bridge", &text)?;
        bridged.push(bench.zeronav(&["run", &file])?);
        let said = robot.said("delay");
        let mut round: Vec<f64> = said.iter().filter_map(|it| it["us"].as_f64()).collect();
        let mut of = |share| percentile(&mut round, share).ok_or("no command reached the robot");
        delays.push([of(0.5)?, of(0.99)?]);
    }
    let none = [Figure::plain(None), Figure::plain(None)];
    let median = |at: usize| {
        let all: Vec<f64> = delays.iter().map(|it: &[f64; 2]| it[at]).collect();
        Figure::median(&all)
    };
    let rows = vec![
        row("simulated robot", &simulated, none)?,
        row("robot of ROS 2", &bridged, [median(0), median(1)])?,
    ];
    let columns = [
        "scan to the stack p50 [us]",
        "p99 [us]",
        "command to the seat p50 [us]",
        "p99 [us]",
        "reaction p50 [us]",
        "p99 [us]",
        "command from the seat to the robot's callback p50 [us]",
        "p99 [us]",
    ];
    Ok(Measured::tables(vec![table("robot", &columns, rows)]))
}

fn row(name: &str, results: &[Value], more: [Figure; 2]) -> Result<Row, String> {
    let mut figures = Vec::new();
    for (of, percentile) in COLUMNS {
        let mut values = Vec::new();
        for result in results {
            let value = latency(result, of)[percentile].as_f64();
            values.push(value.ok_or_else(|| format!("{name}: no {of} {percentile}"))?);
        }
        figures.push(Figure::median(&values));
    }
    figures.extend(more);
    let n = results
        .iter()
        .filter_map(|it| latency(it, "reaction")["n"].as_u64());
    Ok(Row {
        name: name.to_owned(),
        n: n.sum(),
        figures,
    })
}

/// The reaction, or a hop of the direct way.
fn latency<'a>(result: &'a Value, of: &str) -> &'a Value {
    let latency = &result["latency"];
    let hops = list(&latency["every_scan"], "direct").iter();
    let hop = hops.into_iter().find(|hop| hop["name"] == of);
    hop.unwrap_or(&latency[of])
}
