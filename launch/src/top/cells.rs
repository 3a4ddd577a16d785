//! What stands in the tables, on paper and on a terminal.

use super::view::{CompanionLine, ServiceLine, TopicLine, View};
use core::fmt::Write;
use zeronav_casts::Cast;
use zeronav_observe::usage::Usage;

/// Headings of the services.
pub(super) const SERVICE_HEADINGS: [&str; 9] = [
    "service",
    "state",
    "epoch",
    "restarts",
    "cpu %",
    "MB",
    "rejected",
    "superseded",
    "reasons",
];

/// Headings of the topics.
pub(super) const TOPIC_HEADINGS: [&str; 4] = ["topic", "Hz", "kB/s", "age"];

/// The cells of a service.
pub(super) fn service(line: &ServiceLine) -> [String; 9] {
    let [cpu, memory] = taken(&line.usage);
    [
        match &line.host {
            Some(host) => format!("{} on {host}", line.role),
            None => line.role.to_owned(),
        },
        line.state.to_owned(),
        line.epoch.to_string(),
        line.restarts.map_or_else(dash, |n| n.to_string()),
        cpu,
        memory,
        line.rejected.to_string(),
        line.superseded.to_string(),
        line.reasons.join(", "),
    ]
}

/// The cells of a companion, under the same headings: it has no epoch and no inputs, and how it ended stands in
/// the place of reasons.
pub(super) fn companion(line: &CompanionLine) -> [String; 9] {
    let [cpu, memory] = taken(&line.usage);
    [
        line.name.clone(),
        line.state.clone(),
        dash(),
        line.restarts.to_string(),
        cpu,
        memory,
        dash(),
        dash(),
        line.end.clone(),
    ]
}

/// Share of a processor and memory.
fn taken(usage: &Usage) -> [String; 2] {
    [
        usage
            .cpu_percent
            .map_or_else(dash, |percent| format!("{percent:.1}")),
        usage.memory_bytes.map_or_else(dash, megabytes),
    ]
}

/// The cells of a topic.
pub(super) fn topic(line: &TopicLine) -> [String; 4] {
    [
        line.topic.to_owned(),
        if line.hz == 0.0 {
            dash()
        } else {
            format!("{:.1}", line.hz)
        },
        if line.bytes_per_s == 0.0 {
            dash()
        } else {
            format!("{:.1}", 1.0e-3 * line.bytes_per_s)
        },
        line.age_s.map_or_else(dash, age),
    ]
}

/// The stack in one line.
pub(super) fn run(view: &View) -> String {
    let run = &view.run;
    let mut text = format!("{}  {}  {:.1} s", run.scenario, run.mode, run.time_s);
    if run.paused {
        text += "  paused";
    }
    let _ = write!(text, "  task {}", run.task);
    if let Some(remaining_m) = run.remaining_m {
        let _ = write!(text, ", {remaining_m:.1} m left");
    }
    if let Some(v_mps) = run.v_mps {
        let _ = write!(text, "  {v_mps:.2} m/s");
    }
    text
}

/// The reaction in one line.
pub(super) fn reaction(view: &View) -> String {
    let figures = view.reaction.supported();
    let us = |value: Option<f64>| value.map_or_else(dash, |us| format!("{us:.0}"));
    match figures.n {
        0 if view.run.mode == "lockstep" => "reaction: lockstep has no latencies".to_owned(),
        0 => "reaction: nothing measured".to_owned(),
        n => format!(
            "reaction [us]: p50 {}, p99 {}, max {}, {n} scans",
            us(figures.p50_us),
            us(figures.p99_us),
            us(figures.max_us)
        ),
    }
}

/// What this view takes, in one line.
pub(super) fn own(view: &View) -> String {
    let [cpu, memory] = taken(&view.own);
    format!("top: cpu {cpu} %, {memory} MB")
}

fn dash() -> String {
    "-".to_owned()
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1}", bytes.to_f64() / 1.0e6)
}

fn age(age_s: f64) -> String {
    if age_s < 1.0 {
        format!("{:.0} ms", 1.0e3 * age_s)
    } else {
        format!("{age_s:.1} s")
    }
}
