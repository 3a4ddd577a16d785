//! The page of a run that is read from the recording of its messages: what a report has, as far as messages say it.

use super::events::of_messages;
use super::html::{Cell, number, pairs, section, table, text_of, words};
use super::latencies;
use super::page::{Parts, document_of, happened};
use super::perfetto::TraceSection;
use crate::show::recording::Recording;
use crate::why;
use zeronav_measure::result::moment::Moment;
use zeronav_measure::result::{PlannedPath, Touch};

/// What a recording of messages says besides what is played.
#[derive(Debug, Default)]
pub(crate) struct OfMessages {
    /// What is played.
    pub recording: Recording,
    /// Every path, and every reason why there was none.
    pub plans: Vec<PlannedPath>,
    /// Contacts.
    pub touches: Vec<Touch>,
    /// Why the robot did what it did.
    pub reasons: Vec<Moment>,
    /// Smallest clearance; `None` when nothing was near, or nobody knows. [m]
    pub clearance_m_min: Option<f64>,
    /// True when a simulated world said where the robot was and what it touched.
    pub is_simulated: bool,
    /// Why it is not all of the run.
    pub incomplete: Option<String>,
    /// About the file.
    pub about: Vec<(&'static str, String)>,
}

/// The page.
pub(crate) fn page(of: &OfMessages) -> String {
    let recording = &of.recording;
    let events = of_messages(&of.plans, &of.touches, recording);
    let timings = &recording.timings;
    let after = [
        section("figures", "Run", &figures(of)),
        happened(&events, Some(recording)),
        section("why", "Why", &reasons(&of.reasons)),
        section(
            "latency",
            "Latency",
            &latencies::distributions(None, timings),
        ),
        section(
            "slowest",
            "Slowest answers, hop by hop",
            &latencies::slowest(timings),
        ),
        section("computing", "Computing", &latencies::computing(timings)),
        section("environment", "Recording", &pairs(&of.about)),
    ];
    document_of(&Parts {
        title: format!("{}: a recording", recording.scenario),
        before: head(of),
        recording: Some(recording),
        events: &events,
        after: after.concat(),
        trace: TraceSection::default(),
    })
}

/// Title and verdict.
fn head(of: &OfMessages) -> String {
    let Recording {
        scenario,
        title,
        outcome,
        ..
    } = &of.recording;
    let (class, whole) = match &of.incomplete {
        None => ("stay", "complete".to_owned()),
        Some(why) => ("fail", format!("NOT COMPLETE: {why}")),
    };
    format!(
        "<header><h1>{}</h1><p class=\"title\">{}</p><p class=\"verdict\"><b class=\"{class}\">{}</b> {}</p></header>\n",
        text_of(scenario),
        text_of(title),
        text_of(&words(outcome)),
        text_of(&whole)
    )
}

/// The key figures.
fn figures(of: &OfMessages) -> String {
    let recording = &of.recording;
    let mut all = vec![
        ("run time", format!("{:.1} s", recording.time_s)),
        ("distance", format!("{:.1} m", recording.driven_m)),
    ];
    if of.is_simulated {
        let closest = number(of.clearance_m_min, 2);
        all.push(("contacts", recording.contacts.to_string()));
        all.push(("closest", format!("{closest} m")));
    }
    let n = recording.interventions.len() as u64 + recording.interventions_left_out;
    all.extend([
        ("paths", recording.paths.len().to_string()),
        ("guard stepped in", n.to_string()),
    ]);
    if of.is_simulated {
        all.push(("mode", words(&recording.mode)));
        all.push(("seed", recording.seed.to_string()));
    }
    pairs(&all)
}

/// What the stages said, a row for each change.
fn reasons(moments: &[Moment]) -> String {
    let row = |moment: &Moment| {
        let said = why::in_words(moment);
        vec![Cell::moment(moment.time_s), Cell::text(said)]
    };
    let rows: Vec<Vec<Cell>> = moments.iter().map(row).collect();
    table(&["time", "why"], &rows)
}
