//! Reaction: from the capture of a scan to the first command whose author checked that scan's points.
//!
//! A mean over the scans that were answered looks good exactly when the stack stalls: the scans that
//! came meanwhile are overtaken and never counted (coordinated omission). [`Reactions`] has three
//! answers side by side: the scans that an author really read, every scan that was captured, and
//! every scan that the lidar should have captured by its period.

use super::index::Records;
use super::joins::Joins;
use super::series::Series;
use zeronav_msgs::span::Span;

/// The times of one scan and of the command that answered it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Times {
    /// Since the capture of the scan before; 0 for the first. [ns]
    gap_ns: u64,
    /// From the capture to the command; `None` = no answer before the deadline. [ns]
    pub time_ns: Option<u64>,
    /// True when the command's author read this very scan, and no later one.
    is_own: bool,
}

/// A scan that came while a path was followed, and what was made of it.
#[derive(Debug, Clone, Copy)]
pub struct Reaction<'a> {
    /// The robot's record of the scan.
    pub scan: &'a Span,
    /// Records of the first request whose author checked its points, and of the command made of that;
    /// `None` when there was none before the deadline.
    pub answer: Option<(&'a Span, &'a Span)>,
    /// Its times.
    pub times: Times,
}

/// Reaction times of a run or a round.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Reactions {
    /// Of every scan that was captured while a path was followed.
    pub all: Series,
    /// Of the scans that an author read: those overtaken by a newer one are left out.
    pub answered: Series,
    /// Of every scan that should have been captured: where the lidar was late, the scans that its
    /// period asks for count as answered together with the next one.
    pub intended: Series,
}

impl Reactions {
    /// Reaction times of all scans that came while a path was followed. One that was not answered
    /// within `deadline_ns` is censored; one after which the records go on for less than that says
    /// nothing, unless it was answered. The lidar turns once in `period_ns`.
    #[must_use]
    pub fn of(records: &Records, deadline_ns: u64, period_ns: u64) -> Self {
        let each = times(records, deadline_ns);
        let answered = each.iter().filter(|reaction| reaction.is_own);
        Self {
            all: each.iter().map(|reaction| reaction.time_ns).collect(),
            answered: answered.map(|reaction| reaction.time_ns).collect(),
            intended: intended(&each, deadline_ns, period_ns),
        }
    }
}

/// Reaction times of all scans in the order of their capture; see `Reactions::of`.
#[must_use]
pub fn reactions(records: &Records, deadline_ns: u64) -> Series {
    let each = times(records, deadline_ns);
    each.iter().map(|reaction| reaction.time_ns).collect()
}

fn times(records: &Records, deadline_ns: u64) -> Vec<Times> {
    let joins = Joins::of(records);
    let each = reactions_of(&joins, records, deadline_ns);
    each.iter().map(|reaction| reaction.times).collect()
}

/// The same, scan by scan with its records.
#[must_use]
pub fn reactions_of<'a>(
    joins: &Joins<'a>,
    records: &Records,
    deadline_ns: u64,
) -> Vec<Reaction<'a>> {
    let mut each = Vec::new();
    // One that looked at no scan at all answers none.
    let requests: Vec<_> = joins
        .requests()
        .iter()
        .filter(|request| request.scan != 0)
        .collect();
    let commands = joins.commands();
    let driving = joins.requests().iter().filter(|request| request.path != 0);
    let Some(driving_ns) = driving.map(|request| request.started_ns).min() else {
        return each;
    };
    let recorded_ns = records.spans.iter().map(|span| span.started_ns).max();
    let mut scans: Vec<_> = joins.scans().collect();
    scans.sort_by_key(|scan| scan.capture_ns);
    let mut before_ns = None;
    for scan in scans {
        let from_ns = before_ns.replace(scan.capture_ns);
        let gap_ns = from_ns.map_or(0, |from_ns| scan.capture_ns - from_ns);
        if scan.capture_ns < driving_ns {
            continue;
        }
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
        let time_ns =
            answer.map(|(_, command)| command.published_ns.saturating_sub(scan.capture_ns));
        let recorded_ns = recorded_ns.unwrap_or(0).saturating_sub(scan.capture_ns);
        let times = |time_ns| Times {
            gap_ns,
            time_ns,
            is_own: request.is_some_and(|request| request.scan == scan.scan),
        };
        let (answer, times) = match time_ns {
            Some(time_ns) if time_ns <= deadline_ns => (answer, times(Some(time_ns))),
            None if recorded_ns <= deadline_ns => continue,
            _ => (None, times(None)),
        };
        each.push(Reaction {
            scan,
            answer,
            times,
        });
    }
    each
}

/// The reactions of `each`, with those of the scans that are missing in between. After a gap longer
/// than the deadline the lidar was off, which is no stall.
fn intended(each: &[Times], deadline_ns: u64, period_ns: u64) -> Series {
    let mut series = Series::default();
    for reaction in each {
        if period_ns > 0 && reaction.gap_ns <= deadline_ns {
            let missing = ((reaction.gap_ns + period_ns / 2) / period_ns).saturating_sub(1);
            for n in (1..=missing).rev() {
                let time_ns = reaction.time_ns.map(|time_ns| time_ns + n * period_ns);
                match time_ns.filter(|time_ns| *time_ns <= deadline_ns) {
                    Some(time_ns) => series.add(time_ns),
                    None => series.censor(),
                }
            }
        }
        match reaction.time_ns {
            Some(time_ns) => series.add(time_ns),
            None => series.censor(),
        }
    }
    series
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn reaction(gap_ms: u64, time_ms: Option<u64>) -> Times {
        Times {
            gap_ns: gap_ms * MS,
            time_ns: time_ms.map(|time_ms| time_ms * MS),
            is_own: true,
        }
    }

    #[test]
    fn scans_that_a_stall_kept_from_being_captured_count_from_when_they_were_due() {
        let each = [
            reaction(0, Some(1)),
            // Three more were due before it; its command answers them, too.
            reaction(400, Some(5)),
            reaction(100, Some(1)),
        ];
        let expected: Series = [1, 305, 205, 105, 5, 1]
            .into_iter()
            .map(|time_ms| Some(time_ms * MS))
            .collect();
        assert_eq!(intended(&each, 5000 * MS, 100 * MS), expected);
    }

    #[test]
    fn a_steady_lidar_has_nothing_to_correct_and_one_that_was_off_no_stall() {
        let steady = [
            reaction(0, Some(1)),
            reaction(104, Some(1)),
            reaction(93, None),
        ];
        assert_eq!(intended(&steady, 5000 * MS, 100 * MS).len(), 3);
        let off = [reaction(0, Some(1)), reaction(9000, Some(1))];
        assert_eq!(intended(&off, 5000 * MS, 100 * MS).len(), 2);
        // Beyond the deadline it was not answered.
        let late = [reaction(0, Some(1)), reaction(400, Some(5))];
        let late = intended(&late, 401 * MS, 100 * MS).figures(401 * MS);
        assert_eq!((late.n, late.censored), (5, 0));
        let later = [reaction(0, Some(1)), reaction(400, Some(150))];
        let later = intended(&later, 401 * MS, 100 * MS).figures(401 * MS);
        assert_eq!((later.n, later.censored), (5, 1));
    }
}
