//! What the scenario expects of a run, against what it gave.

use crate::drive::Driven;
use crate::prepare::Prepared;
use std::collections::BTreeMap;
use zeronav_measure::result::{Expectation, PlannedPath};
use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_scenario::{ExpectSpec, Outcome};

/// The expectations of the scenario. `replans` are the paths that replaced another, `by_reason` the
/// interventions of the collision guard by their reason.
pub(super) fn expectations(
    prepared: &Prepared,
    driven: &Driven,
    replans: &[PlannedPath],
    by_reason: &BTreeMap<String, usize>,
) -> Vec<Expectation> {
    let expect = &prepared.scenario.expect;
    let truth = driven.collector.totals.truth.unwrap_or_default();
    let mut list = vec![
        outcome(expect, driven.ending.outcome()),
        contacts(expect, truth.contacts_moving + truth.contacts_standing),
    ];
    list.extend(obstacle_replans(expect, replans));
    if let Some(least_m) = expect.driven_m_min {
        let driven_m = driven.collector.totals.driven_m();
        list.push(Expectation {
            name: "metres driven".to_owned(),
            expected: format!("at least {least_m}"),
            actual: format!("{driven_m:.2}"),
            met: driven_m >= least_m,
        });
    }
    if let (Some(most_m), Some(goal)) = (expect.goal_distance_m_max, prepared.scenario.goals.last())
    {
        let distance_m = truth.pose.distance_m(&goal.pose);
        list.push(Expectation {
            name: "metres from the goal".to_owned(),
            expected: format!("at most {most_m}"),
            actual: format!("{distance_m:.2}"),
            met: distance_m <= most_m,
        });
    }
    for (reason, least) in &expect.interventions_min {
        let n = by_reason.get(reason).copied().unwrap_or(0);
        let name = format!("interventions of the guard, {reason}");
        list.push(at_least(&name, *least, n));
    }
    if let Some(least) = expect.restarts_min {
        list.push(at_least("restarts", least, driven.restarts.len()));
    }
    list
}

/// The limit of contacts, which also holds for trials.
pub(super) fn contacts(expect: &ExpectSpec, n: u32) -> Expectation {
    Expectation {
        name: "contacts".to_owned(),
        expected: format!("at most {}", expect.contacts_max),
        actual: n.to_string(),
        met: n <= expect.contacts_max,
    }
}

fn outcome(expect: &ExpectSpec, actual: &str) -> Expectation {
    let (expected, met) = match expect.outcome {
        Outcome::Unreachable => (
            "unreachable",
            matches!(actual, "unreachable" | "goal_blocked"),
        ),
        Outcome::Reached => ("reached", actual == "reached"),
        Outcome::Timeout => ("timeout", actual == "timeout"),
    };
    Expectation {
        name: "outcome".to_owned(),
        expected: expected.to_owned(),
        actual: actual.to_owned(),
        met,
    }
}

fn obstacle_replans<'a>(
    expect: &'a ExpectSpec,
    replans: &[PlannedPath],
) -> impl Iterator<Item = Expectation> + use<'a> {
    const NAME: &str = "replans because of an obstacle";
    let by_obstacle = |replan: &&PlannedPath| {
        replan.cause == PathCause::Obstacle.label() && replan.status == PathStatus::Found.label()
    };
    let n = replans.iter().filter(by_obstacle).count();
    let least = expect.obstacle_replans_min;
    let most = expect.obstacle_replans_max.map(|most| Expectation {
        name: NAME.to_owned(),
        expected: format!("at most {most}"),
        actual: n.to_string(),
        met: n <= most as usize,
    });
    let least = least.map(|least| at_least(NAME, least, n));
    least.into_iter().chain(most)
}

fn at_least(name: &str, least: u32, n: usize) -> Expectation {
    Expectation {
        name: name.to_owned(),
        expected: format!("at least {least}"),
        actual: n.to_string(),
        met: n >= least as usize,
    }
}
