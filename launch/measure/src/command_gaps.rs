//! Velocity commands that came late, and which hop made them late.
//!
//! The time from one command to the next is the time between the odometry messages behind them, plus
//! by how much each hop took longer than the same hop of the command before: the terms add up to the
//! gap. The largest one is the cause.

use super::distribution::to_us;
use super::index::Records;
use super::joins::Joins;
use crate::result::profile::CommandGaps;
use std::collections::BTreeMap;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::Span;
use zeronav_observe::hop_chain::{self, DIRECT};

/// The hops behind a command, from the robot's odometry on.
const HOPS: [&str; 5] = {
    let [robot, to_local, local, to_guard, guard, _] = DIRECT;
    [
        hop_chain::HOPS[robot],
        hop_chain::HOPS[to_local],
        hop_chain::HOPS[local],
        hop_chain::HOPS[to_guard],
        hop_chain::HOPS[guard],
    ]
};

/// The times between commands while a path was followed; one per `period_ns` is due. A gap longer
/// than the deadline is a pause, and no late command.
#[must_use]
pub(crate) fn command_gaps(records: &Records, period_ns: u64, deadline_ns: u64) -> CommandGaps {
    let joins = Joins::of(records);
    let mut gaps = CommandGaps {
        period_us: to_us(period_ns),
        ..CommandGaps::default()
    };
    let following = joins.requests().iter().filter(|request| request.path != 0);
    let Some((from, to)) = ends(following.map(|request| request.published_ns)) else {
        return gaps;
    };
    let commands: Vec<&Span> = joins
        .commands()
        .iter()
        .filter(|command| (from..=to).contains(&command.published_ns))
        .copied()
        .collect();
    gaps.n = commands.len() as u64;
    for pair in commands.windows(2) {
        let gap_ns = pair[1].published_ns.saturating_sub(pair[0].published_ns);
        if gap_ns > deadline_ns {
            continue;
        }
        gaps.gap_us_max = gaps.gap_us_max.max(to_us(gap_ns));
        if 2 * gap_ns > 3 * period_ns {
            gaps.missed += 1;
            let cause = cause(&joins, pair[0], pair[1], period_ns);
            *gaps.missed_by_cause.entry(cause).or_default() += 1;
        }
    }
    gaps
}

fn ends(times_ns: impl Iterator<Item = u64>) -> Option<(u64, u64)> {
    times_ns.fold(None, |ends, time_ns| {
        let (from, to) = ends.unwrap_or((time_ns, time_ns));
        Some((from.min(time_ns), to.max(time_ns)))
    })
}

/// The moments behind a command, and what its processes were off the processor.
fn moments<'a>(joins: &Joins<'a>, command: &'a Span) -> Option<([u64; 5], [&'a Span; 3])> {
    let local = joins.output(Role::LocalPlanner, command.request)?;
    let robot = joins.output(Role::Robot, local.odometry)?;
    let moments = [
        robot.published_ns,
        local.started_ns,
        local.published_ns,
        command.started_ns,
        command.published_ns,
    ];
    Some((moments, [robot, local, command]))
}

/// Why `late` came so long after `before`.
fn cause(joins: &Joins<'_>, before: &Span, late: &Span, period_ns: u64) -> String {
    if before.epoch != late.epoch {
        return "collision_guard, restarted".to_owned();
    }
    if before.request == late.request {
        return "local_planner, no request".to_owned();
    }
    let both = moments(joins, before).zip(moments(joins, late));
    let Some(((before, _), (late, spans))) = both else {
        return "unknown: a record is missing".to_owned();
    };
    let length = |moments: &[u64; 5], hop: usize| moments[hop].abs_diff(moments[hop - 1]);
    let mut excess_ns = [0; HOPS.len()];
    excess_ns[0] = late[0].saturating_sub(before[0]).saturating_sub(period_ns);
    for (hop, excess_ns) in excess_ns.iter_mut().enumerate().skip(1) {
        *excess_ns = length(&late, hop).saturating_sub(length(&before, hop));
    }
    let worst = (0..HOPS.len()).max_by_key(|hop| excess_ns[*hop]);
    let worst = worst.unwrap_or_default();
    // Transport and waking have no record of their own; work has.
    let worker = spans.get(worst / 2).filter(|_| worst % 2 == 0);
    let was_off = worker.is_some_and(|span| 2 * span.off_processor_ns >= excess_ns[worst]);
    let off = if was_off { ", off the processor" } else { "" };
    format!("{}{off}", HOPS[worst])
}

/// Several rounds as one.
#[must_use]
pub(crate) fn of_rounds<'a>(rounds: impl Iterator<Item = &'a CommandGaps>) -> CommandGaps {
    let mut all = CommandGaps::default();
    let mut by_cause: BTreeMap<String, u64> = BTreeMap::new();
    for round in rounds {
        all.period_us = round.period_us;
        all.n += round.n;
        all.gap_us_max = all.gap_us_max.max(round.gap_us_max);
        all.missed += round.missed;
        for (cause, n) in &round.missed_by_cause {
            *by_cause.entry(cause.clone()).or_default() += n;
        }
    }
    all.missed_by_cause = by_cause;
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::span::SpanKind;

    const MS: u64 = 1_000_000;
    const PERIOD_NS: u64 = 20 * MS;

    /// One cycle: robot, local planner and guard, each 1 ms of work and 1 ms on the way; `late_ns` is
    /// added to the hop `hop`.
    fn cycle(records: &mut Records, n: u64, hop: usize, late_ns: u64, off_ns: u64) {
        let mut at_ns = n * PERIOD_NS;
        let mut next = |is: usize| {
            at_ns += MS + if is == hop { late_ns } else { 0 };
            at_ns
        };
        let moments = [next(0), next(1), next(2), next(3), next(4)];
        let span = |role: Role, started_ns, published_ns| Span {
            role: role.code(),
            kind: SpanKind::Answer.code(),
            epoch: 1,
            output: n,
            odometry: n,
            request: n,
            path: 1,
            started_ns,
            published_ns,
            off_processor_ns: off_ns,
            ..Span::default()
        };
        records.spans.extend([
            span(Role::Robot, n * PERIOD_NS, moments[0]),
            span(Role::LocalPlanner, moments[1], moments[2]),
            span(Role::CollisionGuard, moments[3], moments[4]),
        ]);
    }

    fn drive(hop: usize, late_ns: u64, off_ns: u64) -> CommandGaps {
        let mut records = Records::default();
        for n in 1..=10 {
            let is_late = n == 5;
            let late_ns = if is_late { late_ns } else { 0 };
            cycle(
                &mut records,
                n,
                hop,
                late_ns,
                if is_late { off_ns } else { 0 },
            );
        }
        command_gaps(&records, PERIOD_NS, 5000 * MS)
    }

    #[test]
    fn a_late_command_names_the_hop_that_made_it_late() {
        for (hop, name) in HOPS.iter().enumerate() {
            let gaps = drive(hop, 12 * MS, 0);
            // The last one came after the last request.
            assert_eq!((gaps.n, gaps.missed), (9, 1), "{name}");
            assert_eq!(gaps.missed_by_cause.keys().collect::<Vec<_>>(), [name]);
            assert!((gaps.gap_us_max - 32_000.0).abs() < 1.0, "{gaps:?}");
        }
        let gaps = drive(2, 12 * MS, 10 * MS);
        assert_eq!(gaps.missed_by_cause["local_planner, off the processor"], 1);
        // Nothing that transport took is a matter of the process that was woken.
        let gaps = drive(1, 12 * MS, 10 * MS);
        assert_eq!(gaps.missed_by_cause["to_local_planner"], 1);
    }

    #[test]
    fn half_a_period_is_tolerated_and_without_a_path_nothing_is_due() {
        assert_eq!(drive(2, 9 * MS, 0).missed, 0);
        let mut records = Records::default();
        for n in 1..=3 {
            cycle(&mut records, n, 0, 0, 0);
        }
        for span in &mut records.spans {
            span.path = 0;
        }
        assert_eq!(command_gaps(&records, PERIOD_NS, 5000 * MS).n, 0);
    }
}
