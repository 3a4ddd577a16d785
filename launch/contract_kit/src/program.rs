//! The program that is tested, and its short runs: those that print something and end.

use super::cli::ContractArgs;
use super::room;
use rustix::process::{Pid, Signal, kill_process_group};
use std::ffi::OsString;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use zeronav_msgs::role::Role;
use zeronav_supervise::binaries;
use zeronav_supervise::process::end_with_this_thread;

/// Longest time that a short run may take: as `zeronav check` gives it.
const ANSWER_LIMIT: Duration = Duration::from_secs(5);

/// Most of an output that is read. [bytes]
const BYTES_MAX: u64 = 1 << 20;

/// An output beyond this has no end. [bytes]
const FLOOD_BYTES: u64 = 4 << 20;

const PAUSE: Duration = Duration::from_millis(2);

/// The program under test.
#[derive(Debug, Clone)]
pub struct Program {
    /// The seat that it is tested in.
    pub role: Role,
    /// The file.
    pub binary: PathBuf,
    /// Arguments in front of the flags of a service.
    pub arguments: Vec<OsString>,
    /// Its configuration file.
    pub config: PathBuf,
    /// Folder for logs and configurations.
    pub folder: PathBuf,
}

/// A short run that has ended.
#[derive(Debug)]
pub struct Ended {
    /// How; `None` when it had to be killed.
    status: Option<ExitStatus>,
    /// True when it wrote more than [`FLOOD_BYTES`].
    flooded: bool,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Program {
    /// The program that the command line names; its configuration, when that names none, is written to
    /// `folder`.
    ///
    /// # Errors
    /// What is not there, or could not be written.
    pub fn find(arguments: &ContractArgs, folder: &Path) -> Result<Self, String> {
        let found = binaries::find_or_build(&arguments.binary)?;
        let binary = as_named(&arguments.binary, found);
        let config = if let Some(config) = &arguments.config {
            let absolute = std::fs::canonicalize(config);
            absolute.map_err(|error| format!("--config {}: {error}", config.display()))?
        } else {
            let config = folder.join("config.toml");
            let text = match arguments.role {
                Role::Mapping => room::mapping_config(),
                _ => String::new(),
            };
            let written = std::fs::write(&config, text);
            written.map_err(|error| format!("{}: {error}", config.display()))?;
            config
        };
        Ok(Self {
            role: arguments.role,
            binary,
            arguments: arguments.arguments.clone(),
            config,
            folder: folder.to_owned(),
        })
    }

    /// Its own arguments, then `flags`.
    pub fn with(&self, flags: &[OsString]) -> Vec<OsString> {
        [&self.arguments[..], flags].concat()
    }

    /// Runs it with these flags to its end, or kills it after [`ANSWER_LIMIT`] or [`FLOOD_BYTES`]; calls `meanwhile` now
    /// and then.
    fn run(&self, flags: &[OsString], meanwhile: &dyn Fn()) -> std::io::Result<Ended> {
        let (mut stdout, mut stderr) = (tempfile::tempfile()?, tempfile::tempfile()?);
        let mut command = Command::new(&self.binary);
        command
            .args(self.with(flags))
            .stdin(Stdio::null())
            .stdout(stdout.try_clone()?)
            .stderr(stderr.try_clone()?)
            .process_group(0);
        end_with_this_thread(&mut command, Signal::KILL);
        let mut process = command.spawn()?;
        let started = Instant::now();
        let status = loop {
            match process.try_wait()? {
                Some(status) => break Some(status),
                None if started.elapsed() > ANSWER_LIMIT => break None,
                None if is_flooded(&stdout) || is_flooded(&stderr) => break None,
                None => {
                    meanwhile();
                    std::thread::sleep(PAUSE);
                }
            }
        };
        if status.is_none() {
            let group = i32::try_from(process.id()).ok().and_then(Pid::from_raw);
            if let Some(group) = group {
                let _ = kill_process_group(group, Signal::KILL);
            }
            let _ = process.wait();
        }
        Ok(Ended {
            status,
            flooded: is_flooded(&stdout) || is_flooded(&stderr),
            stdout: text(&mut stdout)?,
            stderr: text(&mut stderr)?,
        })
    }

    /// Runs it with these flags to its end; its exit code has to be `code`.
    ///
    /// # Errors
    /// How it ended instead, with the last line that it wrote to standard error.
    pub fn expect(&self, flags: &[OsString], code: i32) -> Result<Ended, String> {
        self.expect_while(flags, code, &|| ())
    }

    /// [`Self::expect`], with something to be done `meanwhile`, every few milliseconds.
    ///
    /// # Errors
    /// As [`Self::expect`].
    pub fn expect_while(
        &self,
        flags: &[OsString],
        code: i32,
        meanwhile: &dyn Fn(),
    ) -> Result<Ended, String> {
        let ended = self.run(flags, meanwhile);
        let ended = ended.map_err(|error| format!("{}: {error}", self.binary.display()))?;
        match ended.status {
            Some(status) if status.code() == Some(code) => Ok(ended),
            Some(status) => Err(format!(
                "{status} and not exit code {code}; it said: {}",
                ended.last_words()
            )),
            None if ended.flooded => Err(format!(
                "it wrote more than {} MB; expected exit code {code}",
                FLOOD_BYTES >> 20
            )),
            None => Err(format!(
                "it had not ended after {} s; expected exit code {code}",
                ANSWER_LIMIT.as_secs()
            )),
        }
    }
}

impl Ended {
    /// The last line on standard error that says something.
    pub fn last_words(&self) -> &str {
        last_line(&self.stderr)
    }
}

/// The program under the name that leads to `found`. A link is not followed: the Python of a virtual
/// environment is a link, and knows by its name which one it is of.
fn as_named(name: &Path, found: PathBuf) -> PathBuf {
    if name.components().count() > 1 {
        return std::path::absolute(name).unwrap_or(found);
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut places = std::env::split_paths(&path).map(|folder| folder.join(name));
    let leads_there = |place: &PathBuf| std::fs::canonicalize(place).is_ok_and(|it| it == found);
    places.find(leads_there).unwrap_or(found)
}

/// The last line of a text that says something.
pub(crate) fn last_line(text: &str) -> &str {
    let mut lines = text.lines().map(str::trim).rev();
    lines.find(|line| !line.is_empty()).unwrap_or("nothing")
}

fn is_flooded(output: &File) -> bool {
    output.metadata().is_ok_and(|it| it.len() > FLOOD_BYTES)
}

fn text(file: &mut File) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(0))?;
    file.take(BYTES_MAX).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
