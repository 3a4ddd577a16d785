//! The first commit of a range with whose binary a run differs.

use super::worktree::Worktree;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_console::terminal::note;
use zeronav_msgs::role::Role;
use zeronav_shell::printable::printable;

/// One commit, by the exit codes of `git bisect run`: 0 equal, 1 different, 125 cannot be told, 255 ends the search.
const STEP: &str = r#"
git log -1 --format='%h %s' >&2
sh -c "$ZERONAV_BISECT_BUILD" >&2 || { git reset --quiet --hard; exit 125; }
"$@" >&2
code=$?
# A build may change files that are in the repository, which git would not go on from.
[ -n "$ZERONAV_BISECT_STAYS" ] || git reset --quiet --hard
case $code in 0|1) exit $code ;; 130) exit 255 ;; *) exit 125 ;; esac
"#;

/// The same when it cannot be told.
const SKIPPED: i32 = 125;

/// Why nothing was found.
#[derive(Debug)]
pub(super) enum Problem {
    /// In words.
    Usage(String),
    Interrupted,
}

impl From<String> for Problem {
    fn from(why: String) -> Self {
        Self::Usage(why)
    }
}

/// A search.
#[derive(Debug)]
pub(super) struct Commits<'a> {
    pub good: &'a str,
    pub bad: &'a str,
    /// For the shell.
    pub build: &'a str,
    /// The recording that a good commit drives again.
    pub file: &'a Path,
    /// Folder of the runs.
    pub out: &'a Path,
}

/// What was found.
#[derive(Debug)]
pub(super) enum Found {
    /// Its short hash and subject; it is built in the worktree.
    First(String),
    /// Short hashes and subjects, the oldest first: between these nothing can be told.
    OneOf(Vec<String>),
}

impl Commits<'_> {
    /// Searches in a worktree, with the binaries of a commit in these seats.
    ///
    /// # Errors
    /// [`Problem`].
    pub(super) fn first(
        &self,
        worktree: &Worktree,
        swap: &[(Role, PathBuf)],
        interrupted: &Arc<AtomicBool>,
    ) -> Result<Found, Problem> {
        let good = worktree.git(&[
            "rev-parse",
            "--verify",
            &format!("{}^{{commit}}", self.good),
        ])?;
        let bad = worktree.git(&["rev-parse", "--verify", &format!("{}^{{commit}}", self.bad)])?;
        // A search between ends that are not what they are called ends somewhere all the same.
        for (commit, name, expected) in [(&bad, self.bad, EXIT_FAIL), (&good, self.good, EXIT_PASS)]
        {
            worktree.go_to(commit)?;
            let code = self.step(worktree, swap)?;
            if interrupted.load(Ordering::Relaxed) {
                return Err(Problem::Interrupted);
            }
            let why = match code {
                _ if code == i32::from(expected) => continue,
                SKIPPED => "cannot be built or driven, see above",
                _ if expected == EXIT_FAIL => "does not differ from the recording",
                _ => "differs from the recording already",
            };
            return Err(Problem::Usage(format!(
                "{name} {why}: nothing to search for"
            )));
        }
        worktree.git(&["reset", "--quiet", "--hard"])?;
        worktree.git(&["bisect", "start", "--first-parent", &bad, &good])?;
        self.run(worktree, swap)?;
        if interrupted.load(Ordering::Relaxed) {
            return Err(Problem::Interrupted);
        }
        self.found(worktree, swap)
    }

    fn found(&self, worktree: &Worktree, swap: &[(Role, PathBuf)]) -> Result<Found, Problem> {
        let shown = |commits: &str| -> Result<Vec<String>, String> {
            let words = ["log", "--no-walk=unsorted", "--format=%h %s"];
            let commits = commits.split_whitespace();
            Ok(worktree
                .git(&words.into_iter().chain(commits).collect::<Vec<_>>())?
                .lines()
                .map(str::to_owned)
                .collect())
        };
        let bad = worktree.git(&["rev-parse", "refs/bisect/bad"])?;
        // Those between the last good commit and the first bad one.
        let goods = worktree.git(&[
            "for-each-ref",
            "--format=^%(objectname)",
            "refs/bisect/good-*",
        ])?;
        let list = ["rev-list", "--first-parent", "--reverse", &bad];
        let left = worktree.git(
            &list
                .into_iter()
                .chain(goods.split_whitespace())
                .collect::<Vec<_>>(),
        )?;
        let mut left = shown(&left)?;
        if left.len() > 1 {
            return Ok(Found::OneOf(left));
        }
        worktree.go_to(&bad)?;
        self.step(worktree, swap)?;
        Ok(Found::First(left.pop().unwrap_or(bad)))
    }

    /// Judges the commit in the worktree; as `git bisect run` does.
    fn step(&self, worktree: &Worktree, swap: &[(Role, PathBuf)]) -> Result<i32, String> {
        let mut command = Command::new("sh");
        command.args(["-c", STEP, "sh"]).args(self.replay(swap)?);
        command.env("ZERONAV_BISECT_STAYS", "1");
        self.carry_out(command, worktree)
    }

    /// Lets git search.
    fn run(&self, worktree: &Worktree, swap: &[(Role, PathBuf)]) -> Result<i32, String> {
        let mut command = Command::new("git");
        let words = ["bisect", "run", "sh", "-c", STEP, "sh"];
        command.args(words).args(self.replay(swap)?);
        self.carry_out(command, worktree)
    }

    /// Runs a command in the worktree, with what it says on standard error; its exit code.
    fn carry_out(&self, mut command: Command, worktree: &Worktree) -> Result<i32, String> {
        note(&printable(&format!(
            "in {}: {}",
            worktree.path().display(),
            self.build
        )));
        let status = command
            .current_dir(worktree.path())
            .env("ZERONAV_BISECT_BUILD", self.build)
            .stdin(std::process::Stdio::null())
            .stdout(std::io::stderr())
            .status();
        let status = status.map_err(|error| format!("starting the search: {error}"))?;
        Ok(status.code().unwrap_or(SKIPPED))
    }

    /// The command that compares, with these binaries.
    fn replay(&self, swap: &[(Role, PathBuf)]) -> Result<Vec<OsString>, String> {
        let own = std::env::current_exe().map_err(|error| format!("finding zeronav: {error}"))?;
        let out = std::path::absolute(self.out);
        let out = out.map_err(|error| error.to_string())?;
        let mut words: Vec<OsString> = vec![own.into(), "replay".into(), self.file.into()];
        words.extend(["--equal", "--headless", "--out"].map(OsString::from));
        words.push(out.into());
        for (role, binary) in swap {
            let mut seat = OsString::from(format!("{role}="));
            seat.push(binary);
            words.extend(["--swap".into(), seat]);
        }
        Ok(words)
    }
}
