//! The command line.

use crate::background_load;
use crate::bag::BagArgs;
use crate::bag::diff::DiffArgs;
use crate::bisect::BisectArgs;
use crate::compare::cli::CompareArgs;
use crate::debug::DebugArgs;
use crate::doctor::DoctorArgs;
use crate::host::keys::LinkCommand;
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
use crate::remote::zone::ZoneArgs;
use crate::replay::ReplayArgs;
use crate::run_plan::{RunPlan, Source};
use crate::start_up::StartUpArgs;
use crate::suite_args::SuiteArgs;
use crate::top::cli::TopArgs;
use crate::topics::cli::TopicsArgs;
use crate::why::cli::WhyArgs;
use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use std::io::IsTerminal;
use std::path::PathBuf;
use zeronav_console::arguments::{delay, service_role};
use zeronav_console::version::VERSION;
use zeronav_contract_kit::cli::ContractArgs;
use zeronav_contract_kit::no_memory;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_scenario::settings::DriverArgs;
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
    /// Put a zone where the robot may not go or is slow, take it away, or list them.
    Zone(ZoneArgs),
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
    /// Say where two recorded runs begin to differ, by tick, topic and field: exit code 1 when they do.
    Diff(DiffArgs),
    /// Drive a recorded run again, the same or with another binary in a seat, as a whole or played to some seats, and say
    /// where it begins to differ.
    Replay(ReplayArgs),
    /// Find the first tick, seat and field in which two programs or parameter values drive a run otherwise, or the first
    /// commit whose program does.
    Bisect(BisectArgs),
    /// Let a lockstep run stand before a tick, with a debugger on one of its processes, and go on or back from there.
    Debug(DebugArgs),
    /// Bring the log of another robot into the form of a recording, to be played with `replay --open`.
    Import(ImportArgs),
    /// A live page of a running stack: prints its link, and serves it until the stack ends. Of a
    /// recording, a page that plays it.
    View(ViewArgs),
    /// Whether this machine can run a stack well, or with --ros2 whether a robot of ROS 2 can be driven, and
    /// what to do where it cannot.
    Doctor(DoctorArgs),
    /// What two hosts of a stack need: keys by which they know each other.
    #[command(subcommand)]
    Link(LinkCommand),
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
    #[command(name = background_load::COMMAND, hide = true)]
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
    /// Which of the scenario's hosts this computer is: it fills that one's seats, and the other host the others. The
    /// one with the robot drives; the other takes part in run after run, until it is interrupted.
    #[arg(long, value_name = "NAME")]
    pub host: Option<String>,
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
            host: self.host.clone(),
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
    /// floor of the transport between them. With --record each round has a file of its own:
    /// `recording-1.mcap`, `recording-2.mcap`, `recording-3.mcap`.
    #[arg(long, value_name = "N", conflicts_with = "lockstep",
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub trials: Option<u32>,
    /// Delay every answer of a service, to see that the delay appears in its hop and nowhere
    /// else. May be given several times.
    #[arg(long, value_name = "ROLE=TIME", value_parser = delay, conflicts_with = "lockstep")]
    pub inject: Vec<(Role, u16)>,
    /// Name of the run's own folder, which must not be there yet; without, the scenario's, with the time and
    /// the process.
    #[arg(long, value_name = "NAME")]
    pub folder: Option<String>,
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
            folder: self.folder.clone(),
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
    /// Tell the robot that it is where the last stack of this scenario was left (`last-pose-SCENARIO.json` in the folder
    /// of the runs), if the map is the same and there is room. What it sees is held against that as against any pose.
    #[arg(long)]
    pub resume_pose: bool,
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
            resume_pose: self.resume_pose,
            ..self.start.plan(source)
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
