//! The live page of a stack: `zeronav view` without a file, and the viewer that `zeronav run` and `zeronav up`
//! start beside the services as a companion.

use crate::running;
use clap::Args;
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use zeronav_console::terminal::{complain, note, usage};
use zeronav_supervise::binaries;
use zeronav_supervise::child_log::last_lines;
use zeronav_supervise::process::Process;

/// The binary.
const BINARY: &str = "zeronav-viewer";

/// What to do about a viewer that is lost.
pub(crate) const HINT: &str = "`zeronav view` brings the live page back";

/// Longest line that is read from the viewer. [bytes]
const LINK_BYTES_MAX: u64 = 256;

/// Where the page is served and what it is opened with.
#[derive(Debug, Clone, Default, Args)]
pub struct PageArgs {
    /// Port of the live page on 127.0.0.1; without, 8090, or any that is free.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub port: Option<u16>,
    /// Open the page in a browser.
    #[arg(long)]
    pub open: bool,
}

impl PageArgs {
    fn flags(&self, root: &Path) -> Vec<OsString> {
        let mut flags: Vec<OsString> = vec!["--domain".into(), root.into()];
        if let Some(port) = self.port {
            flags.extend(["--port".into(), port.to_string().into()]);
        }
        if self.open {
            flags.push("--open".into());
        }
        flags
    }
}

/// Arguments of `zeronav view`.
#[derive(Debug, Clone, Args)]
pub struct ViewArgs {
    /// A recording to be played in a page of its own: an MCAP file of `--record`, `bag recover` or
    /// `import`, or the folder of a run with one. Without, the live page of a running stack.
    #[arg(conflicts_with_all = ["port", "view_only"])]
    pub file: Option<PathBuf>,
    /// The page of a recording; without, beside it with the same name.
    #[arg(short, long, value_name = "PAGE", requires = "file")]
    pub out: Option<PathBuf>,
    /// Replace a page of the same name.
    #[arg(long, requires = "file")]
    pub force: bool,
    /// Print what is played of a recording as one JSON object, as in `recording.json`, and write no
    /// page.
    #[arg(long, requires = "file", conflicts_with_all = ["out", "open"])]
    pub json: bool,
    /// Root folder of the stack, when several run (see `zeronav ps`).
    #[arg(long, value_name = "ROOT", env = "ZERONAV_DOMAIN")]
    pub domain: Option<PathBuf>,
    /// The page.
    #[command(flatten)]
    pub page: PageArgs,
    /// Let every user of this machine look at the run, and nobody change anything from the page.
    #[arg(long)]
    pub view_only: bool,
}

/// `zeronav view`: becomes the viewer, which prints the link and ends with the stack or with Ctrl-C.
#[must_use]
pub fn view(arguments: &ViewArgs) -> ExitCode {
    let found = running::find(arguments.domain.as_deref())
        .and_then(|run| Ok((run, binaries::find_or_build(Path::new(BINARY))?)));
    let (run, binary) = match found {
        Ok(found) => found,
        Err(problem) => return usage(&problem),
    };
    let mut command = Command::new(&binary);
    command.args(arguments.page.flags(run.root()));
    if arguments.view_only {
        command.arg("--view-only");
    }
    let error = command.exec();
    usage(&format!("starting {}: {error}", binary.display()))
}

/// Finds the binary of the viewer.
///
/// # Errors
/// Why there is none, and what to do.
pub(crate) fn binary() -> Result<PathBuf, String> {
    binaries::find(Path::new(BINARY))
}

/// The live page of a run, served by one viewer after the other.
#[derive(Debug)]
pub(crate) struct LivePage {
    page: PageArgs,
    /// The link that the viewers so far have printed last.
    link: Arc<Mutex<Option<String>>>,
}

impl LivePage {
    /// A page that is not served yet.
    pub(crate) fn new(page: &PageArgs) -> Self {
        Self {
            page: page.clone(),
            link: Arc::default(),
        }
    }

    fn link(&self) -> Option<String> {
        let link = self.link.lock();
        link.unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The flags of the next viewer. One that comes back under the link of the one before opens no browser.
    pub(crate) fn flags(&self, root: &Path) -> Vec<OsString> {
        if self.link().is_none() {
            return self.page.flags(root);
        }
        let page = PageArgs::default();
        let mut flags = page.flags(root);
        flags.push("--come-back".into());
        flags
    }

    /// The standard input of the next viewer: the link has a token, which stands in no argument.
    pub(crate) fn stdin(&self) -> Stdio {
        self.link().map_or_else(Stdio::null, |_| Stdio::piped())
    }

    /// Tells a viewer that was started with these flags the link of the one before, and has the one that it
    /// prints shown when it is known. The thread that waits for it ends with the viewer.
    ///
    /// # Errors
    /// When there is no room for a thread.
    pub(crate) fn ingest(&self, process: &mut Process) -> std::io::Result<()> {
        let before = self.link();
        if let (Some(link), Some(mut stdin)) = (&before, process.stdin()) {
            // One that has died already is noticed as such.
            let _ = writeln!(stdin, "{link}");
        }
        let (output, log) = (process.stdout(), process.log()?);
        let known = Arc::clone(&self.link);
        let hear = move || {
            let Some(output) = output else { return };
            let mut link = String::new();
            let read = BufReader::new(output.take(LINK_BYTES_MAX)).read_line(&mut link);
            match (read, link.trim()) {
                (Ok(1..), link) if link.starts_with("http://127.0.0.1:") => {
                    if before.as_deref() == Some(link) {
                        note("the live page is back under the same link");
                    } else {
                        note(&format!("live page: {link}"));
                    }
                    *known.lock().unwrap_or_else(PoisonError::into_inner) = Some(link.to_owned());
                }
                _ => {
                    let said = last_lines(&log, 1);
                    let why = said.first().map_or("the viewer has ended", String::as_str);
                    complain(&format!("no live page: {why}"));
                }
            }
        };
        std::thread::Builder::new().spawn(hear).map(|_| ())
    }
}
