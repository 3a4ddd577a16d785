//! `zeronav doctor --ros2`: becomes the program that looks at a robot of ROS 2.

use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, ExitCode};
use zeronav_console::terminal::usage;
use zeronav_scenario::Scenario;
use zeronav_supervise::binaries;

/// The program in the seat of a robot of ROS 2.
const SEAT: &str = "zeronav-ros2";

/// What the names of its programs end with: identities of Humble have another length.
const DISTROS: [&str; 2] = ["", "-humble"];

/// The program that looks.
const BINARY: &str = "zeronav-ros2-doctor";

/// Listens for so long to the robot of the scenario, or to one with the usual topics. [s]
pub(super) fn doctor(scenario: Option<&str>, seconds: u64, json: bool) -> ExitCode {
    let ready = robot(scenario)
        .and_then(|(binary, ros)| Ok((binaries::find_or_build(Path::new(&binary))?, ros)));
    let (binary, ros) = match ready {
        Ok(ready) => ready,
        Err(problem) => return usage(&problem),
    };
    let mut command = Command::new(&binary);
    command.args(["--ros", &ros, "--seconds", &seconds.to_string()]);
    if json {
        command.arg("--json");
    }
    let error = command.exec();
    usage(&format!("starting {}: {error}", binary.display()))
}

/// The program that looks, and the robot's table `config.ros`.
fn robot(scenario: Option<&str>) -> Result<(String, String), String> {
    let Some(name) = scenario else {
        return Ok((BINARY.to_owned(), String::new()));
    };
    let scenario = Scenario::load(name).map_err(|error| error.to_string())?;
    let robot = &scenario.services.robot;
    let file = robot.binary.as_deref().and_then(Path::file_name);
    let seat = file.and_then(|it| it.to_str()).unwrap_or_default();
    let distro = seat.strip_prefix(SEAT);
    let Some(distro) = distro.filter(|it| DISTROS.contains(it)) else {
        return Err(format!(
            "{name}: its robot is no robot of ROS 2: [services.robot] binary = \"{SEAT}\""
        ));
    };
    let ros = robot.config.get("ros").and_then(toml::Value::as_table);
    let ros = ros.map(|ros| toml::to_string(ros).map_err(|error| error.to_string()));
    let ros = ros.transpose()?.unwrap_or_default();
    Ok((format!("{BINARY}{distro}"), ros))
}
