//! The first commit of a range with whose binary a run differs.

use super::worktree::{Worktree, in_no_repository};
use rustix::process::{Pid, Signal, kill_process_group, test_kill_process_group};
use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_console::terminal::note;
use zeronav_msgs::role::Role;
use zeronav_shell::printable::printable;

/// One commit, by the exit codes of `git bisect run`: 0 equal, 1 different, 125 cannot be told, 255 ends the search.
const STEP: &str = r#"
git log -1 --format=%h >&2
sh -c "$ZERONAV_BISECT_BUILD" >&2 || { git reset --quiet --hard; exit 125; }
"$@" >&2
code=$?
# A build may change files that are in the repository, which git would not go on from.
[ -n "$ZERONAV_BISECT_STAYS" ] || git reset --quiet --hard
case $code in 0|1) exit $code ;; 130) exit 255 ;; *) exit 125 ;; esac
"#;

/// The same when it cannot be told.
const SKIPPED: i32 = 125;

/// Between two looks.
const PAUSE: Duration = Duration::from_millis(50);

/// How long a build or a run may take to end once it is interrupted.
const ENDS_WITHIN: Duration = Duration::from_secs(30);

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
    /// Name and hash of the ends.
    pub good: (&'a str, &'a str),
    pub bad: (&'a str, &'a str),
    /// For the shell.
    pub build: &'a str,
    /// The recording that a good commit drives again.
    pub file: &'a Path,
    /// Folder of the runs.
    pub out: &'a Path,
    pub interrupted: &'a AtomicBool,
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
    ) -> Result<Found, Problem> {
        // A search between ends that are not what they are called ends somewhere all the same.
        for ((name, commit), expected) in [(self.bad, EXIT_FAIL), (self.good, EXIT_PASS)] {
            worktree.go_to(commit)?;
            let code = self.step(worktree, swap)?;
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
        worktree.git(&["bisect", "start", "--first-parent", self.bad.1, self.good.1])?;
        // 2 = only commits that cannot be told are left.
        let code = self.run(worktree, swap)?;
        if ![0, 2].contains(&code) {
            let why = "git bisect stopped before the end of the search, see above";
            return Err(Problem::Usage(why.to_owned()));
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
    fn step(&self, worktree: &Worktree, swap: &[(Role, PathBuf)]) -> Result<i32, Problem> {
        let mut command = in_no_repository("sh");
        command.args(["-c", STEP, "sh"]).args(self.replay(swap)?);
        command.env("ZERONAV_BISECT_STAYS", "1");
        self.carry_out(command, worktree)
    }

    /// Lets git search.
    fn run(&self, worktree: &Worktree, swap: &[(Role, PathBuf)]) -> Result<i32, Problem> {
        let mut command = in_no_repository("git");
        let words = ["bisect", "run", "sh", "-c", STEP, "sh"];
        command.args(words).args(self.replay(swap)?);
        self.carry_out(command, worktree)
    }

    /// Runs a command in the worktree, with what it says on standard error; its exit code. When this command is
    /// interrupted, so is that one, and all that it has started.
    fn carry_out(&self, mut command: Command, worktree: &Worktree) -> Result<i32, Problem> {
        note(&printable(&format!(
            "in {}: {}",
            worktree.path().display(),
            self.build
        )));
        let child = command
            .current_dir(worktree.path())
            .env("ZERONAV_BISECT_BUILD", self.build)
            .stdin(Stdio::null())
            .stdout(std::io::stderr())
            .process_group(0)
            .spawn();
        let failed = |error: std::io::Error| Problem::Usage(format!("the search: {error}"));
        let mut child = child.map_err(failed)?;
        loop {
            if let Some(status) = child.try_wait().map_err(failed)? {
                return Ok(status.code().unwrap_or(SKIPPED));
            }
            if self.interrupted.load(Ordering::Relaxed) {
                end_group(&mut child);
                return Err(Problem::Interrupted);
            }
            std::thread::sleep(PAUSE);
        }
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

/// Ends a process and all that it has started in its group, and waits until none is left.
fn end_group(child: &mut Child) {
    let group = Pid::from_child(child);
    let _ = kill_process_group(group, Signal::INT);
    let since = Instant::now();
    loop {
        // It would stay in its group as a zombie.
        let _ = child.try_wait();
        if test_kill_process_group(group).is_err() {
            return;
        }
        if since.elapsed() > ENDS_WITHIN {
            let _ = kill_process_group(group, Signal::KILL);
            let _ = child.wait();
            return;
        }
        std::thread::sleep(PAUSE);
    }
}
