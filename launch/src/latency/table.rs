//! The report of `zeronav latency` for people.

use super::report::{Assertion, Cell, Report};
use core::fmt::Write;
use std::collections::BTreeMap;
use zeronav_measure::profile::{FLOOR, REACTIONS};
use zeronav_measure::result::profile::ProfileRow;
use zeronav_measure::result::trials::Disturbance;
use zeronav_observe::hop_chain::HOPS;

impl Report {
    /// The report as a page of text.
    pub(super) fn to_text(&self) -> String {
        let mut text = String::new();
        for cell in &self.cells {
            write_cell(cell, &mut text);
        }
        if !self.assertions.is_empty() {
            text.push_str("asserted\n");
        }
        for assertion in &self.assertions {
            write_assertion(assertion, &mut text);
        }
        text
    }
}

fn write_cell(cell: &Cell, text: &mut String) {
    let made = match cell.trials {
        0 => "one drive".to_owned(),
        n => format!("{n} trials in {} rounds", cell.rounds),
    };
    let _ = writeln!(
        text,
        "{}, {} scans per second, {} machine: {made}; {}: {}",
        cell.scenario, cell.rate_hz, cell.load, cell.verdict, cell.reason
    );
    write_latencies(cell, text);
    write_every_scan(cell, text);
    write_edges(cell, text);
    write_commands(cell, text);
    write_kernel(&cell.disturbances, text);
    for lint in &cell.lints {
        let _ = writeln!(text, "  note: {lint}");
    }
    let _ = writeln!(text, "  {}\n", cell.directory);
}

fn write_latencies(cell: &Cell, text: &mut String) {
    let head = "latency [us], 95 % intervals";
    let _ = writeln!(
        text,
        "\n  {head:<28} {:>6} {:>8}  {:<22} {:<22} {:<22} {:>8}",
        "n", "censored", "p50", "p90", "p99", "max"
    );
    let mut row = |label: &str, name: &str| {
        if let Some(row) = cell.row(name).filter(|row| row.figures.n > 0) {
            write_row(label, row, text);
        }
    };
    row("reaction", REACTIONS[0]);
    row("  naive: scans read", REACTIONS[1]);
    row("  corrected: scans due", REACTIONS[2]);
    row("replanning", "replanning");
    row("event to motion", "event_to_motion");
    for hop in HOPS {
        row(&format!("  {hop}"), hop);
    }
    row("transport floor", FLOOR);
    if let Some(ratio) = cell.replanning_to_floor {
        let _ = writeln!(
            text,
            "  replanning takes {ratio:.1} times the floor (medians)"
        );
    }
}

fn write_row(label: &str, row: &ProfileRow, text: &mut String) {
    let figures = row.figures.supported();
    let cell = |value: Option<f64>, interval: Option<[f64; 2]>| match (value, interval) {
        (Some(value), Some([low, high])) => format!("{value:.0} [{low:.0}, {high:.0}]"),
        (Some(value), None) => format!("{value:.0}"),
        (None, _) => "-".to_owned(),
    };
    let _ = writeln!(
        text,
        "  {label:<28} {:>6} {:>8}  {:<22} {:<22} {:<22} {:>8}",
        figures.n,
        figures.censored,
        cell(figures.p50_us, row.p50_interval_us),
        cell(figures.p90_us, row.p90_interval_us),
        cell(figures.p99_us, row.p99_interval_us),
        cell(figures.max_us, None)
    );
}

/// The hops of every scan, both ways side by side.
fn write_every_scan(cell: &Cell, text: &mut String) {
    let _ = writeln!(
        text,
        "\n  {:<28} {:<22} {:<22} {:<22} through map p99",
        "every scan [us]", "direct p50", "direct p99", "through map p50"
    );
    for hop in HOPS {
        let figure = |table: &str, is_p99: bool| {
            let row = cell.row(&format!("{table}.{hop}"));
            let found = row.and_then(|row| {
                let figures = row.figures.supported();
                if is_p99 {
                    figures.p99_us.zip(row.p99_interval_us)
                } else {
                    figures.p50_us.zip(row.p50_interval_us)
                }
            });
            found.map(|(value, [low, high])| format!("{value:.0} [{low:.0}, {high:.0}]"))
        };
        let figures = [
            figure("direct", false),
            figure("direct", true),
            figure("through_map", false),
            figure("through_map", true),
        ];
        if figures.iter().all(Option::is_none) {
            continue;
        }
        let [a, b, c, d] = figures.map(|figure| figure.unwrap_or_else(|| "-".to_owned()));
        let _ = writeln!(text, "    {hop:<26} {a:<22} {b:<22} {c:<22} {d}");
    }
}

fn write_edges(cell: &Cell, text: &mut String) {
    let _ = writeln!(
        text,
        "\n  {:<48} {:>8} {:>11}",
        "messages", "sent", "superseded"
    );
    for edge in &cell.edges {
        let name = format!("{} -> {}", edge.topic, edge.reader);
        let _ = writeln!(
            text,
            "    {name:<46} {:>8} {:>11}",
            edge.sent, edge.superseded
        );
    }
}

fn write_commands(cell: &Cell, text: &mut String) {
    let commands = &cell.commands;
    let causes: Vec<String> = commands
        .missed_by_cause
        .iter()
        .map(|(cause, n)| format!("{cause} {n}"))
        .collect();
    let causes = if causes.is_empty() {
        String::new()
    } else {
        format!(" ({})", causes.join("; "))
    };
    let _ = writeln!(
        text,
        "\n  {} velocity commands, one every {:.1} ms: longest gap {:.1} ms, {} beyond one and a half \
         periods{causes}",
        commands.n,
        commands.period_us / 1.0e3,
        commands.gap_us_max / 1.0e3,
        commands.missed
    );
}

/// What the kernel did, over all rounds.
fn write_kernel(disturbances: &[Disturbance], text: &mut String) {
    #[derive(Default)]
    struct Sum {
        ran_us: f64,
        waited_us: f64,
        off_us_max: f64,
        preempted: u64,
        slept: u64,
        faults: u64,
    }
    let mut names: Vec<&str> = Vec::new();
    let mut sums: BTreeMap<&str, Sum> = BTreeMap::new();
    for service in disturbances.iter().flat_map(|all| &all.services) {
        if !names.contains(&service.name.as_str()) {
            names.push(&service.name);
        }
        let sum = sums.entry(&service.name).or_default();
        sum.ran_us += service.processor_us;
        sum.waited_us += service.queue_us;
        sum.off_us_max = sum.off_us_max.max(service.off_processor_us_max);
        sum.preempted += service.involuntary_switches;
        sum.slept += service.voluntary_switches;
        sum.faults += service.major_faults;
    }
    if names.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "\n  {:<22} {:>10} {:>12} {:>18} {:>12} {:>10} {:>12}",
        "kernel",
        "ran [ms]",
        "waited [ms]",
        "longest off [us]",
        "preemptions",
        "sleeps",
        "major faults"
    );
    for (name, sum) in names.iter().filter_map(|name| sums.get_key_value(name)) {
        let _ = writeln!(
            text,
            "    {name:<20} {:>10.0} {:>12.1} {:>18.0} {:>12} {:>10} {:>12}",
            sum.ran_us / 1.0e3,
            sum.waited_us / 1.0e3,
            sum.off_us_max,
            sum.preempted,
            sum.slept,
            sum.faults
        );
    }
    let load = disturbances
        .iter()
        .map(|one| one.load_end)
        .fold(0.0, f64::max);
    let steal = disturbances.iter().map(|one| one.steal).fold(0.0, f64::max);
    let _ = writeln!(text, "    load {load:.1}, steal {:.1} %", 1.0e2 * steal);
}

fn write_assertion(assertion: &Assertion, text: &mut String) {
    let Assertion {
        clause,
        rate_hz,
        load,
        met,
        n,
        said,
        ..
    } = assertion;
    let verdict = if *met { "met    " } else { "NOT MET" };
    let _ = writeln!(
        text,
        "  {verdict}  {clause}: {said} (n {n}), {rate_hz} Hz, {load}"
    );
}
