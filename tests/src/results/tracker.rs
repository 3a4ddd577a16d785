//! The tracker of mapping against the truth.

use super::bench::{Bench, Measured};
use super::record::Table;
use serde::Deserialize;

/// What `zeronav-tracker-bench --json` prints, as far as it is kept.
#[derive(Debug, Deserialize)]
struct Printed {
    tables: Vec<Table>,
}

/// With the robot's own lidar, as in the suites, and with a slow one.
const RUNS: [&[&str]; 2] = [&["--json"], &["--rate-hz", "10", "--json"]];

pub(super) fn make(bench: &mut Bench) -> Result<Measured, String> {
    let mut tables = Vec::new();
    for arguments in RUNS {
        let text = bench.tool("zeronav-tracker-bench", arguments)?;
        let printed: Printed = serde_json::from_str(&text)
            .map_err(|error| format!("zeronav-tracker-bench {arguments:?}: {error}"))?;
        tables.extend(printed.tables);
    }
    Ok(Measured::tables(tables))
}
