//! The result of a stack that stayed up, from what was seen of it, and as text.

use crate::drive::Driven;
use crate::judge;
use crate::prepare::Prepared;
use crate::show::page::{write_companions, write_troubles};
use crate::subject::Subject;
use core::fmt::Write;
use zeronav_measure::result::Environment;
use zeronav_measure::result::latency::{Figures, Latency};
use zeronav_measure::result::stay::StayResult;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::time::seconds;

/// What was seen of it.
pub(crate) fn of(prepared: &Prepared, driven: &Driven, environment: Environment) -> StayResult {
    let truth = driven.collector.truth.unwrap_or_default();
    StayResult {
        scenario: prepared.scenario.name.clone(),
        outcome: driven.ending.outcome().to_owned(),
        time_s: seconds(driven.end_run_ns.saturating_sub(driven.goals_run_ns)),
        wall_s: driven.wall.as_secs_f64(),
        goals: driven.redirects.clone(),
        contacts: truth.contacts_moving + truth.contacts_standing,
        restarts: driven.restarts.clone(),
        starved: driven.starved.clone(),
        faults: driven.faults.clone(),
        swaps: driven.swaps.clone(),
        latency: (prepared.mode == RunMode::RealTime).then(|| latency(prepared, driven)),
        services: driven.services.clone(),
        companions: driven.companions.clone(),
        link: driven.link.clone(),
        environment,
        directory: prepared.directory.display().to_string(),
    }
}

fn latency(prepared: &Prepared, driven: &Driven) -> Latency {
    let (_, mut latency) = judge::latency(&Subject::of(prepared, driven));
    judge::add_clocks(&mut latency, prepared, driven);
    latency
}

/// A few lines.
pub(crate) fn to_text(result: &StayResult) -> String {
    let reached = result.goals.iter().filter(|goal| goal.outcome == "reached");
    let mut text = format!(
        "{}: {} after {:.1} s of run time, {} of {} goals reached, {} contacts, {} restarts\n",
        result.scenario,
        result.outcome,
        result.time_s,
        reached.count(),
        result.goals.len(),
        result.contacts,
        result.restarts.len(),
    );
    if let Some(latency) = &result.latency {
        for (name, figures) in [
            ("reaction", &latency.reaction),
            ("replanning", &latency.replanning),
        ] {
            text.push_str(&latency_line(name, figures));
        }
    }
    write_troubles(
        (&result.restarts, &result.starved, &result.faults),
        &mut text,
    );
    write_companions(&result.companions, &mut text);
    if let Some(link) = &result.link {
        let _ = writeln!(text, "  link {link}");
    }
    let _ = writeln!(text, "  {}", result.directory);
    text
}

/// Median and 99th percentile, where there are samples enough for them.
fn latency_line(name: &str, figures: &Figures) -> String {
    let figures = figures.supported();
    let times: Vec<String> = [("p50", figures.p50_us), ("p99", figures.p99_us)]
        .into_iter()
        .filter_map(|(percentile, us)| Some(format!("{percentile} {:.2} ms", us? / 1.0e3)))
        .collect();
    if times.is_empty() {
        return String::new();
    }
    format!("  {name} {}, n {}\n", times.join(", "), figures.n)
}
