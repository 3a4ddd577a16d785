//! Which file a seat's binary is, and that it is not stale.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use zeronav_msgs::role::Role;

/// The stock binary of a seat.
#[must_use]
pub fn stock(role: Role) -> &'static str {
    match role {
        Role::Robot => "zeronav-robot-sim",
        Role::Mapping => "zeronav-mapping",
        Role::GlobalPlanner => "zeronav-global-planner",
        Role::LocalPlanner => "zeronav-local-planner",
        Role::CollisionGuard => "zeronav-collision-guard",
        Role::Launch | Role::Tap => "zeronav",
    }
}

/// Finds a binary: a path, or a name beside this program, or a name on the search path.
///
/// # Errors
/// Why there is none, and what to do.
pub fn find(name: &Path) -> Result<PathBuf, String> {
    let beside = beside_this_program();
    let is_name = name.components().count() == 1;
    let mut candidates = Vec::new();
    if is_name {
        candidates.extend(beside.iter().map(|folder| folder.join(name)));
        candidates.extend(
            beside
                .iter()
                .map(|folder| folder.join("examples").join(name)),
        );
        let path = std::env::var_os("PATH").unwrap_or_default();
        candidates.extend(std::env::split_paths(&path).map(|folder| folder.join(name)));
    } else {
        candidates.push(name.to_owned());
    }
    let found = candidates.iter().find(|candidate| is_executable(candidate));
    found
        .map(|path| std::fs::canonicalize(path).unwrap_or_else(|_| path.clone()))
        .ok_or_else(|| match beside {
            Some(folder) if is_name => format!(
                "no executable `{}` beside {} or on the search path; build it \
                 (`cargo build --workspace --bins --examples`) or name its path",
                name.display(),
                folder.join("zeronav").display()
            ),
            _ if name.is_file() => format!("{} is not executable: chmod +x it", name.display()),
            _ => format!(
                "no executable {}; build it or name another path",
                name.display()
            ),
        })
}

fn beside_this_program() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let folder = program.parent()?;
    // Test programs lie one folder deeper.
    if folder.ends_with("deps") {
        folder.parent().map(Path::to_owned)
    } else {
        Some(folder.to_owned())
    }
}

fn is_executable(path: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    path.metadata()
        .is_ok_and(|meta| meta.is_file() && meta.permissions().mode() & 0o111 != 0)
}

/// Which binaries a run may need.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needed {
    /// The stock ones alone.
    Stock,
    /// Any of the workspace, those of the tests too.
    Any,
}

/// Under cargo, builds the binaries of the workspace that are needed in this program's own profile,
/// so that a stale service is never driven. Elsewhere it does nothing.
///
/// # Errors
/// One line when cargo cannot be run or the build fails; cargo's own words went to stderr.
pub fn refresh_under_cargo(needed: Needed) -> Result<(), String> {
    let bins: &[&str] = match needed {
        Needed::Stock => &[
            "--exclude",
            "zeronav-tests",
            "--exclude",
            "zeronav-papers",
            // Built when a scenario names them: others need no network.
            "--exclude",
            "zeronav-ros2",
            "--exclude",
            "zeronav-link",
            "--bins",
        ],
        Needed::Any => &["--bins"],
    };
    match build(bins) {
        Some(Ok(false)) => Err("the services do not build, see above".to_owned()),
        Some(Err(error)) => Err(format!("running cargo to build the services: {error}")),
        Some(Ok(true)) | None => Ok(()),
    }
}

/// Finds a binary like [`find`]; under cargo, a name that is not there may be a binary or an example that is
/// still to be built.
///
/// # Errors
/// As [`find`].
pub fn find_or_build(name: &Path) -> Result<PathBuf, String> {
    let found = find(name);
    let (Err(_), Some(example)) = (&found, name.to_str()) else {
        return found;
    };
    let is_name = name.components().count() == 1;
    let is_built = |kind| matches!(build(&[kind, example]), Some(Ok(true)));
    if is_name && (is_built("--bin") || is_built("--example")) {
        return find(name);
    }
    found
}

/// Runs `cargo build --workspace` with `what` in this program's own profile and target folder:
/// whether it succeeded, or `None` when this program does not run under its own cargo.
fn build(what: &[&str]) -> Option<std::io::Result<bool>> {
    let cargo = std::env::var_os("CARGO")?;
    let package = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from)?;
    let workspace = own_workspace(&package)?;
    let folder = beside_this_program()?;
    let (target, profile) = folder.parent().zip(folder.file_name())?;
    if !target.join(".rustc_info.json").exists() && !target.join("CACHEDIR.TAG").exists() {
        return None;
    }
    let profile = if profile == "debug" {
        "dev".as_ref()
    } else {
        profile
    };
    let status = Command::new(cargo)
        .args(["build", "--quiet", "--workspace", "--manifest-path"])
        .arg(workspace.join("Cargo.toml"))
        .args(what)
        .arg("--profile")
        .arg(profile)
        .arg("--target-dir")
        .arg(target)
        .current_dir(&workspace)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .status();
    Some(status.map(|status| status.success()))
}

/// The workspace that this program was built from, when cargo runs one of its packages. Cargo
/// exports the same variables to the tests of any project that starts this program, and that
/// project is not to be built here.
fn own_workspace(package: &Path) -> Option<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2)?;
    let own = own.canonicalize().ok()?;
    let package = package.canonicalize().ok()?;
    (package.starts_with(&own) && own.join("Cargo.toml").is_file()).then_some(own)
}

#[cfg(test)]
mod tests {
    use super::own_workspace;
    use std::path::Path;

    #[test]
    fn only_packages_of_this_workspace_are_built() {
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        let own = own_workspace(package).expect("this very workspace");
        assert_eq!(Some(own.as_path()), package.ancestors().nth(2));
        let other = tempfile::tempdir().expect("a folder");
        std::fs::write(other.path().join("Cargo.toml"), "[package]").expect("written");
        assert_eq!(own_workspace(other.path()), None);
        assert_eq!(own_workspace(&other.path().join("absent")), None);
    }
}
