//! What is measured: one row per experiment. A figure in a README is one of these or none.
// long: a row for each experiment

use super::bench::{Bench, Measured};
use super::printed::{lost_in_a_log, mapping_scale, planner_replan, with_data};
use super::{
    big_map, bridge, extract, faults, hosts, kidnapped, latencies, paired, shards, standing,
    suites, tracker, trials, viewing,
};

/// One experiment.
#[derive(Debug)]
pub struct Experiment {
    /// Its name on the command line and in the marks of the READMEs.
    pub key: &'static str,
    /// What it answers.
    pub title: &'static str,
    /// Rough wall time on two cores. [min]
    pub minutes: f64,
    /// True when `measure` without names makes it.
    pub by_default: bool,
    /// What a reader has to know to read the figures.
    pub note: Option<&'static str>,
    /// Makes it.
    pub make: fn(&mut Bench) -> Result<Measured, String>,
}

/// Every experiment, in the order of the page.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        key: "example",
        title: "what a run prints",
        minutes: 0.8,
        by_default: true,
        note: None,
        make: example,
    },
    Experiment {
        key: "replanning",
        title: "from a scan that shows an obstacle to the wheels, 200 trials in real time",
        minutes: 5.2,
        by_default: true,
        note: Some(
            "Percentiles are the median of three rounds, behind the median are the lowest and \
             the highest round; the worst is that of all rounds.",
        ),
        make: replanning,
    },
    Experiment {
        key: "lockstep",
        title: "speed and repeatability without a clock",
        minutes: 0.5,
        by_default: true,
        note: None,
        make: lockstep,
    },
    Experiment {
        key: "memory",
        title: "memory of a run",
        minutes: 0.3,
        by_default: true,
        note: None,
        make: memory,
    },
    Experiment {
        key: "drives",
        title: "long drives with every noise on, seeds 1 to 5, lockstep",
        minutes: 1.2,
        by_default: true,
        note: Some(
            "The pose is that of mapping at every scan, against the truth; quartiles over the seeds.",
        ),
        make: drives,
    },
    Experiment {
        key: "faults",
        title: "every service with every fault, in the middle of an aisle at 0.9 m/s",
        minutes: 13.0,
        by_default: false,
        note: Some(
            "Times to the next answer are from three runs in real time. Of `kill`, `stop` and `slow` the \
             other figures are from a fourth run in lockstep, in which a seat stays empty for 20 ticks. \
             Topics and clocks are disturbed for a second, one after the other in one drive to and fro; \
             half of the messages are lost or corrupted, or all are 100 ms late.",
        ),
        make: faults::make,
    },
    Experiment {
        key: "swaps",
        title: "each seat exchanged 20 times in one drive in real time",
        minutes: 4.5,
        by_default: false,
        note: Some("A gap of one period is none: one command a period."),
        make: standing::swaps,
    },
    Experiment {
        key: "restarts",
        title: "the global planner killed 100 times in one drive in real time",
        minutes: 10.5,
        by_default: false,
        note: None,
        make: standing::restarts,
    },
    Experiment {
        key: "shadow",
        title: "the own time of a seat with and without a shadow of it, five pairs of drives",
        minutes: 11.0,
        by_default: false,
        note: None,
        make: standing::shadow,
    },
    Experiment {
        key: "viewers",
        title: "latencies while somebody looks at the live page, five rounds of 20 trials each",
        minutes: 16.0,
        by_default: false,
        note: Some(
            "Ratios are to the run of the same round without a viewer; in brackets the quartiles of the \
             rounds. A client takes in the stream of the page and draws nothing.",
        ),
        make: viewing::viewers,
    },
    Experiment {
        key: "bridge",
        title: "the same drive with a simulated robot and with a robot of ROS 2, five rounds in turn",
        minutes: 6.0,
        by_default: false,
        note: Some(
            "The robot of ROS 2 is a node of rclpy (Kilted, Fast DDS) on the same machine with the simulator \
             behind it. From the stamp of a scan to its publication in the stack, from the guard to the seat, \
             from the seat to the callback of the node. Medians of the rounds, behind them their quartiles.",
        ),
        make: bridge::make,
    },
    Experiment {
        key: "hosts",
        title: "mapping and planners on a second host, five rounds in turn, and 20 drives over each bad way",
        minutes: 25.0,
        by_default: false,
        note: Some(
            "Two network namespaces of one machine. A way becomes bad after 2 s of a drive of 11 m; four drives at a time.",
        ),
        make: hosts::make,
    },
    Experiment {
        key: "shards",
        title: "a suite in shards by one worker of Ray and by two, three rounds in turn, and 10,000 runs estimated",
        minutes: 10.0,
        by_default: false,
        note: Some(
            "Wall times hold the start of Ray and the merging. Estimates begin each run on the core that is \
             free first, with the wall times that the runs of one worker took, one after the other until there are \
             10,000; a machine whose cores are all in use is slower.",
        ),
        make: shards::make,
    },
    Experiment {
        key: "stages",
        title: "latencies with and without timed stages, eight rounds of 20 trials each",
        minutes: 8.0,
        by_default: false,
        note: Some(
            "Ratios are to the run of the same round with `--no-stages`; in brackets the quartiles of the \
             rounds.",
        ),
        make: paired::stages,
    },
    Experiment {
        key: "placement",
        title: "latencies by how the kernel schedules the services, four rounds of 20 trials each",
        minutes: 9.0,
        by_default: false,
        note: Some(
            "On a machine with two processors. Ratios are to the run of the same round in which nothing \
             is asked of the kernel; in brackets the quartiles of the rounds.",
        ),
        make: paired::placement,
    },
    Experiment {
        key: "full_search",
        title: "replanning by a kept detour and by a full search, four rounds of 20 trials each",
        minutes: 5.0,
        by_default: false,
        note: Some(
            "Ratios are to the kept detour of the same round; in brackets the quartiles of the rounds.",
        ),
        make: paired::full_search,
    },
    Experiment {
        key: "rates",
        title: "latencies by the rate of the scans and their beams, 102 trials each",
        minutes: 14.0,
        by_default: false,
        note: Some(
            "Percentiles are the median of three rounds, behind medians are the lowest and the highest \
             round. The control rate is 50 Hz, and 100 Hz at 100 scans a second.",
        ),
        make: latencies::rates,
    },
    Experiment {
        key: "tail",
        title: "the slowest of 1,000 trials in real time, and what was slow in them",
        minutes: 20.0,
        by_default: false,
        note: Some(
            "p50, p90 and p99 are the median of three rounds; p99.9 is that of all samples together.",
        ),
        make: latencies::tail,
    },
    Experiment {
        key: "big_map",
        title: "the same aisle in a map of 4000 x 4000 cells, four rounds of 20 trials each",
        minutes: 6.0,
        by_default: false,
        note: Some(
            "The large map holds the same warehouse, and one door leads from it to 394 rooms. Ratios are \
             to the run of the same round in the warehouse alone; in brackets the quartiles of the \
             rounds. The memory of a run is that of all services and the shared memory. The start is \
             that of a short drive and counts from the command.",
        ),
        make: big_map::make,
    },
    Experiment {
        key: "hops",
        title: "the time of the global planner in the running stack, 102 trials each",
        minutes: 20.0,
        by_default: false,
        note: Some(
            "From the map that shows the obstacle, taken in, to the new path, sent. Percentiles are the \
             median of three rounds, behind the median are the lowest and the highest round.",
        ),
        make: latencies::hops,
    },
    Experiment {
        key: "generated",
        title: "worlds drawn from seeds, which need no data: clutter, cylinders, walkers",
        minutes: 3.0,
        by_default: true,
        note: None,
        make: suites::generated,
    },
    Experiment {
        key: "field",
        title: "what real robots meet, drawn from seeds: walls beside, docks, corners, late drives, slip, people",
        minutes: 20.0,
        by_default: false,
        note: Some(
            "A way of the outline is one that a search in place and yaw found, 1 cm from everything that \
             stands; run time is per time of that way at top speeds.",
        ),
        make: suites::field,
    },
    Experiment {
        key: "kidnapped",
        title: "robots that wake on a map without a pose, or with a wrong one",
        minutes: 20.0,
        by_default: false,
        note: Some(
            "Told wrong is 2 m ahead and turned by 180 degrees. A robot that is told nothing shall stay, and is found \
             when it says so, within 10 s; one that is told wrong, or right, shall drive elsewhere, within 60 s, and one that \
             is told right is not found if it was lost once. One that looks around is told nothing, makes small motions until \
             it knows, and shall drive there, too, within 90 s. Pose errors are those of then; wrong and certain: off by \
             more than 0.5 m or 0.3 rad.",
        ),
        make: kidnapped::make,
    },
    Experiment {
        key: "lost_in_a_log",
        title: "robots that may be anywhere on the map of a real lidar log",
        minutes: 2.0,
        by_default: false,
        note: Some(
            "The log is that of the Intel Research Lab with its corrected poses. Every other scan makes the map; the robots have \
             50 of the scans in between.",
        ),
        make: lost_in_a_log,
    },
    Experiment {
        key: "barn",
        title: "every public BARN world once, in our own 2-D simulator: no leaderboard entry",
        minutes: 3.0,
        by_default: true,
        note: None,
        make: suites::barn,
    },
    Experiment {
        key: "barn_controllers",
        title: "every controller on the same 10 BARN worlds",
        minutes: 10.0,
        by_default: false,
        note: Some("Ten worlds show how controllers differ, not how often they fail."),
        make: suites::barn_controllers,
    },
    Experiment {
        key: "pedestrians",
        title: "recorded people who do not see the robot, 60 runs for each controller",
        minutes: 12.0,
        by_default: false,
        note: None,
        make: suites::pedestrians,
    },
    Experiment {
        key: "dynabarn",
        title: "every DynaBARN world with three seeds for each controller",
        minutes: 8.0,
        by_default: false,
        note: None,
        make: suites::dynabarn,
    },
    Experiment {
        key: "told",
        title: "what is possible among what moves, and what perception and prediction cost",
        minutes: 25.0,
        by_default: false,
        note: Some(
            "Perception and prediction: `sensed` and `model` are the stack's own; with `truth` the \
             simulator tells mapping what moves, or the local planner where it will be, and the row \
             is no result of the stack.",
        ),
        make: suites::told,
    },
    Experiment {
        key: "papers_dyn",
        title: "the papers' scenes with dynamic obstacles",
        minutes: 4.0,
        by_default: false,
        note: Some("In brackets the 95 % intervals of Wilson."),
        make: suites::papers_dyn,
    },
    Experiment {
        key: "tracker",
        title: "the tracker of mapping against the truth, among recorded people and in DynaBARN worlds",
        minutes: 1.5,
        by_default: false,
        note: Some(
            "In one process, by the script of `tests/src/tracker_bench`: a Jackal with its noise stands \
             at the edge, or drives to and fro at 1 m/s. What is true is taken into mapping's map by the \
             pose that mapping says.",
        ),
        make: tracker::make,
    },
    Experiment {
        key: "bench_guard",
        title: "a cycle of the collision guard in an aisle 0.9 m wide at 1 m/s",
        minutes: 0.7,
        by_default: true,
        note: None,
        make: |bench| criterion(bench, "zeronav-collision-guard", &["guard"]),
    },
    Experiment {
        key: "bench_controllers",
        title: "a cycle of the local planner's controllers",
        minutes: 1.4,
        by_default: true,
        note: Some(
            "`ready`: between two scans; `new scan`: points with noise and a changed map, so that \
             the cost-to-go is recomputed.",
        ),
        make: |bench| criterion(bench, "zeronav-local-planner", &["dwa", "mppi", "beam"]),
    },
    Experiment {
        key: "bench_mapping",
        title: "a scan into the map",
        minutes: 0.8,
        by_default: true,
        note: None,
        make: |bench| criterion(bench, "zeronav-mapping", &["scan"]),
    },
    Experiment {
        key: "bench_search",
        title: "searches of the global planner",
        minutes: 2.0,
        by_default: true,
        note: None,
        make: |bench| criterion(bench, "zeronav-global-planner", &["astar"]),
    },
    Experiment {
        key: "bench_simulator",
        title: "a scan of the simulated lidar",
        minutes: 0.8,
        by_default: true,
        note: None,
        make: |bench| criterion(bench, "zeronav-robot-sim", &["lidar"]),
    },
    Experiment {
        key: "bench_records",
        title: "what an answer costs that is measured: its record and its clock readings",
        minutes: 0.3,
        by_default: false,
        note: Some(
            "The record is written after the readers of the answer were rung, so it delays none of \
             them; the readings are in every hop.",
        ),
        make: |bench| criterion(bench, "zeronav-shell", &["records"]),
    },
    Experiment {
        key: "planner_replan",
        title: "searching again after a local change of the map",
        minutes: 9.0,
        by_default: false,
        note: None,
        make: planner_replan,
    },
    Experiment {
        key: "planner_lengths",
        title: "lengths of paths on MovingAI maps",
        minutes: 5.0,
        by_default: false,
        note: None,
        make: |bench| with_data(bench, "movingai", "100"),
    },
    Experiment {
        key: "planner_peers",
        title: "searches against published crates on MovingAI maps",
        minutes: 10.0,
        by_default: false,
        note: None,
        make: |bench| with_data(bench, "peers", "20"),
    },
    Experiment {
        key: "mapping_scale",
        title: "time of a scan against the size of the map",
        minutes: 1.0,
        by_default: false,
        note: None,
        make: mapping_scale,
    },
];

/// Runs of an experiment in lockstep, with the seeds from 1.
const LOCKSTEP_RUNS: usize = 12;

fn example(bench: &mut Bench) -> Result<Measured, String> {
    let page = bench.zeronav_page(&["run", "blocked_aisle"])?;
    // The last line is the folder.
    let lines: Vec<&str> = page.trim_end().lines().collect();
    Ok(Measured::printed(
        &lines[..lines.len().saturating_sub(1)].join("\n"),
    ))
}

fn replanning(bench: &mut Bench) -> Result<Measured, String> {
    let result = bench.zeronav(&["run", "blocked_aisle", "--trials", "200"])?;
    Ok(Measured::tables(vec![
        trials::latency(&result),
        trials::checks(&result),
        trials::slowest(&result, 5),
        trials::disturbance(&result),
    ]))
}

fn lockstep_runs(bench: &mut Bench, n: usize) -> Result<Vec<serde_json::Value>, String> {
    (0..n)
        .map(|_| bench.zeronav(&["run", "blocked_aisle", "--lockstep"]))
        .collect()
}

fn lockstep(bench: &mut Bench) -> Result<Measured, String> {
    let results = lockstep_runs(bench, LOCKSTEP_RUNS)?;
    Ok(Measured::tables(vec![extract::lockstep(
        "`blocked_aisle`",
        &results,
    )]))
}

fn memory(bench: &mut Bench) -> Result<Measured, String> {
    let results = lockstep_runs(bench, 5)?;
    Ok(Measured::tables(vec![extract::memory(&results)]))
}

fn drives(bench: &mut Bench) -> Result<Measured, String> {
    let scenarios = [
        ("drive_warehouse", "tests/scenarios/drive_warehouse.toml"),
        ("noisy_rooms", "tests/scenarios/noisy_rooms.toml"),
        ("moving_discs", "moving_discs"),
        ("crossing_walkers", "crossing_walkers"),
    ];
    let mut runs = Vec::new();
    for (name, scenario) in scenarios {
        let mut results = Vec::new();
        for seed in ["1", "2", "3", "4", "5"] {
            results.push(bench.zeronav(&["run", scenario, "--lockstep", "--seed", seed])?);
        }
        runs.push((name, results));
    }
    Ok(Measured::tables(vec![extract::drives(&runs)]))
}

fn criterion(bench: &mut Bench, package: &str, benches: &[&str]) -> Result<Measured, String> {
    let mut timings = Vec::new();
    for name in benches {
        for mut timing in bench.criterion(package, name)? {
            if benches.len() > 1 {
                timing.name = format!("{name}: {}", timing.name);
            }
            timings.push(timing);
        }
    }
    Ok(Measured::tables(vec![extract::timings(&timings)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_words_and_the_default_set_takes_less_than_20_minutes() {
        let mut keys: Vec<&str> = EXPERIMENTS.iter().map(|one| one.key).collect();
        let word = |key: &&str| {
            key.bytes()
                .all(|byte| byte.is_ascii_lowercase() || byte == b'_')
        };
        assert!(keys.iter().all(word), "{keys:?}");
        let n = keys.len();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), n, "twice the same key");
        let by_default = EXPERIMENTS.iter().filter(|one| one.by_default);
        let minutes: f64 = by_default.map(|one| one.minutes).sum();
        assert!(minutes < 20.0, "{minutes} minutes");
    }
}
