//! Requests to a run in progress: `zeronav ps` and `zeronav goal`.

use crate::exit::EXIT_PASS;
use crate::running;
use crate::show::terminal::{say, say_json, usage};
use crate::supervise::control::{Reply, Request, RunReport};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use zeronav_shell::printable;

/// `zeronav ps`.
#[must_use]
pub fn ps(json: bool) -> ExitCode {
    let runs: Vec<RunReport> = running::all()
        .into_iter()
        .map(|(_, report)| report)
        .collect();
    if json {
        say_json(&json!({ "runs": runs }));
        return ExitCode::from(EXIT_PASS);
    }
    if runs.is_empty() {
        say("no run goes on\n");
    }
    for run in &runs {
        say(&format!(
            "{}  pid {}  {}  {}  {:.1} s  task {}\n",
            printable(&run.scenario),
            run.pid,
            printable(&run.domain),
            printable(&run.mode),
            run.time_s,
            printable(&run.task)
        ));
        for service in &run.services {
            say(&format!(
                "  {:<16} pid {:<8} epoch {}  {:<9} {:>5.0} MB  {}\n",
                printable(&service.role),
                service.pid,
                service.epoch,
                printable(&service.state),
                megabytes(service.memory_peak_bytes),
                printable(&service.binary)
            ));
        }
    }
    ExitCode::from(EXIT_PASS)
}

#[allow(clippy::cast_precision_loss, reason = "sizes far below 2^53")]
fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1.0e6
}

/// A goal for a run in progress.
#[derive(Debug, Clone)]
pub struct GoalOrder {
    /// x, y [m] and yaw [rad] in the map frame.
    pub pose: [f64; 3],
    /// Largest distance that counts as reached. [m]
    pub tolerance_m: f64,
    /// Largest difference of yaw that counts as reached; pi and more accept any. [rad]
    pub yaw_tolerance_rad: f64,
    /// Root folder of the run; `None` when only one run is in progress.
    pub root: Option<PathBuf>,
}

/// `zeronav goal`.
#[must_use]
pub fn goal(order: &GoalOrder) -> ExitCode {
    let run = match running::find(order.root.as_deref()) {
        Ok(run) => run,
        Err(problem) => return usage(&problem),
    };
    let request = Request::Goal {
        pose: order.pose,
        tolerance_m: order.tolerance_m,
        yaw_tolerance_rad: order.yaw_tolerance_rad,
    };
    match run.ask(&request) {
        Ok(Reply::Done) => {
            let [x_m, y_m, yaw_rad] = order.pose;
            say(&format!("on its way to ({x_m}, {y_m}, {yaw_rad})\n"));
            ExitCode::from(EXIT_PASS)
        }
        Ok(_) => usage(&run.refusal("the answer is not one to a goal")),
        Err(problem) => usage(&problem),
    }
}
