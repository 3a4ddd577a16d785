//! Reaction: from the capture of a scan to the first command whose author checked that scan's points.

use super::distribution::Distribution;
use super::index::Records;
use super::joins::Joins;
use zeronav_msgs::span::Span;

/// A scan that came while a path was followed, and what was made of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reaction<'a> {
    /// The robot's record of the scan.
    pub scan: &'a Span,
    /// Records of the first request whose author checked its points, and of the command made of that;
    /// `None` when there was none before the deadline.
    pub answer: Option<(&'a Span, &'a Span)>,
}

impl Reaction<'_> {
    /// From the capture to the command. [ns]
    pub(crate) fn time_ns(&self) -> Option<u64> {
        let (_, command) = self.answer?;
        Some(command.published_ns.saturating_sub(self.scan.capture_ns))
    }
}

/// Reaction times of all scans that came while a path was followed. One that was not answered
/// within `deadline_ns` is censored; one after which the records go on for less than that says
/// nothing, unless it was answered.
#[must_use]
pub fn reactions(records: &Records, deadline_ns: u64) -> Distribution {
    let joins = Joins::of(records);
    let mut distribution = Distribution::new();
    for reaction in reactions_of(&joins, records, deadline_ns) {
        match reaction.time_ns() {
            Some(time_ns) => distribution.add(time_ns),
            None => distribution.censor(deadline_ns),
        }
    }
    distribution
}

/// The same, scan by scan, in no order.
pub(crate) fn reactions_of<'a>(
    joins: &Joins<'a>,
    records: &Records,
    deadline_ns: u64,
) -> Vec<Reaction<'a>> {
    // One that looked at no scan at all answers none.
    let requests: Vec<_> = joins
        .requests()
        .iter()
        .filter(|request| request.scan != 0)
        .collect();
    let commands = joins.commands();
    let driving = joins.requests().iter().filter(|request| request.path != 0);
    let Some(driving_ns) = driving.map(|request| request.started_ns).min() else {
        return Vec::new();
    };
    let recorded_ns = records.spans.iter().map(|span| span.started_ns).max();
    let mut reactions = Vec::new();
    for scan in joins.scans().filter(|scan| scan.capture_ns >= driving_ns) {
        // Scans and requests both grow, so the first that checked it is found by bisection.
        let at = requests.partition_point(|request| request.scan < scan.scan);
        let request = requests.get(at);
        if request.is_some_and(|request| request.path == 0) {
            continue;
        }
        let answer = request.and_then(|request| {
            let at = commands.partition_point(|command| command.request < request.output);
            Some((**request, *commands.get(at)?))
        });
        let reaction = Reaction { scan, answer };
        let recorded_ns = recorded_ns.unwrap_or(0).saturating_sub(scan.capture_ns);
        match reaction.time_ns() {
            Some(time_ns) if time_ns <= deadline_ns => reactions.push(reaction),
            None if recorded_ns <= deadline_ns => {}
            _ => reactions.push(Reaction { scan, answer: None }),
        }
    }
    reactions
}
