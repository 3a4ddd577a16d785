//! The processes of a run, and what was done to them.

use super::events::Event;
use super::html::{Cell, megabytes, number, table, time, words};
use zeronav_measure::result::companion::CompanionResult;
use zeronav_measure::result::fault::FaultResult;
use zeronav_measure::result::swap::SwapResult;
use zeronav_measure::result::{Restart, ServiceResult, Starved};
use zeronav_measure::timings::Timings;

/// The table of processes.
pub(super) fn services(services: &[ServiceResult], timings: Option<&Timings>) -> String {
    let computing = |seat: &str| {
        let all = timings.map_or(&[][..], |timings| &timings.computing);
        let found = all.iter().find(|(name, _)| name == seat);
        found.map(|(_, spread)| spread.figures.supported())
    };
    let row = |service: &ServiceResult| {
        let by_hand = if service.external { ", by hand" } else { "" };
        let host = service.host.as_ref();
        let host = host.map_or_else(String::new, |host| format!(" on {host}"));
        let answers = computing(&service.name);
        vec![
            Cell::text(words(&service.name)),
            Cell::text(format!("{}{host}{by_hand}", service.binary)),
            Cell::text(service.key.clone().unwrap_or_default()),
            Cell::count(service.starts.saturating_sub(1)),
            Cell::Number(megabytes(service.memory_peak_bytes)),
            Cell::Number(answers.map_or_else(|| "–".to_owned(), |figures| figures.n.to_string())),
            Cell::Number(time(answers.and_then(|figures| figures.p50_us))),
            Cell::Number(time(answers.and_then(|figures| figures.p99_us))),
            Cell::Number(time(answers.and_then(|figures| figures.max_us))),
            Cell::text(scheduling(service)),
            Cell::text(service.end.clone()),
        ]
    };
    let rows: Vec<Vec<Cell>> = services.iter().map(row).collect();
    table(
        &[
            "seat",
            "binary",
            "algorithm",
            "#restarts",
            "#peak memory",
            "#answers",
            "#computing, p50",
            "#p99",
            "#max",
            "scheduling",
            "end",
        ],
        &rows,
    )
}

/// The processes that ran beside the stack.
pub(super) fn companions(companions: &[CompanionResult]) -> String {
    let row = |companion: &CompanionResult| {
        vec![
            Cell::text(companion.name.clone()),
            Cell::text(companion.binary.clone()),
            Cell::count(companion.starts.saturating_sub(1)),
            Cell::text(companion.end.clone()),
        ]
    };
    let rows: Vec<Vec<Cell>> = companions.iter().map(row).collect();
    let heads = ["companion", "binary", "#restarts", "end"];
    titled("Companions", &table(&heads, &rows))
}

/// What the kernel granted, and what it did not.
fn scheduling(service: &ServiceResult) -> String {
    let Some(scheduling) = &service.scheduling else {
        return String::new();
    };
    let refused = scheduling.refused.iter();
    let refused = refused.map(|refused| format!("; not granted: {refused}"));
    scheduling.in_words() + &refused.collect::<String>()
}

/// Restarts, by the time of the page.
pub(super) fn restarts(restarts: &[Restart], from_s: f64) -> String {
    let row = |restart: &Restart| {
        vec![
            Cell::moment((restart.time_s - from_s).max(0.0)),
            Cell::text(words(&restart.service)),
            Cell::text(restart.how.clone()),
            Cell::Number(format!("{} ms", restart.wait_ms)),
        ]
    };
    let rows: Vec<Vec<Cell>> = restarts.iter().map(row).collect();
    titled(
        "Restarts",
        &table(
            &["time", "seat", "how it ended", "#wait before the successor"],
            &rows,
        ),
    )
}

/// Services that got no processor, by the time of the page.
pub(super) fn starved(starved: &[Starved], from_s: f64) -> String {
    let row = |seat: &Starved| {
        vec![
            Cell::moment((seat.time_s - from_s).max(0.0)),
            Cell::text(words(&seat.service)),
            Cell::Number(seat.times.to_string()),
            Cell::Number(format!("{} s", number(seat.longest_s, 1))),
            Cell::Number(format!("{} s", number(seat.waited_s, 1))),
        ]
    };
    let rows: Vec<Vec<Cell>> = starved.iter().map(row).collect();
    let heads = [
        "first at",
        "seat",
        "#times without progress",
        "#longest",
        "#waited for a processor",
    ];
    titled("Starved", &table(&heads, &rows))
}

/// Faults that were made on purpose.
pub(super) fn faults(faults: &[FaultResult], from_s: f64) -> String {
    let row = |fault: &FaultResult| {
        vec![
            Cell::moment((fault.time_s - from_s).max(0.0)),
            Cell::text(fault.kind.clone()),
            Cell::text(words(&fault.target)),
            Cell::text(fault.figures.clone()),
            Cell::Number(fault.until_s.map_or_else(
                || "–".to_owned(),
                |until_s| format!("{} s", number((until_s - from_s).max(0.0), 2)),
            )),
            Cell::Number(
                fault
                    .recovery_ms
                    .map_or_else(|| "–".to_owned(), |ms| format!("{ms:.0} ms")),
            ),
            Cell::text(fault.why.clone().unwrap_or_default()),
        ]
    };
    let rows: Vec<Vec<Cell>> = faults.iter().map(row).collect();
    let heads = [
        "time",
        "fault",
        "target",
        "figures",
        "#until",
        "#answered again after",
        "not made because",
    ];
    titled("Faults", &table(&heads, &rows))
}

/// Swaps and comparisons.
pub(super) fn swaps(swaps: &[SwapResult], events: &[Event]) -> String {
    let row = |swap: &SwapResult| {
        let comparison = &swap.comparison;
        let times = [&comparison.office, &comparison.newcomer];
        let times = times.map(|times| format!("{} / {}", time(times.p50_us), time(times.p99_us)));
        let [incumbent, newcomer] = times;
        vec![
            Cell::text(words(&swap.role)),
            Cell::text(swap.binary.clone()),
            Cell::text(words(&swap.state)),
            Cell::count(comparison.ticks),
            Cell::number(comparison.agree, 3),
            Cell::Number(incumbent),
            Cell::Number(newcomer),
            Cell::count(swap.command_gap_ticks),
            Cell::text(swap.why.clone().unwrap_or_default()),
        ]
    };
    let rows: Vec<Vec<Cell>> = swaps.iter().map(row).collect();
    let heads = [
        "seat",
        "newcomer",
        "state",
        "#ticks compared",
        "#agree",
        "#before, p50 / p99",
        "#newcomer, p50 / p99",
        "#longest command gap [ticks]",
        "why",
    ];
    let mut html = titled("Swaps", &table(&heads, &rows));
    let moments: Vec<Vec<Cell>> = events
        .iter()
        .filter(|event| event.kind == "swap")
        .map(|event| vec![Cell::moment(event.time_s), Cell::text(event.text.clone())])
        .collect();
    html.push_str(&table(&["time", "what"], &moments));
    html
}

fn titled(title: &str, table: &str) -> String {
    if table.is_empty() {
        return String::new();
    }
    format!("<h3>{title}</h3>\n{table}")
}
