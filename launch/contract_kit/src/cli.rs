//! Arguments of `zeronav contract`.

use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;
use zeronav_console::arguments::service_role;
use zeronav_msgs::role::Role;

/// Arguments of `zeronav contract`.
#[derive(Debug, Clone, Args)]
pub struct ContractArgs {
    /// The seat that the program is for: mapping, `global_planner`, `local_planner` or
    /// `collision_guard`.
    #[arg(value_name = "ROLE", value_parser = swappable_role)]
    pub role: Role,
    /// The program: a path, or a name beside zeronav or on the search path.
    #[arg(value_name = "BINARY")]
    pub binary: PathBuf,
    /// Arguments in front of the flags that launch gives a service, such as a script.
    #[arg(last = true, value_name = "ARGS")]
    pub arguments: Vec<OsString>,
    /// Configuration file; without, what launch writes for a seat that nothing is set for.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Hostile messages, spread over the inputs of the seat.
    #[arg(long, value_name = "N", default_value_t = 1_000_000,
          value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    pub hostile: u64,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// The seat of a service that can be swapped.
///
/// # Errors
/// One line: there is no such seat, or it is the robot's.
pub fn swappable_role(name: &str) -> Result<Role, String> {
    match service_role(name)? {
        Role::Robot => Err(
            "the robot's seat is the clock of a stack: no kit plays the stack for it; test a robot \
             with `zeronav run` and `[services.robot]`"
                .to_owned(),
        ),
        role => Ok(role),
    }
}
