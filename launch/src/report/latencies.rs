//! The part of a report about times: distributions, hops, the slowest answers.

use super::charts;
use super::html::{Cell, note, table, time, words};
use core::fmt::Write;
use zeronav_measure::result::latency::{Figures, Hop, Latency};
use zeronav_measure::timings::{Slow, Timings};

/// Most of the slowest answers that are shown of each kind.
const SLOWEST: usize = 10;

/// Fewest samples that are drawn as a histogram.
const SAMPLES_MIN: u64 = 5;

/// Distributions of reaction and replanning, and their figures.
pub(super) fn distributions(latency: Option<&Latency>, timings: &Timings) -> String {
    let mut charts = String::new();
    let named = [
        ("reaction", &timings.reaction),
        ("replanning", &timings.replanning),
    ];
    for (name, spread) in named {
        if let Some(spread) = spread
            && spread.figures.n >= SAMPLES_MIN
        {
            charts.push_str(&charts::histogram(name, spread));
        }
    }
    let mut html = String::new();
    if !charts.is_empty() {
        html = format!("<div class=\"charts\">{charts}</div>\n");
    }
    let Some(latency) = latency else {
        return html;
    };
    let mut rows = vec![
        figures_row(
            "reaction",
            "scan captured to the first command that took it into account",
            &latency.reaction,
        ),
        figures_row(
            "replanning",
            "scan captured to the first command along the new path",
            &latency.replanning,
        ),
        figures_row(
            "event to motion",
            "obstacle appears to the wheels",
            &latency.event_to_motion,
        ),
    ];
    if let Some(floor) = &latency.transport_floor {
        rows.push(figures_row(
            "transport floor",
            "the same way through processes that do nothing",
            floor,
        ));
    }
    if let Some(clock) = &latency.second_clock {
        rows.push(figures_row(
            "second clock",
            "scan captured to the wheels, by the robot's own second clock",
            &clock.end_to_end,
        ));
        rows.push(figures_row("of it not in the hops", "", &clock.difference));
    }
    html.push_str(&table(
        &[
            "",
            "from … to",
            "#n",
            "#unanswered",
            "#p50",
            "#p90",
            "#p99",
            "#max",
        ],
        &rows,
    ));
    let disorder: u64 = latency.hops_out_of_order.values().sum();
    html.push_str(&note(&format!(
        "{} commands followed back to their scan: {} records missing, {disorder} stamps before their \
         predecessor. A dash stands where there are too few samples for the percentile.",
        latency.ways, latency.ways_broken
    )));
    html
}

fn figures_row(name: &str, what: &str, figures: &Figures) -> Vec<Cell> {
    let figures = figures.supported();
    let mut row = vec![
        Cell::text(name),
        Cell::text(what),
        Cell::count(figures.n),
        Cell::count(figures.censored),
    ];
    let times = [
        figures.p50_us,
        figures.p90_us,
        figures.p99_us,
        figures.max_us,
    ];
    row.extend(times.map(|us| Cell::Number(time(us))));
    row
}

/// Hop by hop: bars of the median on those of the 99th percentile.
pub(super) fn hops(latency: &Latency) -> String {
    let mut html = String::new();
    for (title, hops) in [
        (
            "Through the map, every scan",
            &latency.every_scan.through_map,
        ),
        ("Direct, every scan", &latency.every_scan.direct),
        ("Of the replannings", &latency.hops),
    ] {
        if hops.iter().all(|hop| hop.figures.n == 0) {
            continue;
        }
        let _ = write!(html, "<h3>{title}</h3>\n{}", hop_table(hops));
    }
    if html.is_empty() {
        return html;
    }
    charts::hop_legend()
        + &note("Dark: median. Light: 99th percentile, or the worst of fewer than 100.")
        + &html
}

fn hop_table(hops: &[Hop]) -> String {
    let far_us = |hop: &Hop| {
        let figures = hop.figures.supported();
        figures.p99_us.or(figures.max_us).unwrap_or(0.0)
    };
    // The wait for the next control tick would flatten all others.
    let shown = hops.iter().filter(|hop| hop.name != "to_robot");
    let whole_us = shown.map(far_us).fold(0.0, f64::max);
    let row = |hop: &Hop| {
        let figures = hop.figures.supported();
        let mut row = vec![
            Cell::text(words(&hop.title())),
            Cell::Html(charts::hop_bar(&hop.name, &figures, whole_us)),
            Cell::count(figures.n),
        ];
        let times = [
            figures.p50_us,
            figures.p90_us,
            figures.p99_us,
            figures.max_us,
        ];
        row.extend(times.map(|us| Cell::Number(time(us))));
        row
    };
    let rows: Vec<Vec<Cell>> = hops.iter().take(32).map(row).collect();
    table(&["hop", "", "#n", "#p50", "#p90", "#p99", "#max"], &rows)
}

/// How long each service computed for an answer.
pub(super) fn computing(timings: &Timings) -> String {
    let charts: String = timings
        .computing
        .iter()
        .take(8)
        .map(|(seat, spread)| charts::histogram(&words(seat), spread))
        .collect();
    if charts.is_empty() {
        return charts;
    }
    format!("<div class=\"charts small\">{charts}</div>\n")
        + &note("From the inputs taken in to the message sent, every answer.")
}

/// The slowest answers as waterfalls.
pub(super) fn slowest(timings: &Timings) -> String {
    let mut html = String::new();
    for (title, all) in [
        ("Slowest reactions", &timings.slowest_reactions),
        ("Slowest replannings", &timings.slowest_replannings),
    ] {
        let whole_us = all.iter().map(|slow| slow.total_us).fold(0.0, f64::max);
        let row = |slow: &Slow| {
            let longest = slow.hops.iter().max_by(|a, b| a.1.total_cmp(&b.1));
            let longest = longest.map_or_else(String::new, |(name, us)| {
                let within = slow.stages.iter().filter(|stage| stage.hop == *name);
                let most = within.max_by(|a, b| a.time_us.total_cmp(&b.time_us));
                let most = most.map_or_else(String::new, |stage| {
                    format!(" ({} {})", stage.name, time(stage.time_us))
                });
                format!("{} {}{most}", words(name), time(*us))
            });
            let when = match slow.round {
                // The player shows the last round only.
                Some(round) => Cell::text(format!("round {round}, {:.2} s", slow.time_s)),
                None => Cell::moment(slow.time_s),
            };
            vec![
                when,
                Cell::Html(charts::waterfall(slow, whole_us)),
                Cell::Number(time(slow.total_us)),
                Cell::text(longest),
            ]
        };
        let rows: Vec<Vec<Cell>> = all.iter().take(SLOWEST).map(row).collect();
        if !rows.is_empty() {
            let _ = writeln!(html, "<h3>{title}</h3>");
            html.push_str(&table(
                &["scan at", "hops, stages below", "#total", "longest hop"],
                &rows,
            ));
        }
    }
    if html.is_empty() {
        return html;
    }
    charts::hop_legend() + &html
}
