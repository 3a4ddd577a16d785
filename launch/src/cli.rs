//! The command line.

use crate::logs::LogsArgs;
use crate::remote::GoalOrder;
use crate::run_plan::RunPlan;
use crate::scenario::{COORDINATE_M_MAX, TOLERANCE, YAW_RAD_MAX};
use crate::suite::noise::Noise;
use crate::suite::plan::SuitePlan;
use crate::supervise::cleaner;
use crate::topics::cli::TopicsArgs;
use crate::version::VERSION;
use clap::{Args, Parser, Subcommand};
use core::ops::Range;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{DELAY_STEP_NS, RunMode};
use zeronav_msgs::time::seconds;
use zeronav_shell::logs;
use zeronav_shell::nearest::unknown;
use zeronav_world::error::number;

/// Zero-copy, multi-process navigation: launch a scenario, swap a service, profile latency.
#[derive(Debug, Parser)]
#[command(name = "zeronav", version = VERSION, propagate_version = true)]
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
    /// The global planners that `services.global_planner.config.planner` can name.
    Planners {
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// The controllers that `services.local_planner.config.controller` can name.
    Controllers {
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// The parameters of a service: type, default, range, unit and meaning, as its binary says.
    Params {
        /// Whose, such as `local_planner`; without, of all services.
        #[arg(value_name = "ROLE", value_parser = service_role)]
        role: Option<Role>,
        /// Ask this binary in place of the stock one.
        #[arg(long, value_name = "FILE", requires = "role")]
        binary: Option<PathBuf>,
        /// Print tables, as in `services/PARAMETERS.md`.
        #[arg(long, conflicts_with = "json")]
        markdown: bool,
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// The JSON schema of a scenario, for editors.
    Schema,
    /// The runs that go on, and their processes.
    Ps {
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Send a running robot somewhere else.
    Goal(GoalArgs),
    /// Look into a running stack: its topics, their rates, every message with its units.
    Topics(TopicsArgs),
    /// What the processes of a running stack write, merged by time.
    Logs(LogsArgs),
    /// Whether this machine can run a stack well, and what to do where it cannot.
    Doctor {
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Run the worlds of a data set, or a folder of scenarios, in lockstep on all cores.
    Suite(SuiteArgs),
    /// Draw a recorded run as an animated SVG.
    Draw(DrawArgs),
    /// Remove what a dead service left in a domain; `zeronav run` starts it by itself.
    #[command(name = cleaner::COMMAND, hide = true)]
    Clean {
        /// Root folder of the domain.
        root: PathBuf,
    },
    /// Watch over a run from outside; started by zeronav itself.
    #[command(hide = true)]
    Warden,
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
    /// Measure: drop the scenario's obstacle before the robot N times, in three rounds, with the
    /// floor of the transport between them.
    #[arg(long, value_name = "N", conflicts_with = "lockstep",
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub trials: Option<u32>,
    /// Delay every answer of a service, to see that the delay appears in its hop and nowhere
    /// else. May be given several times.
    #[arg(long, value_name = "ROLE=TIME", value_parser = delay, conflicts_with = "lockstep")]
    pub inject: Vec<(Role, u16)>,
    /// Folder in which the run's own folder is made.
    #[arg(long, value_name = "FOLDER", default_value = "runs")]
    pub out: PathBuf,
    /// What the services log: error, warn, info, debug, trace, or a filter.
    #[arg(long, value_name = "LEVEL", default_value = "info", value_parser = logs::filter)]
    pub log_level: String,
}

impl RunArgs {
    /// What the arguments mean.
    #[must_use]
    pub fn plan(&self) -> RunPlan {
        RunPlan {
            scenario: self.scenario.clone(),
            mode: if self.lockstep {
                RunMode::Lockstep
            } else {
                RunMode::RealTime
            },
            seed: self.seed,
            external: self.external.clone(),
            trials: self.trials,
            delays: self.inject.iter().copied().collect(),
            out: self.out.clone(),
            log_level: self.log_level.clone(),
            progress: !self.headless,
        }
    }
}

/// Arguments of `zeronav goal`.
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true)]
pub struct GoalArgs {
    /// [m] in the map frame.
    #[arg(value_parser = coordinate)]
    pub x: f64,
    /// [m] in the map frame.
    #[arg(value_parser = coordinate)]
    pub y: f64,
    /// [rad] counter-clockwise from +x.
    #[arg(value_parser = yaw)]
    pub yaw: f64,
    /// How close counts. [m]
    #[arg(long, value_name = "METRES", default_value_t = 0.25, value_parser = tolerance)]
    pub tolerance: f64,
    /// How close the yaw must be; 3.15 takes any. [rad]
    #[arg(long, value_name = "RADIANS", default_value_t = 0.25, value_parser = tolerance)]
    pub yaw_tolerance: f64,
    /// Root folder of the run, when several go on (see `zeronav ps`).
    #[arg(long, value_name = "ROOT")]
    pub domain: Option<PathBuf>,
}

impl GoalArgs {
    /// The goal and the run that it is for.
    #[must_use]
    pub fn order(&self) -> GoalOrder {
        GoalOrder {
            pose: [self.x, self.y, self.yaw],
            tolerance_m: self.tolerance,
            yaw_tolerance_rad: self.yaw_tolerance,
            root: self.domain.clone(),
        }
    }
}

/// Arguments of `zeronav suite`.
#[derive(Debug, Clone, Args)]
pub struct SuiteArgs {
    /// generated (needs no data), barn, dynabarn, pedestrians, or a folder of scenarios.
    #[arg(
        value_name = "generated|barn|dynabarn|pedestrians|FOLDER",
        default_value = "",
        hide_default_value = true,
        required_unless_present = "resume"
    )]
    pub suite: String,
    /// Go on with the suite in this folder, which was interrupted, with the arguments that it was
    /// begun with.
    #[arg(long, value_name = "FOLDER",
          conflicts_with_all = ["suite", "controller", "seeds", "worlds", "noise", "data", "out"])]
    pub resume: Option<PathBuf>,
    /// Key of the local planner's controller; without, beam for dynabarn, pedestrians and what moves
    /// in generated, else its default or the scenario's.
    #[arg(long, value_name = "KEY")]
    pub controller: Option<String>,
    /// Runs of each world, with the seeds 1 to N.
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u64).range(1..=10_000))]
    pub seeds: u64,
    /// Only the worlds with a number from A up to, but not including, B. Scenes and scenarios are
    /// numbered from 0 by name.
    #[arg(long, value_name = "A..B", value_parser = world_range)]
    pub worlds: Option<Range<u32>>,
    /// How badly wheels, odometry and lidar do.
    #[arg(long, value_enum, default_value_t)]
    pub noise: Noise,
    /// Folder of the data sets: barn, dynabarn and pedestrians lie in it. Without, the environment's
    /// `$ZERONAV_DATA`, then ./data.
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// Runs at a time; without, as many as there are cores.
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// Print the report as one JSON object on standard output.
    #[arg(long)]
    pub json: bool,
    /// Show nothing while it runs.
    #[arg(long)]
    pub headless: bool,
    /// Folder in which the suite's own folder is made.
    #[arg(long, value_name = "FOLDER", default_value = "runs")]
    pub out: PathBuf,
}

impl SuiteArgs {
    /// What the arguments mean.
    #[must_use]
    pub fn plan(&self) -> SuitePlan {
        SuitePlan {
            suite: self.suite.clone(),
            resume: self.resume.clone(),
            controller: self.controller.clone(),
            seeds: self.seeds,
            worlds: self.worlds.clone(),
            noise: self.noise,
            data: self.data.clone(),
            jobs: self.jobs,
            progress: !self.headless,
            out: self.out.clone(),
        }
    }
}

/// Arguments of `zeronav draw`.
#[derive(Debug, Clone, Args)]
pub struct DrawArgs {
    /// Folder of a run, as `zeronav run` left it.
    pub run: PathBuf,
    /// File to write; without, animation.svg in that folder.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// A number within a range.
fn ranged(text: &str, [min, max]: [f64; 2]) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    number(value, min, max, "").map_err(|error| error.why)?;
    Ok(value)
}

fn coordinate(text: &str) -> Result<f64, String> {
    ranged(text, [-COORDINATE_M_MAX, COORDINATE_M_MAX])
}

fn yaw(text: &str) -> Result<f64, String> {
    ranged(text, [-YAW_RAD_MAX, YAW_RAD_MAX])
}

fn tolerance(text: &str) -> Result<f64, String> {
    ranged(text, TOLERANCE)
}

/// `0..20` as 0 to 19.
fn world_range(text: &str) -> Result<Range<u32>, String> {
    let (from, until) = text.split_once("..").ok_or("worlds read like 0..20")?;
    let number = |text: &str| {
        text.parse::<u32>()
            .map_err(|_| format!("`{text}` is no number of a world"))
    };
    let range = number(from)?..number(until)?;
    if range.is_empty() {
        return Err(format!("no world lies in {text}"));
    }
    Ok(range)
}

/// The seat of a service by its name.
fn service_role(name: &str) -> Result<Role, String> {
    let role = Role::from_label(name).filter(|role| Role::SERVICES.contains(role));
    role.ok_or_else(|| {
        unknown(
            "service",
            name,
            Role::SERVICES.iter().map(|role| role.label()),
        )
    })
}

/// `global_planner=5ms` as a seat and its delay in steps of
/// [`zeronav_msgs::run::DELAY_STEP_NS`].
fn delay(text: &str) -> Result<(Role, u16), String> {
    let (role, time) = text
        .split_once('=')
        .ok_or("a delay reads like global_planner=5ms")?;
    let role = service_role(role)?;
    if role == Role::Robot {
        return Err("the robot keeps the time and cannot be delayed".to_owned());
    }
    let (number, unit_us) = match (time.strip_suffix("ms"), time.strip_suffix("us")) {
        (Some(number), _) => (number, 1.0e3),
        (None, Some(number)) => (number, 1.0),
        (None, None) => return Err("the time needs its unit, ms or us".to_owned()),
    };
    let number: f64 = number
        .parse()
        .map_err(|_| format!("`{number}` is no number"))?;
    let step_us = 1.0e6 * seconds(DELAY_STEP_NS);
    let steps = (number * unit_us / step_us).round();
    if !(1.0..=f64::from(u16::MAX)).contains(&steps) {
        return Err("a delay lasts 10us to 655ms".to_owned());
    }
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "its range was checked"
    )]
    Ok((role, steps as u16))
}
