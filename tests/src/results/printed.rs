//! Examples of the services whose output is kept as it is printed.

use super::bench::{Bench, Measured};

/// Arguments of an example of the global planner.
fn example_of_planner(name: &str) -> [&str; 11] {
    [
        "run",
        "--release",
        "--quiet",
        "-p",
        "zeronav-global-planner",
        "--no-default-features",
        "--features",
        "peers",
        "--example",
        name,
        "--",
    ]
}

pub(super) fn planner_replan(bench: &mut Bench) -> Result<Measured, String> {
    let mut arguments = example_of_planner("replan").to_vec();
    arguments.extend(["--events", "20"]);
    let text = if bench.has_data() {
        bench.cargo_with_data(&arguments, "movingai")?
    } else {
        bench.cargo(&arguments)?
    };
    Ok(Measured::printed(&text))
}

pub(super) fn with_data(
    bench: &mut Bench,
    example: &str,
    sample: &str,
) -> Result<Measured, String> {
    let mut arguments = example_of_planner(example).to_vec();
    arguments.extend(["--sample", sample]);
    Ok(Measured::printed(
        &bench.cargo_with_data(&arguments, "movingai")?,
    ))
}

/// Robots that may be anywhere on the map of a real log.
pub(super) fn lost_in_a_log(bench: &mut Bench) -> Result<Measured, String> {
    let arguments = [
        "run",
        "--release",
        "--quiet",
        "-p",
        "zeronav-mapping",
        "--no-default-features",
        "--example",
        "carmen",
        "--",
        "--lost",
        "50",
    ];
    Ok(Measured::printed(
        &bench.cargo_with_data(&arguments, "rosmaps")?,
    ))
}

pub(super) fn mapping_scale(bench: &mut Bench) -> Result<Measured, String> {
    let text = bench.cargo(&[
        "run",
        "--release",
        "--quiet",
        "-p",
        "zeronav-mapping",
        "--no-default-features",
        "--example",
        "scale",
    ])?;
    Ok(Measured::printed(&text))
}
