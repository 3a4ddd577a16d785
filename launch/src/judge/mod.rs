//! From what was seen of a run to its result.

mod expectations;
mod reason;

use crate::drive::Driven;
use crate::prepare::Prepared;
use crate::subject::Subject;
use crate::trials::{self, Trials};
use expectations::{contacts, expectations};
use nalgebra::Point2;
use reason::reason;
use std::collections::BTreeMap;
use zeronav_measure::index::PathRecord;
use zeronav_measure::motion::{Contact, Moment, jerk_mps3};
use zeronav_measure::profile::RoundProfile;
use zeronav_measure::result::ServiceResult;
use zeronav_measure::result::latency::Latency;
use zeronav_measure::result::profile::Profile;
use zeronav_measure::result::start_up::StartUp;
use zeronav_measure::result::trials::TrialsResult;
use zeronav_measure::result::{
    Environment, Expectation, ObstacleResult, PlannedPath, RunResult, Touch,
};
use zeronav_measure::start_up::start_up;
use zeronav_measure::{self, DEADLINE_NS, Event};
use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::time::seconds;
use zeronav_scenario::hosts::host_of;

/// The result of a run.
#[must_use]
pub(crate) fn judge(prepared: &Prepared, driven: &Driven, environment: Environment) -> RunResult {
    let (collector, totals) = (&driven.collector, &driven.collector.totals);
    let truth = totals.truth.unwrap_or_default();
    let subject = Subject::of(prepared, driven);
    let plans = plans(&subject);
    let replans: Vec<PlannedPath> = plans
        .iter()
        .filter(|plan| plan.cause != PathCause::Goal.label())
        .cloned()
        .collect();
    let by_reason = interventions(driven);
    let moments = moments(&subject);
    let expectations = expectations(prepared, driven, &replans, &by_reason);
    let outcome = driven.ending.outcome();
    let met = expectations.iter().all(|expectation| expectation.met);
    let time_s = seconds(driven.end_run_ns.saturating_sub(driven.goals_run_ns));
    let wall_s = driven.wall.as_secs_f64();
    let lockstep = prepared.mode == RunMode::Lockstep;
    let (latency, profile) = latencies(prepared, driven).unzip();
    RunResult {
        scenario: prepared.scenario.name.clone(),
        verdict: if met { "pass" } else { "fail" }.to_owned(),
        reason: reason(prepared, driven, met, &expectations),
        outcome: outcome.to_owned(),
        reached: outcome == "reached",
        contacts: truth.contacts_moving + truth.contacts_standing,
        contacts_moving: truth.contacts_moving,
        contacts_standing: truth.contacts_standing,
        clearance_m_min: totals.clearance_m_min,
        time_s,
        first_goal_s: seconds(driven.goals_run_ns),
        driven_m: totals.driven_m(),
        mode: prepared.mode.to_string(),
        seed: prepared.seed,
        wall_s,
        speed_factor: if wall_s > 0.0 { time_s / wall_s } else { 0.0 },
        slipped_ms: seconds(truth.slipped_ns) * 1.0e3,
        plans,
        replans,
        obstacles: obstacles(prepared, driven),
        track_m: totals.track_m.clone(),
        motion: moments.iter().map(|moment| row(moment, driven)).collect(),
        jerk_mps3: jerk_mps3(moments),
        recoveries: totals.task.map_or(0, |task| task.recoveries),
        stuck_cause: totals.stuck_cause().map(|cause| cause.to_string()),
        touches: touches(&subject),
        interventions: by_reason.values().sum(),
        interventions_by_reason: by_reason,
        pose: totals.comparison.pose(),
        tracking: totals.comparison.tracking(),
        command_lag: totals.lag.result(),
        latency,
        profile,
        disturbance: driven.disturbance.clone(),
        start_up: (!lockstep).then(|| started(driven)).flatten(),
        trials: None,
        injected_us: injected(prepared),
        services: services(driven),
        companions: driven.companions.clone(),
        link: driven.link.clone(),
        restarts: driven.restarts.clone(),
        starved: driven.starved.clone(),
        faults: driven.faults.clone(),
        redirects: driven.redirects.clone(),
        swaps: driven.swaps.clone(),
        reasons: (collector.reasons).moments(driven.goals_run_ns, driven.end_run_ns),
        environment,
        shared_memory_bytes: driven.shared_memory_bytes,
        run_hash: lockstep.then(|| driven.run_hash()),
        reproducible: lockstep.then_some(driven.not_reproducible.is_empty()),
        not_reproducible: driven.not_reproducible.clone(),
        expectations,
        directory: prepared.directory.display().to_string(),
    }
}

/// The result of trials, whose last drive is `driven`. Paths and track are those of that drive.
#[must_use]
pub(crate) fn judge_trials(
    prepared: &Prepared,
    driven: &Driven,
    trials: &Trials,
    environment: Environment,
) -> RunResult {
    let mut whole = judge(prepared, driven, environment);
    for before in &trials.drives {
        let totals = &before.collector.totals;
        let truth = totals.truth.unwrap_or_default();
        whole.contacts_moving += truth.contacts_moving;
        whole.contacts_standing += truth.contacts_standing;
        whole.driven_m += totals.driven_m();
        whole.time_s += seconds(before.end_run_ns.saturating_sub(before.goals_run_ns));
        whole.wall_s += before.wall.as_secs_f64();
        whole.slipped_ms += seconds(truth.slipped_ns) * 1.0e3;
        whole.restarts.extend(before.restarts.iter().cloned());
        whole.starved.extend(before.starved.iter().cloned());
        for (whole, seat) in whole.services.iter_mut().zip(&before.services) {
            whole.memory_peak_bytes = whole.memory_peak_bytes.max(seat.memory_peak_bytes);
            whole.starts += seat.starts;
        }
        let least = totals.clearance_m_min;
        whole.clearance_m_min = match (whole.clearance_m_min, least) {
            (Some(one), Some(other)) => Some(one.min(other)),
            (one, other) => one.or(other),
        };
    }
    whole.contacts = whole.contacts_moving + whole.contacts_standing;
    // Hundreds of paths with all their points are of no use to anybody.
    whole.plans.clear();
    whole.replans.clear();
    whole.reasons.clear();
    whole.motion.clear();
    let replanning = trials.latency.replanning;
    let made: usize = trials.rounds.iter().map(|round| round.trials).sum();
    let expectation = |name: &str, expected: String, actual: String, met| Expectation {
        name: name.to_owned(),
        expected,
        actual,
        met,
    };
    whole.expectations = vec![
        expectation(
            "trials",
            trials.wanted.to_string(),
            made.to_string(),
            made == trials.wanted,
        ),
        expectation(
            "trials without an answer",
            "0".to_owned(),
            replanning.censored.to_string(),
            replanning.censored == 0,
        ),
        contacts(&prepared.scenario.expect, whole.contacts),
    ];
    let met = whole.expectations.iter().all(|expectation| expectation.met);
    if met { "pass" } else { "fail" }.clone_into(&mut whole.verdict);
    whole.reason = reason(prepared, driven, met, &whole.expectations);
    let mut latency = trials.latency.clone();
    add_clocks(&mut latency, prepared, driven);
    whole.latency = Some(latency);
    whole.profile = Some(trials.profile.clone());
    // Each round has its own.
    whole.disturbance = None;
    // Only the first stack of several was started by the command.
    whole.start_up = None;
    whole.trials = Some(TrialsResult {
        wanted: trials.wanted,
        made,
        rounds: trials.rounds.clone(),
        worst: trials.worst.clone(),
    });
    whole
}

/// The delays that were put into seats on purpose, by seat. [us]
fn injected(prepared: &Prepared) -> BTreeMap<String, f64> {
    let delays = prepared.delays.iter();
    delays
        .map(|(role, steps)| (role.to_string(), injected_us(*steps)))
        .collect()
}

/// A delay that was put into a seat on purpose. [us]
fn injected_us(steps: u16) -> f64 {
    let seat = zeronav_msgs::run::Seat {
        delay: steps,
        ..Default::default()
    };
    (1.0e6 * seconds(seat.delay_ns())).round()
}

/// The moments from the first goal to the end of the task.
pub(crate) fn moments<'a>(subject: &Subject<'a>) -> &'a [Moment] {
    let moments = &subject.collector.totals.motion.moments;
    let from = moments.partition_point(|moment| moment.run_ns < subject.goals_run_ns);
    let to = moments.partition_point(|moment| moment.run_ns <= subject.end_run_ns);
    moments.get(from..to).unwrap_or_default()
}

fn row(moment: &Moment, driven: &Driven) -> [f64; 6] {
    [
        seconds(moment.run_ns.saturating_sub(driven.goals_run_ns)),
        moment.pose.x_m,
        moment.pose.y_m,
        moment.pose.yaw_rad,
        moment.v_mps,
        moment.w_radps,
    ]
}

/// The contacts of the robot.
pub(crate) fn touches(subject: &Subject<'_>) -> Vec<Touch> {
    let touch = |contact: &Contact| {
        let Contact { at, moving, .. } = contact;
        Touch {
            time_s: seconds(at.run_ns.saturating_sub(subject.goals_run_ns)),
            moving: *moving,
            v_mps: contact.v_before_mps,
            with: touched(subject, contact),
            pose: [at.pose.x_m, at.pose.y_m, at.pose.yaw_rad],
        }
    };
    let contacts = &subject.collector.totals.motion.contacts;
    contacts.iter().map(touch).collect()
}

/// The nearest thing at a contact.
fn touched(subject: &Subject<'_>, contact: &Contact) -> String {
    /// Nothing that is farther away can be touched. [m]
    const REACH_M: f64 = 0.5;
    let robot = subject.footprint.placed(&contact.at.pose);
    let mut nearest = ("world", subject.world.convex_distance_m(&robot, REACH_M));
    for (index, pose) in &contact.obstacles {
        let Some(obstacle) = subject.world.obstacles().get(*index) else {
            continue;
        };
        let distance_m = robot.distance_m(&obstacle.shape.placed_at(pose));
        if distance_m < nearest.1 {
            nearest = (&obstacle.spec.name, distance_m);
        }
    }
    nearest.0.to_owned()
}

/// How often the guard stepped in until the end of the task, by reason.
fn interventions(driven: &Driven) -> BTreeMap<String, usize> {
    let mut by_reason = BTreeMap::new();
    for (run_ns, why) in &driven.collector.totals.motion.interventions {
        if (driven.goals_run_ns..=driven.end_run_ns).contains(run_ns) {
            *by_reason.entry(why.label().to_owned()).or_default() += 1;
        }
    }
    by_reason
}

/// Every path, and every reason why there was none.
pub(crate) fn plans(subject: &Subject<'_>) -> Vec<PlannedPath> {
    let paths = subject.collector.records.paths.iter();
    paths
        .filter(|path| path.status != PathStatus::NoGoal && path.run_ns <= subject.end_run_ns)
        .map(|path| plan(subject, path))
        .collect()
}

fn plan(subject: &Subject<'_>, path: &PathRecord) -> PlannedPath {
    let points: Vec<Point2<f64>> = path.points_m.iter().map(|at| Point2::from(*at)).collect();
    let clearance_m =
        subject.world.polyline_clearance_m(&points) - subject.footprint.inscribed_radius_m();
    PlannedPath {
        time_s: seconds(path.run_ns.saturating_sub(subject.goals_run_ns)),
        cause: path.cause.to_string(),
        planner: path.planner.clone(),
        status: path.status.to_string(),
        length_m: path.length_m,
        beside_goal_m: path.beside_goal_m,
        expanded: path.expanded,
        clearance_m_min: clearance_m.is_finite().then_some(clearance_m),
        collides: clearance_m < 0.0,
        points_m: path.points_m.clone(),
    }
}

/// The latencies of a run in real time and what lies behind them. Those of trials are measured
/// trial by trial.
fn latencies(prepared: &Prepared, driven: &Driven) -> Option<(Latency, Profile)> {
    if prepared.mode == RunMode::Lockstep {
        return None;
    }
    let (events, mut latency) = latency(&Subject::of(prepared, driven));
    add_clocks(&mut latency, prepared, driven);
    let records = &driven.collector.records;
    let round = RoundProfile::of(&events, records, None, trials::timing(prepared));
    Some((latency, trials::profile(prepared, &[round])))
}

/// How uncertain the hops are that end on another host than they begin.
pub(crate) fn add_clocks(latency: &mut Latency, prepared: &Prepared, driven: &Driven) {
    let link = driven.link.as_ref();
    if let Some(us) = link.and_then(|link| link.uncertainty_us_max) {
        let hosts = &prepared.scenario.hosts;
        latency.add_clock_uncertainty(us, |seat| host_of(hosts, seat));
    }
}

/// What became of the obstacles of a drive, and its latencies.
pub(crate) fn latency(subject: &Subject<'_>) -> (Vec<Event>, Latency) {
    let (collector, world) = (subject.collector, subject.world);
    let clearance_m = |index: usize, points_m: &[[f64; 2]]| {
        let pose = collector.obstacles.get(&index);
        let obstacle = world.obstacles().get(index);
        obstacle
            .zip(pose)
            .map_or(f64::INFINITY, |(obstacle, pose)| {
                let polyline: Vec<Point2<f64>> = points_m
                    .iter()
                    .map(|point| Point2::new(point[0], point[1]))
                    .collect();
                obstacle.shape.polyline_clearance_m(pose, &polyline)
            })
    };
    let radius_m = subject.footprint.inscribed_radius_m();
    zeronav_measure::measure(&collector.records, &clearance_m, radius_m, DEADLINE_NS)
}

/// What the start took.
fn started(driven: &Driven) -> Option<StartUp> {
    let collector = &driven.collector;
    start_up(
        &driven.start,
        &collector.records,
        collector.first_motion_tick,
    )
}

fn obstacles(prepared: &Prepared, driven: &Driven) -> Vec<ObstacleResult> {
    let seen = |(index, obstacle): (usize, &zeronav_world::Obstacle)| {
        let pose = driven.collector.totals.obstacles.get(&index)?;
        let outline = obstacle.shape.placed_at(pose).outline();
        Some(ObstacleResult {
            name: obstacle.spec.name.clone(),
            corners_m: outline.iter().map(|corner| [corner.x, corner.y]).collect(),
        })
    };
    prepared
        .world
        .obstacles()
        .iter()
        .enumerate()
        .filter_map(seen)
        .collect()
}

/// The processes of the run; the planner's with the key that its last path names.
fn services(driven: &Driven) -> Vec<ServiceResult> {
    let mut services = driven.services.clone();
    let paths = &driven.collector.records.paths;
    let path = paths.iter().rev().find(|path| !path.planner.is_empty());
    let planner = Role::GlobalPlanner.label();
    if let Some(service) = services.iter_mut().find(|service| service.name == planner) {
        service.key = path.map(|path| path.planner.clone());
    }
    services
}
