//! Several runs side by side; the first is the one that the others are compared with.

use super::environment::machine_line;
use super::folder::{Outcome, RunFolder};
use super::html::{document, note, section, text_of, words};
use super::paired::{Measure, Unit};
use crate::show::picture::{Line, Picture};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use core::fmt::Write;
use zeronav_casts::Cast;
use zeronav_measure::result::ServiceResult;
use zeronav_measure::timings::{Spread, Timings};

/// Colours of the tracks, the first run's first.
const COLOURS: [&str; 6] = [
    "#1f78b4", "#d95f02", "#1b9e3b", "#7570b3", "#e7298a", "#a6761d",
];

/// Largest picture of the tracks. [bytes]
const PICTURE_BYTES_MAX: usize = 1_000_000;

/// A row of the comparison: name, unit, and the measure of each run.
struct Row {
    name: String,
    unit: Unit,
    measures: Vec<Measure>,
}

/// The page.
///
/// # Errors
/// One line when there is nothing to compare.
pub(super) fn page(runs: &[RunFolder]) -> Result<String, String> {
    let Some(first) = runs.first().filter(|_| runs.len() > 1) else {
        return Err("name the folders of at least two runs".to_owned());
    };
    let mut body = format!(
        "<header><h1>{} runs compared</h1><p class=\"verdict\">Differences are to the first, {}.</p></header>\n",
        runs.len(),
        text_of(&first.name())
    );
    let alike = |of: fn(&RunFolder) -> String| runs.iter().all(|run| of(run) == of(first));
    if !alike(|run| run.scenario().to_owned()) {
        body.push_str(&note(
            "The runs are of different scenarios: their differences say little.",
        ));
    }
    if !alike(seed) {
        body.push_str(&note(
            "The seeds differ, so noise and random obstacles do, too.",
        ));
    }
    body.push_str(&section("runs", "Runs", &heads(runs)));
    body.push_str(&section("drive", "Drive", &rows(runs, &drive(runs))));
    let latencies = rows(runs, &latencies(runs));
    let about = note(
        "Medians and 99th percentiles with their intervals at 95 %, for which samples count as \
         independent. Where intervals overlap there is no difference. What differs from one run to \
         the next of the same kind is not in them: repeat before you believe a small one.",
    );
    if !latencies.is_empty() {
        body.push_str(&section(
            "latency",
            "Latency and computing",
            &(about + &latencies),
        ));
    }
    body.push_str(&section(
        "services",
        "Services",
        &rows(runs, &services(runs)),
    ));
    if let Some(tracks) = tracks(runs) {
        body.push_str(&section("tracks", "Tracks", &tracks));
    }
    let title = format!("{}: {} runs compared", first.scenario(), runs.len());
    Ok(document(&title, &body))
}

fn seed(run: &RunFolder) -> String {
    run.result()
        .map_or_else(String::new, |result| result.seed.to_string())
}

/// Names, verdicts and machines.
fn heads(runs: &[RunFolder]) -> String {
    let mut html = "<div class=\"scroll\"><table><thead><tr><th></th><th>run</th><th>scenario</th>\
                    <th>verdict</th><th>why</th><th>mode</th><th class=\"n\">seed</th><th>made with and on</th>\
                    </tr></thead><tbody>\n"
        .to_owned();
    for (at, run) in runs.iter().enumerate() {
        let (class, verdict, reason, mode) = match &run.outcome {
            Outcome::Run(result) => {
                let class = if result.verdict == "pass" {
                    "pass"
                } else {
                    "fail"
                };
                (class, &*result.verdict, &*result.reason, &*result.mode)
            }
            Outcome::Stay(result) => ("stay", &*result.outcome, "", ""),
        };
        let _ = writeln!(
            html,
            "<tr><td class=\"n\">{}</td><td>{}</td><td>{}</td><td><b class=\"{class}\">{}</b></td><td>{}</td>\
             <td>{}</td><td class=\"n\">{}</td><td>{}</td></tr>",
            at + 1,
            text_of(&run.name()),
            text_of(run.scenario()),
            text_of(verdict),
            text_of(reason),
            text_of(&words(mode)),
            text_of(&seed(run)),
            text_of(&machine_line(run)),
        );
    }
    html.push_str("</tbody></table></div>\n");
    html
}

/// Measures side by side. One that no run has is left out.
fn rows(runs: &[RunFolder], rows: &[Row]) -> String {
    let known = |row: &&Row| row.measures.iter().any(|measure| measure.value.is_some());
    let rows: Vec<&Row> = rows.iter().filter(known).collect();
    if rows.is_empty() {
        return String::new();
    }
    let mut html = "<div class=\"scroll\"><table class=\"paired\"><thead><tr><th></th>".to_owned();
    for at in 1..=runs.len() {
        let _ = write!(html, "<th class=\"n\">run {at}</th>");
    }
    html.push_str("</tr></thead><tbody>\n");
    for row in rows {
        let _ = write!(html, "<tr><td>{}</td>", text_of(&row.name));
        let first = row.measures.first().copied().unwrap_or_default();
        for (at, measure) in row.measures.iter().enumerate() {
            let _ = write!(html, "<td class=\"n\">{}", text_of(&measure.text(row.unit)));
            if at > 0 {
                let difference = first.to(measure).text(row.unit, first.value);
                let _ = write!(
                    html,
                    "<br><span class=\"difference\">{}</span>",
                    text_of(&difference)
                );
            }
            html.push_str("</td>");
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody></table></div>\n");
    html
}

fn row(runs: &[RunFolder], name: &str, unit: Unit, of: impl Fn(&RunFolder) -> Measure) -> Row {
    Row {
        name: name.to_owned(),
        unit,
        measures: runs.iter().map(of).collect(),
    }
}

fn count(n: usize) -> f64 {
    n.to_f64()
}

/// What the drives came to.
fn drive(runs: &[RunFolder]) -> Vec<Row> {
    let of_run = |name: &str, unit, of: fn(&zeronav_measure::result::RunResult) -> Option<f64>| {
        row(runs, name, unit, |run| {
            Measure::exact(run.result().and_then(of))
        })
    };
    vec![
        row(runs, "run time", Unit::Seconds, |run| {
            Measure::exact(match &run.outcome {
                Outcome::Run(result) => result.time_s,
                Outcome::Stay(result) => result.time_s,
            })
        }),
        of_run("distance", Unit::Metres, |result| Some(result.driven_m)),
        row(runs, "contacts", Unit::Count, |run| {
            Measure::exact(f64::from(match &run.outcome {
                Outcome::Run(result) => result.contacts,
                Outcome::Stay(result) => result.contacts,
            }))
        }),
        of_run("closest", Unit::Metres, |result| result.clearance_m_min),
        of_run("new paths", Unit::Count, |result| {
            Some(count(result.replans.len()))
        }),
        of_run("recoveries", Unit::Count, |result| {
            Some(f64::from(result.recoveries))
        }),
        of_run("guard stepped in", Unit::Count, |result| {
            Some(count(result.interventions))
        }),
        of_run("mean jerk", Unit::Jerk, |result| result.jerk_mps3),
        of_run("largest pose error", Unit::Metres, |result| {
            result.pose.as_ref().map(|pose| pose.error_m_max)
        }),
        of_run("run time slipped", Unit::Seconds, |result| {
            Some(result.slipped_ms / 1.0e3)
        }),
    ]
}

/// Median and 99th percentile of everything that was timed.
fn latencies(runs: &[RunFolder]) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut add = |name: &str, of: &dyn Fn(&Timings) -> Option<Spread>| {
        let spread = |run: &RunFolder| of(&run.recording.as_ref()?.timings);
        rows.push(row(runs, &format!("{name}, p50"), Unit::Time, |run| {
            spread(run).map_or_else(Measure::default, |spread| {
                let figures = spread.figures.supported();
                Measure::estimate(figures.p50_us, spread.p50_interval_us, figures.n)
            })
        }));
        rows.push(row(runs, &format!("{name}, p99"), Unit::Time, |run| {
            spread(run).map_or_else(Measure::default, |spread| {
                let figures = spread.figures.supported();
                Measure::estimate(figures.p99_us, spread.p99_interval_us, figures.n)
            })
        }));
    };
    add("reaction", &|timings| timings.reaction.clone());
    add("replanning", &|timings| timings.replanning.clone());
    for seat in seats(runs) {
        add(&format!("computing of {}", words(&seat)), &|timings| {
            let found = timings.computing.iter().find(|(name, _)| *name == seat);
            found.map(|(_, spread)| spread.clone())
        });
    }
    rows
}

/// Seats in the order of the first run that has them, a bounded number.
fn seats(runs: &[RunFolder]) -> Vec<String> {
    let mut seats: Vec<String> = Vec::new();
    for service in runs.iter().flat_map(services_of) {
        if !seats.contains(&service.name) && seats.len() < 16 {
            seats.push(service.name.clone());
        }
    }
    seats
}

fn services_of(run: &RunFolder) -> &[ServiceResult] {
    match &run.outcome {
        Outcome::Run(result) => &result.services,
        Outcome::Stay(result) => &result.services,
    }
}

/// Restarts and memory of each seat.
fn services(runs: &[RunFolder]) -> Vec<Row> {
    let mut rows = Vec::new();
    for seat in seats(runs) {
        let service = |run: &RunFolder| {
            let all = services_of(run).iter();
            all.clone().find(|service| service.name == seat).cloned()
        };
        rows.push(row(
            runs,
            &format!("restarts of {}", words(&seat)),
            Unit::Count,
            |run| {
                Measure::exact(
                    service(run).map(|service| f64::from(service.starts.saturating_sub(1))),
                )
            },
        ));
        rows.push(row(
            runs,
            &format!("peak memory of {}", words(&seat)),
            Unit::Bytes,
            |run| Measure::exact(service(run).map(|service| service.memory_peak_bytes.to_f64())),
        ));
    }
    rows
}

/// The driven tracks on the map of the first run, as far as the others drove on the same.
fn tracks(runs: &[RunFolder]) -> Option<String> {
    let first = runs.first()?.recording.as_ref()?;
    let mut lines = Vec::new();
    for (at, run) in runs.iter().enumerate() {
        let Some(recording) = &run.recording else {
            continue;
        };
        let corners = recording.area_m.as_flattened().iter();
        let mut corners = corners.zip(first.area_m.as_flattened());
        let is_same_map = corners.all(|(a, b)| (a - b).abs() < 1.0e-6);
        if is_same_map && lines.len() < 2 * COLOURS.len() {
            lines.push(Line {
                name: format!("run {}: {:.1} m", at + 1, recording.driven_m),
                colour: COLOURS[at % COLOURS.len()],
                dashed: at >= COLOURS.len(),
                points_m: recording
                    .robot
                    .iter()
                    .map(|pose| [pose[1], pose[2]])
                    .collect(),
            });
        }
    }
    let picture = Picture {
        title: String::new(),
        subtitle: String::new(),
        area_m: first.area_m,
        walls_m: first.walls_m.clone(),
        areas: Vec::new(),
        lines,
        start_m: first
            .robot
            .first()
            .map_or(first.area_m[0], |at| [at[1], at[2]]),
        goals_m: first.goals.iter().map(|goal| [goal[0], goal[1]]).collect(),
        robot_radius_m: 0.1,
    };
    let svg = picture.to_svg();
    (svg.len() <= PICTURE_BYTES_MAX).then(|| {
        format!(
            "<img class=\"tracks\" alt=\"the driven tracks\" src=\"data:image/svg+xml;base64,{}\">\n",
            STANDARD.encode(svg)
        )
    })
}
