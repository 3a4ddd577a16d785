//! The workspace and what is built of it for tests, and scripts that they write.

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// Root folder of the workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap_or(Path::new("."))
}

/// The example services that scenarios name.
pub(crate) const EXAMPLES: [&str; 3] = [
    "straight_line_service",
    "requests_full_speed",
    "requests_nan",
];

/// Folder of the binaries of this very build, of the example services and of those that misbehave
/// under each of their names, built once per test program.
///
/// # Panics
/// When they do not build.
pub fn binaries() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let program = std::env::current_exe().expect("this test has a path");
        let folder = program.parent().expect("programs lie in a folder");
        // Those of tests lie in target/PROFILE/deps, others in target/PROFILE.
        let is_test = folder.ends_with("deps");
        let folder = folder.parent().filter(|_| is_test).unwrap_or(folder);
        let folder = folder.to_owned();
        let profile = match folder.file_name().and_then(|name| name.to_str()) {
            Some("debug") | None => "dev",
            Some(name) => name,
        };
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        // With an example cargo counts in what only tests depend on, as `cargo test --workspace`
        // does: its build of all dependencies serves this one, too.
        let status = from_a_shell(Command::new(cargo))
            .args(["build", "--quiet", "--workspace", "--bins", "--lib"])
            .args(EXAMPLES.map(|name| format!("--example={name}")))
            .args(["--profile", profile])
            .arg("--target-dir")
            .arg(folder.parent().expect("a target folder"))
            .current_dir(workspace())
            .status()
            .expect("cargo runs");
        assert!(status.success(), "the binaries do not build");
        let mut links = Command::new(folder.join("misbehaving"));
        let links = links.arg(&folder).status().expect("it starts");
        assert!(
            links.success(),
            "the names of those that misbehave are missing"
        );
        folder
    })
}

/// A command of `zeronav`. Under cargo it would build its workspace first, which [`binaries`] has
/// done: a test would wait for that, behind all others.
///
/// # Panics
/// As [`binaries`].
#[must_use]
pub fn command() -> Command {
    without_cargo(Command::new(binaries().join("zeronav")))
}

/// [`command`] for what does not depend on the clock, such as a run in lockstep: it takes the
/// processor time that others leave.
///
/// # Panics
/// As [`binaries`].
#[must_use]
pub(crate) fn background_command() -> Command {
    without_cargo(background(binaries().join("zeronav")))
}

/// A command that takes the processor time that others leave.
#[must_use]
pub fn background(program: impl AsRef<OsStr>) -> Command {
    let mut command = from_a_shell(Command::new("nice"));
    command.args(["-n", "19"]).arg(program);
    command
}

/// Without the variables that cargo sets for the package of a test. Build scripts of dependencies look at some of them, so
/// that cargo would build these dependencies again, and once more when it is called from a shell.
fn from_a_shell(mut command: Command) -> Command {
    let of_package = |name: &str| {
        name == "OUT_DIR" || name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_")
    };
    for (name, _) in std::env::vars_os() {
        if name.to_str().is_some_and(of_package) {
            command.env_remove(name);
        }
    }
    command
}

fn without_cargo(mut command: Command) -> Command {
    command.env_remove("CARGO");
    command
}

/// A configuration of cargo for a package outside the workspace, whose dependencies are built for it
/// alone: as fast as that goes, but for what it spends its time in.
#[must_use]
pub fn quick_profile(package: &str) -> String {
    let optimised = [package, "zeronav-msgs", "zeronav-shell", "zeronav-world"];
    let optimised = optimised.map(|name| format!("[profile.dev.package.{name}]\nopt-level = 2\n"));
    format!(
        "[profile.dev]\nopt-level = 0\ndebug = \"none\"\n{}",
        optimised.concat()
    )
}

/// Writes a script that can be executed at once.
///
/// Another process writes it: a program that any process has open for writing cannot be executed
/// (`ETXTBSY`), and what this process has open, the children that other tests start hold, too,
/// until they execute their own program.
///
/// # Panics
/// When it cannot be written.
pub fn executable(path: &Path, text: &str) {
    let mut install = Command::new("install");
    install.args(["--mode=755", "/dev/stdin"]).arg(path);
    let mut install = install.stdin(Stdio::piped()).spawn().expect("it starts");
    let mut script = install.stdin.take().expect("its standard input");
    script.write_all(text.as_bytes()).expect("it reads");
    drop(script);
    let status = install.wait().expect("it ends");
    assert!(status.success(), "{} is not written", path.display());
}

/// Copies a binary of this build into `folder`, so that it can be executed at once, as [`executable`].
///
/// # Panics
/// When it cannot be copied.
pub fn copy_binary(name: &str, folder: &Path) {
    let mut install = Command::new("install");
    let install = install.arg("--mode=755").arg(binaries().join(name));
    let status = install.arg(folder).status().expect("it runs");
    assert!(status.success(), "{name} is not copied");
}
