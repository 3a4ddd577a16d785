//! A worktree of a repository, in a temporary folder, for as long as it is needed.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use zeronav_msgs::role::Role;
use zeronav_shell::printable::printable;

/// See the module's description.
#[derive(Debug)]
pub(super) struct Worktree {
    repository: PathBuf,
    /// Around the worktree.
    folder: tempfile::TempDir,
}

impl Worktree {
    /// Adds one at `commit`.
    ///
    /// # Errors
    /// What git says.
    pub(super) fn add(repository: &Path, commit: &str) -> Result<Self, String> {
        let folder = tempfile::Builder::new().prefix("zeronav-bisect").tempdir();
        let folder = folder.map_err(|error| format!("making a temporary folder: {error}"))?;
        let path = path_in(&folder);
        let words = ["worktree", "add", "--quiet", "--detach"].map(OsStr::new);
        let commit = [path.as_os_str(), OsStr::new(commit)];
        git(repository, words.into_iter().chain(commit))?;
        Ok(Self {
            repository: repository.to_owned(),
            folder,
        })
    }

    /// Its top folder.
    pub(super) fn path(&self) -> PathBuf {
        path_in(&self.folder)
    }

    /// Goes to a commit, whatever a build has changed.
    ///
    /// # Errors
    /// What git says against it.
    pub(super) fn go_to(&self, commit: &str) -> Result<(), String> {
        self.git(&["checkout", "--quiet", "--force", "--detach", commit])?;
        Ok(())
    }

    /// Runs git in it; what it says.
    ///
    /// # Errors
    /// What git says against it.
    pub(super) fn git(&self, words: &[&str]) -> Result<String, String> {
        git(&self.path(), words.iter().map(OsStr::new))
    }

    /// Binaries that are named from its top folder.
    pub(super) fn laid_under(&self, swap: &[(Role, PathBuf)]) -> Vec<(Role, PathBuf)> {
        let swap = swap.iter();
        swap.map(|(role, binary)| (*role, self.path().join(binary)))
            .collect()
    }
}

impl Drop for Worktree {
    fn drop(&mut self) {
        let path = self.path();
        let words = ["worktree", "remove", "--force", "--force"].map(OsStr::new);
        let removed = git(
            &self.repository,
            words.into_iter().chain([path.as_os_str()]),
        );
        if let Err(error) = removed {
            tracing::warn!(error, "the worktree is left");
        }
    }
}

fn path_in(folder: &tempfile::TempDir) -> PathBuf {
    folder.path().join("commit")
}

/// The hash of a commit that is named so in a repository.
///
/// # Errors
/// What git says against it.
pub(super) fn commit(repository: &Path, name: &str) -> Result<String, String> {
    let commit = format!("{name}^{{commit}}");
    let words = ["rev-parse", "--verify", "--quiet", &commit].map(OsStr::new);
    let found = git(repository, words.into_iter());
    found.map_err(|why| format!("{name} is no commit there: {why}"))
}

/// Runs git in `folder`; its standard output.
fn git<'a>(folder: &Path, words: impl Iterator<Item = &'a OsStr>) -> Result<String, String> {
    let ran = in_no_repository("git")
        .arg("-C")
        .arg(folder)
        .args(words)
        .output();
    let Output {
        status,
        stdout,
        stderr,
    } = ran.map_err(|error| format!("git: {error}: install it"))?;
    if status.success() {
        return Ok(String::from_utf8_lossy(&stdout).trim_end().to_owned());
    }
    let said = String::from_utf8_lossy(&stderr);
    let line = said
        .lines()
        .find(|line| !line.trim().is_empty())
        .unwrap_or("it says nothing");
    Err(format!("git in {}: {}", folder.display(), printable(line)))
}

/// A command that takes the repository from its folder, whoever calls zeronav.
pub(super) fn in_no_repository(program: &str) -> Command {
    let mut command = Command::new(program);
    for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE"] {
        command.env_remove(name);
    }
    command
}
