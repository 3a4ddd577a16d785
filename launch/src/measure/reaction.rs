//! Reaction: from the capture of a scan to the first command whose author checked that scan's points.

use super::distribution::Distribution;
use super::index::Records;
use super::joins::Joins;

/// Reaction times of all scans that came while a path was followed. One that was not answered
/// within `deadline_ns` is censored; one after which the records go on for less than that says
/// nothing, unless it was answered.
#[must_use]
pub fn reactions(records: &Records, deadline_ns: u64) -> Distribution {
    let joins = Joins::of(records);
    let mut distribution = Distribution::new();
    // One that looked at no scan at all answers none.
    let requests: Vec<_> = joins
        .requests()
        .iter()
        .filter(|request| request.scan != 0)
        .collect();
    let commands = joins.commands();
    let driving = joins.requests().iter().filter(|request| request.path != 0);
    let Some(driving_ns) = driving.map(|request| request.started_ns).min() else {
        return distribution;
    };
    let recorded_ns = records.spans.iter().map(|span| span.started_ns).max();
    for scan in joins.scans().filter(|scan| scan.capture_ns >= driving_ns) {
        // Scans and requests both grow, so the first that checked it is found by bisection.
        let at = requests.partition_point(|request| request.scan < scan.scan);
        let request = requests.get(at);
        if request.is_some_and(|request| request.path == 0) {
            continue;
        }
        let command = request.and_then(|request| {
            let at = commands.partition_point(|command| command.request < request.output);
            commands.get(at)
        });
        let time_ns = command.map(|command| command.published_ns.saturating_sub(scan.capture_ns));
        let recorded_ns = recorded_ns.unwrap_or(0).saturating_sub(scan.capture_ns);
        match time_ns {
            Some(time_ns) if time_ns <= deadline_ns => distribution.add(time_ns),
            None if recorded_ns <= deadline_ns => {}
            _ => distribution.censor(deadline_ns),
        }
    }
    distribution
}
