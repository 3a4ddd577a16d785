//! From what was seen of a run to its result and its picture.

use crate::ending::Ending;
use crate::measure;
use crate::measure::index::PathRecord;
use crate::measure::motion::{Contact, Moment, jerk_mps3};
use crate::prepare::Prepared;
use crate::run::{DEADLINE_NS, Driven};
use crate::scenario::Outcome;
use crate::seat_report::SeatReport;
use crate::show::picture::{Area, Line, Picture};
use crate::show::report::{
    Environment, Expectation, ObstacleResult, Plan, RunResult, ServiceResult, Touch, TrialsResult,
};
use crate::trials::Trials;
use nalgebra::Point2;
use std::collections::BTreeMap;
use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::task::{EndReason, StuckCause, TaskState};
use zeronav_msgs::time::seconds;
use zeronav_world::static_map::Occupancy;

/// Colours of the last paths in the picture.
const COLOURS: [&str; 4] = ["#d95f02", "#7570b3", "#e7298a", "#66a61e"];

/// The outcome of a run in one word.
#[must_use]
pub fn outcome(ending: &Ending) -> &'static str {
    match ending {
        Ending::Task(TaskState::Reached, _) => "reached",
        Ending::Task(TaskState::Cancelled, _) => "cancelled",
        Ending::Task(_, EndReason::None) => "failed",
        Ending::Task(_, reason) => reason.label(),
        Ending::Redirected => "redirected",
        Ending::Timeout => "timeout",
        Ending::TrialsOver => "trials_over",
        Ending::Died { .. } => "service_died",
        Ending::NotReady(_) => "not_ready",
        Ending::Silent(_) => "silent",
        Ending::Interrupted => "interrupted",
    }
}

/// The result of a run.
#[must_use]
pub fn result(prepared: &Prepared, driven: &Driven, environment: Environment) -> RunResult {
    let collector = &driven.collector;
    let seen = &collector.seen;
    let truth = seen.truth.unwrap_or_default();
    let plans: Vec<Plan> = collector
        .records
        .paths
        .iter()
        .filter(|path| path.status != PathStatus::NoGoal && path.run_ns <= driven.end_run_ns)
        .map(|path| plan(path, driven.goals_run_ns))
        .collect();
    let replans: Vec<Plan> = plans
        .iter()
        .filter(|plan| plan.cause != PathCause::Goal.label())
        .cloned()
        .collect();
    let by_reason = interventions(driven);
    let moments = moments(driven);
    let expectations = expectations(prepared, driven, &replans, &by_reason);
    let outcome = outcome(&driven.ending);
    let met = expectations.iter().all(|expectation| expectation.met);
    let time_s = seconds(driven.end_run_ns.saturating_sub(driven.goals_run_ns));
    let wall_s = driven.wall.as_secs_f64();
    let lockstep = prepared.mode == RunMode::Lockstep;
    RunResult {
        scenario: prepared.scenario.name.clone(),
        verdict: if met { "pass" } else { "fail" }.to_owned(),
        reason: reason(prepared, driven, met, &expectations),
        outcome: outcome.to_owned(),
        reached: outcome == "reached",
        contacts: truth.contacts_moving + truth.contacts_standing,
        contacts_moving: truth.contacts_moving,
        contacts_standing: truth.contacts_standing,
        clearance_m_min: seen.clearance_m_min,
        time_s,
        driven_m: seen.driven_m(),
        mode: prepared.mode.to_string(),
        seed: prepared.seed,
        wall_s,
        speed_factor: if wall_s > 0.0 { time_s / wall_s } else { 0.0 },
        slipped_ms: seconds(truth.slipped_ns) * 1.0e3,
        plans,
        replans,
        obstacles: obstacles(prepared, driven),
        track_m: seen.track_m.clone(),
        motion: moments.iter().map(|moment| row(moment, driven)).collect(),
        jerk_mps3: jerk_mps3(moments),
        recoveries: seen.task.map_or(0, |task| task.recoveries),
        stuck_cause: stuck_cause(driven).map(|cause| cause.to_string()),
        touches: touches(prepared, driven),
        interventions: by_reason.values().sum(),
        interventions_by_reason: by_reason,
        pose: seen.witness.pose(),
        tracking: seen.witness.tracking(),
        latency: (!lockstep).then(|| latency(prepared, driven)),
        trials: None,
        injected_us: prepared
            .delays
            .iter()
            .map(|(role, steps)| (role.to_string(), injected_us(*steps)))
            .collect(),
        services: services(driven),
        restarts: driven.restarts.clone(),
        redirects: driven.redirects.clone(),
        environment,
        shared_memory_bytes: driven.shared_memory_bytes,
        // The last tick is left out: while it is answered, launch may already stop the robot.
        run_hash: lockstep.then(|| collector.hash.value(driven.end_tick.saturating_sub(1))),
        expectations,
        directory: prepared.directory.display().to_string(),
    }
}

/// The result of trials, whose last drive is `driven`. Paths and track are those of that drive.
#[must_use]
pub fn of_trials(
    prepared: &Prepared,
    driven: &Driven,
    trials: &Trials,
    environment: Environment,
) -> RunResult {
    let mut whole = result(prepared, driven, environment);
    for before in &trials.drives {
        let seen = &before.collector.seen;
        let truth = seen.truth.unwrap_or_default();
        whole.contacts_moving += truth.contacts_moving;
        whole.contacts_standing += truth.contacts_standing;
        whole.driven_m += seen.driven_m();
        whole.time_s += seconds(before.end_run_ns.saturating_sub(before.goals_run_ns));
        whole.wall_s += before.wall.as_secs_f64();
        whole.slipped_ms += seconds(truth.slipped_ns) * 1.0e3;
        whole.restarts.extend(before.restarts.iter().cloned());
        for (whole, seat) in whole.services.iter_mut().zip(&before.services) {
            whole.memory_peak_bytes = whole.memory_peak_bytes.max(seat.memory_peak_bytes);
            whole.starts += seat.starts;
        }
        let least = seen.clearance_m_min;
        whole.clearance_m_min = match (whole.clearance_m_min, least) {
            (Some(one), Some(other)) => Some(one.min(other)),
            (one, other) => one.or(other),
        };
    }
    whole.contacts = whole.contacts_moving + whole.contacts_standing;
    // Hundreds of paths with all their points are of no use to anybody.
    whole.plans.clear();
    whole.replans.clear();
    whole.motion.clear();
    let replanning = trials.latency.replanning;
    let made: usize = trials.rounds.iter().map(|round| round.trials).sum();
    let most = prepared.scenario.expect.contacts_max;
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
        expectation(
            "contacts",
            format!("at most {most}"),
            whole.contacts.to_string(),
            whole.contacts <= most,
        ),
    ];
    let met = whole.expectations.iter().all(|expectation| expectation.met);
    if met { "pass" } else { "fail" }.clone_into(&mut whole.verdict);
    whole.reason = reason(prepared, driven, met, &whole.expectations);
    whole.latency = Some(trials.latency.clone());
    whole.trials = Some(TrialsResult {
        wanted: trials.wanted,
        made,
        rounds: trials.rounds.clone(),
        worst: trials.worst.clone(),
    });
    whole
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
fn moments(driven: &Driven) -> &[Moment] {
    let moments = &driven.collector.seen.motion.moments;
    let from = moments.partition_point(|moment| moment.run_ns < driven.goals_run_ns);
    let to = moments.partition_point(|moment| moment.run_ns <= driven.end_run_ns);
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

fn touches(prepared: &Prepared, driven: &Driven) -> Vec<Touch> {
    let touch = |contact: &Contact| {
        let Contact { at, moving, .. } = contact;
        Touch {
            time_s: seconds(at.run_ns.saturating_sub(driven.goals_run_ns)),
            moving: *moving,
            v_mps: contact.v_before_mps,
            with: touched(prepared, contact),
            pose: [at.pose.x_m, at.pose.y_m, at.pose.yaw_rad],
        }
    };
    driven
        .collector
        .seen
        .motion
        .contacts
        .iter()
        .map(touch)
        .collect()
}

/// The nearest thing at a contact.
fn touched(prepared: &Prepared, contact: &Contact) -> String {
    /// Nothing that is farther away can be touched. [m]
    const REACH_M: f64 = 0.5;
    let robot = prepared.footprint.placed(&contact.at.pose);
    let mut nearest = ("world", prepared.world.convex_distance_m(&robot, REACH_M));
    for (index, pose) in &contact.obstacles {
        let Some(obstacle) = prepared.world.obstacles().get(*index) else {
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
    for (run_ns, why) in &driven.collector.seen.motion.interventions {
        if (driven.goals_run_ns..=driven.end_run_ns).contains(run_ns) {
            *by_reason.entry(why.label().to_owned()).or_default() += 1;
        }
    }
    by_reason
}

fn plan(path: &PathRecord, goals_run_ns: u64) -> Plan {
    Plan {
        time_s: seconds(path.run_ns.saturating_sub(goals_run_ns)),
        cause: path.cause.to_string(),
        planner: path.planner.clone(),
        status: path.status.to_string(),
        length_m: path.length_m,
        beside_goal_m: path.beside_goal_m,
        expanded: path.expanded,
        points_m: path.points_m.clone(),
    }
}

fn latency(prepared: &Prepared, driven: &Driven) -> measure::Latency {
    let clearance_m = |index: usize, points_m: &[[f64; 2]]| {
        let pose = driven.collector.obstacles.get(&index);
        let obstacle = prepared.world.obstacles().get(index);
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
    let radius_m = prepared.footprint.inscribed_radius_m();
    measure::measure(
        &driven.collector.records,
        &clearance_m,
        radius_m,
        DEADLINE_NS,
    )
    .1
}

fn obstacles(prepared: &Prepared, driven: &Driven) -> Vec<ObstacleResult> {
    let seen = |(index, obstacle): (usize, &zeronav_world::Obstacle)| {
        let pose = driven.collector.seen.obstacles.get(&index)?;
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

fn services(driven: &Driven) -> Vec<ServiceResult> {
    let paths = &driven.collector.records.paths;
    let planner = paths.iter().rev().find(|path| !path.planner.is_empty());
    let key = |role: Role| {
        planner
            .filter(|_| role == Role::GlobalPlanner)
            .map(|path| path.planner.clone())
    };
    let row = |seat: &SeatReport| ServiceResult {
        name: seat.role.to_string(),
        binary: seat.binary.clone(),
        pid: seat.pid,
        external: seat.external,
        key: key(seat.role),
        starts: seat.starts,
        memory_peak_bytes: seat.memory_peak_bytes,
        end: seat.end.clone(),
    };
    driven.services.iter().map(row).collect()
}

fn expectations(
    prepared: &Prepared,
    driven: &Driven,
    replans: &[Plan],
    by_reason: &BTreeMap<String, usize>,
) -> Vec<Expectation> {
    let expect = &prepared.scenario.expect;
    let truth = driven.collector.seen.truth.unwrap_or_default();
    let actual = outcome(&driven.ending);
    let mut list = Vec::new();
    let mut add = |name: &str, expected: String, actual: String, met: bool| {
        list.push(Expectation {
            name: name.to_owned(),
            expected,
            actual,
            met,
        });
    };
    let (wished, met) = match expect.outcome {
        Outcome::Unreachable => (
            "unreachable",
            matches!(actual, "unreachable" | "goal_blocked"),
        ),
        Outcome::Reached => ("reached", actual == "reached"),
        Outcome::Timeout => ("timeout", actual == "timeout"),
    };
    add("outcome", wished.to_owned(), actual.to_owned(), met);
    let contacts = truth.contacts_moving + truth.contacts_standing;
    add(
        "contacts",
        format!("at most {}", expect.contacts_max),
        contacts.to_string(),
        contacts <= expect.contacts_max,
    );
    let obstacle = replans
        .iter()
        .filter(|replan| {
            replan.cause == PathCause::Obstacle.label()
                && replan.status == PathStatus::Found.label()
        })
        .count();
    if let Some(least) = expect.obstacle_replans_min {
        let met = obstacle >= least as usize;
        add(
            "replans because of an obstacle",
            format!("at least {least}"),
            obstacle.to_string(),
            met,
        );
    }
    if let Some(most) = expect.obstacle_replans_max {
        let met = obstacle <= most as usize;
        add(
            "replans because of an obstacle",
            format!("at most {most}"),
            obstacle.to_string(),
            met,
        );
    }
    if let Some(least_m) = expect.driven_m_min {
        let driven_m = driven.collector.seen.driven_m();
        add(
            "metres driven",
            format!("at least {least_m}"),
            format!("{driven_m:.2}"),
            driven_m >= least_m,
        );
    }
    if let (Some(most_m), Some(goal)) = (expect.goal_distance_m_max, prepared.scenario.goals.last())
    {
        let distance_m = truth.pose.distance_m(&goal.pose);
        add(
            "metres from the goal",
            format!("at most {most_m}"),
            format!("{distance_m:.2}"),
            distance_m <= most_m,
        );
    }
    for (reason, least) in &expect.interventions_min {
        let n = by_reason.get(reason).copied().unwrap_or(0);
        add(
            &format!("interventions of the guard, {reason}"),
            format!("at least {least}"),
            n.to_string(),
            n >= *least as usize,
        );
    }
    if let Some(least) = expect.restarts_min {
        let n = driven.restarts.len();
        add(
            "restarts",
            format!("at least {least}"),
            n.to_string(),
            n >= least as usize,
        );
    }
    list
}

/// Why the robot got stuck, if it did.
fn stuck_cause(driven: &Driven) -> Option<StuckCause> {
    let cause = driven.collector.seen.task?.cause;
    (cause != StuckCause::None).then_some(cause)
}

fn reason(prepared: &Prepared, driven: &Driven, met: bool, expectations: &[Expectation]) -> String {
    let ending = &driven.ending;
    let what = match ending {
        Ending::Task(TaskState::Reached, _) => "the robot reached its goal".to_owned(),
        Ending::Task(TaskState::Cancelled, _) => "the task was cancelled".to_owned(),
        Ending::Task(_, EndReason::Unreachable) => "the goal is unreachable".to_owned(),
        Ending::Task(_, EndReason::GoalBlocked) => {
            "the goal is unreachable: no free pose within its tolerance".to_owned()
        }
        Ending::Task(_, reason) => match stuck_cause(driven) {
            Some(cause) => {
                let recoveries = driven.collector.seen.task.map_or(0, |task| task.recoveries);
                format!("the robot gave up: {reason} ({cause}) after {recoveries} recoveries")
            }
            None => format!("the robot gave up: {reason}"),
        },
        Ending::Redirected => {
            "the robot reached a goal that was given by hand, not the scenario's".to_owned()
        }
        Ending::Timeout => {
            format!(
                "not done within {} s of run time",
                prepared.scenario.run.time_limit_s
            )
        }
        Ending::TrialsOver => "all trials were made".to_owned(),
        Ending::Died { role, how, .. } => format!("{role} ended during the run: {how}"),
        Ending::NotReady(roles) => format!("not ready in time: {}", names(roles)),
        Ending::Silent(role) => format!("{role} stopped answering"),
        Ending::Interrupted => "interrupted".to_owned(),
    };
    let missed: Vec<String> = expectations
        .iter()
        .filter(|expectation| !expectation.met && expectation.name != "outcome")
        .map(|expectation| format!("{}: {}", expectation.name, expectation.actual))
        .collect();
    match (met, ending) {
        (true, Ending::Task(TaskState::Reached, _) | Ending::TrialsOver) => what,
        (true, _) => format!("{what}, as the scenario expects"),
        (false, _) if missed.is_empty() => what,
        (false, _) => format!("{what}; {}", missed.join("; ")),
    }
}

fn names(roles: &[Role]) -> String {
    roles
        .iter()
        .map(|role| role.label())
        .collect::<Vec<_>>()
        .join(", ")
}

/// The picture of a run.
#[must_use]
pub fn picture(prepared: &Prepared, driven: &Driven, result: &RunResult) -> Picture {
    let map = prepared.world.rasterise();
    let paths: Vec<&PathRecord> = driven
        .collector
        .records
        .paths
        .iter()
        .filter(|path| path.status == PathStatus::Found && path.run_ns <= driven.end_run_ns)
        .collect();
    let mut lines = Vec::new();
    let mut line = |path: &PathRecord, colour, dashed| {
        lines.push(Line {
            name: format!(
                "path at {:.1} s ({}), {:.1} m",
                seconds(path.run_ns),
                path.cause,
                path.length_m
            ),
            colour,
            dashed,
            points_m: path.points_m.clone(),
        });
    };
    // The first path and the last ones; a run that replans all the time would hide the map.
    if let Some((first, rest)) = paths.split_first() {
        line(first, "#1f78b4", true);
        let skip = rest.len().saturating_sub(COLOURS.len());
        for (path, colour) in rest.iter().skip(skip).zip(COLOURS) {
            line(path, colour, true);
        }
    }
    lines.push(Line {
        name: format!("driven track, {:.1} m", result.driven_m),
        colour: "#1b9e3b",
        dashed: false,
        points_m: driven.collector.seen.track_m.clone(),
    });
    let start = prepared.scenario.start;
    Picture {
        title: format!("{}: {}", result.scenario, result.reason),
        subtitle: format!(
            "{}, {:.1} s of run time, {} contacts, seed {}",
            result.mode, result.time_s, result.contacts, result.seed
        ),
        geometry: map.geometry,
        occupied: map
            .cells
            .iter()
            .map(|cell| *cell == Occupancy::Occupied)
            .collect(),
        areas: result
            .obstacles
            .iter()
            .map(|obstacle| Area {
                name: obstacle.name.clone(),
                colour: "#e34a33",
                corners_m: obstacle.corners_m.clone(),
            })
            .collect(),
        lines,
        start_m: [start.x_m, start.y_m],
        goals_m: prepared
            .scenario
            .goals
            .iter()
            .map(|goal| [goal.pose.x_m, goal.pose.y_m])
            .collect(),
        robot_radius_m: prepared.footprint.circumscribed_radius_m(),
    }
}
