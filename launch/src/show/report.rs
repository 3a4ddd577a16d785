//! The result of a run: one object for machines, one page for people.

use crate::keeper::RestartRecord;
use crate::measure::Latency;
use crate::measure::tracking::{PoseResult, TrackingResult};
use crate::redirect::Redirect;
use crate::trials::{Round, SlowTrial};
use core::fmt::Write;
use serde::Serialize;
use std::collections::BTreeMap;

/// A path that was published.
#[derive(Debug, Clone, Serialize)]
pub struct Plan {
    /// Run time. [s]
    pub time_s: f64,
    /// Why it was made.
    pub cause: String,
    /// Who made it.
    pub planner: String,
    /// `found`, or why there is none.
    pub status: String,
    /// Length. [m]
    pub length_m: f64,
    /// From its end to the goal, above 0 when the goal itself cannot be reached. [m]
    pub beside_goal_m: f64,
    /// Nodes expanded.
    pub expanded: u64,
    /// Its corners, `map` frame. [m]
    pub points_m: Vec<[f64; 2]>,
}

/// A scripted obstacle that appeared.
#[derive(Debug, Clone, Serialize)]
pub struct ObstacleResult {
    /// Its name.
    pub name: String,
    /// Corners of its outline where it was last, `map` frame. [m]
    pub corners_m: Vec<[f64; 2]>,
}

/// The begin of a contact.
#[derive(Debug, Clone, Serialize)]
pub struct Touch {
    /// Time since the first goal. [s]
    pub time_s: f64,
    /// True when the robot moved.
    pub moving: bool,
    /// Forward speed just before. [m/s]
    pub v_mps: f64,
    /// What was touched: a scripted obstacle's name, or `world`.
    pub with: String,
    /// True `map_from_base`: x [m], y [m], yaw [rad].
    pub pose: [f64; 3],
}

/// What was expected, and whether it came.
#[derive(Debug, Clone, Serialize)]
pub struct Expectation {
    /// What.
    pub name: String,
    /// As the scenario wishes.
    pub expected: String,
    /// As it came.
    pub actual: String,
    /// True when both agree.
    pub met: bool,
}

/// One process of the run.
#[derive(Debug, Clone, Serialize)]
pub struct ServiceResult {
    /// Its seat.
    pub name: String,
    /// File name of the program that answered.
    pub binary: String,
    /// Its process id; 0 when none answered.
    pub pid: u32,
    /// True when the seat was left to a process that was started by hand.
    pub external: bool,
    /// Key of its algorithm, where it has told one.
    pub key: Option<String>,
    /// How many times it was started.
    pub starts: u32,
    /// Largest resident memory. [bytes]
    pub memory_peak_bytes: u64,
    /// How it ended.
    pub end: String,
}

impl ServiceResult {
    /// The process that answered, for people.
    fn who(&self) -> String {
        let by_hand = if self.external {
            ", started by hand"
        } else {
            ""
        };
        format!("{} {} (pid {}{by_hand})", self.name, self.binary, self.pid)
    }
}

/// Where and with what the run was made.
#[derive(Debug, Clone, Serialize)]
pub struct Environment {
    /// Version of the project.
    pub version: String,
    /// `release` or `debug`.
    pub build: String,
    /// Processor.
    pub cpu: String,
    /// Processors that this process may use.
    pub cores: usize,
    /// Kernel.
    pub kernel: String,
    /// Load average of the last minute at the start.
    pub load_start: f64,
    /// Load average of the last minute at the end.
    pub load_end: f64,
    /// Share of processor time that the host gave to others during the run, 0 to 1.
    pub steal: f64,
}

/// What the trials were.
#[derive(Debug, Clone, Serialize)]
pub struct TrialsResult {
    /// Trials that were asked for.
    pub wanted: usize,
    /// Trials that were made and count.
    pub made: usize,
    /// The rounds.
    pub rounds: Vec<Round>,
    /// The slowest trials with what disturbed them, slowest first.
    pub worst: Vec<SlowTrial>,
}

/// The result of a run.
#[derive(Debug, Clone, Serialize)]
pub struct RunResult {
    /// Scenario.
    pub scenario: String,
    /// `pass` or `fail`.
    pub verdict: String,
    /// The same in words.
    pub reason: String,
    /// `reached`, `unreachable`, `stuck`, `timeout` and so on.
    pub outcome: String,
    /// True when every goal was reached.
    pub reached: bool,
    /// Contacts of the robot with anything.
    pub contacts: u32,
    /// Contacts that began while the robot moved.
    pub contacts_moving: u32,
    /// Contacts that began while the robot stood.
    pub contacts_standing: u32,
    /// Smallest distance of the footprint to anything; null when nothing was near. [m]
    pub clearance_m_min: Option<f64>,
    /// Run time from the first goal to the end. [s]
    pub time_s: f64,
    /// Distance driven. [m]
    pub driven_m: f64,
    /// `real_time` or `lockstep`.
    pub mode: String,
    /// Seed.
    pub seed: u64,
    /// Wall time of the drive. [s]
    pub wall_s: f64,
    /// Run time per wall time.
    pub speed_factor: f64,
    /// Run time that was lost because the machine was busy. [ms]
    pub slipped_ms: f64,
    /// Every path, the first ones included.
    pub plans: Vec<Plan>,
    /// Every path that took the place of another.
    pub replans: Vec<Plan>,
    /// Scripted obstacles that appeared.
    pub obstacles: Vec<ObstacleResult>,
    /// Where the robot really drove, every 5 cm. [m]
    pub track_m: Vec<[f64; 2]>,
    /// Ten times a second: time since the first goal [s], true x [m], y [m] and yaw [rad], forward
    /// speed [m/s], yaw rate [rad/s]. Empty after trials.
    pub motion: Vec<[f64; 6]>,
    /// Mean absolute jerk of the forward speed. [m/s^3] Of trials: of the last drive.
    pub jerk_mps3: Option<f64>,
    /// Manoeuvres and waits of the local planner's recovery. Of trials: in the last drive.
    pub recoveries: u32,
    /// Why the robot got stuck, `blocked`, `no_progress` or `too_many_attempts`; null when it has
    /// not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stuck_cause: Option<String>,
    /// What the robot touched. Of trials: in the last drive.
    pub touches: Vec<Touch>,
    /// How often the collision guard stepped in. Of trials: in the last drive.
    pub interventions: usize,
    /// The same by reason.
    pub interventions_by_reason: BTreeMap<String, usize>,
    /// Where mapping said the robot was against where it was; of trials: of the last drive.
    pub pose: Option<PoseResult>,
    /// Moving obstacles as mapping followed them; null when nothing moved. Of trials: of the last
    /// drive.
    pub tracking: Option<TrackingResult>,
    /// Latencies; null in lockstep. Of trials: the median of the rounds, the worst of all.
    pub latency: Option<Latency>,
    /// The rounds of `--trials`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trials: Option<TrialsResult>,
    /// Delays of `--inject` by seat. [us]
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub injected_us: BTreeMap<String, f64>,
    /// The processes.
    pub services: Vec<ServiceResult>,
    /// Restarts of services during the run.
    pub restarts: Vec<RestartRecord>,
    /// Goals that were given by hand.
    pub redirects: Vec<Redirect>,
    /// Machine and build.
    pub environment: Environment,
    /// Shared memory of the run. [bytes]
    pub shared_memory_bytes: u64,
    /// Hash of a lockstep run.
    pub run_hash: Option<String>,
    /// What was expected.
    pub expectations: Vec<Expectation>,
    /// Folder with everything that the run left.
    pub directory: String,
}

impl RunResult {
    /// What the services took, and which processes they were.
    fn write_services(&self, text: &mut String) {
        let _ = writeln!(
            text,
            "\n  shared memory {:.1} MB; peak memory {}",
            megabytes(self.shared_memory_bytes),
            self.services
                .iter()
                .map(|service| format!(
                    "{} {:.0} MB",
                    service.name,
                    megabytes(service.memory_peak_bytes)
                ))
                .collect::<Vec<_>>()
                .join(", ")
        );
        let _ = writeln!(text, "  answered by {}", self.who_answered());
    }

    /// The processes that answered, for people.
    fn who_answered(&self) -> String {
        let who: Vec<String> = self.services.iter().map(ServiceResult::who).collect();
        who.join(", ")
    }

    /// The page for people.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(
            text,
            "{}  {}: {}",
            self.verdict.to_uppercase(),
            self.scenario,
            self.reason
        );
        let _ = writeln!(
            text,
            "  drove {:.1} m in {:.1} s of run time ({}, {:.1} x real time), {} contacts{}",
            self.driven_m,
            self.time_s,
            self.mode,
            self.speed_factor,
            self.contacts,
            self.clearance_m_min
                .map_or_else(String::new, |least| format!(", closest {least:.2} m")),
        );
        if self.slipped_ms > 0.0 {
            let _ = writeln!(
                text,
                "  run time slipped by {:.1} ms: the machine was busy",
                self.slipped_ms
            );
        }
        if !self.injected_us.is_empty() {
            let delays = self.injected_us.iter();
            let delays: Vec<String> = delays
                .map(|(role, delay_us)| format!("{role} {:.2} ms", delay_us / 1.0e3))
                .collect();
            let _ = writeln!(text, "  delays were injected: {}", delays.join(", "));
        }
        for plan in &self.plans {
            let _ = writeln!(
                text,
                "  {:8.2} s  path by {}: {}, {:.1} m, {} expanded, cause {}{}",
                plan.time_s,
                plan.planner,
                plan.status,
                plan.length_m,
                plan.expanded,
                plan.cause,
                beside(plan.beside_goal_m)
            );
        }
        for restart in &self.restarts {
            let _ = writeln!(
                text,
                "  {:8.2} s  {} restarted: {}",
                restart.time_s, restart.service, restart.how
            );
        }
        for Redirect {
            time_s,
            goal: [x_m, y_m, yaw_rad],
            outcome,
        } in &self.redirects
        {
            let _ = writeln!(
                text,
                "  {time_s:8.2} s  sent to ({x_m:.2}, {y_m:.2}, {yaw_rad:.2}) by hand: {outcome}"
            );
        }
        if let Some(pose) = &self.pose {
            pose.write(&mut text);
        }
        if let Some(tracking) = &self.tracking {
            tracking.write(&mut text);
        }
        if let Some(latency) = &self.latency {
            write_latency(latency, &mut text);
        }
        if let Some(trials) = &self.trials {
            text.push_str("  slowest trials\n");
            trials.worst.iter().for_each(|slow| slow.write(&mut text));
        }
        self.write_services(&mut text);
        if let Some(hash) = &self.run_hash {
            let _ = writeln!(text, "  run hash {hash}");
        }
        for expectation in self
            .expectations
            .iter()
            .filter(|expectation| !expectation.met)
        {
            let _ = writeln!(
                text,
                "  expected {}: {}, but it was {}",
                expectation.name, expectation.expected, expectation.actual
            );
        }
        let _ = writeln!(text, "  {}", self.directory);
        text
    }
}

/// Says where a path ends that does not end at its goal.
fn beside(beside_goal_m: f64) -> String {
    if beside_goal_m < 0.005 {
        return String::new();
    }
    format!(", to {beside_goal_m:.2} m beside the goal, which is blocked")
}

/// The table of latencies.
fn write_latency(latency: &Latency, text: &mut String) {
    let _ = writeln!(
        text,
        "\n  latency [us]              n  censored        p50        p90        p99        max"
    );
    let mut row = |name: &str, figures: &crate::measure::distribution::Figures| {
        let figures = figures.supported();
        let cell = |value: Option<f64>| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.0}"))
        };
        let _ = writeln!(
            text,
            "  {name:<20} {:>6}  {:>8} {:>10} {:>10} {:>10} {:>10}",
            figures.n,
            figures.censored,
            cell(figures.p50_us),
            cell(figures.p90_us),
            cell(figures.p99_us),
            cell(figures.max_us)
        );
    };
    row("reaction", &latency.reaction);
    row("replanning", &latency.replanning);
    row("event to motion", &latency.event_to_motion);
    for hop in &latency.hops {
        row(&format!("  {}", hop.name), &hop.figures);
    }
    if let Some(floor) = &latency.transport_floor {
        row("transport floor", floor);
    }
    if let Some(ratio) = latency.replanning_to_floor {
        let _ = writeln!(
            text,
            "  replanning takes {ratio:.1} times the floor (medians)"
        );
    }
    let disorder: u64 = latency.hops_out_of_order.values().sum();
    let _ = writeln!(
        text,
        "  {} commands followed back to their scan: {} records missing, {disorder} stamps before \
         their predecessor",
        latency.ways, latency.ways_broken
    );
    if let Some(clock) = &latency.second_clock
        && let Some((median_us, most_us)) = clock.difference.p50_us.zip(clock.difference.max_us)
    {
        let _ = writeln!(
            text,
            "  the hops add up to the robot's time on its second clock within {median_us:.0} us \
             (median), {most_us:.0} us (most); {} beyond what the clocks' rates allow",
            clock.beyond
        );
    }
    if latency.revised > 0 {
        let _ = writeln!(
            text,
            "  {} answers corrected later, when more of the obstacle had been seen",
            latency.revised
        );
    }
}

#[allow(clippy::cast_precision_loss, reason = "sizes far below 2^53")]
fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1.0e6
}
