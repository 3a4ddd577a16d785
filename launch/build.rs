//! Lists the files of `scenarios/` and `worlds/` for `scenario/library.rs`, so that a file that is
//! there is built in and none can be forgotten; and asks git for the commit, for `--version`.

use std::error::Error;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;
use std::{env, fs, io};

fn main() -> Result<(), Box<dyn Error>> {
    let (package, out) = (env::var("CARGO_MANIFEST_DIR")?, env::var("OUT_DIR")?);
    let mut list = String::new();
    for (folder, name) in [("scenarios", "SCENARIOS"), ("worlds", "WORLDS")] {
        writeln!(io::stdout(), "cargo::rerun-if-changed={folder}")?;
        let mut files = fs::read_dir(Path::new(&package).join(folder))?
            .map(|entry| Ok(entry?.path()))
            .collect::<io::Result<Vec<_>>>()?;
        files.retain(|file| file.extension().is_some_and(|ending| ending == "toml"));
        files.sort();
        writeln!(list, "const {name}: [(&str, &str); {}] = [", files.len())?;
        for file in files {
            let stem = file.file_stem().and_then(|stem| stem.to_str());
            let (Some(stem), Some(file)) = (stem, file.to_str()) else {
                return Err("the name of a file is no text".into());
            };
            writeln!(list, "    ({stem:?}, include_str!({file:?})),")?;
        }
        writeln!(list, "];")?;
    }
    fs::write(Path::new(&out).join("library.rs"), list)?;
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
