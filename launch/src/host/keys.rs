//! `zeronav link keys`: becomes the program that makes them, which others do without.

use clap::Subcommand;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use zeronav_console::terminal::usage;
use zeronav_supervise::binaries;

/// The program that makes keys.
const BINARY: &str = "zeronav-link-keys";

/// What `zeronav link` does.
#[derive(Debug, Clone, Subcommand)]
pub enum LinkCommand {
    /// Make a key and a certificate for each host, signed by an authority whose own key is thrown away: nobody joins
    /// who has none of them.
    Keys {
        /// A new folder; each host gets `ca.pem` and the two files of its name from it.
        folder: PathBuf,
        /// Name of a host as in the scenario, with the names and addresses by which it is found.
        #[arg(required = true, num_args = 2, value_names = ["HOST=ADDRESS,...", "HOST=ADDRESS,..."])]
        hosts: Vec<String>,
    },
}

/// Does it.
#[must_use]
pub fn link(command: &LinkCommand) -> ExitCode {
    let LinkCommand::Keys { folder, hosts } = command;
    let binary = match binaries::find_or_build(Path::new(BINARY)) {
        Ok(binary) => binary,
        Err(problem) => return usage(&problem),
    };
    let error = Command::new(&binary).arg(folder).args(hosts).exec();
    usage(&format!("starting {}: {error}", binary.display()))
}
