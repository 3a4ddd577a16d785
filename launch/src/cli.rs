//! The command line.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use zeronav_msgs::role::Role;

/// Zero-copy, multi-process navigation: launch a scenario, swap a service, profile latency.
#[derive(Debug, Parser)]
#[command(name = "zeronav", version, propagate_version = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Drive a scenario: start the world, the robot and every service, end with a verdict.
    Run(RunArgs),
    /// The scenarios that are there.
    List {
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Read a scenario, look for everything that is wrong with it, start nothing.
    Check {
        /// Name (see `zeronav list`) or path of a scenario.
        scenario: String,
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// The runs that go on, and their processes.
    Ps {
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Send a running robot somewhere else.
    Goal(GoalArgs),
}

/// Arguments of `zeronav run`.
#[derive(Debug, Clone, Args)]
pub struct RunArgs {
    /// Name (see `zeronav list`) or path of a scenario.
    pub scenario: String,
    /// Every stage answers every tick exactly once: as fast as the machine can, the same every time.
    #[arg(long)]
    pub lockstep: bool,
    /// Show nothing while it runs.
    #[arg(long)]
    pub headless: bool,
    /// Print the result as one JSON object on standard output.
    #[arg(long)]
    pub json: bool,
    /// Seed of everything random, in place of the scenario's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Do not start the service in this seat: wait for a process that is started by hand, such as
    /// one in a debugger. May be given several times.
    #[arg(long, value_name = "ROLE", value_parser = service_role)]
    pub external: Vec<Role>,
    /// Folder in which the run's own folder is made.
    #[arg(long, value_name = "FOLDER", default_value = "runs")]
    pub out: PathBuf,
    /// What the services log: error, warn, info, debug, trace, or a filter.
    #[arg(long, value_name = "LEVEL", default_value = "info")]
    pub log_level: String,
}

/// Arguments of `zeronav goal`.
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true)]
pub struct GoalArgs {
    /// [m] in the map frame.
    pub x: f64,
    /// [m] in the map frame.
    pub y: f64,
    /// [rad] counter-clockwise from +x.
    pub yaw: f64,
    /// How close counts. [m]
    #[arg(long, value_name = "METRES", default_value_t = 0.25)]
    pub tolerance: f64,
    /// Root folder of the run, when several go on (see `zeronav ps`).
    #[arg(long, value_name = "ROOT")]
    pub domain: Option<PathBuf>,
}

/// The seat of a service by its name.
fn service_role(name: &str) -> Result<Role, String> {
    let role = Role::from_label(name).filter(|role| Role::SERVICES.contains(role));
    role.ok_or_else(|| {
        let known: Vec<&str> = Role::SERVICES.iter().map(|role| role.label()).collect();
        format!("known are {}", known.join(", "))
    })
}
