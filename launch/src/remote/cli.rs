//! Arguments of the requests to a stack that runs.

use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;
use zeronav_console::arguments::{
    clock_offset, delay, service_role, time_s, topic_delay, topic_share,
};
use zeronav_msgs::role::Role;
use zeronav_scenario::{COORDINATE_M_MAX, TIME_LIMIT_S_MAX, TOLERANCE, YAW_RAD_MAX};
use zeronav_world::error::number;

/// Which stack, and how the answer is printed.
#[derive(Debug, Clone, Args)]
pub struct StackArgs {
    /// Root folder of the stack, when several run (see `zeronav ps`).
    #[arg(long, value_name = "ROOT", global = true, env = "ZERONAV_DOMAIN")]
    pub domain: Option<PathBuf>,
    /// Print JSON: one object, or one per line while something goes on.
    #[arg(long, global = true)]
    pub json: bool,
}

/// How a client's goals are served.
#[derive(Debug, Clone, Args)]
pub struct OrderArgs {
    /// Say how it goes on, and end when the goal is reached (exit code 0) or not (1).
    #[arg(long)]
    pub wait: bool,
    /// Take the place of all goals that were asked for before; without, wait until they are over.
    #[arg(long)]
    pub now: bool,
    /// Give up after this run time. [s]
    #[arg(long, value_name = "SECONDS", value_parser = time_limit)]
    pub time_limit: Option<f64>,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
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
    /// How it is served.
    #[command(flatten)]
    pub order: OrderArgs,
}

/// Arguments of `zeronav goals`.
#[derive(Debug, Clone, Args)]
pub struct GoalsArgs {
    /// TOML file with `[[goals]]` as in a scenario: `pose`, and if wanted `tolerance_m` and
    /// `yaw_tolerance_rad`.
    pub file: PathBuf,
    /// Begin again with the first after the last one, until cancelled.
    #[arg(long = "loop")]
    pub repeats: bool,
    /// How they are served.
    #[command(flatten)]
    pub order: OrderArgs,
}

/// Arguments of `zeronav cancel`.
#[derive(Debug, Clone, Args)]
pub struct CancelArgs {
    /// Number of the goal, as `zeronav goal` printed it; without, all goals.
    pub id: Option<u64>,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// Arguments of `zeronav step`.
#[derive(Debug, Clone, Args)]
pub struct StepArgs {
    /// Ticks of the robot.
    #[arg(default_value_t = 1)]
    pub ticks: u64,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// Arguments of `zeronav speed`.
#[derive(Debug, Clone, Args)]
pub struct SpeedArgs {
    /// Times real time, from 0.01 to 100; `max` = as fast as it can.
    #[arg(value_parser = speed)]
    pub factor: Speed,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// A speed of a lockstep stack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speed(pub Option<f64>);

/// Reads a speed; the stack knows which ones can be.
fn speed(text: &str) -> Result<Speed, String> {
    if text == "max" {
        return Ok(Speed(None));
    }
    let factor = text.parse::<f64>().ok().filter(|factor| factor.is_finite());
    factor
        .map(|factor| Speed(Some(factor)))
        .ok_or_else(|| "a number, or max".to_owned())
}

/// Arguments of `zeronav wait`.
#[derive(Debug, Clone, Args)]
pub struct WaitArgs {
    /// What for.
    pub what: WaitFor,
    /// Longest wait; when it is over the exit code is 1. [s]
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = time_limit)]
    pub timeout: f64,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// Arguments of `zeronav pose`.
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true)]
pub struct InitialPoseArgs {
    /// Where it is.
    #[command(flatten)]
    pub at: PoseArgs,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// Arguments of `zeronav obstacle`.
#[derive(Debug, Clone, Args)]
#[command(allow_negative_numbers = true)]
pub struct ObstacleArgs {
    /// What becomes of it.
    #[command(subcommand)]
    pub change: ObstacleCommand,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// What becomes of an obstacle.
#[derive(Debug, Clone, Subcommand)]
#[command(allow_negative_numbers = true)]
pub enum ObstacleCommand {
    /// Put a new one into the world.
    #[command(allow_negative_numbers = true)]
    Add {
        /// A name that the world does not have yet.
        name: String,
        /// Where.
        #[command(flatten)]
        at: PoseArgs,
        /// Sides of a rectangle. [m]
        #[arg(long, num_args = 2, value_names = ["X", "Y"], required_unless_present = "radius")]
        size: Option<Vec<f64>>,
        /// Radius of a disc. [m]
        #[arg(long, value_name = "METRES", conflicts_with = "size")]
        radius: Option<f64>,
    },
    /// Put one somewhere else, whatever its script says.
    #[command(allow_negative_numbers = true)]
    Move {
        /// Its name, in the scenario or as it was added.
        name: String,
        /// Where.
        #[command(flatten)]
        at: PoseArgs,
    },
    /// Take one out of the world.
    Remove {
        /// Its name, in the scenario or as it was added.
        name: String,
    },
}

/// Arguments of `zeronav fault`.
#[derive(Debug, Clone, Args)]
pub struct FaultArgs {
    /// How.
    #[command(subcommand)]
    pub fault: FaultCommand,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// What is broken, and how.
#[derive(Debug, Clone, Subcommand)]
pub enum FaultCommand {
    /// Kill it (SIGKILL), as if it had crashed.
    Kill {
        /// Its seat.
        #[arg(value_name = "ROLE", value_parser = service_role)]
        role: Role,
    },
    /// Stop it (SIGSTOP), so that it hangs until it is restarted, healed, or the time is over.
    Stop {
        /// Its seat.
        #[arg(value_name = "ROLE", value_parser = service_role)]
        role: Role,
        /// For how long.
        #[command(flatten)]
        lasts: LastsArgs,
    },
    /// Delay each of its answers.
    Slow {
        /// Its seat and the delay, such as `global_planner=20ms`.
        #[arg(value_name = "ROLE=TIME", value_parser = delay)]
        delay: (Role, u16),
        /// For how long.
        #[command(flatten)]
        lasts: LastsArgs,
    },
    /// Lose messages of a topic on their way to each of its readers; real time only.
    Drop {
        /// The topic, and the share if it is not every message, such as `plan/path=0.3`.
        #[arg(value_name = "TOPIC[=SHARE]", value_parser = topic_share)]
        share: (String, f64),
        /// For how long.
        #[command(flatten)]
        lasts: LastsArgs,
    },
    /// Delay the messages of a topic for all of its readers; real time only.
    Delay {
        /// The topic and the delay, such as `robot/scan=50ms`.
        #[arg(value_name = "TOPIC=TIME", value_parser = topic_delay)]
        delay: (String, f64),
        /// For how long.
        #[command(flatten)]
        lasts: LastsArgs,
    },
    /// Flip a bit of the messages of a topic: in header, fixed fields or slice; real time only.
    Corrupt {
        /// The topic, and the share if it is not every message, such as `robot/scan=0.1`.
        #[arg(value_name = "TOPIC[=SHARE]", value_parser = topic_share)]
        share: (String, f64),
        /// For how long.
        #[command(flatten)]
        lasts: LastsArgs,
    },
    /// Put the clock of a service forward, or back; real time only.
    Clock {
        /// Its seat and the offset, such as `mapping=+200ms` or `mapping=-200ms`.
        #[arg(value_name = "ROLE=TIME", value_parser = clock_offset)]
        offset: (Role, f64),
        /// For how long.
        #[command(flatten)]
        lasts: LastsArgs,
    },
    /// Fill the machine's shared memory, for every program on it.
    FillShm {
        /// For how long.
        #[arg(long = "for", value_name = "TIME", value_parser = time_s, default_value = "5s")]
        lasts_s: f64,
    },
    /// Fill the file system of the run's folder, for every program that uses it.
    DiskFull {
        /// For how long.
        #[arg(long = "for", value_name = "TIME", value_parser = time_s, default_value = "5s")]
        lasts_s: f64,
    },
    /// End faults that go on.
    Heal {
        /// Of this seat or topic, `shared_memory` or `disk`; without, all.
        #[arg(value_name = "ROLE|TOPIC")]
        target: Option<String>,
    },
}

/// For how long a fault lasts.
#[derive(Debug, Clone, Copy, Args)]
pub struct LastsArgs {
    /// Run time after which it ends by itself, such as 5s or 500ms; without, when it is healed.
    #[arg(long = "for", value_name = "TIME", value_parser = time_s)]
    pub lasts_s: Option<f64>,
}

/// A pose in the map frame.
#[derive(Debug, Clone, Args)]
pub struct PoseArgs {
    /// [m]
    #[arg(value_parser = coordinate)]
    pub x: f64,
    /// [m]
    #[arg(value_parser = coordinate)]
    pub y: f64,
    /// [rad] counter-clockwise from +x.
    #[arg(value_parser = yaw, default_value_t = 0.0)]
    pub yaw: f64,
}

/// What can be waited for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum WaitFor {
    /// A stack runs and every service can answer.
    Ready,
    /// The goal that is being driven to is over; the exit code is that of `zeronav goal --wait`.
    Goal,
    /// The robot has no goal.
    Idle,
}

impl core::fmt::Display for WaitFor {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let value = self.to_possible_value();
        f.write_str(value.as_ref().map_or("", |value| value.get_name()))
    }
}

/// A number within a range.
fn ranged(text: &str, [min, max]: [f64; 2]) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    number(value, min, max, "").map_err(|error| error.why)?;
    Ok(value)
}

pub(crate) fn coordinate(text: &str) -> Result<f64, String> {
    ranged(text, [-COORDINATE_M_MAX, COORDINATE_M_MAX])
}

pub(crate) fn yaw(text: &str) -> Result<f64, String> {
    ranged(text, [-YAW_RAD_MAX, YAW_RAD_MAX])
}

fn tolerance(text: &str) -> Result<f64, String> {
    ranged(text, TOLERANCE)
}

fn time_limit(text: &str) -> Result<f64, String> {
    ranged(text, [1.0e-3, TIME_LIMIT_S_MAX])
}
