//! The command line.

use crate::bag::BagArgs;
use crate::busy;
use crate::compare::cli::CompareArgs;
use crate::import::ImportArgs;
use crate::latency::cli::LatencyArgs;
use crate::live_view::{PageArgs, ViewArgs};
use crate::logs::LogsArgs;
use crate::map_save::MapArgs;
use crate::new_package::cli::NewArgs;
use crate::output_args::OutputArgs;
use crate::params::ParamsArgs;
use crate::recorder::RecordArgs;
use crate::remote::cli::{
    CancelArgs, FaultArgs, GoalArgs, GoalsArgs, InitialPoseArgs, ObstacleArgs, SpeedArgs,
    StackArgs, StepArgs, WaitArgs,
};
use crate::remote::swap::{ShadowArgs, SwapArgs};
use crate::replay::ReplayArgs;
use crate::run_plan::{RunPlan, Source};
use crate::start_up::StartUpArgs;
use crate::top::cli::TopArgs;
use crate::topics::cli::TopicsArgs;
use crate::why::cli::WhyArgs;
use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use core::ops::Range;
use std::io::IsTerminal;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use zeronav_console::arguments::{delay, hours, service_role};
use zeronav_console::version::VERSION;
use zeronav_contract_kit::cli::ContractArgs;
use zeronav_contract_kit::no_memory;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_scenario::settings::DriverArgs;
use zeronav_scenario::{ForesightSpec, Perceive, Predict};
use zeronav_suite::noise::Noise;
use zeronav_suite::plan::SuitePlan;
use zeronav_supervise::cleaner;

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
    /// Measure latencies with their intervals, or show those of a run; a gate for CI.
    Latency(LatencyArgs),
    /// Compare two scenarios, or two binaries in a seat, round by round on the same seeds.
    Compare(CompareArgs),
    /// What a run did from the command to the first motion, and who waited for whom.
    StartUp(StartUpArgs),
    /// The scenarios that are there, and the methods of papers that can drive them.
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
    Params(ParamsArgs),
    /// The JSON schema of a scenario, for editors.
    Schema,
    /// The runs that go on, and their processes.
    Ps {
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Bring a stack up and keep it until `zeronav down`: it waits for goals.
    Up(UpArgs),
    /// Send the robot of a running stack to a pose, after the goals that were asked for before.
    Goal(GoalArgs),
    /// Send it to the poses in a file, in order.
    Goals(GoalsArgs),
    /// Stop driving to a goal, or to all.
    Cancel(CancelArgs),
    /// Hold the run time of a running stack: the robot stops where it is.
    Pause(StackArgs),
    /// Let it go on.
    Resume(StackArgs),
    /// Let a paused lockstep stack do some ticks.
    Step(StepArgs),
    /// Let a lockstep stack go as fast as real time, faster or slower.
    Speed(SpeedArgs),
    /// Tell a running stack where its robot is: an initial pose, or another one when it got lost.
    Pose(InitialPoseArgs),
    /// Put an obstacle into the simulated world of a running stack, move it, or take it out.
    Obstacle(ObstacleArgs),
    /// Break a service of a running stack on purpose.
    Fault(FaultArgs),
    /// Exchange the process in a seat while the stack runs, or change its parameters.
    Swap(SwapArgs),
    /// Compare a binary with the process in a seat; it hears everything and is never obeyed.
    Shadow(ShadowArgs),
    /// What a running stack does.
    Status(StackArgs),
    /// Wait until a stack is ready, its goal is over, or its robot has none.
    Wait(WaitArgs),
    /// Bring the robot of a running stack to rest and end the stack.
    Down(StackArgs),
    /// Say in plain words why the robot does what it does, now or at a moment of a run.
    Why(WhyArgs),
    /// Watch a running stack: services, topics, latencies, events.
    Top(TopArgs),
    /// Look into a running stack: its topics, their rates, every message with its units.
    Topics(TopicsArgs),
    /// What the processes of a running stack write, merged by time.
    Logs(LogsArgs),
    /// The map of a running stack.
    Map(MapArgs),
    /// What is in a recording, where two differ, tables of one, and one that was cut made whole again.
    Bag(BagArgs),
    /// Drive a recorded run again, the same or with another binary in a seat, as a whole or played to some seats, and say
    /// where it begins to differ.
    Replay(ReplayArgs),
    /// Bring the log of another robot into the form of a recording, to be played with `replay --open`.
    Import(ImportArgs),
    /// A live page of a running stack: prints its link, and serves it until the stack ends.
    View(ViewArgs),
    /// Whether this machine can run a stack well, and what to do where it cannot.
    Doctor {
        /// Print one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Run the worlds of a data set, or a folder of scenarios, in lockstep on all cores.
    Suite(SuiteArgs),
    /// Test whether a program may be swapped into a seat: the contract, clause by clause.
    Contract(ContractArgs),
    /// Write a package for a seat, which builds, keeps the contract and drives as it is.
    New(NewArgs),
    /// Draw a recorded run as an SVG: a still, or animated.
    Picture(PictureArgs),
    /// `picture --animated`.
    Draw(DrawArgs),
    /// Write the report of a recorded run again, or one page that compares several.
    Report(ReportArgs),
    /// The completions of a shell, to be sourced or put where it looks for them.
    Completions {
        /// Which shell.
        shell: Shell,
    },
    /// Write the manual pages, one for each verb.
    Man {
        /// Folder to write them to, such as `~/.local/share/man/man1`.
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// Replace files of the same names.
        #[arg(long)]
        force: bool,
    },
    /// Remove what a dead service left in a domain; `zeronav run` starts it by itself.
    #[command(name = cleaner::COMMAND, hide = true)]
    Clean {
        /// Root folder of the domain.
        root: PathBuf,
    },
    /// Test a program with too little shared memory; `zeronav contract` starts it by itself, in a
    /// namespace of its own.
    #[command(name = no_memory::COMMAND, hide = true)]
    WithoutMemory(ContractArgs),
    /// Compute until standard input is closed; `zeronav latency --load busy` starts it by itself.
    #[command(name = busy::COMMAND, hide = true)]
    Busy {
        /// Most seconds.
        limit_s: u64,
    },
    /// Watch over a run from outside; started by zeronav itself.
    #[command(hide = true)]
    Warden,
}

/// How a stack is brought up.
#[derive(Debug, Clone, Args)]
#[allow(clippy::struct_excessive_bools, reason = "switches of a command line")]
pub struct StartArgs {
    /// Every stage answers every tick exactly once: as fast as the machine can, the same every time.
    #[arg(long)]
    pub lockstep: bool,
    /// What it shows.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Seed of everything random, in place of the scenario's.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Do not start the service in this seat: wait for a process that is started by hand, such as
    /// one in a debugger. May be given several times.
    #[arg(long, value_name = "ROLE", value_parser = service_role)]
    pub external: Vec<Role>,
    /// Who drives.
    #[command(flatten)]
    pub driver: DriverArgs,
    /// Serve no live page. There is one when standard output is a terminal, without --json and
    /// --headless; a run in lockstep and trials have none.
    #[arg(long, conflicts_with_all = ["port", "open"])]
    pub no_view: bool,
    /// The live page.
    #[command(flatten)]
    pub page: PageArgs,
    /// The recording.
    #[command(flatten)]
    pub record: RecordArgs,
}

impl StartArgs {
    /// What the arguments mean for a scenario.
    fn plan(&self, scenario: Source) -> RunPlan {
        let mode = if self.lockstep {
            RunMode::Lockstep
        } else {
            RunMode::RealTime
        };
        let is_watched =
            !self.output.json && !self.output.headless && std::io::stdout().is_terminal();
        let plan = RunPlan {
            view: (is_watched && !self.no_view).then(|| self.page.clone()),
            record: self.record.record.clone(),
            seed: self.seed,
            external: self.external.clone(),
            settings: self.driver.settings(),
            ..RunPlan::of(scenario, mode)
        };
        self.output.laid_over(plan)
    }
}

/// Arguments of `zeronav run`.
#[derive(Debug, Clone, Args)]
pub struct RunArgs {
    /// Name (see `zeronav list`) or path of a scenario.
    pub scenario: String,
    /// How the stack is brought up.
    #[command(flatten)]
    pub start: StartArgs,
    /// Measure: drop the scenario's obstacle before the robot N times, in three rounds, with the
    /// floor of the transport between them.
    #[arg(long, value_name = "N", conflicts_with_all = ["lockstep", "record"],
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub trials: Option<u32>,
    /// Delay every answer of a service, to see that the delay appears in its hop and nowhere
    /// else. May be given several times.
    #[arg(long, value_name = "ROLE=TIME", value_parser = delay, conflicts_with = "lockstep")]
    pub inject: Vec<(Role, u16)>,
    /// Leave no report, and no frames for one, when the run passes; the runs of a suite do so.
    #[arg(long)]
    pub report_failures_only: bool,
    /// Do not time the stages of each cycle, which costs a reading of the clock each: `trace.json`
    /// is without them.
    #[arg(long)]
    pub no_stages: bool,
}

impl RunArgs {
    /// What the arguments mean.
    #[must_use]
    pub fn plan(&self) -> RunPlan {
        RunPlan {
            trials: self.trials,
            delays: self.inject.iter().copied().collect(),
            report_failures_only: self.report_failures_only,
            stages: !self.no_stages,
            ..self.start.plan(Source::Named(self.scenario.clone()))
        }
    }
}

/// Arguments of `zeronav up`.
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true)]
pub struct UpArgs {
    /// Name (see `zeronav list`) or path of a scenario; its goals are left out.
    #[arg(required_unless_present = "map")]
    pub scenario: Option<String>,
    /// YAML file of a ROS `map_server` map, in place of a scenario.
    #[arg(long, value_name = "MAP.yaml", conflicts_with = "scenario")]
    pub map: Option<PathBuf>,
    /// The robot on that map: the name of a base, such as porter, jackal or `turtlebot3_burger`.
    #[arg(
        long,
        value_name = "PRESET",
        default_value = "porter",
        requires = "map"
    )]
    pub robot: String,
    /// Where the robot starts on that map, x [m], y [m] and yaw [rad]; without, a free pose near its
    /// middle.
    #[arg(long, value_names = ["X", "Y", "YAW"], num_args = 3, requires = "map")]
    pub start_pose: Option<Vec<f64>>,
    /// How the stack is brought up.
    #[command(flatten)]
    pub start: StartArgs,
}

impl UpArgs {
    /// What the arguments mean.
    #[must_use]
    pub fn plan(&self) -> RunPlan {
        let source = match (&self.scenario, &self.map) {
            (Some(scenario), _) => Source::Named(scenario.clone()),
            (None, map) => Source::Map {
                map: map.clone().unwrap_or_default(),
                robot: self.robot.clone(),
                start: (self.start_pose.as_deref()).and_then(|pose| pose.try_into().ok()),
            },
        };
        RunPlan {
            stays: true,
            ..self.start.plan(source)
        }
    }
}

/// Arguments of `zeronav suite`.
#[derive(Debug, Clone, Args)]
pub struct SuiteArgs {
    /// generated and field (where real robots fail) need no data; barn, dynabarn, pedestrians, soak
    /// (drives under random faults), or a folder of scenarios.
    #[arg(
        value_name = "generated|field|barn|dynabarn|pedestrians|soak|FOLDER",
        default_value = "",
        hide_default_value = true,
        required_unless_present = "resume"
    )]
    pub suite: String,
    /// Go on with the suite in this folder, which was interrupted, with the arguments that it was
    /// begun with.
    #[arg(long, value_name = "FOLDER",
          conflicts_with_all = ["suite", "controller", "method", "setting", "seeds", "worlds", "noise",
                                 "perceive", "predict", "data", "out"])]
    pub resume: Option<PathBuf>,
    /// Wall time of a soak in all of its calls, after which it begins no more drives; without, an hour.
    #[arg(long, value_name = "H", value_parser = hours)]
    pub hours: Option<f64>,
    /// Key of the local planner's controller; without, beam for dynabarn, pedestrians and what moves
    /// in generated, else its default or the scenario's.
    #[arg(long, value_name = "KEY", conflicts_with = "method")]
    pub controller: Option<String>,
    /// Who drives.
    #[command(flatten)]
    pub driver: DriverArgs,
    /// Drive nothing: plan a way through each run's world that touches nothing, with exact wheels and
    /// the future of everything that moves known, and report what is possible. Where none is found
    /// there may be one.
    #[arg(long, conflicts_with_all = ["controller", "method", "setting", "resume", "perceive",
                                      "predict"])]
    pub bound: bool,
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
    /// How mapping knows what moves: truth measures what perception costs, and is no result.
    #[arg(long, value_enum, default_value_t)]
    pub perceive: Perceive,
    /// How the local planner knows where that will be: truth measures what prediction costs, and is no
    /// result.
    #[arg(long, value_enum, default_value_t)]
    pub predict: Predict,
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
            settings: self.driver.settings(),
            bound: self.bound,
            seeds: self.seeds,
            worlds: self.worlds.clone(),
            noise: self.noise,
            foresight: ForesightSpec {
                perceive: self.perceive,
                predict: self.predict,
            },
            data: self.data.clone(),
            hours: self.hours,
            jobs: self.jobs,
            progress: !self.headless,
            out: self.out.clone(),
        }
    }
}

/// Arguments of `zeronav picture`.
#[derive(Debug, Clone, Args)]
pub struct PictureArgs {
    /// Folder of a run, as `zeronav run` left it.
    pub run: PathBuf,
    /// File to write; without, run.svg or animation.svg in that folder.
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// The drive in a loop, in place of its end.
    #[arg(long)]
    pub animated: bool,
}

/// Arguments of `zeronav report`.
#[derive(Debug, Clone, Args)]
pub struct ReportArgs {
    /// Folders of runs, as `zeronav run` or `zeronav up` left them; with more than one they are
    /// compared with the first.
    #[arg(required = true, value_name = "RUN")]
    pub runs: Vec<PathBuf>,
    /// File to write; without, report.html in the folder of the run, or comparison.html in this one.
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
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
