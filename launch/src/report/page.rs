//! The report of one run.

use super::events::{Event, events, list, marked};
use super::folder::{Outcome, RunFolder};
use super::html::{document, json_in_script, note, section};
use super::perfetto::{TraceSection, trace_section};
use super::{environment, latencies, services, summary};
use crate::picture;
use crate::show::recording::Recording;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;
use zeronav_measure::timings::Timings;
use zeronav_viewer::page::{PLAYER_JS, SCENE_JS};

/// Largest report. [bytes]
const BYTES_MAX: usize = 3_000_000;

/// Where the trace stands in what is below the player.
const TRACE_PLACE: &str = "<!--trace-->";

/// The drive in a player: markup and script.
const DRIVE: &str = include_str!("page/drive.html");
const DRIVE_JS: &str = include_str!("page/drive.js");

/// What a page is put together from.
pub(super) struct Parts<'a> {
    /// Its title.
    pub title: String,
    /// What stands above the player.
    pub before: String,
    /// What the player plays.
    pub recording: Option<&'a Recording>,
    /// What it marks.
    pub events: &'a [Event],
    /// What stands below it, with [`TRACE_PLACE`] where the trace belongs.
    pub after: String,
    /// The trace.
    pub trace: TraceSection,
}

/// The report as one HTML document of at most [`BYTES_MAX`].
pub(super) fn page(run: &RunFolder) -> String {
    let events = events(run);
    document_of(&Parts {
        title: format!("{}: report of a run", run.scenario()),
        before: summary::head(run),
        recording: run.recording.as_ref(),
        events: &events,
        after: below(run, &events),
        trace: trace_section(run),
    })
}

/// One HTML document of at most [`BYTES_MAX`].
pub(super) fn document_of(parts: &Parts<'_>) -> String {
    let recording = parts.recording;
    let scene = recording.and_then(|recording| player(recording, parts.events));
    let still = recording.map(still);
    let nothing = String::new();
    let (scene, still) = (scene.as_ref(), still.as_ref().unwrap_or(&nothing));
    let TraceSection {
        with_data: trace,
        without_data: linked,
    } = &parts.trace;
    let mut smallest = String::new();
    // What is left out first is the trace, which lies beside the page, then the picture for paper, then
    // the player.
    for (scene, still, trace, why) in [
        (scene, still, trace, ""),
        (scene, still, linked, ""),
        (scene, &nothing, linked, ""),
        (
            None,
            still,
            linked,
            "The recorded frames are too large for this page.",
        ),
        (
            None,
            &nothing,
            linked,
            "Picture and recorded frames are too large for this page.",
        ),
    ] {
        let mut body = parts.before.clone() + still;
        match scene {
            Some(scene) => body.push_str(scene),
            None if !why.is_empty() => body.push_str(&note(why)),
            None => body.push_str(&note(
                "No frames were kept of this run; it cannot be played.",
            )),
        }
        body.push_str(&parts.after.replacen(TRACE_PLACE, trace, 1));
        smallest = document(&parts.title, &body);
        if smallest.len() <= BYTES_MAX {
            return smallest;
        }
    }
    smallest
}

/// Everything below the player.
fn below(run: &RunFolder, events: &[Event]) -> String {
    let recording = run.recording.as_ref();
    let from_s = recording.map_or(0.0, |recording| recording.first_goal_s);
    let none = Timings::default();
    let timings = recording.map_or(&none, |recording| &recording.timings);
    let mut html = section("figures", "Run", &summary::figures(run));
    let (processes, companions, restarts, starved, faults, swaps) = match &run.outcome {
        Outcome::Run(result) => {
            let expectations = summary::expectations(&result.expectations);
            html.push_str(&section("expectations", "Expectations", &expectations));
            (
                &result.services,
                &result.companions,
                &result.restarts,
                &result.starved,
                &result.faults,
                &result.swaps,
            )
        }
        Outcome::Stay(result) => (
            &result.services,
            &result.companions,
            &result.restarts,
            &result.starved,
            &result.faults,
            &result.swaps,
        ),
    };
    html.push_str(&happened(events, recording));
    let latency = run.latency();
    let times = latencies::distributions(latency, timings);
    html.push_str(&section("latency", "Latency", &times));
    let hops = latency.map_or_else(String::new, latencies::hops);
    html.push_str(&section("hops", "Hops", &hops));
    html.push_str(&section(
        "slowest",
        "Slowest answers, hop by hop",
        &latencies::slowest(timings),
    ));
    html.push_str(TRACE_PLACE);
    html.push_str(&section(
        "computing",
        "Computing",
        &latencies::computing(timings),
    ));
    let table = services::services(processes, Some(timings)) + &services::companions(companions);
    html.push_str(&section("services", "Services", &table));
    let done_to_them = services::restarts(restarts, from_s)
        + &services::starved(starved, from_s)
        + &services::faults(faults, from_s)
        + &services::swaps(swaps, events);
    html.push_str(&section(
        "faults",
        "Restarts, faults and swaps",
        &done_to_them,
    ));
    html.push_str(&section(
        "environment",
        "Environment",
        &environment::environment(run),
    ));
    html
}

/// The events.
pub(super) fn happened(events: &[Event], recording: Option<&Recording>) -> String {
    let left_out = recording.map_or(0, |recording| recording.interventions_left_out);
    let mut happened = list(events);
    if left_out > 0 {
        happened.push_str(&note(&format!(
            "{left_out} more interventions of the guard were not kept."
        )));
    }
    section("events", "Events", &happened)
}

/// The picture for paper and for browsers without scripts.
fn still(recording: &Recording) -> String {
    let svg = picture::still(recording);
    format!(
        "<img class=\"still\" alt=\"the drive as a picture\" src=\"data:image/svg+xml;base64,{}\">\n",
        STANDARD.encode(svg)
    )
}

/// The player with its frames; `None` when there are none.
fn player(recording: &Recording, events: &[Event]) -> Option<String> {
    let scene = recording.scene.as_ref()?;
    let rates = recording.rates;
    let data = json!({
        "scene": scene,
        "end_s": recording.time_s,
        "events": marked(events),
    });
    let about = if rates.thinned {
        format!(
            "Poses every {:.1} s, scans every {:.1} s, the map every {:.1} s: less often than at first, \
             because the drive was long.",
            rates.pose_s, rates.scan_s, rates.map_s
        )
    } else {
        format!(
            "Poses every {:.1} s, scans every {:.1} s, the map every {:.1} s.",
            rates.pose_s, rates.scan_s, rates.map_s
        )
    };
    Some(format!(
        "{}\n<script type=\"application/json\" id=\"data\">{}</script>\n\
         <script>\n{SCENE_JS}</script>\n<script>\n{PLAYER_JS}</script>\n\
         <script>\n{DRIVE_JS}</script>\n",
        DRIVE.replace("<!--about-->", &note(&about)),
        json_in_script(&data.to_string())
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Cut;
    use crate::film::tests::busy_drive;
    use crate::report::perfetto::PERFETTO_JS;
    use core::fmt::Write;
    use std::path::PathBuf;
    use zeronav_measure::result::{PlannedPath, RunResult};
    use zeronav_msgs::message::{FNV_OFFSET, fnv1a};

    fn result() -> RunResult {
        let text = include_str!("../../measure/tests/data/result_lockstep.json");
        serde_json::from_str(text).expect("a result")
    }

    fn folder(result: RunResult, recording: Option<Recording>) -> RunFolder {
        RunFolder {
            path: PathBuf::from("nowhere"),
            outcome: Outcome::Run(Box::new(result)),
            recording,
        }
    }

    #[test]
    fn the_report_of_an_hour_keeps_its_budget() {
        let film = busy_drive(3600);
        let cut = Cut {
            scenario: "busy",
            mode: "real_time",
            from_ns: 0,
            until_ns: 3_600_000_000_000,
        };
        let (kept, left_out) = film.interventions();
        let interventions = kept
            .iter()
            .map(|(at, why)| (zeronav_msgs::time::seconds(*at), why.to_string()));
        let recording = Recording {
            time_s: 3600.0,
            interventions: interventions.collect(),
            interventions_left_out: left_out,
            rates: film.rates(),
            area_m: [[0.0, 0.0], [50.0, 50.0]],
            scene: serde_json::to_value(film.scene(&cut)).ok(),
            ..Recording::default()
        };
        let mut result = result();
        let plan = PlannedPath {
            status: "<".repeat(1000),
            ..result.plans[0].clone()
        };
        result.plans = vec![plan; 20_000];
        let page = page(&folder(result, Some(recording)));
        assert!(page.len() <= BYTES_MAX, "{} bytes", page.len());
        assert!(page.contains("id=\"data\"") && page.contains("class=\"still\""));
        assert!(page.contains("because the drive was long"));
        assert!(page.contains("more interventions of the guard were not kept"));
    }

    #[test]
    fn frames_that_are_too_large_are_left_out() {
        let recording = Recording {
            area_m: [[0.0, 0.0], [5.0, 5.0]],
            scene: Some("x".repeat(BYTES_MAX).into()),
            ..Recording::default()
        };
        let page = page(&folder(result(), Some(recording)));
        assert!(page.len() < 1_000_000, "{} bytes", page.len());
        assert!(page.contains("too large for this page") && page.contains("class=\"still\""));
    }

    #[test]
    fn scripts_of_the_page_do_not_end_early() {
        for script in [SCENE_JS, PLAYER_JS, DRIVE_JS, PERFETTO_JS] {
            assert!(!script.contains("</script") && !script.contains("<!--"));
        }
    }

    #[test]
    fn a_trace_lies_in_the_page_where_there_is_room() {
        let place = tempfile::tempdir().expect("a folder");
        let run = RunFolder {
            path: place.path().to_owned(),
            ..folder(result(), None)
        };
        let made = |trace: &str| {
            std::fs::write(place.path().join("trace.json"), trace).expect("written");
            page(&run)
        };
        assert!(!page(&run).contains("perfetto"), "no trace, no button");
        let small = made("{\"traceEvents\":[]}");
        assert!(small.contains("id=\"trace-data\"") && !small.contains("id=\"trace-file\""));
        // What cannot be compressed to less than half.
        let mut noise = String::new();
        for n in 0..400_000_u32 {
            let _ = write!(noise, "{:016x}", fnv1a(FNV_OFFSET, &n.to_le_bytes()));
        }
        let large = made(&noise);
        assert!(large.len() < BYTES_MAX, "{} bytes", large.len());
        assert!(!large.contains("id=\"trace-data\"") && large.contains("id=\"trace-file\""));
        for page in [small, large] {
            let button = page.find("id=\"perfetto\"").expect("a button");
            let environment = page.find("<h2>Environment").expect("a section");
            assert!(button < environment && !page.contains(TRACE_PLACE));
        }
    }
}
