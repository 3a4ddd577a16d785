//! The result of a run as a page of text.

use core::fmt::Write;
use zeronav_casts::Cast;
use zeronav_measure::lints::lints;
use zeronav_measure::result::companion::{CompanionResult, STOPPED};
use zeronav_measure::result::fault::FaultResult;
use zeronav_measure::result::latency::{Figures, Latency};
use zeronav_measure::result::trials::{SlowHop, SlowTrial};
use zeronav_measure::result::truth::{PoseResult, TrackingResult};
use zeronav_measure::result::{Redirect, Restart, RunResult, ServiceResult, Starved};

/// Odometry that is never farther from the truth than this is the truth. [m]
const EXACT_M: f64 = 1.0e-6;

/// Services that were off the processor for less in a cycle are not named to people. [us]
const SHOWN_US: f64 = 100.0;

/// Slowest trials that are shown; the result holds more.
const SLOWEST_SHOWN: usize = 5;

/// What the services took, and which processes they were.
fn write_services(result: &RunResult, text: &mut String) {
    let _ = writeln!(
        text,
        "\n  shared memory {:.1} MB; peak memory {}",
        megabytes(result.shared_memory_bytes),
        result
            .services
            .iter()
            .map(|service| format!(
                "{} {:.0} MB",
                service.name,
                megabytes(service.memory_peak_bytes)
            ))
            .collect::<Vec<_>>()
            .join(", ")
    );
    let _ = writeln!(text, "  answered by {}", who_answered(result));
    for service in &result.services {
        for refused in service.scheduling.iter().flat_map(|it| &it.refused) {
            let _ = writeln!(text, "  {} was not granted {refused}", service.name);
        }
    }
}

/// The processes that answered, for people.
fn who_answered(result: &RunResult) -> String {
    let who: Vec<String> = result.services.iter().map(who).collect();
    who.join(", ")
}

/// The expectations that were not met.
fn write_missed(result: &RunResult, text: &mut String) {
    let missed = result.expectations.iter();
    for expectation in missed.filter(|expectation| !expectation.met) {
        let _ = writeln!(
            text,
            "  expected {}: {}, but it was {}",
            expectation.name, expectation.expected, expectation.actual
        );
    }
}

/// The restarts, the services without a processor, and the faults that were made.
pub(crate) fn write_troubles(
    (restarts, starved, faults): (&[Restart], &[Starved], &[FaultResult]),
    text: &mut String,
) {
    for restart in restarts {
        let _ = writeln!(
            text,
            "  {:8.2} s  {} restarted: {}",
            restart.time_s, restart.service, restart.how
        );
    }
    for seat in starved {
        text.push_str(&starved_line(seat));
    }
    for fault in faults {
        text.push_str(&fault_line(fault));
    }
}

/// The companions that did not end as they were asked to, or were started more than once.
pub(crate) fn write_companions(companions: &[CompanionResult], text: &mut String) {
    for companion in companions {
        if companion.starts > 1 || companion.end != STOPPED {
            let _ = writeln!(
                text,
                "  companion {}: {} starts, {}",
                companion.name, companion.starts, companion.end
            );
        }
    }
}

/// The paths, the restarts, and the goals given by hand.
fn write_events(result: &RunResult, text: &mut String) {
    for plan in &result.plans {
        let _ = writeln!(
            text,
            "  {:8.2} s  path by {}: {}, {:.1} m, {} expanded, cause {}{}",
            plan.time_s,
            plan.planner,
            plan.status,
            plan.length_m,
            plan.expanded,
            plan.cause,
            beside(plan.beside_goal_m)
        );
    }
    write_troubles((&result.restarts, &result.starved, &result.faults), text);
    write_companions(&result.companions, text);
    if let Some(link) = &result.link {
        let _ = writeln!(text, "  link {link}");
    }
    for Redirect {
        time_s,
        goal: [x_m, y_m, yaw_rad],
        outcome,
    } in &result.redirects
    {
        let _ = writeln!(
            text,
            "  {time_s:8.2} s  sent to ({x_m:.2}, {y_m:.2}, {yaw_rad:.2}) by hand: {outcome}"
        );
    }
}

/// The result as a page of text.
#[must_use]
pub(crate) fn to_text(result: &RunResult) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}  {}: {}",
        result.verdict.to_uppercase(),
        result.scenario,
        result.reason
    );
    let _ = writeln!(
        text,
        "  drove {:.1} m in {:.1} s of run time ({}, {:.1} x real time), {} contacts{}",
        result.driven_m,
        result.time_s,
        result.mode,
        result.speed_factor,
        result.contacts,
        result
            .clearance_m_min
            .map_or_else(String::new, |least| format!(", closest {least:.2} m")),
    );
    if result.slipped_ms > 0.0 {
        let _ = writeln!(
            text,
            "  run time slipped by {:.1} ms: the machine was busy",
            result.slipped_ms
        );
    }
    if !result.injected_us.is_empty() {
        let delays = result.injected_us.iter();
        let delays: Vec<String> = delays
            .map(|(role, delay_us)| format!("{role} {:.2} ms", delay_us / 1.0e3))
            .collect();
        let _ = writeln!(text, "  delays were injected: {}", delays.join(", "));
    }
    write_events(result, &mut text);
    if let Some(pose) = &result.pose {
        write_pose(pose, &mut text);
    }
    if let Some(tracking) = &result.tracking {
        write_tracking(tracking, &mut text);
    }
    if let Some(latency) = &result.latency {
        write_latency(latency, &mut text);
    }
    for lint in lints(result) {
        let _ = writeln!(text, "  note: {lint}");
    }
    if let Some(trials) = &result.trials {
        text.push_str("  slowest trials\n");
        for slow in trials.worst.iter().take(SLOWEST_SHOWN) {
            write_slow(slow, &mut text);
        }
    }
    write_services(result, &mut text);
    if let Some(hash) = &result.run_hash {
        let _ = writeln!(text, "  run hash {hash}");
    }
    for why in &result.not_reproducible {
        let _ = writeln!(text, "  not reproducible: {why}");
    }
    write_missed(result, &mut text);
    let _ = writeln!(text, "  {}", result.directory);
    text
}

/// A service that got no processor, in one line.
fn starved_line(seat: &Starved) -> String {
    let Starved {
        service,
        time_s,
        times,
        longest_s,
        waited_s,
    } = seat;
    format!(
        "  {time_s:8.2} s  {service} was starved: {times} times without progress, {longest_s:.1} s at the \
         longest, it waited {waited_s:.1} s for a processor\n"
    )
}

/// A fault and how its seat recovered, in one line.
fn fault_line(fault: &FaultResult) -> String {
    let figures = match fault.figures.as_str() {
        "" => String::new(),
        figures => format!(" {figures}"),
    };
    let until = fault
        .until_s
        .map_or_else(String::new, |until_s| format!(" until {until_s:.2} s"));
    let recovery = match (&fault.why, fault.recovery_ms) {
        (Some(why), _) => format!(", not made: {why}"),
        (None, Some(recovery_ms)) => format!(", answered again after {recovery_ms:.0} ms"),
        (None, None) => String::new(),
    };
    format!(
        "  {:8.2} s  fault: {} {}{figures}{until}{recovery}\n",
        fault.time_s, fault.kind, fault.target
    )
}

/// Says where a path ends that does not end at its goal.
fn beside(beside_goal_m: f64) -> String {
    if beside_goal_m < 0.005 {
        return String::new();
    }
    format!(", ends {beside_goal_m:.2} m beside the goal")
}

/// The table of latencies.
fn write_latency(latency: &Latency, text: &mut String) {
    let _ = writeln!(
        text,
        "\n  latency [us]              n  censored        p50        p90        p99        max"
    );
    let mut row = |name: &str, figures: &Figures| {
        let figures = figures.supported();
        let cell = |value: Option<f64>| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.0}"))
        };
        let _ = writeln!(
            text,
            "  {name:<20} {:>6}  {:>8} {:>10} {:>10} {:>10} {:>10}",
            figures.n,
            figures.censored,
            cell(figures.p50_us),
            cell(figures.p90_us),
            cell(figures.p99_us),
            cell(figures.max_us)
        );
    };
    row("reaction", &latency.reaction);
    row("replanning", &latency.replanning);
    row("event to motion", &latency.event_to_motion);
    for hop in &latency.hops {
        row(&format!("  {}", hop.title()), &hop.figures);
    }
    if let Some(floor) = &latency.transport_floor {
        row("transport floor", floor);
    }
    if let Some(ratio) = latency.replanning_to_floor {
        let _ = writeln!(
            text,
            "  replanning takes {ratio:.1} times the floor (medians)"
        );
    }
    let disorder: u64 = latency.hops_out_of_order.values().sum();
    let _ = writeln!(
        text,
        "  {} commands followed back to their scan: {} records missing, {disorder} stamps before \
         their predecessor",
        latency.ways, latency.ways_broken
    );
    if let Some(clock) = &latency.second_clock
        && let Some((median_us, most_us)) = clock.difference.p50_us.zip(clock.difference.max_us)
    {
        let _ = writeln!(
            text,
            "  the hops add up to the robot's time on its second clock within {median_us:.0} us \
             (median), {most_us:.0} us (most); {} beyond what the clocks' rates allow",
            clock.beyond
        );
    }
    if latency.revised > 0 {
        let _ = writeln!(
            text,
            "  {} answers corrected later, when more of the obstacle had been seen",
            latency.revised
        );
    }
}

fn megabytes(bytes: u64) -> f64 {
    bytes.to_f64() / 1.0e6
}

/// The line for people; nothing when odometry was the truth and was left alone.
fn write_pose(pose: &PoseResult, text: &mut String) {
    if pose.odometry_error_m_max <= EXACT_M && pose.error_m_max <= EXACT_M {
        return;
    }
    let _ = writeln!(
        text,
        "  pose off by at most {:.1} cm and {:.2} degrees, {:.1} cm in the mean, over {} scans; \
         odometry alone by {:.2} m",
        1.0e2 * pose.error_m_max,
        pose.error_rad_max.to_degrees(),
        1.0e2 * pose.error_m_rms,
        pose.scans,
        pose.odometry_error_m_max,
    );
}

/// The line for people.
fn write_tracking(tracking: &TrackingResult, text: &mut String) {
    let delays = tracking
        .detection_delay_s_median
        .zip(tracking.detection_delay_s_max)
        .map_or_else(String::new, |(median_s, most_s)| {
            format!(" after {median_s:.2} s (at most {most_s:.2} s)")
        });
    let rmse = tracking
        .velocity_rmse_mps
        .map_or_else(String::new, |rmse| format!("; velocity RMSE {rmse:.2} m/s"));
    let _ = writeln!(
        text,
        "  moving obstacles: {} found{delays}, {} missed, {} made up in {:.0} s{rmse}",
        tracking.found, tracking.missed, tracking.false_moving, tracking.duration_s,
    );
}

/// One line for people: the hop, and the service that was disturbed most.
fn write_slow(slow: &SlowTrial, text: &mut String) {
    let time = slow.replanning_us;
    let time = time.map_or_else(|| "unanswered".to_owned(), |us| format!("{us:.0} us"));
    let _ = write!(
        text,
        "    round {} trial {}: {time}",
        slow.round, slow.trial
    );
    if let Some(SlowHop {
        name,
        time_us,
        p50_us,
    }) = &slow.hop
    {
        let _ = write!(text, ", {name} {time_us:.0} us");
        if let Some(p50_us) = p50_us {
            let _ = write!(text, " (median {p50_us:.0})");
        }
    }
    let services = slow.disturbance.iter().flat_map(|all| &all.services);
    for service in services.filter(|service| service.off_processor_us_max >= SHOWN_US) {
        let _ = write!(
            text,
            "; {} off the processor for {:.0} us, queued {:.0} us, {} preemptions",
            service.name,
            service.off_processor_us_max,
            service.queue_us,
            service.involuntary_switches
        );
    }
    text.push('\n');
}

/// The process that answered, for people.
fn who(service: &ServiceResult) -> String {
    let by_hand = if service.external {
        ", started by hand"
    } else {
        ""
    };
    format!(
        "{} {} (pid {}{by_hand})",
        service.name, service.binary, service.pid
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pose_errors_and_tracked_obstacles_have_a_line_each() {
        let pose = PoseResult {
            scans: 29,
            error_m_max: 0.05,
            odometry_error_m_max: 0.4,
            ..PoseResult::default()
        };
        let tracking = TrackingResult {
            found: 1,
            detection_delay_s_median: Some(0.3),
            detection_delay_s_max: Some(0.3),
            ..TrackingResult::default()
        };
        let mut text = String::new();
        write_pose(&pose, &mut text);
        write_tracking(&tracking, &mut text);
        assert!(text.contains("at most 5.0 cm"), "{text}");
        assert!(text.contains("1 found after 0.30 s"), "{text}");
    }

    #[test]
    fn without_a_found_obstacle_no_delay_is_shown() {
        let mut text = String::new();
        let nothing = TrackingResult {
            missed: 2,
            duration_s: 30.0,
            ..TrackingResult::default()
        };
        write_tracking(&nothing, &mut text);
        assert_eq!(
            text,
            "  moving obstacles: 0 found, 2 missed, 0 made up in 30 s\n"
        );
    }
}
