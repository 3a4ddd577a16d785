//! `zeronav doctor`: whether this machine can run a stack well, and what to do where it cannot.

mod checks;
mod logind;
mod processor;
mod ros2;

use checks::{Finding, Level};
use clap::Args;
use rustix::process::{Resource, getrlimit};
use serde_json::json;
use std::process::ExitCode;
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_console::terminal::{say, say_json};
use zeronav_shell::memory::SHM;
use zeronav_shell::{domain, printable};

/// Arguments of `zeronav doctor`.
#[derive(Debug, Clone, Args)]
pub struct DoctorArgs {
    /// Look at a robot of ROS 2: who publishes what and how, rates, ages, transforms, clocks.
    #[arg(long)]
    pub ros2: bool,
    /// Scenario whose robot it is, which names its topics; without, those that are usual.
    #[arg(requires = "ros2")]
    pub scenario: Option<String>,
    /// How long to listen to it. [s]
    #[arg(long, requires = "ros2", value_name = "S", default_value_t = 6, value_parser = clap::value_parser!(u64).range(1..=600))]
    pub seconds: u64,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// `zeronav doctor`.
#[must_use]
pub fn doctor(arguments: &DoctorArgs) -> ExitCode {
    if arguments.ros2 {
        let scenario = arguments.scenario.as_deref();
        return ros2::doctor(scenario, arguments.seconds, arguments.json);
    }
    let json = arguments.json;
    let findings = examine();
    let worst = findings.iter().map(|finding| finding.level).max();
    let can_run = worst < Some(Level::Error);
    if json {
        say_json(&json!({ "can_run": can_run, "checks": findings }));
    } else {
        say(&findings.iter().map(text).collect::<String>());
    }
    ExitCode::from(if can_run { EXIT_PASS } else { EXIT_FAIL })
}

/// Why a stack that is left running will lose its memory when the caller logs out, and the ways out,
/// in one line; `None` when it will not.
#[must_use]
pub(crate) fn logout_warning() -> Option<String> {
    let finding = checks::remove_ipc(&logind::Facts::read());
    finding.fix.map(|fix| format!("{}; {fix}", finding.seen))
}

/// Why shared memory is deleted under a stack that runs, and the ways out, in one line.
#[must_use]
pub(crate) fn deletion() -> String {
    logout_warning().unwrap_or_else(|| {
        format!(
            "logind does so at logout (RemoveIPC=yes) when the user neither lingers nor is a system \
             user; {}",
            checks::ways_out(&logind::Facts::read().user)
        )
    })
}

/// A finding as one line, and its fix below.
fn text(finding: &Finding) -> String {
    let level = match finding.level {
        Level::Ok => "ok",
        Level::Warning => "warning",
        Level::Error => "error",
    };
    let fix = finding
        .fix
        .as_ref()
        .map(|fix| format!("{:8}   {}\n", "", printable(fix)));
    format!(
        "{level:8} {}: {}\n{}",
        finding.check,
        printable(&finding.seen),
        fix.unwrap_or_default()
    )
}

fn examine() -> Vec<Finding> {
    let read = |file: &str| std::fs::read_to_string(file).ok();
    // The only thing that is changed: domains whose lock is free.
    let removed = domain::sweep_dead();
    let (files, locked) = (getrlimit(Resource::Nofile), getrlimit(Resource::Memlock));
    let clock = read("/sys/devices/system/clocksource/clocksource0/current_clocksource");
    vec![
        checks::leftovers(domain::all().len(), &removed, &domain::stray_segments()),
        checks::shared_memory(shared_memory()),
        checks::open_files(files.current, files.maximum),
        checks::locked_memory(locked.current, &read("/proc/swaps").unwrap_or_default()),
        checks::clock_source(clock.as_deref()),
        checks::cores(std::thread::available_parallelism().map_or(1, usize::from)),
        processor::share(&processor::measure()),
        checks::governor(&governors()),
        checks::remove_ipc(&logind::Facts::read()),
    ]
}

/// Size of /dev/shm and what is free of it. [bytes]
fn shared_memory() -> Option<[u64; 2]> {
    let stat = rustix::fs::statvfs(SHM).ok()?;
    Some([stat.f_blocks, stat.f_bavail].map(|blocks| blocks.saturating_mul(stat.f_frsize)))
}

/// The governor of every core.
fn governors() -> Vec<String> {
    let cores = std::fs::read_dir("/sys/devices/system/cpu");
    cores
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|core| {
            std::fs::read_to_string(core.path().join("cpufreq/scaling_governor")).ok()
        })
        .collect()
}
