//! Asks git for the commit, for `--version`.

use std::error::Error;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;
use std::{env, io};

fn main() -> Result<(), Box<dyn Error>> {
    let version = env::var("CARGO_PKG_VERSION")?;
    // Not that of a project which this source tree is only unpacked in.
    let is_checkout = git(&["ls-files", "--error-unmatch", "build.rs"]).is_some();
    let commit = git(&["rev-parse", "--short=10", "HEAD"]).filter(|_| is_checkout);
    let version = match commit {
        Some(commit) => format!("{version} (commit {commit})"),
        None => version,
    };
    writeln!(io::stdout(), "cargo::rustc-env=ZERONAV_VERSION={version}")?;
    // The commit is another one when this log has grown; without git there is none to watch.
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"])
        && Path::new(&log).exists()
    {
        writeln!(io::stdout(), "cargo::rerun-if-changed={log}")?;
    }
    Ok(())
}

/// What git says in one line; `None` without git or outside a checkout.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
