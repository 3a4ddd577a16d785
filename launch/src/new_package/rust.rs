//! A package in Rust: a workspace of its own, with the versions of zeronav's lock file.

use super::name::Name;
use super::place::Text;
use super::sources::Sources;
use super::template::Template;
use zeronav_files::read;

/// The lock file of this source tree.
const LOCK: &str = include_str!("../../../Cargo.lock");

/// Largest lock file of sources that are named. [bytes]
const LOCK_BYTES_MAX: u64 = 16 << 20;

/// Where cargo puts the binary.
pub(crate) fn binary(name: &Name) -> String {
    format!("./target/debug/{}", name.as_str())
}

/// What builds it, in its folder.
pub(crate) const BUILD: &str = "cargo build";

/// What git ignores.
pub(crate) const IGNORED: &str = "/target\n/runs\n";

/// The files.
///
/// # Errors
/// The lock file of the sources cannot be read.
pub(crate) fn files(
    template: &Template,
    name: &Name,
    sources: &Sources,
) -> Result<Vec<Text>, String> {
    // The middleware is one exact version, and the rest is what was tested.
    let lock = match sources {
        Sources::Folder(folder) => {
            let file = folder.join("Cargo.lock");
            read::text(&file, LOCK_BYTES_MAX)
                .map_err(|error| format!("{}: {error}", file.display()))?
        }
        Sources::Git { .. } => LOCK.to_owned(),
    };
    Ok(vec![
        ("Cargo.toml".into(), manifest(template, name, sources)),
        ("Cargo.lock".into(), lock),
        ("src/main.rs".into(), template.text(name)),
    ])
}

fn manifest(template: &Template, name: &Name, sources: &Sources) -> String {
    let own = [
        ("zeronav-msgs", "msgs"),
        ("zeronav-shell", "services/shell"),
    ];
    let mut dependencies = String::new();
    for (package, folder) in own.iter().chain(template.packages) {
        let source = match sources {
            Sources::Folder(root) => {
                format!("path = {}", quoted(&root.join(folder).to_string_lossy()))
            }
            Sources::Git { url, commit } => {
                let rev = commit
                    .as_ref()
                    .map(|commit| format!(", rev = {}", quoted(commit)));
                format!("git = {}{}", quoted(url), rev.unwrap_or_default())
            }
        };
        let line = format!("{package} = {{ {source} }}\n");
        dependencies += &line;
    }
    let (name, registry) = (name.as_str(), template.registry);
    format!(
        r#"[package]
name = "{name}"
version = "0.1.0"
edition = "2024"
publish = false

[workspace]

[dependencies]
# The middleware's exact version comes with the shell; the versions of the rest are those of Cargo.lock.
{dependencies}{registry}
[profile.dev]
opt-level = 2
debug = "line-tables-only"

[profile.dev.build-override]
opt-level = 0
"#
    )
}

/// A string of TOML.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::new_package::template::TEMPLATES;
    use std::process::Command;

    #[test]
    fn a_lock_file_that_is_no_file_is_not_waited_for() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("Cargo.lock");
        let template = TEMPLATES.first().unwrap();
        let name = Name::new("mine").unwrap();
        let sources = Sources::Folder(root.path().to_owned());
        let made = Command::new("mkfifo").arg(&file).status().unwrap();
        assert!(made.success());
        let why = files(template, &name, &sources).unwrap_err();
        assert_eq!(why, format!("{}: is a pipe, not a file", file.display()));
        std::fs::remove_file(&file).unwrap();
        let large = std::fs::File::create(&file).unwrap();
        large.set_len(LOCK_BYTES_MAX + 1).unwrap();
        let why = files(template, &name, &sources).unwrap_err();
        assert!(why.contains("has more than"), "{why}");
        large.set_len(0).unwrap();
        assert!(files(template, &name, &sources).is_ok());
    }
}
